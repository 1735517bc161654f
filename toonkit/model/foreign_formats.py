"""Files that hold a picture in a format that toonkit does not read: their names, and what to export instead."""

from __future__ import annotations

import io
import zipfile

_PLAIN = "export it as PNG"
_LAYERED = "export it, with its layers merged and a transparent background, as PNG of 8 or 16 bits"
_LINEAR = "it holds linear light: apply its view transform and export it as 16-bit PNG"

_STARTS = (
    (b"8BPS", "a Photoshop document (PSD or PSB)", _LAYERED),
    (b"gimp xcf", "a GIMP document (XCF)", _LAYERED),
    (b"CSFCHUNK", "a Clip Studio Paint document (CLIP)", _LAYERED),
    (b"PDN3", "a Paint.NET document (PDN)", _LAYERED),
    (b"v/1\x01", "an OpenEXR picture", _LINEAR),
    (b"#?RADIANCE", "a Radiance HDR picture", _LINEAR),
    (b"#?RGBE", "a Radiance HDR picture", _LINEAR),
    (b"PF\n", "a portable float map (PFM)", _LINEAR),
    (b"Pf\n", "a portable float map (PFM)", _LINEAR),
    (b"\0\0\0\x0cJXL \r\n\x87\n", "a JPEG XL picture", _PLAIN),
    (b"\xff\x0a", "a JPEG XL picture", _PLAIN),
    (b"\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 picture", _PLAIN),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 picture", _PLAIN),
    (b"DDS ", "a DirectDraw texture (DDS)", _PLAIN),
    (b"\xabKTX ", "a Khronos texture (KTX)", _PLAIN),
    (b"\0\0\1\0", "an icon (ICO)", _PLAIN),
    (b"%PDF", "a PDF document", _PLAIN),
    (b"%!PS", "a PostScript document", _PLAIN),
)

_BRANDS = (
    ((b"avif", b"avis"), "an AVIF picture"),
    ((b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1"), "a HEIC picture"),
)

_MOST_MEMBERS = 1 << 16


def name_format(data: bytes) -> str | None:
    """Name a known format that toonkit does not read, and what to export instead."""
    for start, name, advice in _STARTS:
        if data.startswith(start):
            return f"{name}: {advice}"
    if data[4:8] == b"ftyp":
        # The major brand comes first; AVIF files list mif1 too, which alone means HEIF of any kind.
        brands = [data[8:12], *(data[at : at + 4] for at in range(16, min(len(data), 64), 4))]
        for known, name in _BRANDS:
            if any(brand in known for brand in brands):
                return f"{name}: {_PLAIN}"
        return "a film (MP4 or MOV): export one frame as PNG"
    if data.startswith(b"PK\x03\x04"):
        return _name_archive(data)
    if b"<svg" in data[:1000]:
        return f"an SVG drawing: {_PLAIN}"
    return None


def _name_archive(data: bytes) -> str:
    """Name the document in a ZIP file, by the member that says what it is."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()[:_MOST_MEMBERS]
            kind = archive.open("mimetype").read(100) if "mimetype" in names else b""
    except Exception:  # a damaged archive raises nearly every type there is
        names, kind = [], data[30:200]  # the first member's name and content, uncompressed by convention
    if b"image/openraster" in kind:
        return f"an OpenRaster document (ORA): {_LAYERED}"
    if b"application/x-krita" in kind or "maindoc.xml" in names:
        return f"a Krita document (KRA): {_LAYERED}"
    if "Document.archive" in names:
        return f"a Procreate document: {_LAYERED}"
    if any(name.endswith(".npy") for name in names):
        return "a NumPy archive, not a picture"
    return "a ZIP archive: unpack it"

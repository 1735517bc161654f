"""Formats that toonkit does not read are named, with what to export."""

import io
import zipfile

import numpy as np
import pytest

from toonkit import ToonkitError, load_image


def archive(**members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as writer:
        for name, content in members.items():
            writer.writestr(name, content)
    return file.getvalue()


def arrays():
    file = io.BytesIO()
    np.savez(file, normals=np.zeros(3))
    return file.getvalue()


def media(major, *others):
    content = b"ftyp" + major + b"\0\0\0\0" + b"".join(others)
    return (len(content) + 4).to_bytes(4, "big") + content + b"\0\0\0\x08mdat"


KRITA = archive(**{"mimetype": "application/x-krita", "maindoc.xml": "<DOC/>"})
LAYERED = [
    pytest.param(b"8BPS\0\1" + b"\0" * 40, r"Photoshop document \(PSD or PSB\): export .* PNG", id="PSD"),
    pytest.param(
        archive(mimetype="image/openraster"), r"OpenRaster document \(ORA\): export .* PNG", id="ORA"
    ),
    pytest.param(KRITA, r"Krita document \(KRA\): export .* PNG", id="KRA"),
    pytest.param(KRITA[: len(KRITA) // 2], r"Krita document \(KRA\)", id="half a KRA"),
]


@pytest.mark.parametrize(("content", "named"), LAYERED)
def test_a_mask_is_no_layered_document(tmp_path, content, named):
    path = tmp_path / "mask"
    path.write_bytes(content)
    with pytest.raises(ToonkitError, match=f"mask must be a PNG, .* picture; got .*mask, (an? )?.*{named}"):
        load_image(np.ones((9, 9, 3)), mask=path)


@pytest.mark.parametrize(
    ("content", "named"),
    [
        pytest.param(media(b"avif", b"mif1", b"miaf"), "an AVIF picture: export it as PNG", id="AVIF"),
        pytest.param(media(b"mif1", b"avif"), "an AVIF picture", id="AVIF by its compatible brand"),
        pytest.param(media(b"heic", b"mif1"), "a HEIC picture: export it as PNG", id="HEIC"),
        pytest.param(media(b"isom", b"mp41"), "a film", id="MP4"),
        pytest.param(b"v/1\x01" + b"\2\0\0\0" * 4, "OpenEXR picture: .* linear light", id="EXR"),
        pytest.param(b"gimp xcf v011\0" + b"\0" * 20, r"GIMP document \(XCF\)", id="XCF"),
        pytest.param(b"%PDF-1.7\n", "PDF document", id="PDF"),
        pytest.param(b"<?xml version='1.0'?><svg></svg>", "SVG drawing: export it as PNG", id="SVG"),
        pytest.param(arrays(), "a NumPy archive, not a picture", id="npz"),
        pytest.param(archive(readme="text"), "a ZIP archive", id="ZIP"),
        pytest.param(b"PK\x03\x04" + b"\0" * 40, "a ZIP archive", id="damaged ZIP"),
    ],
)
def test_a_file_of_another_format_is_named(tmp_path, content, named):
    path = tmp_path / "drawing"
    path.write_bytes(content)
    with pytest.raises(
        ToonkitError, match=f"must be a PNG, WebP, .* picture; got .*drawing, (an? )?.*{named}"
    ):
        load_image(path)

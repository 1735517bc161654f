"""What Pillow does not tell of a PNG file: its depth, what its colors mean, and its 16-bit samples."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit.model.color_space import DISPLAY_P3, REC2020, SRGB, Chromaticities, ColorSpace

SIGNATURE = b"\x89PNG\r\n\x1a\n"

_USUAL_GAMMA = 1 / 2.2
_GAMMA_TOLERANCE = 0.05  # relative; browsers, too, read gammas nearer to the usual one as sRGB
_GAMMA_RANGE = (0.1, 5.0)
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}  # by color type
_TRANSPARENT_BYTES = {0: 2, 2: 6}  # length of tRNS by color type
_PASSES = ((0, 8, 0, 8), (0, 8, 4, 8), (4, 8, 0, 4), (0, 4, 2, 4), (2, 4, 0, 2), (0, 2, 1, 2), (1, 2, 0, 1))
_PIECE = 1 << 20

_CODED_PRIMARIES = {1: SRGB, 9: REC2020, 12: DISPLAY_P3}
_CODED_EXPONENTS = {4: 2.2, 5: 2.8, 8: 1.0, 13: None}  # ITU-T H.273: gamma 2.2, 2.8, linear, sRGB


@dataclass(frozen=True)
class PngHeader:
    """
    The first chunk of a PNG file.

    Attributes
    ----------
    width, height : int
        Pixels.
    bits : int
        Bits a sample.
    kind : int
        Color type: 0 gray, 2 RGB, 3 palette, 4 gray and alpha, 6 RGB and alpha.
    interlaced : bool
        True if its pixels come in seven passes.
    """

    width: int
    height: int
    bits: int
    kind: int
    interlaced: bool


def read_header(data: bytes) -> PngHeader | None:
    """Return the header of a PNG file, None if it has none that makes sense."""
    if len(data) < 33 or data[12:16] != b"IHDR":
        return None
    width, height, bits, kind, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    if kind not in _CHANNELS or interlaced > 1:
        return None
    return PngHeader(width, height, bits, kind, bool(interlaced))


def declared_space(data: bytes, profile: bytes | None) -> ColorSpace:
    """Find what a PNG file says its colors mean: the first of cICP, its ICC profile, sRGB, and gAMA with cHRM; else sRGB."""
    chunks: dict[bytes, bytes] = {}
    for name, content, _ in _chunks(data):
        if name == b"IDAT":
            break
        if name in (b"cICP", b"sRGB", b"gAMA", b"cHRM"):
            chunks.setdefault(name, content)
    if len(coded := chunks.get(b"cICP", b"")) == 4:
        return _coded_space(*coded)
    if profile or b"sRGB" in chunks:
        return ColorSpace(profile=profile)
    exponent: float | None = None
    primaries: Chromaticities = SRGB
    if len(chunks.get(b"gAMA", b"")) == 4:
        gamma = struct.unpack(">I", chunks[b"gAMA"])[0] / 100_000
        if not _GAMMA_RANGE[0] <= gamma <= _GAMMA_RANGE[1]:
            return ColorSpace(remark=f"its gamma of {gamma:g} is ignored, the colors are read as sRGB")
        if abs(gamma / _USUAL_GAMMA - 1) > _GAMMA_TOLERANCE:
            exponent = 1 / gamma
    if len(chunks.get(b"cHRM", b"")) == 32:
        x0, y0, x1, y1, x2, y2, x3, y3 = (value / 100_000 for value in struct.unpack(">8I", chunks[b"cHRM"]))
        primaries = (x0, y0, x1, y1, x2, y2, x3, y3)
    return ColorSpace(exponent=exponent, primaries=primaries)


def decode_deep_png(data: bytes, header: PngHeader) -> NDArray[np.unsignedinteger[Any]]:
    """Decode a PNG file of sixteen bits a sample, which Pillow would cut to eight, as uint16 (H, W, 1..4)."""
    import imagecodecs  # noqa: PLC0415  # its compiled codecs load slowly, and few pictures need them

    samples: NDArray[np.unsignedinteger[Any]] = imagecodecs.png_decode(_plain(data, header))
    return samples[..., None] if samples.ndim == 2 else samples


def _coded_space(primaries: int, transfer: int, matrix: int, full: int) -> ColorSpace:
    if primaries in _CODED_PRIMARIES and transfer in _CODED_EXPONENTS and matrix == 0 and full == 1:
        return ColorSpace(exponent=_CODED_EXPONENTS[transfer], primaries=_CODED_PRIMARIES[primaries])
    coded = f"{primaries}-{transfer}-{matrix}-{full}"
    return ColorSpace(remark=f"its color space (cICP {coded}) is ignored, the colors are read as sRGB")


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes, bytes]]:
    """Yield name, content and all bytes of each whole chunk."""
    at = len(SIGNATURE)
    while at + 12 <= len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        end = at + 12 + length
        if end > len(data):
            return
        yield data[at + 4 : at + 8], data[at + 8 : end - 4], data[at:end]
        at = end


def _plain(data: bytes, header: PngHeader) -> bytes:
    """Leave out all that does not bear on the samples: libpng prints what is odd about the rest."""
    kept, packed = [SIGNATURE], []
    for name, content, whole in _chunks(data):
        if name in (b"IHDR", b"IDAT", b"IEND"):
            kept.append(whole)
        elif name == b"tRNS" and len(content) == _TRANSPARENT_BYTES.get(header.kind):
            kept.append(_chunk(name, content))
        if name == b"IDAT":
            packed.append(content)
        elif packed:
            break
    raw_size = _raw_size(header)
    if _unpacks_to(packed, raw_size):
        return b"".join(kept)
    # More than the picture needs, which libpng would print: what it needs is packed anew.
    unpacker = zlib.decompressobj()
    raw = unpacker.decompress(b"".join(packed), raw_size)
    before = [whole for whole in kept if whole[4:8] not in (b"IDAT", b"IEND")]
    return b"".join([*before, _chunk(b"IDAT", zlib.compress(raw, 1)), _chunk(b"IEND", b"")])


def _chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def _raw_size(header: PngHeader) -> int:
    """Bytes of the unpacked samples: a filter byte before each row of each pass."""
    pixel = _CHANNELS[header.kind] * 2
    if not header.interlaced:
        return header.height * (1 + header.width * pixel)
    size = 0
    for first_row, row_step, first_column, column_step in _PASSES:
        rows = -(-(header.height - first_row) // row_step)
        columns = -(-(header.width - first_column) // column_step)
        if rows > 0 and columns > 0:
            size += rows * (1 + columns * pixel)
    return size


def _unpacks_to(packed: list[bytes], size: int) -> bool:
    """Tell whether packed samples end where the picture does, or too soon, which libpng raises as an error."""
    unpacker = zlib.decompressobj()
    found = 0
    for piece in packed:
        rest = piece
        while rest:
            found += len(unpacker.decompress(rest, _PIECE))
            if found > size:
                return False
            rest = unpacker.unconsumed_tail
        if unpacker.eof and (unpacker.unused_data or piece is not packed[-1]):
            return False
    return True

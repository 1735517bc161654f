"""PNG files of sixteen bits: whatever is odd about them, nothing but toonkit speaks of it."""

import io
import zlib

import imagecodecs
import numpy as np
import pytest

from tests.png_chunks import chunk
from toonkit import ToonkitError
from toonkit.model.decoding import read_pixels

SAMPLES = np.random.default_rng(0).integers(0, 65536, (9, 11, 4), dtype=np.uint16)
WHOLE = imagecodecs.png_encode(SAMPLES)
HEADER, REST = WHOLE[:33], WHOLE[33:]
RAW = b"".join(b"\0" + row.astype(">u2").tobytes() for row in SAMPLES)


END = chunk(b"IEND", b"")
PACKED = zlib.compress(RAW)

ODD = {
    "a damaged profile": HEADER + chunk(b"iCCP", b"x\0\0abc") + REST,
    "a damaged text": HEADER + chunk(b"tEXt", b"a\0b", damaged=True) + REST,
    "a transparent color beside alpha": HEADER + chunk(b"tRNS", b"\0" * 6) + REST,
    "too many samples": HEADER + chunk(b"IDAT", zlib.compress(RAW + b"more")) + END,
    "bytes after the samples": HEADER + chunk(b"IDAT", PACKED + b"more") + END,
    "a chunk too many": HEADER + chunk(b"IDAT", PACKED) + chunk(b"IDAT", b"more") + END,
    "no end": HEADER + chunk(b"IDAT", PACKED),
}


@pytest.mark.parametrize("what", ODD)
def test_odd_files_are_read_without_a_line_of_the_decoder(what, capfd):
    try:
        pixels = read_pixels("source", io.BytesIO(ODD[what]))
    except ToonkitError:
        assert what in ("a damaged profile", "a damaged text")  # Pillow refuses them
    else:
        assert pixels.color == pytest.approx(SAMPLES[..., :3] / 65535, abs=1e-12)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("cut", [40, 60, len(WHOLE) // 2, len(WHOLE) - 20])
def test_truncated_files_are_refused_without_a_line_of_the_decoder(cut, capfd):
    with pytest.raises(ToonkitError, match="source must be a "):
        read_pixels("source", io.BytesIO(WHOLE[:cut]))
    assert capfd.readouterr() == ("", "")


def test_the_transparent_color_of_a_deep_file_is_kept():
    rgb = np.ascontiguousarray(SAMPLES[..., :3])
    rgb[3, 4] = (1, 2, 3)
    data = imagecodecs.png_encode(rgb)
    pixels = read_pixels("source", io.BytesIO(data[:33] + chunk(b"tRNS", b"\0\1\0\2\0\3") + data[33:]))
    assert (pixels.alpha == 0).nonzero() == (np.array([3]), np.array([4]))

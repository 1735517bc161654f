"""TIFF files: the right page, bounded sizes, and floats that are not colors from 0 to 1."""

import io
import struct
import tracemalloc
import warnings
import zlib

import numpy as np
import pytest
import tifffile
from PIL import Image

from tests.png_chunks import linear_profile
from toonkit import ToonkitError, load_image
from toonkit._validation import ToonkitWarning
from toonkit.model.decoding import read_pixels

HEIGHT, WIDTH = 40, 56
ROWS, COLUMNS = np.indices((HEIGHT, WIDTH))
PAINTED = np.stack([COLUMNS * 4, ROWS * 6, ROWS + COLUMNS], axis=-1).astype(np.uint8)


def written(*pages):
    file = io.BytesIO()
    with tifffile.TiffWriter(file) as writer:
        for samples, options in pages:
            writer.write(samples, **{"photometric": "rgb", "metadata": None, **options})
    file.seek(0)
    return file


def read(file):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return read_pixels("source", file)


THUMBNAIL = np.ascontiguousarray(PAINTED[::4, ::4])


@pytest.mark.parametrize("scale", [np.uint8(1), np.uint16(257)])
@pytest.mark.parametrize("marked", [True, False])
def test_a_thumbnail_before_the_picture_is_left_out(marked, scale):
    first = (THUMBNAIL * scale, {"subfiletype": 1} if marked else {})
    assert read(written(first, (PAINTED * scale, {}))).color == pytest.approx(PAINTED / 255)


def test_a_picture_within_the_page_of_its_thumbnail_is_found():
    file = io.BytesIO()
    with tifffile.TiffWriter(file) as writer:
        writer.write(THUMBNAIL, photometric="rgb", subifds=1, subfiletype=1, metadata=None)
        writer.write(PAINTED, photometric="rgb", metadata=None)
    file.seek(0)
    assert read(file).color == pytest.approx(PAINTED / 255)


@pytest.mark.parametrize(
    "second",
    [PAINTED[::-1], PAINTED[:-1], np.zeros((600, 900, 3), np.uint8)],
    ids=["of its size", "of nearly its size", "large and of another shape"],
)
def test_of_several_pages_the_first_counts(second):
    first = np.ascontiguousarray(np.tile(PAINTED, (7, 8, 1)))
    assert read(written((first, {}), (np.ascontiguousarray(second), {}))).color == pytest.approx(first / 255)


def test_a_damaged_second_page_does_no_harm():
    content = bytearray(written((PAINTED, {}), (PAINTED, {})).getvalue())
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        second = file.pages[1].offset
    content[second + 2 : second + 40] = b"\xff" * 38
    assert read(io.BytesIO(content)).color == pytest.approx(PAINTED / 255)


@pytest.mark.parametrize(
    "options",
    [
        {"compression": "zlib"},
        {"compression": "lzw", "predictor": True},
        {"tile": (32, 32)},
        {"planarconfig": "separate"},
    ],
    ids=str,
)
def test_eight_bits_are_read_however_they_are_packed(options, capfd):
    samples = PAINTED
    if "planarconfig" in options:
        samples = np.ascontiguousarray(np.moveaxis(PAINTED, -1, 0))
    assert read(written((samples, options))).color == pytest.approx(PAINTED / 255)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("mode", ["1", "L", "P", "LA", "RGBA", "CMYK"])
@pytest.mark.parametrize("compression", [None, "tiff_lzw"])
def test_every_mode_that_pillow_writes_is_read_as_pillow_reads_it(mode, compression):
    picture = Image.fromarray(np.dstack([PAINTED, np.full((HEIGHT, WIDTH), 99, np.uint8)])).convert(
        mode if mode != "CMYK" else "RGB"
    )
    if mode == "CMYK":
        picture = picture.convert("CMYK")
    file = io.BytesIO()
    picture.save(file, "TIFF", compression=compression)
    file.seek(0)
    assert read(file).color == pytest.approx(np.asarray(picture.convert("RGB")) / 255)


def test_a_jpeg_within_a_tiff_is_read():
    file = io.BytesIO()
    Image.fromarray(PAINTED).save(file, "TIFF", compression="jpeg", quality=95)
    file.seek(0)
    assert np.abs(read(file).color - PAINTED / 255).mean() < 3 / 255


@pytest.mark.parametrize("value", [b"upside down", b"\xff\xfe", b""])
def test_an_orientation_of_text_says_nothing(value):
    file = written((PAINTED, {"extratags": [(274, "s", 0, value, True)]}))
    assert read(file).color == pytest.approx(PAINTED / 255)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("layout", [{"rowsperstrip": 40}, {"rowsperstrip": 8}, {"tile": (16, 16)}], ids=str)
def test_a_picture_with_a_part_too_short_is_refused(kind, layout):
    with pytest.raises(ToonkitError, match="complete, undamaged"):
        read(_with_one_part_cut(written((PAINTED.astype(kind), {"compression": "zlib", **layout}))))


def _with_one_part_cut(file):
    """The same file, its last strip or tile packed anew with a fifth of its bytes."""
    content = bytearray(file.getvalue())
    with tifffile.TiffFile(file) as tiff:
        page = tiff.pages[0]
        at, count = page.dataoffsets[-1], page.databytecounts[-1]
    raw = zlib.decompress(content[at : at + count])
    packed = zlib.compress(raw[: len(raw) // 5])
    assert len(packed) <= count
    content[at : at + len(packed)] = packed
    return io.BytesIO(content)


# Floats


def test_floats_without_a_profile_are_read_as_srgb_and_a_warning_says_so():
    with pytest.warns(ToonkitWarning, match="float TIFF; it has no color profile and is read as sRGB"):
        pixels = read_pixels("source", written(((PAINTED / 255).astype(np.float32), {})))
    assert pixels.color == pytest.approx(PAINTED / 255, abs=1e-6)


def test_floats_of_linear_light_are_converted_by_their_profile():
    linear = np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
    pixels = read(written((linear, {"iccprofile": linear_profile()})))
    assert pixels.color == pytest.approx(np.full((HEIGHT, WIDTH, 3), 0.7354), abs=1.5 / 255)


@pytest.mark.parametrize("top", [255, 65535])
def test_whole_floats_beyond_one_are_divided_by_their_white(top):
    samples = np.round(PAINTED / 255 * top).astype(np.float32)
    samples[0, 0] = top
    with pytest.warns(ToonkitWarning, match=f"divided by {top};"):
        color = read_pixels("source", written((samples, {}))).color
    assert color == pytest.approx(samples / top)


@pytest.mark.parametrize(("full", "name"), [(255, "255"), (1, "1")])
def test_their_alpha_may_count_to_either(full, name):
    samples = np.dstack([PAINTED.astype(np.float32), np.full((HEIGHT, WIDTH), full, np.float32)])
    with pytest.warns(ToonkitWarning, match="divided by 255"):
        pixels = read_pixels("source", written((samples, {"extrasamples": ["unassalpha"]})))
    assert (pixels.alpha == 1).all()


@pytest.mark.parametrize(
    ("factor", "advice"), [(0.97, "divide them by 255"), (0.02, "tone map them"), (1e6, "tone map them")]
)
def test_floats_of_unknown_white_are_refused(factor, advice):
    samples = (PAINTED * np.float32(factor)).astype(np.float32)
    with pytest.raises(ToonkitError, match=rf"must have colors in \[0, 1\] .*{advice}.*values up to"):
        read_pixels("source", written((samples, {})))


def test_the_overshoot_of_a_resize_is_clipped():
    samples = (PAINTED / 255 * 1.1 - 0.02).astype(np.float32)
    with pytest.warns(ToonkitWarning, match="read as sRGB"):
        color = read_pixels("source", written((samples, {}))).color
    assert color == pytest.approx(np.clip(samples, 0, 1))


# Bounds


def header(*entries):
    """A TIFF file of tags (number, type, value) and nothing else."""
    tags = b"".join(struct.pack("<HHII", number, kind, 1, value) for number, kind, value in sorted(entries))
    return b"II*\0" + struct.pack("<IH", 8, len(entries)) + tags + b"\0" * 64


def declared(width, height, samples, *more):
    entries = {256: width, 257: height, 258: 16, 259: 1, 262: 2, 273: 64, 277: samples, 278: height, 279: 64}
    return header(*((number, 4, value) for number, value in {**entries, **dict(more)}.items()))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (declared(8192, 8192, 65535), "at most 5 samples a pixel .*TIFF of 65535"),
        (declared(512, 512, 8), "at most 5 samples a pixel .*TIFF of 8"),
        (declared(2**31, 2**31, 3), "scale the picture down"),
        (declared(64, 64, 3, (259, 8), (322, 2**20), (323, 2**20), (324, 64), (325, 64)), "in tiles of"),
        (declared(64, 64, 3, (32997, 10_000)), "flat; got a TIFF of 10000 slices"),
        (
            declared(64, 64, 3, (262, 8)),
            "must be gray, RGB, CMYK or of a palette if it is a TIFF; got CIELAB",
        ),
        (declared(64, 64, 3, (339, 2)), "unsigned or float samples if it is a TIFF; got int16"),
        (declared(8192, 8192, 3), "complete, undamaged"),
    ],
)
def test_what_a_small_file_declares_is_checked_before_memory_is_taken(content, reason, capfd):
    tracemalloc.start()
    try:
        with pytest.raises(ToonkitError, match=reason):
            load_image(io.BytesIO(content))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 2**26
    assert capfd.readouterr() == ("", "")

"""Color spaces that files declare: applied, or ignored with a word; never applied to what is no color."""

import io
import struct
import warnings

import imagecodecs
import numpy as np
import pytest
from PIL import Image, ImageCms

from tests.png_chunks import chunk, gamma, linear_profile
from toonkit import load_image
from toonkit._validation import ToonkitWarning
from toonkit.model.decoding import read_pixels
from toonkit.model.luminance import linear_to_srgb

SHAPE = (6, 6)
EVERYWHERE = np.ones(SHAPE, dtype=bool)
STEP = 1 / 255


def png(color, *chunks, bits=8):
    """A PNG of one color with further chunks after its header."""
    picture = np.broadcast_to(np.asarray(color, dtype=f"uint{bits}"), (*SHAPE, len(color)))
    data = imagecodecs.png_encode(np.ascontiguousarray(picture))
    return io.BytesIO(data[:33] + b"".join(chunk(*one) for one in chunks) + data[33:])


def primaries(*values):
    return b"cHRM", struct.pack(">8I", *(round(value * 100_000) for value in values))


def coded(*values):
    return b"cICP", bytes(values)


STANDARD = primaries(0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06)
ADOBE = primaries(0.3127, 0.3290, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06)


def color_of(file):
    return load_image(file, mask=EVERYWHERE).color[0, 0]


@pytest.mark.parametrize("bits", [8, 16])
def test_linear_light_of_one_half_is_painted_as_188(bits):
    half = round((2**bits - 1) / 2)
    assert color_of(png([half] * 3, gamma(1.0), bits=bits)) == pytest.approx([188 * STEP] * 3, abs=STEP)


def test_a_gamma_of_1_8_is_brighter_than_the_usual_one():
    expected = float(linear_to_srgb((128 / 255) ** 1.8))
    assert color_of(png([128] * 3, gamma(1 / 1.8))) == pytest.approx([expected] * 3, abs=1e-4)


@pytest.mark.parametrize(
    "chunks",
    [[], [gamma(0.45455)], [gamma(0.45455), STANDARD], [(b"sRGB", b"\0"), gamma(1.0)], [coded(1, 13, 0, 1)]],
    ids=["none", "gamma of sRGB", "its primaries", "sRGB before gamma", "coded sRGB"],
)
def test_what_says_srgb_changes_nothing(chunks):
    assert color_of(png([200, 100, 50], *chunks)) == pytest.approx(
        [200 / 255, 100 / 255, 50 / 255], abs=1e-12
    )


def test_alpha_is_no_color():
    alpha = read_pixels("source", png([128, 128, 128, 64], gamma(1.0))).alpha
    assert alpha == pytest.approx(np.full(SHAPE, 64 / 255))


def test_wide_primaries_make_colors_more_saturated_and_leave_gray_alone():
    red, green, blue = color_of(png([100, 180, 100], gamma(0.45455), ADOBE)) * 255
    assert red < 90
    assert green == pytest.approx(180, abs=3)
    assert blue == pytest.approx(97, abs=4)
    assert color_of(png([128] * 3, gamma(0.45455), ADOBE)) == pytest.approx([128 / 255] * 3, abs=1e-4)


def test_coded_primaries_agree_with_those_in_numbers():
    p3 = primaries(0.3127, 0.3290, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06)
    assert color_of(png([200, 90, 60], coded(12, 13, 0, 1))) == pytest.approx(
        color_of(png([200, 90, 60], p3))
    )


def test_coded_linear_light_is_converted():
    assert color_of(png([128] * 3, coded(1, 8, 0, 1))) == pytest.approx([188 * STEP] * 3, abs=STEP)


def test_a_profile_counts_although_its_name_says_srgb():
    linear = linear_profile()
    description = ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(linear))).strip()
    named = "sRGB linear".ljust(len(description))[: len(description)]
    linear = linear.replace(description.encode("utf-16-be"), named.encode("utf-16-be"))
    assert ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(linear))).startswith("sRGB")
    file = io.BytesIO()
    Image.new("RGB", SHAPE, (128, 128, 128)).save(file, "PNG", icc_profile=linear)
    file.seek(0)
    assert color_of(file) == pytest.approx([188 * STEP] * 3, abs=1.5 * STEP)


def test_a_gray_picture_may_have_an_rgb_profile():
    file = io.BytesIO()
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Image.new("L", SHAPE, 128).save(file, "PNG", icc_profile=srgb)
    file.seek(0)
    assert color_of(file) == pytest.approx([128 / 255] * 3)


@pytest.mark.parametrize(
    ("chunks", "what"),
    [
        ([gamma(0.00002)], "gamma of 2e-05 is ignored"),
        ([(b"gAMA", b"\xff\xff\xff\xff")], "gamma of 42949.7 is ignored"),
        ([primaries(*[0.3] * 8)], "primaries span no colors and are ignored"),
        ([primaries(*[0] * 8)], "primaries span no colors and are ignored"),
        ([coded(9, 16, 0, 1)], "cICP 9-16-0-1"),
    ],
)
def test_what_cannot_be_applied_is_ignored_with_one_line(chunks, what):
    with pytest.warns(ToonkitWarning, match=what) as said:
        color = color_of(png([200, 100, 50], *chunks))
    assert color == pytest.approx([200 / 255, 100 / 255, 50 / 255], abs=1e-12)
    assert len(said) == 1
    assert "\n" not in str(said[0].message)


@pytest.mark.parametrize("chunks", [[gamma(1.0)], [coded(9, 16, 0, 1)], [ADOBE]])
def test_numbers_are_never_converted(chunks):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pixels = read_pixels("source", png([200, 100, 50], *chunks), colors=False)
    assert pixels.color[0, 0] == pytest.approx([200 / 255, 100 / 255, 50 / 255], abs=1e-12)


def test_a_mask_is_no_color():
    soft = load_image(np.ones((*SHAPE, 3)), mask=png([128] * 3, gamma(1.0)))
    assert soft.alpha == pytest.approx(np.full(SHAPE, 128 / 255))

"""Normal maps that are a little off, read the wrong way round, or no normal maps."""

import io
import warnings

import imagecodecs
import numpy as np
import pytest
from PIL import Image

from tests.png_chunks import chunk, gamma, linear_profile
from toonkit import NormalField, ToonkitError
from toonkit._validation import ToonkitWarning
from toonkit.model.luminance import linear_to_srgb
from toonkit.model.normal_map_check import check_normal_map
from toonkit.model.normal_map_loading import read_normal_map
from toonkit.model.normals import decode_normal_map, encode_normal_map

ROWS, COLUMNS = np.indices((60, 70))
X, Y = (COLUMNS - 34.5) / 25, (29.5 - ROWS) / 25
BALL = X**2 + Y**2 < 1
Z = np.sqrt(np.maximum(1 - X**2 - Y**2, 0))
NORMALS = NormalField(np.stack([X, Y, Z], axis=-1), BALL)
MAP = encode_normal_map(NORMALS)


def said(colors, **options):
    """The field, and what the warnings say."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        field = decode_normal_map(colors, BALL, **options)
    assert all(one.category is ToonkitWarning for one in found)
    return field, [str(one.message) for one in found]


def test_a_good_map_is_read_without_a_word():
    assert said(MAP)[1] == []
    assert said(encode_normal_map(NORMALS, bits=16, green="directx"), green="directx")[1] == []


def test_pixels_off_unit_length_are_renormalized_and_counted():
    colors = MAP.copy()
    colors[20, 20:30] = 127 + (colors[20, 20:30].astype(int) - 127) * 6 // 10
    colors[30, 30] = 255
    field, messages = said(colors)
    share = 11 / BALL.sum()
    (message,) = messages
    assert message.startswith(
        f"colors: 11 of {BALL.sum()} vectors ({share:.2%}) are more than 10% off unit length"
    )
    assert message.endswith("the worst 1.73 long; they are renormalized")
    assert np.linalg.norm(field.compact, axis=1) == pytest.approx(1)
    assert (field.vectors[20, 25] * NORMALS.vectors[20, 25]).sum() > np.cos(np.deg2rad(2))


@pytest.mark.parametrize(("written", "read"), [("opengl", "directx"), ("directx", "opengl")])
def test_a_green_axis_that_disagrees_with_the_silhouette_is_named(written, read):
    _, messages = said(encode_normal_map(NORMALS, green=written), green=read)
    assert len(messages) == 1
    assert f'read as "{read}"' in messages[0]
    assert f'try green="{written}"' in messages[0]


def test_a_mirrored_red_axis_is_named():
    colors = MAP.copy()
    colors[..., 0] = 255 - colors[..., 0]
    assert "red is mirrored" in said(colors)[1][0]


def test_a_flat_map_says_nothing_of_its_axes():
    assert said(np.broadcast_to(np.array([128, 128, 255], np.uint8), MAP.shape))[1] == []


def test_the_check_measures_what_the_warnings_say():
    check = check_normal_map(np.where(BALL[..., None], NORMALS.vectors, 0) * [1, -1, 1], BALL)
    assert check.outward == pytest.approx((1, -1), abs=0.1)
    assert check.mirrored == (False, True)
    assert (check.off_unit, check.pixels, check.problem) == (0, BALL.sum(), "")


@pytest.mark.parametrize(
    ("colors", "reason"),
    [
        pytest.param(
            127.5 + (MAP - 127.5) * 0.65, "most about 0.65 long: a color-managed render", id="darkened"
        ),
        pytest.param(127.5 + (MAP - 127.5) * 1.2, "a color-managed render", id="brightened"),
        pytest.param(
            np.dstack([MAP[..., :2], np.where(BALL, Z, 1) * 255]), "blue holds z from 0 to 1", id="z from 0"
        ),
        pytest.param(
            np.random.default_rng(0).integers(0, 256, MAP.shape), "a picture of something else", id="noise"
        ),
    ],
)
def test_what_cannot_be_a_normal_map_is_refused_with_the_reason(colors, reason):
    with pytest.raises(ToonkitError, match=f"colors must encode unit vectors .* off unit length.*{reason}"):
        decode_normal_map(np.clip(np.round(colors), 0, 255).astype(np.uint8), BALL)


def test_an_srgb_curve_over_a_map_is_refused():
    curved = np.round(linear_to_srgb(MAP / 255) * 255).astype(np.uint8)
    with pytest.raises(ToonkitError, match="must encode unit vectors"):
        decode_normal_map(curved, BALL)


# Files


def test_a_map_is_read_from_a_file_whose_alpha_is_the_mask(tmp_path):
    Image.fromarray(np.dstack([MAP, BALL * np.uint8(255)])).save(tmp_path / "map.png")
    field = read_normal_map(tmp_path / "map.png")
    assert np.array_equal(field.mask, BALL)
    assert field.compact == pytest.approx(decode_normal_map(MAP, BALL).compact, abs=1e-12)


def test_no_color_space_applies_to_a_map():
    data = imagecodecs.png_encode(np.ascontiguousarray(MAP))
    declared = io.BytesIO(data[:33] + chunk(*gamma(1.0)) + data[33:])
    with_profile = io.BytesIO()
    Image.fromarray(MAP).save(with_profile, "PNG", icc_profile=linear_profile())
    for file in (declared, io.BytesIO(with_profile.getvalue())):
        assert read_normal_map(file, mask=BALL).compact == pytest.approx(
            decode_normal_map(MAP, BALL).compact, abs=1e-12
        )


def test_an_opaque_map_without_a_mask_is_refused():
    with pytest.raises(
        ToonkitError, match="source must be transparent around the object, or come with a mask"
    ):
        read_normal_map(MAP)


def test_a_mask_of_another_size_is_refused():
    with pytest.raises(ToonkitError, match="mask must have the size of colors"):
        read_normal_map(MAP, mask=BALL[:-1])

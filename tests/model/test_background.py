"""A plain background is found, cut away, and taken out of the outline."""

import io

import numpy as np
import pytest
from PIL import Image, ImageDraw

from toonkit import ToonkitError, load_image
from toonkit.model.background import MIN_FRAME_SHARE, TOLERANCE, cut_out, find_background

SIZE = 96
FINER = 8
BODY, SHADOW = (0.9, 0.55, 0.2), (0.5, 0.2, 0.25)
WHITE, TEAL = (1.0, 1.0, 1.0), (0.2, 0.55, 0.6)


def disc(background=WHITE, *, radius=36, smooth=True):
    """A disc of two tones before a background, and its coverage; averaged from a finer grid if smooth."""
    finer = FINER if smooth else 1
    row, column = (np.indices((SIZE * finer, SIZE * finer)) + 0.5) / finer
    inside = (row - 48.2) ** 2 + (column - 47.6) ** 2 < radius**2
    paint = np.where((row + column < 92)[..., None], BODY, SHADOW)
    fine = np.where(inside[..., None], paint, background)
    blocks = (SIZE, finer, SIZE, finer)
    return fine.reshape(*blocks, 3).mean(axis=(1, 3)), inside.reshape(blocks).mean(axis=(1, 3))


def as_jpeg(color, quality):
    file = io.BytesIO()
    Image.fromarray(np.round(color * 255).astype(np.uint8)).save(file, "JPEG", quality=quality)
    file.seek(0)
    return file


@pytest.mark.parametrize("background", [WHITE, TEAL, (0.0, 0.0, 0.0)])
def test_a_plain_background_and_its_color_are_found(background):
    color, coverage = disc(background)
    found = find_background(color)
    assert found.color == pytest.approx(background)
    assert found.noise == 0
    assert found.mask[coverage == 0].all()
    assert not found.mask[coverage > 0.3].any()


@pytest.mark.parametrize("background", [WHITE, TEAL])
def test_the_outline_is_where_half_a_pixel_is_covered(background):
    color, coverage = disc(background)
    image = load_image(color)
    # Three in a hundred outline pixels: where the two tones meet at the rim, three colors mix.
    assert (image.mask != (coverage >= 0.5)).sum() <= 0.03 * (2 * np.pi * 36)
    # 0.02: coverage is read back from colors, whose neighbor is itself a little mixed at places.
    assert np.abs(image.alpha - coverage).mean() < 0.02 * 2 * np.pi * 36 / SIZE**2


@pytest.mark.parametrize("background", [WHITE, TEAL])
def test_no_background_color_is_left_on_the_object(background):
    image = load_image(disc(background)[0])
    color = image.color[image.mask]
    to_paint = np.minimum(*(np.abs(color - paint).max(axis=1) for paint in (BODY, SHADOW)))
    between = (
        np.abs(np.cross(color - BODY, np.subtract(SHADOW, BODY))).max(axis=1) < 0.02
    )  # tones meet inside, too
    assert ((to_paint < TOLERANCE) | between).mean() > 0.995


def test_a_hard_edged_picture_keeps_every_pixel():
    color, coverage = disc(smooth=False)
    image = load_image(color)
    assert (image.mask == (coverage == 1)).all()
    assert (image.alpha == coverage).all()
    assert (image.color[image.mask] == color[image.mask]).all()


def test_a_light_band_along_a_hard_edge_is_not_taken_for_mixed():
    color = np.ones((40, 40, 3))
    color[8:32, 8:32] = (1.0, 0.9, 0.6)  # on the line from white to the inner color
    color[10:30, 10:30] = (1.0, 0.8, 0.2)
    image = load_image(color)
    assert image.mask.sum() == 24 * 24
    assert (image.alpha[image.mask] == 1).all()


def test_background_color_enclosed_by_the_object_stays_object():
    color, coverage = disc(smooth=False)
    color[40:50, 40:50] = WHITE
    image = load_image(color)
    assert (image.mask == (coverage == 1)).all()
    assert (image.color[45, 45] == 1).all()


def test_a_hole_open_to_the_frame_is_background():
    color, _ = disc(smooth=False)
    color[40:50, 40:] = WHITE
    assert not load_image(color).mask[45, 45:].any()


def test_a_thin_dark_line_is_kept_dark():
    picture = Image.new("RGB", (96 * FINER, 96 * FINER), "white")
    draw = ImageDraw.Draw(picture)
    draw.ellipse(
        [16 * FINER, 16 * FINER, 80 * FINER, 80 * FINER], fill=(255, 220, 60), outline=(20, 20, 30), width=14
    )
    image = load_image(np.asarray(picture.resize((96, 96), Image.Resampling.BOX)))
    rim = image.mask & ~np.roll(image.mask, 1, axis=0)
    assert image.color[rim].mean(axis=0) == pytest.approx(np.array([20, 20, 30]) / 255, abs=0.12)


@pytest.mark.parametrize("quality", [75, 90])
@pytest.mark.parametrize("background", [WHITE, TEAL])
def test_jpeg_noise_does_not_move_the_outline(background, quality):
    color, coverage = disc(background)
    image = load_image(as_jpeg(color, quality))
    expected = coverage >= 0.5
    # JPEG blurs hues over blocks of two pixels: an outline half a pixel off on average is as good as it gets.
    assert (image.mask != expected).sum() < 0.5 * 2 * np.pi * 36
    assert not image.alpha[:6].any()


def test_most_of_the_frame_is_enough():
    color, coverage = disc(smooth=False)
    color[60:, 30:66] = BODY  # the object goes on below the picture: 36 of 380 frame pixels
    mask = load_image(color).mask
    assert mask[-1, 30:66].all()
    assert mask[coverage == 1].all()


@pytest.mark.parametrize(
    "color",
    [
        pytest.param(np.random.default_rng(1).random((32, 32, 3)), id="noise"),
        pytest.param(np.repeat(np.indices((32, 32))[1][..., None] / 31, 3, axis=-1), id="gradient"),
        pytest.param(
            np.where(np.indices((32, 32))[:1].transpose(1, 2, 0) < 16, WHITE, TEAL), id="half and half"
        ),
    ],
)
def test_without_a_plain_background_the_message_says_what_to_do(color):
    with pytest.raises(ToonkitError) as refusal:
        load_image(color)
    assert "mask=" in str(refusal.value)
    assert "transparent background" in str(refusal.value)
    assert f"{MIN_FRAME_SHARE:.0%}" in str(refusal.value)


@pytest.mark.parametrize("dots", [0, 1, 8])
def test_a_picture_of_nearly_nothing_is_refused(dots):
    color = np.ones((32, 32, 3))
    color[10, 10 : 10 + dots] = BODY
    with pytest.raises(ToonkitError, match=f"at least 9 pixels; got {dots} pixels that differ"):
        cut_out(color)


def test_an_opaque_alpha_channel_does_not_hide_the_background():
    color, coverage = disc(smooth=False)
    opaque = np.concatenate([color, np.ones((SIZE, SIZE, 1))], axis=-1)
    assert (load_image(opaque).mask == (coverage == 1)).all()


def test_a_mask_overrides_the_background():
    color, _ = disc(smooth=False)
    everything = np.ones((SIZE, SIZE), dtype=bool)
    assert load_image(color, mask=everything).mask.all()

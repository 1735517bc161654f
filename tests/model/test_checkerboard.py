"""A checkerboard of transparency painted into a picture is recognized, and nothing else is."""

import io

import numpy as np
import pytest
from PIL import Image

from toonkit import ToonkitError, load_image
from toonkit.model.checkerboard import has_checkerboard

ROWS, COLUMNS = np.indices((150, 130))
DISC = np.hypot(ROWS - 75, COLUMNS - 65) < 50


def painted(square, dark, bright, *, background=None):
    board = np.where((ROWS // square + COLUMNS // square) % 2 == 0, bright, dark).astype(np.uint8)
    around = board if background is None else background
    color = np.where(DISC, 90 + COLUMNS // 2, around)
    return np.stack([color, np.where(DISC, 60, around), np.where(DISC, 150, around)], axis=-1).astype(
        np.uint8
    )


@pytest.mark.parametrize("square", [5, 8, 16, 30])
@pytest.mark.parametrize(("dark", "bright"), [(204, 255), (239, 255), (102, 153)])
def test_a_checkerboard_around_the_object_is_named(square, dark, bright):
    with pytest.raises(
        ToonkitError, match=r"source must be transparent .* checkerboard painted around the object"
    ):
        load_image(painted(square, dark, bright))


@pytest.mark.parametrize("quality", [75, 90])
def test_a_jpeg_of_a_checkerboard_is_one(quality):
    file = io.BytesIO()
    Image.fromarray(painted(8, 204, 255)).save(file, "JPEG", quality=quality)
    with pytest.raises(ToonkitError, match="checkerboard"):
        load_image(file.seek(0) or file)


def test_an_enlarged_checkerboard_is_one():
    picture = Image.fromarray(painted(8, 204, 255)).resize((195, 225), Image.Resampling.BICUBIC)
    with pytest.raises(ToonkitError, match="checkerboard"):
        load_image(np.asarray(picture))


def test_a_mask_says_where_the_object_is_on_a_checkerboard():
    assert (load_image(painted(8, 204, 255), mask=DISC).mask == DISC).all()


@pytest.mark.parametrize(
    "background",
    [
        np.full(ROWS.shape, 255),
        np.where(COLUMNS // 8 % 2 == 0, 204, 255),
        np.where(ROWS // 8 % 2 == 0, 204, 255),
        np.where((ROWS + COLUMNS) // 8 % 2 == 0, 204, 255),
        np.where(ROWS < 75, 204, 255),
        200 + ROWS // 4,
        np.random.default_rng(0).choice([204, 255], ROWS.shape),
    ],
    ids=["plain", "upright stripes", "level stripes", "slanted stripes", "horizon", "gradient", "noise"],
)
def test_other_backgrounds_are_no_checkerboard(background):
    assert not has_checkerboard(painted(8, 0, 0, background=background) / 255)


def test_a_board_of_colors_is_no_transparency():
    color = painted(8, 204, 255)
    color[..., 2] //= 2
    assert not has_checkerboard(color / 255)

"""The contact sheet shows the input, the normals and one tile a light."""

import numpy as np
import pytest

from toonkit import ToonkitError, light_direction
from toonkit.export.contact_sheet import STANDARD_LIGHTS, contact_sheet

RIGHT, LEFT = light_direction(0, 20), light_direction(180, 20)
TILE, GAP, MARGIN = 264, 18, 28


def tile(sheet, index):
    """The middle of a tile in the first row."""
    left = MARGIN + index * (TILE + GAP)
    return sheet[MARGIN + 20 : MARGIN + TILE - 20, left + 20 : left + TILE - 20].astype(float)


def test_a_sheet_is_an_opaque_8_bit_picture(analysis):
    sheet = contact_sheet(analysis, [RIGHT])
    assert sheet.dtype == np.uint8
    assert sheet.ndim == 3
    assert sheet.shape[2] == 3


def test_by_default_eight_tiles_stand_in_two_rows(analysis):
    assert len(STANDARD_LIGHTS) == 6
    sheet = contact_sheet(analysis)
    assert sheet.shape[1] == 2 * MARGIN + 4 * TILE + 3 * GAP
    assert 2 * TILE < sheet.shape[0] < 3 * TILE


@pytest.mark.parametrize(("count", "columns"), [(1, 3), (2, 4), (7, 4)])
def test_columns_follow_the_number_of_lights(analysis, count, columns):
    sheet = contact_sheet(analysis, [RIGHT] * count)
    assert sheet.shape[1] == 2 * MARGIN + columns * TILE + (columns - 1) * GAP


def test_each_tile_is_bright_where_its_light_comes_from(analysis):
    sheet = contact_sheet(analysis, [RIGHT, LEFT])
    half = tile(sheet, 2).shape[1] // 2
    center = slice(60, -60)  # rows of the ball, away from the icon in the corner
    right, left = tile(sheet, 2)[center], tile(sheet, 3)[center]
    assert right[:, half:].mean() > right[:, :half].mean() + 20
    assert left[:, half:].mean() < left[:, :half].mean() - 20


def test_the_normals_tile_is_blue_in_the_middle(analysis):
    sheet = contact_sheet(analysis, [RIGHT])
    middle = tile(sheet, 1)[100:124, 100:124].mean(axis=(0, 1))
    assert middle == pytest.approx([128, 128, 255], abs=12)


@pytest.mark.parametrize("lights", [[], [(0, 0, -1)], [(0, 0, 0)], [(1, 2)]])
def test_a_sheet_needs_lights(analysis, lights):
    with pytest.raises(ToonkitError, match="lights must"):
        contact_sheet(analysis, lights)

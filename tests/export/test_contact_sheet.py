"""The contact sheet shows the input, what it was taken apart into, and one tile a light."""

import numpy as np
import pytest

from toonkit import ToonkitError, light_direction
from toonkit.export.contact_sheet import MATTE, STANDARD_LIGHTS, contact_sheet
from toonkit.model.label_colors import label_picture

RIGHT, LEFT = light_direction(0, 20), light_direction(180, 20)
TILE, GAP, MARGIN = 264, 18, 28


CAPTION = 34


def tile(sheet, index, row=0):
    """The middle of a tile."""
    left, top = MARGIN + index * (TILE + GAP), MARGIN + row * (TILE + CAPTION + GAP)
    return sheet[top + 20 : top + TILE - 20, left + 20 : left + TILE - 20].astype(float)


def ball(sheet, index, row):
    """The light's ball in the upper right corner of a tile, without its outline, and the brightness of each pixel."""
    left, top = MARGIN + index * (TILE + GAP) + TILE - 31, MARGIN + row * (TILE + CAPTION + GAP) + 31
    down, along = np.indices((31, 31)) - 15
    within = np.hypot(down, along) < 15
    return sheet[top - 15 : top + 16, left - 15 : left + 16][within].astype(int)


def test_a_sheet_is_an_opaque_8_bit_picture(analysis):
    sheet = contact_sheet(analysis, [RIGHT])
    assert sheet.dtype == np.uint8
    assert sheet.ndim == 3
    assert sheet.shape[2] == 3


def test_by_default_twelve_tiles_fill_three_rows(analysis):
    assert len(STANDARD_LIGHTS) == 8
    assert contact_sheet(analysis).shape == contact_sheet(analysis, [RIGHT] * 8).shape


@pytest.mark.parametrize(("count", "rows"), [(1, 2), (4, 2), (5, 3), (9, 4)])
def test_four_lights_stand_in_a_row_below_the_first(analysis, count, rows):
    sheet = contact_sheet(analysis, [RIGHT] * count)
    assert sheet.shape[1] == 2 * MARGIN + 4 * TILE + 3 * GAP
    assert rows * TILE < sheet.shape[0] < (rows + 1) * TILE


def test_each_tile_is_bright_where_its_light_comes_from(analysis):
    sheet = contact_sheet(analysis, [RIGHT, LEFT])
    half = tile(sheet, 0, 1).shape[1] // 2
    center = slice(60, -60)  # rows of the ball, away from the icon in the corner
    right, left = tile(sheet, 0, 1)[center], tile(sheet, 1, 1)[center]
    assert right[:, half:].mean() > right[:, :half].mean() + 20
    assert left[:, half:].mean() < left[:, :half].mean() - 20


def test_the_normals_tile_is_blue_in_the_middle(analysis):
    sheet = contact_sheet(analysis, [RIGHT])
    middle = tile(sheet, 3)[100:124, 100:124].mean(axis=(0, 1))
    assert middle == pytest.approx([128, 128, 255], abs=12)


def test_the_base_color_is_the_brightest_one_everywhere(analysis):
    middle = tile(contact_sheet(analysis, [RIGHT]), 2)[60:-60, 60:-60]
    assert middle == pytest.approx(np.broadcast_to(analysis.color_map.colors[-1] * 255, middle.shape), abs=1)


def test_one_material_is_shown_as_its_color_map_on_a_ball(analysis):
    shown = tile(contact_sheet(analysis, [RIGHT]), 1)[60:-60, 60:-60]
    colors = {tuple(color) for color in shown.reshape(-1, 3).round()}
    assert {tuple(color) for color in (analysis.color_map.colors * 255).round()} <= colors


def test_several_materials_are_shown_in_a_color_each(several):
    shown = tile(contact_sheet(several, [RIGHT]), 1)
    colors = {tuple(color) for color in shown.reshape(-1, 3)}
    labels = label_picture(np.arange(several.materials.count)[None])[0, :, :3]
    assert {tuple(color) for color in labels} <= colors


def test_a_light_is_shown_on_a_gray_ball_where_there_are_several_materials(analysis, several):
    one, many = (ball(contact_sheet(each, [RIGHT]), 0, 1) for each in (analysis, several))
    darkest = round(MATTE.colors[0, 0] * 255)
    assert np.ptp(many, axis=1).min() == 0
    assert np.median(np.ptp(many, axis=1)) == 0  # all but the dot of the light
    assert many.min() == pytest.approx(darkest, abs=2)
    assert np.median(np.ptp(one, axis=1)) > 50


def test_pixel_art_keeps_its_pixels(analysis):
    shown = tile(contact_sheet(analysis, [RIGHT]), 0)[60:-60, 60:-60]
    drawn = analysis.image.to_rgba()[analysis.image.mask, :3]
    assert {tuple(c) for c in shown.reshape(-1, 3)} <= {tuple(c) for c in drawn.astype(float)}


@pytest.mark.parametrize("lights", [[], [(0, 0, -1)], [(0, 0, 0)], [(1, 2)]])
def test_a_sheet_needs_lights(analysis, lights):
    with pytest.raises(ToonkitError, match="lights must"):
        contact_sheet(analysis, lights)

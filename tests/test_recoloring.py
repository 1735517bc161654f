"""A drawing whose materials have got other tones."""

import numpy as np
import pytest

from tests.analytic import LIGHT, TWO_TONE, ellipse, painted
from tests.pixel_art import LIGHT as SPRITE_LIGHT
from tests.pixel_art import sprite
from toonkit import ToneRamp, ToonImage, ToonkitError, analyze, load_analysis, relight
from toonkit.relighting import relight_pixels

DARK, LIT = "#203060", "#90c0f0"
BLUE = ToneRamp([DARK, LIT], [0.3], [0.02])
NEW_LIGHT = (30, 40)
LOW_LIGHT = (135, -40)  # behind the picture: it leaves the badge in shadow


@pytest.fixture(scope="module")
def analysis():
    """A ball in two tones, with a flat red badge on it."""
    shape = ellipse(40, 40)
    color = painted(shape.normals, TWO_TONE).color
    y, x = (
        np.mgrid[: shape.mask.shape[0], : shape.mask.shape[1]]
        - np.array(shape.mask.shape).reshape(2, 1, 1) / 2
    )
    color[np.hypot(x - 8, y - 8) < 9] = (0.8, 0.1, 0.2)
    color += 0.002 * np.random.default_rng(0).normal(size=color.shape)  # or it would be pixel art
    found = analyze(ToonImage(np.clip(color, 0, 1), shape.mask), LIGHT)
    assert found.materials.flat.tolist() == [False, True]
    assert found.palette is None
    return found


def inside(picture, analysis, material):
    """Colors of a material's pixels a little away from the others."""
    mixed = np.zeros(analysis.image.mask.shape, bool)
    mixed[analysis.drawing.places(analysis.drawing.mixed.pixels)] = True
    return picture.color[(analysis.materials.labels == material) & ~mixed]


def test_a_recolored_material_is_relit_in_its_new_tones(analysis):
    relit = relight(analysis.recolored({0: BLUE}), NEW_LIGHT)
    colors = inside(relit, analysis, 0)
    away = np.linalg.norm(colors[:, None] - BLUE.colors, axis=-1).min(axis=1)
    # But for the few pixels within the step itself.
    assert np.quantile(away, 0.97) < 0.01
    assert np.allclose(inside(relit, analysis, 1), inside(relight(analysis, NEW_LIGHT), analysis, 1))


def test_under_its_own_light_the_drawing_is_recolored_too(analysis):
    own = inside(relight(analysis.recolored({0: BLUE}), analysis.light), analysis, 0)
    assert np.quantile(np.linalg.norm(own[:, None] - BLUE.colors, axis=-1).min(axis=1), 0.97) < 0.01


def test_texture_stays_on_other_tones():
    shape = ellipse(40, 28)
    grain = 0.02 * np.random.default_rng(0).normal(size=(*shape.mask.shape, 1))
    color = np.clip(painted(shape.normals, TWO_TONE).color + grain, 0, 1)
    grained = analyze(ToonImage(color, shape.mask), LIGHT)
    one = ToneRamp(["#557799"])
    shown = relight(grained.recolored({0: one}), grained.light).color[shape.mask] - one.colors
    assert np.corrcoef(shown[:, 0], grain[shape.mask, 0])[0, 1] > 0.8


def test_a_flat_material_takes_its_lit_tone(analysis):
    green = ToneRamp(["#104010", "#40a040"], [0.2])
    recolored = analysis.recolored({1: green})
    # But for the grain.
    assert np.allclose(inside(relight(recolored, analysis.light), analysis, 1), green.colors[1], atol=0.02)
    assert recolored.materials.flat.tolist() == [False, True]


@pytest.mark.parametrize("material", [0, 1])
def test_what_stays_flat_is_relit_as_drawn(analysis, material):
    ramp = ToneRamp.of(analysis.materials.color_maps[material])
    flat = analysis.recolored(
        {material: ToneRamp(ramp.tones, ramp.thresholds, ramp.softness, stays_flat=True)}
    )
    drawn, relit = (
        inside(picture, analysis, material) for picture in (analysis.image, relight(flat, LOW_LIGHT))
    )
    assert np.allclose(relit, drawn, atol=0.5 / 255)
    assert not np.allclose(inside(relight(analysis, LOW_LIGHT), analysis, material), drawn, atol=0.02)


def test_nothing_else_about_the_analysis_changes(analysis):
    recolored = analysis.recolored({0: BLUE})
    assert recolored.normals is analysis.normals
    assert recolored.drawing is analysis.drawing
    assert np.array_equal(recolored.intervals().lower, analysis.intervals().lower, equal_nan=True)
    again = recolored.recolored({})
    assert np.array_equal(relight(again, NEW_LIGHT).to_rgba(), relight(analysis, NEW_LIGHT).to_rgba())


def test_base_color_and_picture_have_the_new_tones(analysis):
    recolored = analysis.recolored({0: BLUE})
    base = inside(recolored.base_color, analysis, 0)
    assert np.quantile(np.linalg.norm(base - BLUE.colors[1], axis=-1), 0.9) < 0.01
    assert np.linalg.norm(inside(recolored.picture, analysis, 0) - BLUE.colors[0], axis=-1).min() < 0.01


def test_single_pixels_are_relit_as_whole_pictures(analysis):
    recolored = analysis.recolored({0: BLUE})
    pixels = np.arange(0, analysis.drawing.grid.size, 7)
    light = np.array([0.6, 0.0, 0.8])
    (colors,) = relight_pixels(recolored, [light], pixels)
    assert np.array_equal(colors, relight(recolored, light).color[analysis.image.mask][pixels])


def test_new_tones_are_saved_and_loaded(analysis, tmp_path):
    recolored = analysis.recolored({0: BLUE})
    recolored.save(tmp_path / "blue.npz")
    found = load_analysis(tmp_path / "blue.npz")
    assert np.array_equal(found.materials.color_maps[0].colors, recolored.materials.color_maps[0].colors)
    difference = relight(found, NEW_LIGHT).to_rgba().astype(int) - relight(recolored, NEW_LIGHT).to_rgba()
    assert (np.abs(difference) > 1).mean() < 1e-3  # as archives round normals
    back = relight(found.recolored({}), analysis.light).to_rgba().astype(int)
    assert np.abs(back - analysis.image.to_rgba()).max() <= 1


def test_in_pixel_art_new_tones_replace_the_palette_of_their_material_alone():
    art = analyze(sprite(48), SPRITE_LIGHT)
    ramp = ToneRamp(["#184018", "#40a040", "#a0f080"], [0.3, 0.7])
    relit = relight(art.recolored({0: ramp}), NEW_LIGHT)
    green = {tuple(color) for color in np.round(ramp.colors * 255).astype(int).tolist()}
    first = relit.to_rgba()[art.materials.labels == 0]
    assert np.mean([tuple(color[:3].tolist()) in green for color in first]) > 0.5
    others = art.materials.labels > 0
    assert np.array_equal(relit.to_rgba()[others], relight(art, NEW_LIGHT).to_rgba()[others])


@pytest.mark.parametrize("ramps", [{2: BLUE}, {-1: BLUE}])
def test_there_must_be_such_a_material(analysis, ramps):
    with pytest.raises(ToonkitError, match="ramps must be of materials 0 to 1"):
        analysis.recolored(ramps)

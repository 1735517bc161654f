"""Light of a color, and from all sides."""

import numpy as np
import pytest

from tests.analytic import LIGHT, TWO_TONE, ellipse, painted
from tests.pixel_art import sprite
from toonkit import ColorMap, Materials, ToonAnalysis, ToonkitError, analyze, light_direction, relight
from toonkit.export.animation import write_orbit
from toonkit.export.layers import split_layers
from toonkit.illustration.light_color import LightColor
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear

SIDE = light_direction(20, 30)
AMBER = (1.0, 0.7, 0.3)
SHADOW, LIT = TWO_TONE.colors[[0, -1]]


def analyzed(color_map):
    shape = ellipse(40, 40)
    return ToonAnalysis(
        image=painted(shape.normals, color_map, alpha=shape.coverage),
        method="toonkit",
        light=LIGHT,
        normals=shape.normals,
        initial_normals=shape.normals,
        materials=Materials.single(shape.mask, color_map),
    )


@pytest.fixture(scope="module")
def ball():
    return analyzed(TWO_TONE)


@pytest.fixture(scope="module")
def several():
    """A ball in an outline: two shaded materials, a highlight, a flat detail."""
    return analyze(sprite(64), (130, 45))


@pytest.mark.parametrize("light", [LIGHT, SIDE])
@pytest.mark.parametrize("palette", [True, False])
def test_white_light_from_one_side_is_what_it_was_to_the_last_bit(several, light, palette):
    plain = relight(several, light, palette=palette)
    same = relight(several, light, palette=palette, light_color=[1, 1, 1], ambient=0)
    assert np.array_equal(same.color, plain.color, equal_nan=True)


@pytest.mark.parametrize("light", [LIGHT, SIDE])
def test_the_lit_side_takes_the_color_of_the_light_and_the_shadow_keeps_its_own(ball, light):
    plain, tinted = relight(ball, light).color, relight(ball, light, light_color=AMBER).color
    dark, bright = (np.abs(plain - tone).max(axis=-1) < 1e-9 for tone in (SHADOW, LIT))
    assert dark.any()
    assert bright.any()
    shadow, lit = srgb_to_linear(SHADOW), srgb_to_linear(LIT)
    expected = linear_to_srgb(shadow + srgb_to_linear(AMBER) * (lit - shadow))
    assert np.allclose(tinted[bright], expected, atol=1e-9)
    assert np.allclose(tinted[dark], plain[dark], rtol=0, atol=1e-12)


def test_without_any_light_there_is_nothing_but_shadow(ball):
    dark = relight(ball, SIDE, light_color=[0, 0, 0])
    assert np.abs(dark.color[dark.mask] - SHADOW).max() < 1e-9


def test_ambient_light_fills_shadows_by_its_share_in_linear_light(ball):
    plain, filled = relight(ball, SIDE).color, relight(ball, SIDE, ambient=0.25).color
    dark, bright = (np.abs(plain - tone).max(axis=-1) < 1e-9 for tone in (SHADOW, LIT))
    expected = linear_to_srgb(0.75 * srgb_to_linear(SHADOW) + 0.25 * srgb_to_linear(LIT))
    assert np.allclose(filled[dark], expected, atol=1e-9)
    assert np.allclose(filled[bright], plain[bright], rtol=0, atol=1e-12)


def test_light_from_all_sides_alone_leaves_no_shadow(ball):
    flat = relight(ball, SIDE, ambient=1.0)
    assert np.abs(flat.color[flat.mask] - LIT).max() < 1e-9
    assert np.abs(flat.fringe_colors - LIT).max() < 1e-9


def test_a_rim_light_from_behind_has_the_color_of_the_light(ball):
    plain, tinted = (relight(ball, (90, -30), **kw).color for kw in ({}, {"light_color": (0.2, 0.5, 1.0)}))
    rim = np.abs(plain - LIT).max(axis=-1) < 1e-9
    assert 0 < rim.sum() < 0.2 * ball.image.mask.sum()
    assert (tinted[rim, 2] == plain[rim, 2]).all()
    assert (tinted[rim, 0] < plain[rim, 0] - 0.2).all()


@pytest.mark.parametrize("palette", [True, False])
def test_line_art_keeps_its_color(several, palette):
    ink = several.drawing.ink_coverage == 1
    assert ink.any()
    tinted = relight(several, SIDE, palette=palette, light_color=AMBER, ambient=0.5)
    assert np.abs(tinted.color - several.image.color)[ink].max() < 1e-12


def test_a_highlight_takes_the_color_of_the_light(several):
    shine = several.drawing.places(several.drawing.mixed.pixels[several.drawing.mixed.highlit])
    tinted = relight(several, several.light, light_color=(1.0, 0.2, 0.2)).color[shine]
    assert len(tinted)
    assert (tinted[:, 1] < 0.6).all()


def test_tinting_turns_each_color_of_pixel_art_into_one_other(several):
    plain, tinted = relight(several, SIDE), relight(several, SIDE, light_color=AMBER)
    inside = plain.mask
    kind = np.dstack([plain.color, several.materials.labels, several.drawing.ink_coverage])[inside]
    before = np.unique(kind, axis=0)
    after = np.unique(np.concatenate([kind, tinted.color[inside]], axis=1).round(12), axis=0)
    assert len(after) == len(before)
    assert (tinted.color != plain.color)[inside].any()


def test_pixel_art_under_ambient_light_keeps_its_palette(several):
    own = {tuple(color) for color in several.image.color[several.image.mask].tolist()}
    filled = relight(several, SIDE, ambient=0.6)
    assert {tuple(color) for color in filled.color[filled.mask].tolist()} <= own
    assert not np.array_equal(filled.to_rgba(), relight(several, SIDE).to_rgba())


def test_what_is_darker_than_the_shadow_has_no_light_to_tint():
    ramp = ColorMap([[0.5, 0.5, 0.5], [0.9, 0.9, 0.9]])
    colors = np.array([[0.3, 0.3, 0.3], [0.7, 0.7, 0.7], [1.0, 1.0, 1.0]])
    LightColor.of(np.zeros(3), 0.0, (ramp,)).tinted(colors, np.zeros(3, int))
    assert np.allclose(colors[:, 0], [0.3, 0.5, 0.5])


def test_layers_and_orbits_take_the_same_options(several, tmp_path):
    options = {"light_color": AMBER, "ambient": 0.3}
    layers = split_layers(several, SIDE, **options)
    assert np.array_equal(layers.picture, relight(several, SIDE, **options).to_rgba())
    assert np.abs(layers.compose().astype(int) - layers.picture).max() <= 1
    write_orbit(several, tmp_path / "plain.png", frames=2)
    write_orbit(several, tmp_path / "tinted.png", frames=2, **options)
    assert (tmp_path / "plain.png").read_bytes() != (tmp_path / "tinted.png").read_bytes()


@pytest.mark.parametrize("color", [[1, 1], [1.1, 1, 1], [-0.1, 0, 0], [np.nan, 1, 1], "red"])
def test_a_light_color_that_is_none_is_refused(ball, color):
    with pytest.raises(ToonkitError, match="light_color"):
        relight(ball, SIDE, light_color=color)


@pytest.mark.parametrize("ambient", [-0.1, 1.1, np.nan, "much"])
def test_ambient_light_beyond_its_range_is_refused(ball, ambient):
    with pytest.raises(ToonkitError, match="ambient must be a number from 0 to 1"):
        relight(ball, SIDE, ambient=ambient)

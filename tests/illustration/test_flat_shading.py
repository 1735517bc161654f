"""Shadows of materials in one tone are derived from those of the others."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit import ColorMap
from toonkit.illustration.flat_shading import PLAIN, derive_shadow
from toonkit.model.luminance import srgb_to_linear
from toonkit.model.oklab import oklab_to_srgb, srgb_to_oklab


def two_tones(lit: tuple[float, float, float], darkness: float, edge: float) -> ColorMap:
    """Return a map whose shadow has a share of the lit tone's OKLab lightness and chroma, up to an illumination."""
    bright = srgb_to_oklab(lit)
    dark = np.clip(oklab_to_srgb(darkness * bright), 0, 1)
    where = np.linspace(-1, 1, 801)[:, None]
    return ColorMap(np.where(where < edge, dark, lit))


def test_the_shadow_is_the_median_of_those_of_the_shaded_materials_by_area():
    maps = [two_tones((0.9, 0.5, 0.4), share, edge) for share, edge in ((0.85, 0.1), (0.8, 0.3), (0.65, 0.5))]
    shadow = derive_shadow(maps, np.array([0.2, 0.5, 0.1]))
    assert shadow.darkness == pytest.approx(0.8, abs=0.01)
    assert shadow.edge == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize(
    ("maps", "areas"),
    [
        ([], []),
        ([two_tones((0.9, 0.5, 0.4), 0.7, 0.2)], [0.01]),
        ([two_tones((0.9, 0.5, 0.4), 0.99, 0.2)], [0.9]),
    ],
    ids=["none shaded", "a detail", "hardly a step"],
)
def test_without_examples_the_shadow_is_plain(maps, areas):
    assert derive_shadow(maps, np.array(areas)) is PLAIN


def test_a_plain_shadow_on_white_multiplies_light():
    dark = PLAIN.color_map(np.ones(3)).colors[0]
    assert np.allclose(srgb_to_linear(dark), [0.55, 0.52, 0.66], atol=1e-6)


@pytest.mark.parametrize("lit", [(1, 1, 1), (0.9, 0.2, 0.2), (0.2, 0.3, 0.8), (0.1, 0.1, 0.1), (0, 0, 0)])
def test_a_derived_map_ends_in_the_lit_tone_and_never_gets_darker(lit):
    colors = PLAIN.color_map(np.array(lit, float)).colors
    assert np.allclose(colors[-1], lit, atol=1e-6)
    assert (np.diff(srgb_to_oklab(colors)[:, 0]) > -1e-6).all()


def test_a_shadow_so_deep_that_it_would_swallow_a_drawing_is_held_back():
    shadow = derive_shadow([two_tones((0.9, 0.5, 0.4), 0.2, 0.9)], np.array([1.0]))
    assert (shadow.darkness, shadow.edge) == (0.6, 0.6)

from dataclasses import replace

import numpy as np
import pytest

from tests.analytic import LIGHT, TWO_TONE, ellipse, painted
from toonkit import (
    ColorMap,
    Materials,
    ToonAnalysis,
    ToonImage,
    ToonkitError,
    analyze,
    color_rmse,
    light_direction,
    load_image,
    relight,
    shade,
)
from toonkit.relighting import detail_weight


@pytest.fixture(scope="module")
def analysis():
    shape = ellipse(40, 28)
    clean = painted(shape.normals, TWO_TONE, alpha=shape.coverage)
    grain = 0.03 * np.random.default_rng(0).normal(size=(*shape.mask.shape, 1))
    return analyze(ToonImage(np.clip(clean.color + grain, 0, 1), shape.mask, alpha=shape.coverage), LIGHT)


def test_at_the_original_light_the_input_returns_unchanged(analysis):
    again = relight(analysis, analysis.light)
    # Sixteen digits, but for the rounding of c - M + M.
    assert np.allclose(again.color[again.mask], analysis.image.color[again.mask], atol=1e-12)
    assert np.array_equal(again.to_rgba(), analysis.image.to_rgba())


def test_without_detail_the_model_paints(analysis):
    light = light_direction(20, 40)
    model = shade(analysis.normals, light, analysis.color_map)
    # Sixteen digits: L · N is summed in another order.
    painted = relight(analysis, light, keep_detail=False).color
    assert np.allclose(painted, model.color, rtol=0, atol=1e-12, equal_nan=True)


def test_far_from_the_original_light_the_model_takes_over(analysis):
    light = light_direction(-50, 40)
    change = np.abs(analysis.normals.vectors @ light - analysis.illumination)
    kept, model = relight(analysis, light), relight(analysis, light, keep_detail=False)
    far = analysis.image.mask & (change > 0.5)
    assert far.any()
    assert np.abs(kept.color[far] - model.color[far]).max() < 1e-4


def test_a_small_turn_of_the_light_changes_the_picture_little(analysis):
    azimuth = 130
    near, far = (relight(analysis, light_direction(azimuth + turn, 50)) for turn in (1, 10))
    assert 0 < color_rmse(near, analysis.image) < color_rmse(far, analysis.image)


def test_alpha_is_preserved(analysis):
    assert np.array_equal(relight(analysis, [0, 1, 1]).alpha, analysis.image.alpha)


def test_the_fringe_moves_with_the_nearest_object_pixel():
    shape = ellipse(20, 20)
    clean = painted(shape.normals, TWO_TONE, alpha=shape.coverage)
    analysis = analyze(clean, LIGHT)
    relit = relight(analysis, [1, -1, 1])
    touched = ~np.isnan(clean.fringe[..., 0])
    assert touched.any()
    assert not np.isnan(relit.fringe[touched]).any()
    assert np.abs(relit.fringe[touched] - clean.fringe[touched]).max() > 0.2


@pytest.mark.parametrize(
    ("light", "words"), [([0, 0, 0], "zero"), ([0, np.nan, -1], "finite"), ("up", "direction")]
)
def test_a_new_light_that_is_none_is_refused_by_its_name(analysis, light, words):
    with pytest.raises(ToonkitError, match=f"new_light.*{words}"):
        relight(analysis, light)


@pytest.fixture(scope="module")
def ball():
    """A two-tone ball whose shape is exact, and its terminator at L · N = 0.2."""
    shape = ellipse(40, 40)
    return ToonAnalysis(
        image=painted(shape.normals, TWO_TONE),
        method="toonkit",
        light=LIGHT,
        normals=shape.normals,
        initial_normals=shape.normals,
        materials=Materials.single(shape.mask, TWO_TONE),
    )


@pytest.mark.parametrize("elevation", [0, -10, -30, -60, -90])
@pytest.mark.parametrize("azimuth", [0, 90, 225])
def test_a_light_from_behind_paints_the_color_map_of_its_illumination(ball, azimuth, elevation):
    light = light_direction(azimuth, elevation)
    model = shade(ball.normals, light, TWO_TONE)
    relit = relight(ball, (azimuth, elevation), keep_detail=False)
    assert np.allclose(relit.color, model.color, rtol=0, atol=1e-12, equal_nan=True)


def test_from_behind_only_a_rim_toward_the_light_is_lit_and_it_narrows(ball):
    lit = [relight(ball, (90, elevation)).color[..., 0] > 0.9 for elevation in (0, -20, -40, -60)]
    areas = [int(part.sum()) for part in lit]
    assert areas == sorted(areas, reverse=True)
    assert areas[2] > 0
    row, _ = np.nonzero(lit[2])
    assert (
        row.max() < ball.image.shape[0] * 0.4
    )  # all of it at the top, where the surface turns toward the light
    assert not lit[2][ball.image.shape[0] // 2].any()


def test_straight_from_behind_everything_is_in_shadow(ball):
    relit = relight(ball, (0, -90))
    assert np.abs(relit.color[relit.mask] - TWO_TONE.colors[0]).max() < 1e-12


def test_texture_outlasts_a_misplaced_band_edge():
    texture, edge = 3 * 0.02**2, 3 * 0.4**2
    assert detail_weight(0.0, texture) == detail_weight(0.0, edge) == 1.0
    assert detail_weight(0.05, texture) > 0.85
    assert detail_weight(0.05, edge) < 1e-6


@pytest.mark.parametrize("keep_detail", [True, False])
def test_relit_colors_lie_in_the_unit_range_exactly(analysis, keep_detail):
    # At this domain's end the position among the samples comes out 3e-14 beyond the last one.
    steep = ColorMap(np.linspace([0.0, 0.1, 0.0], 1.0, 219) ** 9, (0.09, 0.87))
    materials = replace(analysis.materials, color_maps=(steep,))
    relit = relight(replace(analysis, materials=materials), (40, 50), keep_detail=keep_detail)
    inside = relit.color[relit.mask]
    assert inside.max() == 1
    assert inside.min() >= 0
    load_image(relit.color, mask=relit.mask)

"""Ink in whole drawings: told from shading, taken off before the shape is found, and left as drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from tests.analytic import LIGHT, SOFT, TWO_TONE, Ellipse, ellipse, painted
from toonkit import (
    METHODS,
    ColorMap,
    ToonImage,
    analyze,
    angular_error,
    estimate_light,
    find_materials,
    light_direction,
    relight,
)
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES

BLACK = (0.04, 0.03, 0.05)
DARK = ColorMap([[0.05, 0.04, 0.08]] * 300 + [[0.5, 0.3, 0.4]] * 300 + [[0.95, 0.8, 0.6]] * 400)
"""Its darkest tone is as dark as ink."""

RIMMED = ColorMap([[0.05, 0.04, 0.08]] * 675 + [[0.95, 0.8, 0.6]] * 325)
"""Two tones, of which the dark one begins at an illumination of 0.35."""


def covered(image: ToonImage, share: np.ndarray) -> ToonImage:
    """Draw over a picture with some share of ink at each pixel."""
    share = np.clip(share, 0, 1)[..., None]
    return ToonImage(image.color * (1 - share) + share * np.array(BLACK), image.mask, alpha=image.alpha)


def outlined(image: ToonImage, width: float) -> ToonImage:
    """Draw an anti-aliased line along the inside of the silhouette."""
    return covered(image, width + 1.0 - distance_transform_edt(np.pad(image.mask, 1))[1:-1, 1:-1])


def struck_out(image: ToonImage, shape: Ellipse, width: float = 4.0) -> ToonImage:
    """Draw an anti-aliased line across the middle, from one side of the outline to the other."""
    return covered(image, width / 2 + 0.5 - np.abs(shape.y))


def coverage_of(image: ToonImage) -> np.ndarray:
    return prepare(image).ink_coverage


def has_ink(image: ToonImage) -> bool:
    return bool(coverage_of(image).any())


@pytest.fixture(scope="module")
def ball() -> Ellipse:
    return ellipse(60, 60)


@pytest.mark.parametrize("azimuth", range(0, 360, 60))
@pytest.mark.parametrize("elevation", [15, 50, 70])
@pytest.mark.parametrize(
    "color_map", [SOFT, TWO_TONE, DARK, RIMMED], ids=["soft", "two tones", "dark", "dark rim"]
)
def test_a_ball_has_no_line_art_under_a_light_that_is_not_straight_ahead(ball, color_map, elevation, azimuth):
    image = painted(ball.normals, color_map, light=light_direction(azimuth, elevation))
    assert not has_ink(image)


def test_a_dark_rim_of_even_width_under_a_light_straight_ahead_is_taken_for_an_outline(ball):
    """What no picture can tell apart: the limit that the module names."""
    image = painted(ball.normals, RIMMED, light=light_direction(0, 90))
    assert coverage_of(image).sum() == pytest.approx(np.pi * 60**2 * 0.35**2, rel=0.1)


@pytest.mark.parametrize("name", list(SHAPES))
def test_no_picture_of_the_study_has_line_art(name):
    truth = render_shape(SHAPES[name], 96)
    found = [
        color_map
        for color_map, colors in load_color_maps().items()
        if has_ink(painted(truth.normals, colors, alpha=truth.coverage))
    ]
    assert found == []


@pytest.mark.parametrize("width", [1.5, 3.0, 4.0])
@pytest.mark.parametrize("color_map", [SOFT, TWO_TONE], ids=["soft", "two tones"])
def test_an_outline_is_found_where_it_was_drawn(ball, color_map, width):
    image = outlined(painted(ball.normals, color_map, alpha=ball.coverage), width)
    coverage = coverage_of(image)
    inward = distance_transform_edt(image.mask)
    assert (coverage[image.mask & (inward < width)] > 0.8).all()
    # Next to nothing is given up that no ink touches: soft shading is dark near the silhouette, too.
    assert (coverage[image.mask & (inward > width + 2)] < 0.1).all()


def test_an_even_outline_is_told_from_a_crescent_of_the_same_color(ball):
    image = painted(ball.normals, DARK, light=light_direction(20, 60))
    assert not has_ink(image)
    coverage = coverage_of(outlined(image, 3.0))
    assert np.sum(coverage > 0.9) == pytest.approx(np.pi * (60**2 - 57**2), rel=0.15)


def test_a_line_inside_an_outline_is_found_with_it(ball):
    clean = painted(ball.normals, TWO_TONE, alpha=ball.coverage)
    image = struck_out(outlined(clean, 3.0), ball)
    coverage = coverage_of(image)
    assert (coverage[image.mask & (np.abs(ball.y) < 1.5)] == 1).all()


def test_a_mark_darker_than_all_shading_is_a_flat_material(ball):
    clean = painted(ball.normals, TWO_TONE, alpha=ball.coverage)
    eye = 7.5 - np.hypot(ball.x - 15, ball.y - 10)
    materials = find_materials(covered(clean, eye))
    assert materials.count == 2
    assert materials.flat.tolist() == [False, True]
    assert (materials.labels[eye > 1] == 1).all()


@pytest.mark.parametrize("shape", ["disc", "diamond"])
@pytest.mark.parametrize("line", [0.0, 3.0], ids=["without an outline", "with an outline"])
def test_a_wide_dark_patch_is_paint_all_of_it(ball, shape, line):
    image = outlined(painted(ball.normals, TWO_TONE), line) if line else painted(ball.normals, TWO_TONE)
    aside = (ball.x - 8, ball.y + 5)
    patch = (np.hypot(*aside) if shape == "disc" else np.abs(aside).sum(axis=0)) < 18
    image = ToonImage(np.where(patch[..., None], BLACK, image.color), image.mask)
    assert has_ink(image) == (line > 0.0)
    assert coverage_of(image)[patch].mean() < 0.15  # the corners of a diamond are as narrow as lines


@pytest.mark.parametrize("width", [1.5, 3.0, 5.0])
def test_an_outline_mixed_with_a_white_page_is_found(ball, width):
    image = outlined(painted(ball.normals, TWO_TONE, alpha=ball.coverage), width)
    share = ball.coverage[..., None]
    coverage = coverage_of(ToonImage(image.color * share + 1.0 - share, ball.mask))
    assert coverage.sum() == pytest.approx(np.pi * (60**2 - (60 - width) ** 2), rel=0.25)


def test_what_ink_covers_is_the_paint_beside_it(ball):
    clean = painted(ball.normals, TWO_TONE, alpha=ball.coverage)
    image = outlined(clean, 3.0)
    paint = np.zeros_like(clean.color)
    paint[image.mask] = prepare(image).paint
    apart = np.abs(paint - clean.color).max(axis=-1)
    # Wrong only where a band ends under the line, which goes on straight.
    assert np.mean(apart[image.mask] < 0.02) > 0.99


def test_ink_over_its_own_paint_is_the_drawing(ball):
    image = struck_out(outlined(painted(ball.normals, SOFT), 3.0), ball)
    mixed = prepare(image).mixed
    assert len(mixed.pixels) > 500
    paint = np.ones((len(mixed.pixels), 2, 3))
    assert np.allclose(mixed.over(paint, paint), mixed.drawn, rtol=0, atol=1e-15)


def test_a_silhouette_that_the_frame_cuts_off_on_one_side_shows_no_ink(ball):
    image = outlined(painted(ball.normals, TWO_TONE), 3.0)
    half = ToonImage(image.color[:60], image.mask[:60])
    assert not has_ink(half)


@pytest.mark.parametrize("method", list(METHODS))
def test_an_inked_ball_is_the_ball_to_every_method(ball, method):
    def error(image: ToonImage | PreparedDrawing) -> float:
        return angular_error(METHODS[method](prepare(image), LIGHT).normals, ball.normals).mean

    clean = painted(ball.normals, TWO_TONE, alpha=ball.coverage)
    drawing = struck_out(outlined(clean, 2.5), ball)
    taken_off = error(drawing)
    assert taken_off < error(clean) + 2.5
    overlooked = prepare(drawing)
    overlooked.ink = replace(overlooked.ink, coverage=np.zeros_like(overlooked.ink.coverage))
    # lumo does not look at colors; to the others lines would be grooves.
    assert method == "lumo" or error(overlooked) > taken_off + 1.0


def test_lines_around_a_single_color_leave_that_color(ball):
    image = outlined(ToonImage(np.full((*ball.mask.shape, 3), 0.9), ball.mask, alpha=ball.coverage), 3.0)
    assert has_ink(image)
    assert np.allclose(prepare(image).paint, 0.9)
    assert estimate_light(image).confidence == 0
    relit = relight(analyze(image, LIGHT), light_direction(-50, 40), flat_shading=0)
    assert np.allclose(relit.color, image.color, rtol=0, atol=1e-9, equal_nan=True)


def test_the_light_of_an_inked_ball_is_found(ball):
    image = outlined(painted(ball.normals, SOFT, alpha=ball.coverage), 2.0)
    assert estimate_light(image).light @ LIGHT > np.cos(np.deg2rad(12))


def test_line_art_stays_as_drawn_under_another_light(ball):
    image = struck_out(outlined(painted(ball.normals, TWO_TONE, alpha=ball.coverage), 3.0), ball)
    analysis = analyze(image, LIGHT)
    solid = coverage_of(image) == 1
    relit = relight(analysis, light_direction(-50, 40))
    assert np.array_equal(relit.color[solid], image.color[solid])
    assert np.abs(relit.color - image.color)[image.mask & ~solid].max() > 0.3
    again = relight(analysis, LIGHT)
    # Sixteen digits, but for the rounding of c - M + M.
    assert np.allclose(again.color, image.color, rtol=0, atol=1e-12, equal_nan=True)


def test_pixels_between_ink_and_paint_change_with_the_paint(ball):
    clean = painted(ball.normals, TWO_TONE, alpha=ball.coverage)
    analysis = analyze(outlined(clean, 3.0), LIGHT)
    drawing = analysis.drawing
    mixed = drawing.mixed
    relit = relight(analysis, light_direction(-50, 40), keep_detail=False)
    partly = (mixed.shares[:, 0] > 0.2) & (mixed.shares[:, 0] < 0.8)
    assert partly.sum() > 20
    source = drawing.places(mixed.sources[:, 0])
    change = relit.color[source] - analysis.image.color[source]
    expected = mixed.drawn + mixed.shares[:, :1] * change
    found = relit.color[drawing.places(mixed.pixels)]
    assert np.allclose(found, np.clip(expected, 0, 1), rtol=0, atol=1e-12)


def test_the_model_s_picture_has_the_line_art_on_top(ball):
    image = outlined(painted(ball.normals, TWO_TONE, alpha=ball.coverage), 3.0)
    analysis = analyze(image, LIGHT)
    solid = coverage_of(image) == 1
    assert np.array_equal(analysis.picture.color[solid], image.color[solid])

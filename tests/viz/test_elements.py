"""Elements and scenes: what they show, and what they refuse."""

from __future__ import annotations

import subprocess
import sys

import holoviews as hv
import numpy as np
import pytest

from toonkit import ToonkitError
from toonkit.model.luminance import tone
from toonkit.viz.elements import color_map_fit, color_ramp, error_map, normal_map, picture
from toonkit.viz.scene import height_scene


def test_a_picture_has_square_pixels_and_its_top_row_on_top(ball):
    element = picture(ball.image)
    height, width = ball.image.shape
    assert element.bounds.lbrt() == (0, 0, width, height)
    red = element.dimension_values("R", flat=False)[::-1]  # HoloViews gives rows from the bottom
    np.testing.assert_array_equal(red, ball.image.to_rgba()[..., 0])
    figure = hv.render(element, backend="bokeh")
    assert not figure.axis[0].visible


def test_a_normal_map_is_transparent_outside_the_object(ball):
    alpha = normal_map(ball.normals).dimension_values("A", flat=False)[::-1]
    np.testing.assert_array_equal(alpha > 0, ball.normals.mask)


def test_a_fit_shows_pixels_ramp_and_intervals(ball):
    overlay = color_map_fit(ball)
    points = overlay.Points.I
    ramp = overlay.Curve.I
    assert np.abs(points.dimension_values("illumination")).max() <= 1
    where = ramp.dimension_values("illumination")
    np.testing.assert_allclose(ramp.dimension_values("tone"), tone(ball.color_map(where)))
    bars = overlay.Segments.I
    assert (bars.dimension_values("illumination") <= bars.dimension_values("illumination_end")).all()
    hv.render(overlay, backend="bokeh")


def test_a_fit_shows_the_paint_without_the_line_art(inked_ball):
    shown = color_map_fit(inked_ball).Points.I.dimension_values("tone")
    as_drawn = tone(inked_ball.image.color[inked_ball.image.mask])
    assert np.mean(as_drawn < 0.05) > 0.1
    assert np.mean(shown < 0.05) < 0.01


def test_a_ramp_spans_every_illumination(ball):
    assert color_ramp(ball.color_map).bounds.lbrt() == (-1, 0, 1, 1)


def test_an_error_map_ends_at_the_limit(ball):
    error = np.where(ball.image.mask, 4.0, np.nan)
    element = error_map(error, label="normals", unit="degrees", limit=10)
    figure = hv.render(element, backend="bokeh")
    mapper = figure.renderers[0].glyph.color_mapper
    assert (mapper.low, mapper.high) == (0, 10)


@pytest.mark.parametrize(
    ("error", "limit"), [(np.full((4, 4), np.nan), None), (np.ones((4, 4)), 0.0), (np.ones(4), None)]
)
def test_an_error_map_refuses_what_it_cannot_show(error, limit):
    with pytest.raises(ToonkitError):
        error_map(error, label="normals", unit="degrees", limit=limit)


def test_a_ball_rises_toward_the_viewer_and_its_arrows_point_away_from_its_middle(ball):
    scene = height_scene(ball.normals, ball.image, size=60)
    assert scene.surface.point_data["color"].dtype == np.uint8
    low, high = scene.surface.bounds[4:]
    half_width = (scene.surface.bounds[1] - scene.surface.bounds[0]) / 2
    assert high - low == pytest.approx(half_width, rel=0.25)  # a hemisphere, its steep rim sampled coarsely
    faces_viewer = scene.surface.compute_normals(auto_orient_normals=False, consistent_normals=False)
    assert (faces_viewer.point_data["Normals"][:, 2] > -0.2).mean() > 0.99
    assert scene.arrows.n_points > 0


def test_a_scene_refuses_a_size_without_shape(ball):
    with pytest.raises(ToonkitError, match="size"):
        height_scene(ball.normals, size=4)


def test_toonkit_loads_without_its_pictures():
    heavy = "{'panel', 'holoviews', 'pyvista', 'toonkit.viz'}"
    code = f"import sys, toonkit; assert not {heavy} & set(sys.modules), {heavy} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)

"""Elements and scenes: what they show, and what they refuse."""

from __future__ import annotations

import subprocess
import sys
from base64 import b64decode
from io import BytesIO

import holoviews as hv
import numpy as np
import pytest
from PIL import Image

from toonkit import ToonkitError
from toonkit.model.luminance import tone
from toonkit.viz.choice_cards import ramp_choices
from toonkit.viz.elements import (
    color_map_fit,
    error_map,
    material_place,
    normal_map,
    picture,
)
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


@pytest.mark.parametrize("material", [0, 1])
def test_the_fit_of_a_material_shows_its_own_pixels_and_ramp(harlequin, material):
    overlay = color_map_fit(harlequin, material=material)
    ramp = overlay.Curve.I
    where = ramp.dimension_values("illumination")
    wanted = harlequin.materials.color_maps[material]
    np.testing.assert_allclose(ramp.dimension_values("tone"), tone(wanted(where)))
    shown = {int(color[5:], 16) > int(color[1:3], 16) for color in overlay.Points.I.dimension_values("color")}
    assert shown == {material == 1}  # the first is red, the second blue
    assert len(overlay.Segments.I) > 0


def test_a_flat_material_has_no_intervals(harlequin):
    overlay = color_map_fit(harlequin, material=2)
    assert len(overlay.Points.I) > 0
    assert len(overlay.Segments.I) == 0
    hv.render(overlay, backend="bokeh")


def test_a_material_keeps_its_color_and_the_rest_is_nearly_gray(harlequin):
    element = material_place(harlequin, 1)
    shown = np.dstack([element.dimension_values(name, flat=False)[::-1] for name in "RGBA"]).astype(int)
    drawn = harlequin.image.to_rgba()
    own = harlequin.materials.labels == 1
    np.testing.assert_array_equal(shown[own], drawn[own])
    np.testing.assert_array_equal(shown[..., 3], drawn[..., 3])
    assert np.ptp(shown[~own][:, :3], axis=1).max() < 40
    assert np.ptp(drawn[~own][:, :3], axis=1).max() > 150


@pytest.mark.parametrize("show", [lambda a, k: color_map_fit(a, material=k), material_place])
@pytest.mark.parametrize("material", [-1, 3])
def test_a_material_that_is_none_is_refused(harlequin, show, material):
    with pytest.raises(ToonkitError, match="one of 3 materials"):
        show(harlequin, material)


def test_the_card_of_a_ramp_runs_from_its_darkest_color_to_its_brightest(ball):
    (card,) = ramp_choices({"0": ("100 %", "", ball.color_map)})
    with Image.open(BytesIO(b64decode(card["picture"].split(",")[1]))) as picture:
        ends = np.asarray(picture)[0, [0, -1]] / 255
    np.testing.assert_allclose(ends, ball.color_map([-1, 1]), atol=0.5 / 255)


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

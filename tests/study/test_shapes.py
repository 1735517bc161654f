"""Every shape of the study is a solid that renders well, and the vocabulary of distances is exact where it says so."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import ndimage

from toonkit.study.rendering import MARGIN, RenderedShape, render_shape
from toonkit.study.shapes import BOUND, SHAPES, View
from toonkit.study.solids import distance_fields as d

COMPLEX = {
    *("cat", "rabbit", "mushroom", "teapot", "snowman", "pear", "hand", "fish", "duck", "head", "knot"),
    *("vase", "drapery"),
}
PRIMITIVES = {"sphere", "ellipsoid", "cylinder", "cone", "torus", "rounded_box", "three_box"}
SIZE = 48


@cache
def rendered(name: str) -> RenderedShape:
    return render_shape(SHAPES[name], SIZE)


def test_there_are_seven_primitives_and_thirteen_complex_shapes() -> None:
    kinds = {name: shape.kind for name, shape in SHAPES.items()}
    assert kinds == dict.fromkeys(PRIMITIVES, "primitive") | dict.fromkeys(COMPLEX, "complex")


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_listed_under_its_own_name(name: str) -> None:
    assert SHAPES[name].name == name


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_lies_within_its_bound(name: str) -> None:
    points = np.random.default_rng(0).normal(size=(4000, 3))
    points *= BOUND / np.linalg.norm(points, axis=1, keepdims=True)
    assert SHAPES[name].distance(points).min() > 0


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_has_unit_normals_that_face_the_viewer(name: str) -> None:
    vectors = rendered(name).normals.vectors[rendered(name).mask]
    assert np.abs(np.linalg.norm(vectors, axis=1) - 1).max() < 1e-12  # rounding
    assert vectors[:, 2].min() >= 0


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_one_piece(name: str) -> None:
    labels, _ = ndimage.label(rendered(name).mask, np.ones((3, 3)))
    sizes = np.bincount(labels.ravel())[1:]
    assert sizes.max() / sizes.sum() > 0.99  # at 48 pixels a twig may be cut off by a pixel


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_fills_its_picture_up_to_the_margin(name: str) -> None:
    rows, columns = np.nonzero(rendered(name).mask)
    free = [min(side.min(), SIZE - 1 - side.max()) for side in (rows, columns)]
    # A pixel whose center the outline just misses adds one, and so may a tip thinner than a pixel.
    assert MARGIN * SIZE - 1 <= min(free) <= MARGIN * SIZE + 2
    assert abs(rows.min() + rows.max() - (SIZE - 1)) <= 3
    assert abs(columns.min() + columns.max() - (SIZE - 1)) <= 3


@pytest.mark.parametrize("name", SHAPES)
def test_every_material_of_a_shape_is_seen_and_no_other(name: str) -> None:
    part = rendered(name).part
    assert set(np.unique(part[rendered(name).mask])) == set(range(len(SHAPES[name].materials)))
    assert (part[~rendered(name).mask] == -1).all()


@pytest.mark.parametrize(
    ("distance", "point", "expected"),
    [
        (d.sphere((1, 0, 0), 0.5), (3, 0, 0), 1.5),
        (d.ellipsoid((0, 0, 0), (2, 1, 1)), (0, 3, 0), 2),
        (d.capsule((0, -1, 0), (0, 1, 0), 0.25), (1, 0.5, 0), 0.75),
        (d.capsule((0, -1, 0), (0, 1, 0), 0.25), (0, 2, 0), 0.75),
        (d.rounded_box((0, 0, 0), (1, 1, 1), 0.1), (0, 0, 3), 2),
        (d.rounded_box((0, 0, 0), (1, 1, 1)), (2, 2, 0), np.sqrt(2)),
        (d.rounded_box((0, 0, 0), (1, 1, 1)), (0.75, 0, 0), -0.25),
        (d.torus((0, 0, 0), 1, 0.25), (0, 0, 2), 0.75),
        (d.torus((0, 0, 0), 1, 0.25), (0, 0, 0), 0.75),
        (d.cylinder((0, 0, 0), 0.5, 1), (0, 3, 0), 2),
        (d.cylinder((0, 0, 0), 0.5, 1, 0.1), (2, 0, 0), 1.5),
        (d.capped_cone(0, 1, 1, 0), (0, -2, 0), 2),
        (d.capped_cone(0, 1, 1, 0), (1, 1, 0), np.sqrt(0.5)),
        (d.capped_cone(0, 1, 1, 0), (0, 3, 0), 2),
        (d.union(d.sphere((0, 0, 0), 1), d.sphere((3, 0, 0), 1)), (5, 0, 0), 1),
        (d.smooth_union(0.2, d.sphere((0, 0, 0), 1), d.sphere((3, 0, 0), 1)), (5, 0, 0), 1),
        (d.smooth_subtract(0.2, d.sphere((0, 0, 0), 2), d.sphere((0, 0, 0), 1)), (0.5, 0, 0), 0.5),
        (d.intersect(d.sphere((0, 0, 0), 1), d.sphere((1, 0, 0), 1)), (-0.5, 0, 0), 0.5),
        (d.mirror(d.sphere((2, 0, 0), 1)), (-4, 0, 0), 1),
        (d.place(d.capsule((0, 0, 0), (1, 0, 0), 0.1), (0, 0, 1), y=-90), (0, 0, 3), 0.9),
    ],
)
def test_distances_are_those_of_plane_geometry(
    distance: d.Distance, point: tuple[float, float, float], expected: float
) -> None:
    assert distance(np.array([point], dtype=float)) == pytest.approx(expected, abs=1e-12)


def test_a_tube_through_the_knots_of_a_circle_is_a_torus() -> None:
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = d.tube(np.column_stack([np.sin(turn), 0 * turn, np.cos(turn)]).tolist(), 0.2, closed=True)
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (500, 3))
    points = points[np.hypot(points[:, 0], points[:, 2]) > 0.3]  # near the axis no foot is the nearest
    # A periodic cubic spline of 24 knots leaves the circle by (2 pi / 24)^4 / 384 = 1.2e-5.
    assert np.abs(ring(points) - d.torus((0, 0, 0), 1, 0.2)(points)).max() < 5e-5


def test_a_revolved_half_circle_is_a_sphere() -> None:
    rise = np.linspace(-np.pi / 2, np.pi / 2, 13)
    profile = np.column_stack([np.cos(rise), np.sin(rise)])
    profile[[0, -1], 0] = 0
    ball = d.revolve(profile.tolist())
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (500, 3))
    points = points[np.linalg.norm(points, axis=1) > 0.3]
    assert np.abs(ball(points) - (np.linalg.norm(points, axis=1) - 1)).max() < 5e-5  # as above


def test_a_smooth_union_is_never_outside_the_union() -> None:
    parts = d.sphere((0, 0, 0), 1), d.rounded_box((1, 0, 0), (0.5, 0.5, 0.5))
    points = np.random.default_rng(3).uniform(-2, 2, (500, 3))
    assert (d.smooth_union(0.3, *parts)(points) <= d.union(*parts)(points)).all()


@pytest.mark.parametrize(
    ("view", "front_goes_to"),
    [
        (View(), (0, 0, 1)),
        (View(yaw=90), (1, 0, 0)),
        (View(pitch=90), (0, -1, 0)),
        (View(roll=90), (0, 0, 1)),
    ],
)
def test_yaw_turns_the_front_to_the_right_and_pitch_tilts_it_down(
    view: View, front_goes_to: tuple[float, float, float]
) -> None:
    assert view.matrix() @ np.array([0, 0, 1]) == pytest.approx(front_goes_to, abs=1e-12)

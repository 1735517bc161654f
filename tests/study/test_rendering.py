"""Rendered solids agree with closed forms, and meshes with solids."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import trimesh
from scipy import ndimage

from toonkit import ToonkitError
from toonkit.study.rendering import MARGIN, RenderedShape, render_mesh, render_shape
from toonkit.study.shapes import SHAPES, Shape, View
from toonkit.study.solids import distance_fields as d

FRONT = View()


def solid(distance: d.Distance) -> Shape:
    return Shape("test", "primitive", distance)


def places(size: int, extent: float) -> tuple[np.ndarray, np.ndarray]:
    """x and y of pixel centers when a centered silhouette `extent` across fills the picture."""
    row, column = np.mgrid[:size, :size]
    pixel = extent / (1 - 2 * MARGIN) / size
    return (column - (size - 1) / 2) * pixel, ((size - 1) / 2 - row) * pixel


def degrees_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.rad2deg(2 * np.arcsin(np.clip(np.linalg.norm(first - second, axis=-1) / 2, 0, 1)))


def ellipsoid_normals(x: np.ndarray, y: np.ndarray, radii: tuple[float, float, float]) -> np.ndarray:
    a, b, c = radii
    z = c * np.sqrt(1 - (x / a) ** 2 - (y / b) ** 2)
    normals = np.stack([x / a**2, y / b**2, z / c**2], axis=-1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


@pytest.mark.parametrize("radii", [(1.0, 1.0, 1.0), (1.0, 0.6, 0.8), (0.5, 1.1, 0.4)])
def test_ellipsoids_agree_with_the_closed_form(radii: tuple[float, float, float]) -> None:
    size = 128
    extent = 2 * max(radii)
    picture = render_shape(solid(d.ellipsoid((0, 0, 0), radii)), size, view=FRONT)
    x, y = places(size, extent)
    level = np.hypot(x / radii[0], y / radii[1])
    # The frame is measured to within 0.00003; less than a hundredth of a pixel at 128.
    assert (picture.mask == (level < 1))[np.abs(level - 1) > 5e-4].all()
    inner = level < 0.98  # closer to the outline, a displacement that small turns normals by more
    error = degrees_between(picture.normals.vectors[inner], ellipsoid_normals(x[inner], y[inner], radii))
    assert error.max() < 0.05
    z = radii[2] * np.sqrt(1 - level[inner] ** 2)
    pixels = z * size * (1 - 2 * MARGIN) / extent
    assert np.abs(picture.depth[inner] - pixels).max() < 0.05


def test_coverage_sums_to_the_area() -> None:
    picture = render_shape(SHAPES["sphere"], 96)
    area = np.pi * (96 * (0.5 - MARGIN)) ** 2
    # Sixteen rays a pixel are off by up to a fifth of a ray in each of the 300 outline pixels, at random.
    assert picture.coverage.sum() == pytest.approx(area, rel=2e-3)


@pytest.mark.parametrize("name", ["cat", "three_box", "snowman"])
def test_coverage_is_at_least_half_exactly_on_the_mask(name: str) -> None:
    picture = render_shape(SHAPES[name], 64)
    assert ((picture.coverage >= 0.5) == picture.mask).all()
    assert picture.coverage.min() == 0
    assert picture.coverage.max() == 1


def test_nothing_outside_the_mask_is_a_number() -> None:
    picture = render_shape(SHAPES["torus"], 48)
    assert np.isnan(picture.depth[~picture.mask]).all()
    assert np.isfinite(picture.depth[picture.mask]).all()


def test_a_torus_has_its_hole() -> None:
    picture = render_shape(SHAPES["torus"], 64)
    _, holes = ndimage.label(~picture.mask)
    assert holes == 2  # the background and the hole


def test_a_cylinder_keeps_the_normals_of_its_cap_and_its_side() -> None:
    size, pitch = 96, 30.0
    picture = render_shape(solid(d.cylinder((0, 0, 0), 0.6, 0.7)), size, view=View(pitch=pitch))
    vectors = picture.normals.vectors[picture.mask]
    up = np.array([0, np.cos(np.deg2rad(pitch)), np.sin(np.deg2rad(pitch))])
    along = vectors @ up
    cap, side = along > 1 - 1e-6, np.abs(along) < 1e-3
    assert (cap | side).mean() > 0.999  # a ray within 1e-4 of the edge may see it rounded
    assert cap.sum() == pytest.approx(np.pi * 0.6**2 * 0.5 / _pixel_area(picture, 1.2, pitch), rel=0.02)


def _pixel_area(picture: RenderedShape, width: float, pitch: float) -> float:
    """Area of a pixel: the cylinder is higher in the picture than wide."""
    height = 1.4 * np.cos(np.deg2rad(pitch)) + width * np.sin(np.deg2rad(pitch))
    return float((height / (1 - 2 * MARGIN) / len(picture.mask)) ** 2)


def test_the_base_of_a_cone_does_not_smear_its_side() -> None:
    picture = render_shape(solid(d.capped_cone(-0.5, 0.5, 1.0, 0.0)), 96, view=FRONT)
    vectors = picture.normals.vectors[picture.mask]
    # Every normal of the side of a cone as wide as it is high rises by the same angle.
    assert (np.abs(vectors[:, 1] - np.sqrt(0.5)) < 1e-3).mean() > 0.998


def test_what_is_raised_in_y_appears_higher_and_what_is_moved_in_x_to_the_right() -> None:
    snowman = {"big": d.sphere((0, -0.3, 0), 0.6), "small": d.sphere((0.4, 0.6, 0.1), 0.2)}
    shape = Shape(
        "test",
        "complex",
        d.union(*snowman.values()),
        lambda points: np.argmin([distance(points) for distance in snowman.values()], axis=0),
        tuple(snowman),
    )
    picture = render_shape(shape, 64, view=FRONT)
    big, small = (np.argwhere(picture.part == part).mean(axis=0) for part in (0, 1))
    assert small[0] < big[0] - 10
    assert small[1] > big[1] + 5


def test_what_is_nearer_hides_what_is_behind_and_has_the_larger_depth() -> None:
    picture = render_shape(
        solid(d.union(d.sphere((0, 0, 0), 0.9), d.sphere((0, 0, 0.8), 0.3))), 65, view=FRONT
    )
    assert np.nanargmax(picture.depth) == 32 * 65 + 32
    pixel = 1.8 / (1 - 2 * MARGIN) / 65
    assert picture.depth[32, 32] * pixel == pytest.approx(1.1, abs=1e-3)


def test_a_picture_shows_the_same_at_every_size() -> None:
    small, large = render_shape(SHAPES["vase"], 33), render_shape(SHAPES["vase"], 99)
    # Every third pixel center of the larger picture is one of the smaller.
    both = small.mask & large.mask[1::3, 1::3]
    assert (small.mask == large.mask[1::3, 1::3]).all()
    difference = degrees_between(small.normals.vectors[both], large.normals.vectors[1::3, 1::3][both])
    assert np.quantile(difference, 0.99) < 1e-3  # rays arrive within 1e-6 of the surface


@pytest.mark.parametrize("size", [15, 48.0, True, "64"])
def test_sizes_that_are_no_picture_are_refused(size: object) -> None:
    with pytest.raises(ToonkitError, match="size must be a whole number of pixels, at least 16"):
        render_shape(SHAPES["sphere"], size)


def test_a_mesh_of_a_sphere_has_the_normals_of_a_sphere() -> None:
    size = 128
    picture = render_mesh(trimesh.creation.icosphere(subdivisions=6), size)
    x, y = places(size, 2.0)
    inner = np.hypot(x, y) < 0.97
    error = degrees_between(picture.normals.vectors[inner], ellipsoid_normals(x[inner], y[inner], (1, 1, 1)))
    assert error.max() < 0.1


def test_a_mesh_and_a_distance_of_the_same_solid_render_alike() -> None:
    mesh = render_mesh(trimesh.creation.icosphere(subdivisions=5), 96)
    distance = render_shape(SHAPES["sphere"], 96)
    assert (mesh.mask != distance.mask).sum() <= 12  # the mesh is inscribed, by 0.0003
    assert np.abs(mesh.coverage - distance.coverage).max() <= 3 / 16 + 1e-6
    both = ndimage.binary_erosion(mesh.mask & distance.mask, iterations=2)
    assert degrees_between(mesh.normals.vectors[both], distance.normals.vectors[both]).max() < 0.3
    assert np.abs(mesh.depth - distance.depth)[both].max() < 0.1


@pytest.mark.parametrize("inside_out", [False, True])
def test_a_box_mesh_keeps_its_face_normals_however_it_is_wound(inside_out: bool) -> None:
    box = trimesh.creation.box((1, 1, 1))
    if inside_out:
        box.invert()
    picture = render_mesh(box, 64, yaw=30, pitch=25)
    faces = View(yaw=30, pitch=25).matrix().T @ picture.normals.vectors[picture.mask].T
    assert np.abs(np.abs(faces).max(axis=0) - 1).max() < 1e-9  # rounding


def test_a_view_turns_a_mesh_as_it_turns_a_shape() -> None:
    mesh = trimesh.creation.box((1.5, 1.2, 1.2))
    shape = solid(d.rounded_box((0, 0, 0), (0.75, 0.6, 0.6)))
    turned = render_mesh(mesh, 64, yaw=-35, pitch=28, roll=10)
    expected = render_shape(shape, 64, view=View(-35, 28, 10))
    both = turned.mask & expected.mask
    assert (turned.mask != expected.mask).sum() <= 6  # corners between two framing rays
    angle = degrees_between(turned.normals.vectors[both], expected.normals.vectors[both])
    assert (angle < 0.01).mean() > 0.99  # single pixels at edges may fall on the other face


def test_a_mesh_without_faces_is_refused() -> None:
    with pytest.raises(ToonkitError, match="mesh must have faces"):
        render_mesh(trimesh.Trimesh(), 64)


def test_without_embreex_a_mesh_render_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh.ray.ray_pyembree", None)
    with pytest.raises(ToonkitError, match=r'pip install "toonkit\[study\]"'):
        render_mesh(trimesh.creation.box(), 64)

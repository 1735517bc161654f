"""Solids to learn from: closed forms, symmetry, the frame, coverage; and that they know nothing of the study's shapes."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from toonkit import training
from toonkit.training.families import FAMILIES, Family, draw_lathe_body, draw_sheet, random_solid
from toonkit.training.rendering import MARGIN, SUBPIXELS, Rendered, render_solid
from toonkit.training.solids import BOX, CAPSULE, CONE, ELLIPSOID, REACH, TORUS, Solid

FRAME = 0.013  # of a picture's width: the silhouette's ends are looked for in steps that small

EIGHTH = np.pi / 4


def solid(
    *parts: tuple[int, tuple[float, ...]], centers: Any = None, widths: Any = None, **others: Any
) -> Solid:
    """A solid of unturned primitives, with creases where they meet."""
    count = len(parts)
    settings = {"turns": np.tile(np.eye(3), (count, 1, 1)), "mirrored": False, "waves": np.zeros((0, 5))}
    settings |= {"view": np.eye(3), **others}
    return Solid(
        kinds=np.array([kind for kind, _ in parts]),
        centers=np.zeros((count, 3)) if centers is None else np.array(centers, float),
        sizes=np.array([np.resize((*sizes, 0, 0, 0), 4) for _, sizes in parts], float),
        widths=np.full(count, 0.001) if widths is None else np.array(widths, float),
        **settings,
    )


def rendered(shape: Solid, size: int = 96) -> Rendered:
    picture = render_solid(shape, size)
    assert picture is not None
    return picture


def about(axis: int, angle: float) -> np.ndarray:
    """A right-handed turn."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[[first, second], [first, second]] = np.cos(angle)
    turn[first, second], turn[second, first] = -np.sin(angle), np.sin(angle)
    return turn


def degrees_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.rad2deg(2 * np.arcsin(np.clip(np.linalg.norm(first - second, axis=-1) / 2, 0, 1)))


def margins(mask: np.ndarray) -> tuple[np.ndarray, int]:
    """Free pixels to the left, right, top and bottom; and which axis the silhouette is longer along."""
    rows, columns = np.nonzero(mask)
    far = len(mask) - 1
    free = np.array([columns.min(), far - columns.max(), rows.min(), far - rows.max()])
    return free, int(np.ptp(rows) > np.ptp(columns))


@pytest.mark.parametrize("radius", [0.3, 1.0])
@pytest.mark.parametrize("center", [(0, 0, 0), (0.4, -0.7, 0.5)])
def test_a_lone_sphere_has_the_normals_of_a_sphere(center: tuple[float, ...], radius: float) -> None:
    size = 96
    picture = rendered(solid((ELLIPSOID, (radius, radius, radius)), centers=[center]), size)
    row, column = np.nonzero(picture.mask)
    vectors = picture.normals[picture.mask]
    # The frame is known to a few pixels only; on a sphere, x and y of the normal are linear in the pixel's place.
    places = np.stack([column, row, np.ones(len(row))], axis=1)
    linear, *_ = np.linalg.lstsq(places, vectors[:, :2], rcond=None)
    assert np.abs(places @ linear - vectors[:, :2]).max() < 2e-3
    assert linear[0, 0] == pytest.approx(-linear[1, 1], rel=1e-4)
    assert abs(linear[0, 1]) + abs(linear[1, 0]) < 1e-5
    assert 1 / linear[0, 0] == pytest.approx(size * (0.5 - MARGIN), rel=2 * FRAME / radius)
    assert -linear[2] / np.diag(linear[:2]) == pytest.approx([(size - 1) / 2] * 2, abs=FRAME / radius * size)
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(1)
    assert (vectors[:, 2] >= 0).all()
    assert picture.mask.sum() == pytest.approx(np.pi / linear[0, 0] ** 2, rel=0.01)


@pytest.mark.parametrize("radii", [(1.0, 0.6, 0.8), (0.5, 1.0, 0.4)])
def test_an_ellipsoid_agrees_with_the_closed_form(radii: tuple[float, float, float]) -> None:
    size = 96
    picture = rendered(solid((ELLIPSOID, radii)), size)
    pixel = np.sqrt(np.pi * radii[0] * radii[1] / picture.coverage.sum())
    row, column = np.mgrid[:size, :size]
    x, y = (column - (size - 1) / 2) * pixel, ((size - 1) / 2 - row) * pixel
    level = np.hypot(x / radii[0], y / radii[1])
    inner = level < 0.95  # closer to the outline, a hundredth of a pixel turns normals by more
    z = radii[2] * np.sqrt(1 - level[inner] ** 2)
    expected = np.stack([x[inner], y[inner], z], axis=-1) / np.square(radii)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    assert picture.mask[inner].all()
    assert not picture.mask[level > 1.03].any()
    assert degrees_between(picture.normals[inner], expected).max() < 0.7


@pytest.mark.parametrize("axis", [0, 1])
def test_a_box_shows_two_faces_that_its_turn_tells(axis: int) -> None:
    turn = about(axis, EIGHTH)
    picture = rendered(solid((BOX, (0.5, 0.5, 0.5, 0.0)), turns=turn[None]))
    faces = turn @ picture.normals[picture.mask].T
    aligned = np.abs(faces).max(axis=0) > 1 - 1e-6
    assert aligned.mean() > 0.97  # but for the edge between them
    shown = {tuple(face) for face in np.rint(faces[:, aligned]).astype(int).T}
    ahead = turn[:, 2]
    assert shown == {
        tuple(np.sign(ahead[k]).astype(int) * np.eye(3, dtype=int)[k])
        for k in range(3)
        if abs(ahead[k]) > 0.1
    }


def test_a_capsule_is_a_cylinder_between_two_half_spheres() -> None:
    picture = rendered(solid((CAPSULE, (0.8, 0.3, 0.3))))
    rows, _ = np.nonzero(picture.mask)
    height = np.ptp(rows) + 1
    side = np.zeros_like(picture.mask)
    middle, half = (rows.min() + rows.max()) / 2, height * 0.8 / 2.2
    side[int(middle - half + 1) : int(middle + half)] = True
    assert np.abs(picture.normals[side & picture.mask, 1]).max() < 1e-4
    upper = picture.mask & (np.arange(96)[:, None] < middle - half - 2)
    assert (picture.normals[upper, 1] > 0.05).all()
    widths = picture.mask.sum(axis=1)[int(middle - half + 2) : int(middle + half - 2)]
    assert widths.min() >= widths.max() - 1
    assert widths.max() == pytest.approx(height * 0.6 / 2.2, abs=2)


def test_a_torus_seen_along_its_axis_has_a_round_hole() -> None:
    picture = rendered(solid((TORUS, (0.7, 0.25)), view=about(0, np.pi / 2)))
    labels, regions = ndimage.label(~picture.mask)
    assert regions == 2  # the background and the hole
    hole = (labels == labels[48, 48]).sum()
    assert hole / (hole + picture.mask.sum()) == pytest.approx((0.45 / 0.95) ** 2, rel=0.02)
    (left,) = np.nonzero(picture.mask[48, :48])
    outer, inner = picture.normals[48, left[2], 0], picture.normals[48, left[-3], 0]
    assert outer < -0.5  # the tube is round
    assert inner > 0.5


def test_every_normal_of_a_cones_side_rises_alike() -> None:
    picture = rendered(solid((CONE, (0.5, 1.0, 0.0))))
    assert (np.abs(picture.normals[picture.mask, 1] - np.sqrt(0.5)) < 1e-3).mean() > 0.98


def test_a_cut_leaves_a_dent() -> None:
    ball, dent = (ELLIPSOID, (1, 1, 1)), (ELLIPSOID, (0.4, 0.4, 0.4))
    picture = rendered(solid(ball, dent, centers=[(0, 0, 0), (0, 0, 1)], widths=[0.001, -0.001]))
    right, above = picture.normals[47, 55], picture.normals[40, 47]
    assert right[0] < -0.2  # in a hollow, what lies to the right faces left
    assert above[1] < -0.2
    assert picture.normals[47, 80, 0] > 0.5


def test_a_fillet_turns_normals_gradually_where_a_crease_jumps() -> None:
    balls = ((ELLIPSOID, (0.7, 0.7, 0.7)),) * 2
    jumps = []
    for width in (0.001, 0.4):
        picture = rendered(solid(*balls, centers=[(-0.5, 0, 0), (0.5, 0, 0)], widths=[width, width]))
        jumps.append(degrees_between(picture.normals[48, 30:65], picture.normals[48, 31:66]).max())
    assert jumps[0] > 60
    assert jumps[1] < 25


def test_what_is_nearer_hides_what_is_behind() -> None:
    balls = ((ELLIPSOID, (1, 1, 1)), (ELLIPSOID, (0.3, 0.3, 0.3)))
    shown, hidden = (rendered(solid(*balls, centers=[(0, 0, 0), (0, 0, z)])) for z in (1, -1))
    assert np.array_equal(hidden.normals, rendered(solid(balls[0])).normals)
    assert degrees_between(shown.normals[48, 57], hidden.normals[48, 57]) > 20


def test_each_pixel_tells_which_part_it_shows() -> None:
    shape = solid((ELLIPSOID, (1, 1, 1)), (ELLIPSOID, (0.4, 0.4, 0.4)), centers=[[0, 0, 0], [0, 0, 0.9]])
    parts = rendered(shape).parts
    assert np.array_equal(np.unique(parts), [-1, 0, 1])
    assert parts[48, 48] == 1
    away = np.hypot(*(np.indices(parts.shape) - 47.5)) / 48 * (1 + 2 * MARGIN)
    assert (parts[away < 0.35] == 1).all()
    assert (parts[(away > 0.45) & (away < 0.95)] == 0).all()


def test_a_cut_shows_the_part_that_it_is_cut_from() -> None:
    shape = solid(
        (BOX, (1, 1, 1)), (ELLIPSOID, (0.5, 0.5, 0.5)), centers=[[0, 0, 0], [0, 0, 1]], widths=[0.01, -0.01]
    )
    assert set(np.unique(rendered(shape).parts)) == {-1, 0}


def test_a_contour_runs_where_a_part_ends_in_front_of_another_and_nowhere_else() -> None:
    wall, ball = (BOX, (1.0, 1.0, 0.1)), (ELLIPSOID, (0.4, 0.4, 0.4))
    apart = rendered(solid(wall, ball, centers=[(0, 0, -1), (0, 0, 1)]))
    row, column = np.nonzero(apart.contours)
    away = np.hypot(row - 47.5, column - 47.5)
    assert np.ptp(away) < 2.5
    assert len(row) > 4 * away.mean()  # all around
    assert (apart.normals[apart.contours][:, 2] < 0.6).all()  # on the ball's side
    for lone in (ball, wall, (TORUS, (0.7, 0.25))):
        assert not rendered(solid(lone)).contours.any()
    assert not rendered(solid(wall, ball, centers=[(0, 0, 0), (0, 0, 0)])).contours.any()  # grows out of it


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_turned_view_shows_a_turned_picture(quarters: int) -> None:
    parts = (ELLIPSOID, (0.6, 0.4, 0.5)), (CAPSULE, (0.5, 0.2, 0.1))
    straight, turned = (
        rendered(solid(*parts, centers=[(0, 0, 0), (0.5, 0.3, 0.2)], view=about(2, angle)))
        for angle in (0, quarters * np.pi / 2)
    )
    assert (np.rot90(straight.mask, quarters) != turned.mask).sum() <= 4  # rays that graze the outline
    expected = np.rot90(straight.normals, quarters) @ about(2, quarters * np.pi / 2).T
    both = turned.mask & np.rot90(straight.mask, quarters)
    assert np.median(degrees_between(turned.normals, expected)[both]) < 1e-3


def test_a_mirrored_solid_is_symmetric_seen_from_the_front() -> None:
    parts = (ELLIPSOID, (0.6, 0.8, 0.5)), (CAPSULE, (0.5, 0.2, 0.1)), (BOX, (0.2, 0.1, 0.3, 0.05))
    centers = [(0, 0, 0), (0.6, 0.3, 0.2), (-0.3, -0.7, 0.3)]
    turns = np.array([about(axis, 0.4) for axis in range(3)])
    settings = {"centers": centers, "turns": turns, "waves": np.array([[3.0, 2.0, 4.0, 0.7, 0.02]])}
    whole, halves = (rendered(solid(*parts, mirrored=mirrored, **settings)) for mirrored in (True, False))
    flipped = whole.normals[:, ::-1] * [-1, 1, 1]
    assert (whole.mask != whole.mask[:, ::-1]).sum() <= 4  # rays that graze the outline
    both = whole.mask & whole.mask[:, ::-1]
    assert (degrees_between(whole.normals, flipped)[both] < 0.1).mean() > 0.99
    assert (halves.mask != halves.mask[:, ::-1]).sum() > 100  # and without, it is not


def test_waves_are_waves_of_the_normals() -> None:
    wave = np.array([[0.0, 20.0, 0.0, 0.0, 0.01]])
    picture = rendered(solid((BOX, (1, 1, 0.3)), waves=wave))
    tilt = picture.normals[20:76, 48, 1]
    assert tilt.max() == pytest.approx(np.sin(np.arctan(0.2)), abs=0.01)
    assert tilt.min() == pytest.approx(-tilt.max(), abs=0.01)
    assert np.abs(picture.normals[20:76, 48, 0]).max() < 1e-3


def test_steep_waves_leave_no_holes() -> None:
    """Rays that would overshoot a steep wave, or give up where they graze it, would leave pixels of the middle empty."""
    wave = np.array([[0.0, 8.0, 0.0, 0.5, 0.2]])
    picture = rendered(solid((BOX, (1, 1, 0.3)), waves=wave, view=about(1, 0.5)))
    assert np.array_equal(ndimage.binary_fill_holes(picture.mask), picture.mask)
    assert picture.mask.mean() > 0.4


def test_the_outline_of_a_sheet_is_an_edge_and_no_rim() -> None:
    rims = []
    for seed in range(20):
        picture = render_solid(draw_sheet(np.random.default_rng(seed)), 64)
        assert picture is not None
        rim = picture.mask & ~ndimage.binary_erosion(picture.mask)
        rims.append(np.median(picture.normals[rim][:, 2]))
    assert np.median(rims) > 0.3


RANDOM = tuple(range(24))


@cache
def random_picture(seed: int, size: int = 64) -> Rendered:
    rng = np.random.default_rng([99, seed])
    while True:
        picture = render_solid(random_solid(rng), size)
        if picture is not None:
            return picture


@pytest.mark.parametrize("seed", RANDOM)
def test_the_silhouette_of_any_solid_fills_the_frame_to_the_margin(seed: int) -> None:
    size = 64
    free, longer = margins(random_picture(seed, size).mask)
    ends = free[2 * longer : 2 * longer + 2]
    assert ends == pytest.approx(MARGIN * size, abs=1.5)
    assert (free >= MARGIN * size - 1.5).all()
    assert abs(free[0] - free[1]) <= 3  # it stands in the middle
    assert abs(free[2] - free[3]) <= 3


@pytest.mark.parametrize("seed", RANDOM)
def test_any_solid_has_unit_normals_on_its_mask_and_none_beside_it(seed: int) -> None:
    picture = random_picture(seed)
    assert np.linalg.norm(picture.normals[picture.mask], axis=-1) == pytest.approx(1)
    assert (picture.normals[picture.mask][:, 2] >= 0).all()
    assert not picture.normals[~picture.mask].any()


@pytest.mark.parametrize("seed", RANDOM)
def test_coverage_is_at_least_half_exactly_on_the_mask(seed: int) -> None:
    picture = random_picture(seed)
    assert np.array_equal(picture.coverage >= 0.5, picture.mask)
    assert picture.coverage.min() == 0
    assert picture.coverage.max() == 1


def test_coverage_sums_to_the_area_and_mixes_along_the_outline_alone() -> None:
    size = 96
    picture = rendered(solid((ELLIPSOID, (1, 1, 1))), size)
    row, column = np.nonzero(picture.mask)
    places = np.stack([column, row, np.ones(len(row))], axis=1)
    linear, *_ = np.linalg.lstsq(places, picture.normals[picture.mask][:, 0], rcond=None)
    # A ray arrives a 25th of a pixel before the surface: of a radius of 44, a thousandth.
    assert picture.coverage.sum() == pytest.approx(np.pi / linear[0] ** 2, rel=3e-3)
    mixed = (picture.coverage > 0) & (picture.coverage < 1)
    outline = ndimage.binary_dilation(picture.mask, np.ones((3, 3))) & ~ndimage.binary_erosion(
        picture.mask, np.ones((3, 3))
    )
    assert not mixed[~outline].any()
    assert mixed.sum() > 0.5 * 2 * np.pi / linear[0]
    ninths = picture.coverage * SUBPIXELS**2
    assert (np.abs(ninths - np.rint(ninths)) < 0.05).mean() > 0.99  # but for ties with the mask


def test_a_seed_draws_the_same_solid_and_another_seed_another() -> None:
    first, other = random_picture(3), random_picture(4)
    again = random_picture.__wrapped__(3)
    assert np.array_equal(first.normals, again.normals)
    assert np.array_equal(first.coverage, again.coverage)
    assert not np.array_equal(first.mask, other.mask)


def test_all_kinds_of_solids_are_drawn() -> None:
    rng = np.random.default_rng(12)
    solids = [random_solid(rng) for _ in range(300)]
    assert {int(kind) for shape in solids for kind in shape.kinds} == {ELLIPSOID, BOX, CAPSULE, TORUS, CONE}
    for share in (
        [len(shape.kinds) == 1 for shape in solids],
        [shape.mirrored for shape in solids],
        [len(shape.waves) > 0 for shape in solids],
        [bool((shape.widths < 0).any()) for shape in solids],
    ):
        assert 0.03 < np.mean(share) < 0.6
    turns = np.concatenate([[shape.view] for shape in solids] + [shape.turns for shape in solids])
    assert np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(3), atol=1e-9)
    assert np.allclose(np.linalg.det(turns), 1)


FAMILY = pytest.mark.parametrize(
    "family", [family for family, _ in FAMILIES], ids=[family.__name__ for family, _ in FAMILIES]
)


def test_the_shares_of_the_families_sum_to_one() -> None:
    assert sum(share for _, share in FAMILIES) == pytest.approx(1)


@FAMILY
def test_a_family_stays_within_reach_of_the_rays(family: Family) -> None:
    seen = 0
    for seed in range(40):
        shape = family(np.random.default_rng(seed))
        far = np.linalg.norm(shape.centers, axis=1) + np.linalg.norm(shape.sizes[:, :3], axis=1)
        assert far[shape.widths > 0].max() < REACH * np.sqrt(2)
        seen += render_solid(shape, 32) is not None
    assert seen > 30


@FAMILY
def test_no_two_solids_of_a_family_are_alike(family: Family) -> None:
    first, second, again = (family(np.random.default_rng(seed)) for seed in (1, 2, 1))
    assert np.array_equal(first.sizes, again.sizes)
    assert first.sizes.shape != second.sizes.shape or not np.array_equal(first.sizes, second.sizes)


@pytest.mark.parametrize("seed", range(6))
def test_a_body_of_revolution_looks_the_same_from_all_around(seed: int) -> None:
    """Those without a handle or features: all parts stand unturned on one axis."""
    rng = np.random.default_rng(seed)
    while True:
        shape = draw_lathe_body(rng)
        if not shape.centers[:, [0, 2]].any() and len({turn.tobytes() for turn in shape.turns}) == 1:
            break
    pictures = [rendered(replace(shape, view=about(1, angle)), 48) for angle in (0.0, 1.0)]
    assert np.array_equal(pictures[0].mask, pictures[1].mask)
    np.testing.assert_allclose(pictures[0].normals, pictures[1].normals, atol=2e-2)


def test_a_solid_hardly_to_be_seen_is_no_picture() -> None:
    assert render_solid(solid((ELLIPSOID, (0.01, 0.01, 0.01))), 64) is None
    assert render_solid(solid((CAPSULE, (1.5, 0.01, 0.01)), turns=about(2, EIGHTH)[None]), 64) is None


def test_training_knows_nothing_of_the_shapes_and_colors_of_the_study() -> None:
    modules = "toonkit.training.drawings, toonkit.estimation.shape_prior, toonkit.estimation.light_prior"
    code = f"import sys, {modules}; print(*(name for name in sys.modules if name.startswith('toonkit')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert {"toonkit.training.solids", "toonkit.training.rendering"} <= set(loaded)
    assert [name for name in loaded if name.startswith("toonkit.study")] == []
    # The rest of training would load PyTorch, which takes seconds: its imports are read instead.
    sources = [path.read_text(encoding="utf-8") for path in Path(training.__file__).parent.glob("*.py")]
    imported = {
        name
        for source in sources
        for name in re.findall(r"^(?:from|import) (toonkit[\w.]*)", source, re.MULTILINE)
    }
    assert imported - set(loaded) <= {
        f"toonkit.training.{name}" for name in ("light_task", "network", "shape_task", "train")
    }

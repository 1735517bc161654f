from itertools import pairwise

import numpy as np
import pytest

from tests.analytic import ellipse
from toonkit.estimation import silhouette as silhouette_module
from toonkit.estimation.islands import with_surroundings
from toonkit.estimation.silhouette import Silhouette, _Outline, _smooth_curves, trace_silhouette
from toonkit.numerics.masked_grid import OUTSIDE, STEPS, MaskedGrid, bounding_box


def traced(mask, alpha) -> tuple[MaskedGrid, Silhouette]:
    """Trace the object of a picture on its bounding box."""
    box = bounding_box(mask)
    grid = MaskedGrid(mask[box])
    return grid, trace_silhouette(grid, with_surroundings(alpha, box))


def crossings(shape, half_width, half_height, alpha):
    """Each crossing's position, the ellipse's own outward direction there, and the traced one."""
    grid, silhouette = traced(shape.mask, alpha)
    down, along = bounding_box(shape.mask)
    row, column = grid.rows[silhouette.pixels] + down.start, grid.columns[silhouette.pixels] + along.start
    step = np.array(STEPS)[silhouette.directions]
    x = shape.x[row, column] + step[:, 1] * silhouette.distances
    y = shape.y[row, column] - step[:, 0] * silhouette.distances
    truth = np.stack([x / half_width**2, y / half_height**2], axis=1)
    truth /= np.linalg.norm(truth, axis=1, keepdims=True)
    return x, y, truth, silhouette.outward


@pytest.mark.parametrize(
    ("half_width", "half_height"), [(32, 32), (100, 100), (200, 200), (100, 60), (60, 140)]
)
@pytest.mark.parametrize("antialiased", [True, False])
def test_outward_directions_are_right_to_two_degrees(half_width, half_height, antialiased):
    shape = ellipse(half_width, half_height)
    alpha = shape.coverage if antialiased else shape.mask.astype(float)
    _, _, truth, outward = crossings(shape, half_width, half_height, alpha)
    cross = truth[:, 0] * outward[:, 1] - truth[:, 1] * outward[:, 0]
    angle = np.degrees(np.arctan2(np.abs(cross), np.sum(truth * outward, axis=1)))
    assert angle.max() < 2.0


@pytest.mark.parametrize("radius", [16, 64, 128])
def test_alpha_places_the_outline_within_a_twentieth_of_a_pixel(radius):
    shape = ellipse(radius, radius)
    x, y, _, _ = crossings(shape, radius, radius, shape.coverage)
    assert np.abs(np.hypot(x, y) - radius).mean() < 0.05


def test_every_link_that_leaves_the_object_is_crossed_once():
    shape = ellipse(30, 20)
    grid, silhouette = traced(shape.mask, shape.coverage)
    crossed = set(zip(silhouette.pixels.tolist(), silhouette.directions.tolist(), strict=True))
    leaving = set(zip(*(part.tolist() for part in np.nonzero(grid.neighbors == OUTSIDE)), strict=True))
    assert crossed == leaving
    assert len(silhouette.pixels) == len(leaving)


def test_a_hole_is_part_of_the_silhouette_and_its_outward_is_into_the_hole():
    disc, hole = ellipse(40, 40), ellipse(40, 40)
    mask = disc.mask & ~(hole.x**2 + hole.y**2 < 15**2)
    grid, silhouette = traced(mask, mask.astype(float))
    down, along = bounding_box(mask)
    row, column = grid.rows[silhouette.pixels] + down.start, grid.columns[silhouette.pixels] + along.start
    toward_center = -np.stack([disc.x[row, column], disc.y[row, column]], axis=1)
    at_hole = np.hypot(disc.x, disc.y)[row, column] < 20
    assert at_hole.any()
    assert (np.sum(toward_center * silhouette.outward, axis=1)[at_hole] > 0).all()


def chain_by_hand(mask: np.ndarray) -> set[frozenset[tuple[int, int, int]]]:
    """The slow way: walk around every part, from link to link, with the object to the left."""
    left = {
        (row, column, k)
        for row, column in np.argwhere(mask).tolist()
        for k, (down, along) in enumerate(STEPS)
        if not on(mask, row + down, column + along)
    }
    curves = set()
    while left:
        curve, link = [], min(left)
        while link in left:
            left.remove(link)
            curve.append(link)
            row, column, k = link
            ahead, out = STEPS[(k + 1) % 4], STEPS[k]
            beside = row + ahead[0], column + ahead[1]
            across = beside[0] + out[0], beside[1] + out[1]
            if not on(mask, *beside):
                link = (row, column, (k + 1) % 4)
            elif not on(mask, *across):
                link = (*beside, k)
            else:
                link = (*across, (k + 3) % 4)
        curves.add(frozenset(curve))
    return curves


def on(mask: np.ndarray, row: int, column: int) -> bool:
    return 0 <= row < mask.shape[0] and 0 <= column < mask.shape[1] and bool(mask[row, column])


@pytest.mark.parametrize("seed", range(6))
def test_the_outline_is_followed_as_one_would_walk_around_it(seed):
    mask = np.random.default_rng(seed).random((14, 17)) < 0.55
    mask[0, 0] = mask[-1, -1] = True
    grid = MaskedGrid(mask)
    outline = _Outline.of(grid, np.pad(mask, 1).astype(float))
    links = list(
        zip(grid.rows[outline.pixels], grid.columns[outline.pixels], outline.directions, strict=True)
    )
    curves = {frozenset(links[a:b]) for a, b in pairwise(outline.starts)}
    assert outline.closed.all()
    assert curves == chain_by_hand(mask)
    # From one crossing to the next it is a pixel and a half at most.
    for first, last in pairwise(outline.starts):
        steps = np.diff(np.vstack([outline.points[first:last], outline.points[first]]), axis=0)
        assert np.linalg.norm(steps, axis=1).max() < 1.5


def test_the_many_outlines_of_a_dithered_drawing_are_smoothed_together(monkeypatch):
    dots = np.kron(np.ones((60, 60)), np.pad(np.ones((1, 1)), ((0, 1), (0, 1)))) > 0
    dots[:40, :40] |= np.indices((40, 40)).sum(axis=0) % 6 < 3
    calls = []

    def watched(*arguments, count, **others):
        calls.append(count)
        return _smooth_curves(*arguments, count=count, **others)

    monkeypatch.setattr(silhouette_module, "_smooth_curves", watched)
    _, silhouette = traced(dots, dots.astype(float))
    assert len(silhouette.pixels) > 10_000
    assert len(calls) == len(set(calls)) < 50


@pytest.mark.parametrize("framed", [False, True], ids=["at the frame", "with pixels around it"])
def test_a_side_that_the_frame_cut_off_is_no_outline_whatever_is_around_it(framed):
    disc = ellipse(30, 30)
    mask, alpha = disc.mask[: disc.mask.shape[0] // 2], disc.coverage[: disc.mask.shape[0] // 2]
    if framed:
        mask, alpha = (np.pad(part, 5) for part in (mask, alpha))
    _, silhouette = traced(mask, alpha)
    assert not (np.array(STEPS)[silhouette.directions][:, 0] == 1).any()
    assert len(silhouette.pixels) > 60


def test_a_disc_that_touches_the_frame_is_not_cut_off():
    disc = ellipse(30, 30)
    box = bounding_box(disc.mask)
    _, tight = traced(disc.mask[box], disc.mask[box].astype(float))
    _, loose = traced(disc.mask, disc.mask.astype(float))
    assert np.array_equal(tight.pixels, loose.pixels)
    assert np.array_equal(tight.outward, loose.outward)


def test_the_frame_is_the_outline_of_an_object_that_fills_the_picture():
    mask = np.ones((12, 15), dtype=bool)
    _, silhouette = traced(mask, mask.astype(float))
    assert len(silhouette.pixels) == 2 * (12 + 15)

import numpy as np
import pytest

from tests.analytic import ellipse
from toonkit.estimation.silhouette import trace_silhouette
from toonkit.numerics.masked_grid import OUTSIDE, STEPS, MaskedGrid


def crossings(shape, half_width, half_height, alpha):
    """Each crossing's position, the ellipse's own outward direction there, and the traced one."""
    grid = MaskedGrid(shape.mask)
    silhouette = trace_silhouette(grid, alpha)
    row, column = grid.rows[silhouette.pixels], grid.columns[silhouette.pixels]
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
    _, _, truth, traced = crossings(shape, half_width, half_height, alpha)
    cross = truth[:, 0] * traced[:, 1] - truth[:, 1] * traced[:, 0]
    angle = np.degrees(np.arctan2(np.abs(cross), np.sum(truth * traced, axis=1)))
    assert angle.max() < 2.0


@pytest.mark.parametrize("radius", [16, 64, 128])
def test_alpha_places_the_outline_within_a_twentieth_of_a_pixel(radius):
    shape = ellipse(radius, radius)
    x, y, _, _ = crossings(shape, radius, radius, shape.coverage)
    assert np.abs(np.hypot(x, y) - radius).mean() < 0.05


def test_every_link_that_leaves_the_object_is_crossed_once():
    shape = ellipse(30, 20)
    grid = MaskedGrid(shape.mask)
    silhouette = trace_silhouette(grid, shape.coverage)
    crossed = set(zip(silhouette.pixels.tolist(), silhouette.directions.tolist(), strict=True))
    leaving = set(zip(*(part.tolist() for part in np.nonzero(grid.neighbors == OUTSIDE)), strict=True))
    assert crossed == leaving
    assert len(silhouette.pixels) == len(leaving)


def test_a_hole_is_part_of_the_silhouette_and_its_outward_is_into_the_hole():
    disc, hole = ellipse(40, 40), ellipse(40, 40)
    mask = disc.mask & ~(hole.x**2 + hole.y**2 < 15**2)
    grid = MaskedGrid(mask)
    silhouette = trace_silhouette(grid, mask.astype(float))
    row, column = grid.rows[silhouette.pixels], grid.columns[silhouette.pixels]
    toward_center = -np.stack([disc.x[row, column], disc.y[row, column]], axis=1)
    at_hole = np.hypot(disc.x, disc.y)[row, column] < 20
    assert at_hole.any()
    assert (np.sum(toward_center * silhouette.outward, axis=1)[at_hole] > 0).all()


def test_the_frame_is_no_outline_of_an_object_that_has_another():
    mask = np.zeros((30, 30), dtype=bool)
    mask[10:, 5:25] = True  # cut off by the lower side of the picture
    grid = MaskedGrid(mask)
    silhouette = trace_silhouette(grid, mask.astype(float))
    down = np.array(STEPS)[silhouette.directions][:, 0] == 1
    assert not down.any()


def test_the_frame_is_the_outline_of_an_object_that_fills_the_picture():
    mask = np.ones((12, 15), dtype=bool)
    silhouette = trace_silhouette(MaskedGrid(mask), mask.astype(float))
    assert len(silhouette.pixels) == 2 * (12 + 15)

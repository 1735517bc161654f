import numpy as np
import pytest

from tests.analytic import blob_mask
from toonkit.numerics.masked_grid import DOWN, LEFT, OUTSIDE, RIGHT, UP, MaskedGrid


@pytest.mark.parametrize("seed", range(4))
def test_scatter_then_gather_is_the_identity(seed):
    grid = MaskedGrid(blob_mask(seed))
    field = np.random.default_rng(seed).normal(size=(grid.size, 3))
    assert np.array_equal(grid.gather(grid.scatter(field)), field)


def test_outside_the_mask_nothing_is_a_number():
    grid = MaskedGrid(blob_mask(0))
    assert np.isnan(grid.scatter(np.zeros(grid.size))[~grid.mask]).all()


@pytest.mark.parametrize(("there", "back"), [(RIGHT, LEFT), (UP, DOWN)])
def test_neighbors_see_each_other(there, back):
    grid = MaskedGrid(blob_mask(1))
    linked = np.flatnonzero(grid.neighbors[:, there] != OUTSIDE)
    assert np.array_equal(grid.neighbors[grid.neighbors[linked, there], back], linked)


def test_up_is_toward_row_zero():
    grid = MaskedGrid(np.ones((3, 1), dtype=bool))
    assert grid.neighbors[:, UP].tolist() == [OUTSIDE, 0, 1]


@pytest.mark.parametrize("seed", range(4))
def test_differences_agree_with_their_adjoint(seed):
    grid = MaskedGrid(blob_mask(seed))
    random = np.random.default_rng(seed)
    field, flow = random.normal(size=grid.size), random.normal(size=(grid.size, 2))
    there = np.sum(grid.differences(field) * flow)
    back = np.sum(field * grid.differences_adjoint(flow))
    assert there == pytest.approx(back, rel=1e-12, abs=1e-12)


def test_differences_of_a_ramp_are_its_slopes():
    y, x = np.mgrid[:5, :6].astype(float)
    grid = MaskedGrid(np.ones((5, 6), dtype=bool))
    slopes = grid.differences((2 * x - 3 * y).ravel())
    inner = (grid.neighbors[:, RIGHT] != OUTSIDE) & (grid.neighbors[:, UP] != OUTSIDE)
    # y of the frame points up, rows point down: -3 per row is +3 per y.
    assert np.allclose(slopes[inner], [2, 3])


def test_the_rim_touches_the_background():
    grid = MaskedGrid(np.pad(np.ones((3, 3), dtype=bool), 1))
    assert grid.rim.tolist() == [True, True, True, True, False, True, True, True, True]


@pytest.mark.parametrize("seed", range(3))
def test_every_pixel_has_the_parent_of_its_block(seed):
    grid = MaskedGrid(blob_mask(seed, size=23))
    coarse, parent = grid.coarsening.coarse, grid.coarsening.parent
    assert np.array_equal(coarse.rows[parent], grid.rows // 2)
    assert np.array_equal(coarse.columns[parent], grid.columns // 2)
    assert set(parent) == set(range(coarse.size))


@pytest.mark.parametrize("seed", range(3))
def test_a_linear_field_is_interpolated_exactly_where_all_blocks_are_there(seed):
    grid = MaskedGrid(np.pad(np.ones((21, 30), dtype=bool), seed))
    coarse = grid.coarsening.coarse
    slope = np.random.default_rng(seed).normal(size=(2, 3))
    field = np.stack([2.0 * coarse.columns + 0.5, 2.0 * coarse.rows + 0.5], axis=1) @ slope
    fine = grid.coarsening.interpolated(field, np.empty((grid.size, 3)))
    expected = np.stack([grid.columns, grid.rows], axis=1) @ slope
    inner = (
        (grid.rows > seed + 1)
        & (grid.rows < seed + 19)
        & (grid.columns > seed + 1)
        & (grid.columns < seed + 28)
    )
    assert np.allclose(fine[inner], expected[inner])


@pytest.mark.parametrize("seed", range(3))
def test_a_constant_is_interpolated_as_it_is_on_any_mask(seed):
    step = MaskedGrid(blob_mask(seed, size=40)).coarsening
    constant = np.full((step.coarse.size, 2), [3.0, -1.0])
    assert np.allclose(step.interpolated(constant, np.empty((step.fine.size, 2))), [3.0, -1.0])


@pytest.mark.parametrize("seed", range(3))
def test_an_interpolated_field_can_be_added(seed):
    step = MaskedGrid(blob_mask(seed, size=40)).coarsening
    rng = np.random.default_rng(seed)
    coarse, before = rng.normal(size=(step.coarse.size, 2)), rng.normal(size=(step.fine.size, 2))
    alone = step.interpolated(coarse, np.empty((step.fine.size, 2)))
    assert np.allclose(step.interpolated(coarse, before.copy(), adding=True), before + alone)


@pytest.mark.parametrize("columns", [(), (2,)])
def test_values_are_summed_over_each_block(columns):
    step = MaskedGrid(blob_mask(1, size=40)).coarsening
    values = np.random.default_rng(0).normal(size=(step.fine.size, *columns))
    expected = np.zeros((step.coarse.size, *columns))
    np.add.at(expected, step.parent, values)
    assert np.allclose(step.sums(values), expected)


def test_links_of_one_are_links_of_one_between_blocks():
    grid = MaskedGrid(np.ones((16, 24), dtype=bool))
    links = (grid.neighbors != OUTSIDE).astype(float)
    coarse = grid.coarsening.links(links)
    assert np.array_equal(coarse, grid.coarsening.coarse.neighbors != OUTSIDE)


def test_a_grid_is_coarsened_down_to_a_size():
    grid = MaskedGrid(blob_mask(1, size=90))
    steps = grid.coarsenings(20)
    assert steps[0].fine is grid
    assert [step.coarse.size for step in steps[:-1]] == [step.fine.size for step in steps[1:]]
    assert steps[-1].coarse.size <= 20 < steps[-1].fine.size
    assert grid.coarsenings(20)[0] is steps[0]  # made once

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
    fine = grid.coarsening.interpolate(field, np.empty((grid.size, 3)))
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
    assert np.allclose(step.interpolate(constant, np.empty((step.fine.size, 2))), [3.0, -1.0])


@pytest.mark.parametrize("seed", range(3))
def test_an_interpolated_field_can_be_added(seed):
    step = MaskedGrid(blob_mask(seed, size=40)).coarsening
    rng = np.random.default_rng(seed)
    coarse, before = rng.normal(size=(step.coarse.size, 2)), rng.normal(size=(step.fine.size, 2))
    alone = step.interpolate(coarse, np.empty((step.fine.size, 2)))
    assert np.allclose(step.interpolate(coarse, before.copy(), adding=True), before + alone)


@pytest.mark.parametrize("columns", [(), (2,)])
def test_values_are_summed_over_each_block(columns):
    step = MaskedGrid(blob_mask(1, size=40)).coarsening
    values = np.random.default_rng(0).normal(size=(step.fine.size, *columns))
    expected = np.zeros((step.coarse.size, *columns))
    np.add.at(expected, step.parent, values)
    assert np.allclose(step.sum_blocks(values), expected)


def test_unit_edge_weights_stay_one_between_blocks():
    grid = MaskedGrid(np.ones((16, 24), dtype=bool))
    edge_weights = (grid.neighbors != OUTSIDE).astype(float)
    coarse = grid.coarsening.coarsen_edge_weights(edge_weights)
    assert np.array_equal(coarse, grid.coarsening.coarse.neighbors != OUTSIDE)

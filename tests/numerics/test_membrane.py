import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from tests.analytic import blob_mask
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid
from toonkit.numerics.membrane import Membrane, solve_membrane, uniform_links


def random_membrane(seed: int) -> Membrane:
    random = np.random.default_rng(seed)
    grid = MaskedGrid(blob_mask(seed, size=40))
    links = uniform_links(grid)
    for direction, opposite in ((0, 2), (1, 3)):
        there = grid.neighbors[:, direction]
        linked = np.flatnonzero(there != OUTSIDE)
        weight = 10 ** random.uniform(-2, 1, size=len(linked))
        links[linked, direction] = weight
        links[there[linked], opposite] = weight
    return Membrane(grid, links, 10 ** random.uniform(-4, 1, size=grid.size))


def sparse_matrix(membrane: Membrane) -> sp.csr_matrix:
    """The readable reference: the same operator, assembled."""
    grid = membrane.grid
    matrix = sp.lil_matrix((grid.size, grid.size))
    for pixel in range(grid.size):
        matrix[pixel, pixel] = membrane.ties[pixel] + membrane.links[pixel].sum()
        for direction, neighbor in enumerate(grid.neighbors[pixel]):
            if neighbor != OUTSIDE:
                matrix[pixel, neighbor] = -membrane.links[pixel, direction]
    return matrix.tocsr()


@pytest.mark.parametrize("seed", range(4))
def test_the_operator_is_symmetric(seed):
    membrane = random_membrane(seed)
    a, b = np.random.default_rng(seed).normal(size=(2, membrane.grid.size, 1))
    assert np.sum(membrane.apply(a) * b) == pytest.approx(np.sum(a * membrane.apply(b)), rel=1e-10)


@pytest.mark.parametrize("seed", range(6))
def test_multigrid_reaches_the_direct_solution(seed):
    membrane = random_membrane(seed)
    right_side = np.random.default_rng(seed).normal(size=(membrane.grid.size, 2))
    field, report = solve_membrane(membrane, right_side, tolerance=1e-10)
    direct = spsolve(sparse_matrix(membrane).tocsc(), right_side)
    assert report.converged
    # The residual is 1e-10; ties of 1e-4 let it grow 1e4-fold in the solution at worst.
    assert np.abs(field - direct).max() < 1e-5 * np.abs(direct).max()


@pytest.mark.parametrize("seed", range(3))
def test_the_energy_never_rises(seed):
    membrane = random_membrane(seed)
    right_side = np.random.default_rng(seed).normal(size=(membrane.grid.size, 1))
    _, report = solve_membrane(membrane, right_side)
    assert (np.diff(report.energies) <= 1e-9 * np.abs(report.energies[-1])).all()


@pytest.mark.parametrize("size", [64, 256])
def test_iterations_hardly_depend_on_the_size(size):
    grid = MaskedGrid(np.ones((size, size), dtype=bool))
    links = uniform_links(grid)
    ties = 4.0 - links.sum(axis=1)
    right_side = ties[:, None] * np.sin(grid.rows / size * 9)[:, None]
    _, report = solve_membrane(Membrane(grid, links, ties), right_side)
    assert report.converged
    assert report.iterations <= 20  # 12 at 64 and 14 at 256 when this was written


def test_a_lone_pixel_without_a_tie_keeps_its_start():
    mask = np.zeros((5, 5), dtype=bool)
    mask[0, 0] = mask[3:, 3:] = True
    grid = MaskedGrid(mask)
    ties = np.array([0.0, 1, 1, 1, 1])
    field, _ = solve_membrane(Membrane(grid, uniform_links(grid), ties), ties[:, None] * 2.0)
    assert field[:, 0].round(9).tolist() == [0, 2, 2, 2, 2]


def test_the_iteration_limit_is_a_status_not_an_error():
    membrane = random_membrane(0)
    right_side = np.ones((membrane.grid.size, 1))
    _, report = solve_membrane(membrane, right_side, tolerance=1e-14, max_iterations=2)
    assert not report.converged
    assert report.iterations == 2
    assert "limit" in report.reason

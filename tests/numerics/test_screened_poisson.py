import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from tests.analytic import blob_mask
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid
from toonkit.numerics.screened_poisson import ScreenedPoisson, solve_screened_poisson, uniform_edge_weights


def random_system(seed: int) -> ScreenedPoisson:
    random = np.random.default_rng(seed)
    grid = MaskedGrid(blob_mask(seed, size=40))
    edge_weights = uniform_edge_weights(grid)
    for direction, opposite in ((0, 2), (1, 3)):
        there = grid.neighbors[:, direction]
        linked = np.flatnonzero(there != OUTSIDE)
        weight = 10 ** random.uniform(-2, 1, size=len(linked))
        edge_weights[linked, direction] = weight
        edge_weights[there[linked], opposite] = weight
    return ScreenedPoisson(grid, edge_weights, 10 ** random.uniform(-4, 1, size=grid.size))


def sparse_matrix(system: ScreenedPoisson) -> sp.csr_matrix:
    """The readable reference: the same operator, assembled."""
    grid = system.grid
    matrix = sp.lil_matrix((grid.size, grid.size))
    for pixel in range(grid.size):
        matrix[pixel, pixel] = system.screening[pixel] + system.edge_weights[pixel].sum()
        for direction, neighbor in enumerate(grid.neighbors[pixel]):
            if neighbor != OUTSIDE:
                matrix[pixel, neighbor] = -system.edge_weights[pixel, direction]
    return matrix.tocsr()


@pytest.mark.parametrize("seed", range(4))
def test_the_operator_is_symmetric(seed):
    system = random_system(seed)
    a, b = np.random.default_rng(seed).normal(size=(2, system.grid.size))
    assert np.sum(system.apply(a) * b) == pytest.approx(np.sum(a * system.apply(b)), rel=1e-10)


@pytest.mark.parametrize("seed", range(12))
def test_multigrid_reaches_the_direct_solution(seed):
    system = random_system(seed)
    parts = np.random.default_rng(seed).normal(size=(system.grid.size, 2))
    field, report = solve_screened_poisson(system, parts[:, 0] + 1j * parts[:, 1], tolerance=1e-10)
    real, imaginary = spsolve(sparse_matrix(system).tocsc(), parts).T
    direct = real + 1j * imaginary
    assert report.converged
    # The residual is 1e-10; screening of 1e-4 let it grow 1e4-fold in the solution at worst.
    assert np.abs(field - direct).max() < 1e-5 * np.abs(direct).max()


@pytest.mark.parametrize("seed", range(3))
def test_the_energy_never_rises(seed):
    system = random_system(seed)
    right_side = np.random.default_rng(seed).normal(size=system.grid.size)
    _, report = solve_screened_poisson(system, right_side)
    assert (np.diff(report.energies) <= 1e-9 * np.abs(report.energies[-1])).all()


@pytest.mark.parametrize("size", [64, 256])
def test_iterations_hardly_depend_on_the_size(size):
    grid = MaskedGrid(np.ones((size, size), dtype=bool))
    edge_weights = uniform_edge_weights(grid)
    screening = 4.0 - edge_weights.sum(axis=1)
    right_side = screening * np.sin(grid.rows / size * 9)
    _, report = solve_screened_poisson(ScreenedPoisson(grid, edge_weights, screening), right_side)
    assert report.converged
    assert report.iterations <= 12


def test_a_lone_pixel_without_a_tie_keeps_its_start():
    mask = np.zeros((5, 5), dtype=bool)
    mask[0, 0] = mask[3:, 3:] = True
    grid = MaskedGrid(mask)
    screening = np.array([0.0, 1, 1, 1, 1])
    field, _ = solve_screened_poisson(
        ScreenedPoisson(grid, uniform_edge_weights(grid), screening), screening * 2.0
    )
    assert field.round(9).tolist() == [0, 2, 2, 2, 2]


def test_the_iteration_limit_is_a_status_not_an_error():
    system = random_system(0)
    right_side = np.ones(system.grid.size)
    _, report = solve_screened_poisson(system, right_side, tolerance=1e-14, max_iterations=2)
    assert not report.converged
    assert report.iterations == 2
    assert "limit" in report.reason


def test_two_real_problems_are_one_complex_one():
    system = random_system(3)
    parts = np.random.default_rng(3).normal(size=(2, system.grid.size))
    both, _ = solve_screened_poisson(system, parts[0] + 1j * parts[1], tolerance=1e-11)
    for part, field in zip(parts, (both.real, both.imag), strict=True):
        assert np.allclose(solve_screened_poisson(system, part, tolerance=1e-11)[0], field, atol=1e-6)


@pytest.mark.parametrize("mask", ["lines", "dust", "comb"])
def test_thin_parts_dust_and_combs_are_solved_as_quickly(mask):
    on = np.zeros((96, 96), dtype=bool)
    if mask == "lines":
        on[::5] = True
    elif mask == "dust":
        on[::3, ::4] = True
    else:
        on[:, ::4], on[40:43] = True, True
    grid = MaskedGrid(on)
    edge_weights = uniform_edge_weights(grid)
    screening = np.where(edge_weights.sum(axis=1) < 2, 1.0, 1e-3)
    right_side = screening * np.sin(grid.columns / 9.0)
    field, report = solve_screened_poisson(ScreenedPoisson(grid, edge_weights, screening), right_side)
    direct = spsolve(sparse_matrix(ScreenedPoisson(grid, edge_weights, screening)).tocsc(), right_side)
    assert report.converged
    assert report.iterations <= 40
    assert np.allclose(field, direct, atol=1e-4)

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
    a, b = np.random.default_rng(seed).normal(size=(2, membrane.grid.size))
    assert np.sum(membrane.apply(a) * b) == pytest.approx(np.sum(a * membrane.apply(b)), rel=1e-10)


@pytest.mark.parametrize("seed", range(12))
def test_multigrid_reaches_the_direct_solution(seed):
    membrane = random_membrane(seed)
    parts = np.random.default_rng(seed).normal(size=(membrane.grid.size, 2))
    field, report = solve_membrane(membrane, parts[:, 0] + 1j * parts[:, 1], tolerance=1e-10)
    real, imaginary = spsolve(sparse_matrix(membrane).tocsc(), parts).T
    direct = real + 1j * imaginary
    assert report.converged
    # The residual is 1e-10; ties of 1e-4 let it grow 1e4-fold in the solution at worst.
    assert np.abs(field - direct).max() < 1e-5 * np.abs(direct).max()


@pytest.mark.parametrize("seed", range(3))
def test_the_energy_never_rises(seed):
    membrane = random_membrane(seed)
    right_side = np.random.default_rng(seed).normal(size=membrane.grid.size)
    _, report = solve_membrane(membrane, right_side)
    assert (np.diff(report.energies) <= 1e-9 * np.abs(report.energies[-1])).all()


@pytest.mark.parametrize("size", [64, 256])
def test_iterations_hardly_depend_on_the_size(size):
    grid = MaskedGrid(np.ones((size, size), dtype=bool))
    links = uniform_links(grid)
    ties = 4.0 - links.sum(axis=1)
    right_side = ties * np.sin(grid.rows / size * 9)
    _, report = solve_membrane(Membrane(grid, links, ties), right_side)
    assert report.converged
    assert report.iterations <= 12


def test_a_lone_pixel_without_a_tie_keeps_its_start():
    mask = np.zeros((5, 5), dtype=bool)
    mask[0, 0] = mask[3:, 3:] = True
    grid = MaskedGrid(mask)
    ties = np.array([0.0, 1, 1, 1, 1])
    field, _ = solve_membrane(Membrane(grid, uniform_links(grid), ties), ties * 2.0)
    assert field.round(9).tolist() == [0, 2, 2, 2, 2]


def test_the_iteration_limit_is_a_status_not_an_error():
    membrane = random_membrane(0)
    right_side = np.ones(membrane.grid.size)
    _, report = solve_membrane(membrane, right_side, tolerance=1e-14, max_iterations=2)
    assert not report.converged
    assert report.iterations == 2
    assert "limit" in report.reason


def test_two_real_problems_are_one_complex_one():
    membrane = random_membrane(3)
    parts = np.random.default_rng(3).normal(size=(2, membrane.grid.size))
    both, _ = solve_membrane(membrane, parts[0] + 1j * parts[1], tolerance=1e-11)
    for part, field in zip(parts, (both.real, both.imag), strict=True):
        assert np.allclose(solve_membrane(membrane, part, tolerance=1e-11)[0], field, atol=1e-6)


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
    links = uniform_links(grid)
    ties = np.where(links.sum(axis=1) < 2, 1.0, 1e-3)
    right_side = ties * np.sin(grid.columns / 9.0)
    field, report = solve_membrane(Membrane(grid, links, ties), right_side)
    direct = spsolve(sparse_matrix(Membrane(grid, links, ties)).tocsc(), right_side)
    assert report.converged
    assert report.iterations <= 40
    assert np.allclose(field, direct, atol=1e-4)

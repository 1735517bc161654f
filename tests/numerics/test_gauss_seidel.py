import numpy as np
import pytest

from tests.analytic import LIGHT
from tests.numerics.test_smoothing import random_problem as smoothing_problem
from toonkit.numerics.gauss_seidel import over_relaxed_sweeps


def run(seed: int, *, relaxation: float = 1.0, max_sweeps: int = 400, tolerance: float = 1e-9):
    energy = smoothing_problem(seed)
    return over_relaxed_sweeps(energy, relaxation=relaxation, max_sweeps=max_sweeps, tolerance=tolerance)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("relaxation", [1.0, 1.5])
def test_sweeps_lower_the_energy(seed, relaxation):
    _, report = run(seed, relaxation=relaxation)
    assert report.energies[-1] < 0.2 * report.energies[0]


def test_the_limit_and_the_standstill_are_told_apart():
    _, few = run(0, max_sweeps=10)
    _, many = run(0, max_sweeps=100_000, tolerance=1e-6)
    assert (few.converged, few.iterations) == (False, 10)
    assert many.converged
    assert "stands still" in many.reason


def test_vectors_stay_unit_and_face_the_viewer():
    field, _ = run(1)
    assert np.allclose(np.linalg.norm(field, axis=1), 1)
    assert (field[:, 2] >= 0).all()


def plain_sweeps(energy, sweeps: int, relaxation: float):
    """One pixel after the other, one sweep after the other, the Laplacian from scratch each time."""
    grid, field = energy.grid, energy.start.copy()
    rho, smoothness = 20.0, 30.0
    for _ in range(sweeps):
        for p in range(grid.size):
            inside = grid.neighbors[p][grid.neighbors[p] >= 0]
            curvature = smoothness * (len(inside) ** 2 + len(inside))
            laplacian = grid.laplacian(field)
            slope = laplacian[inside].sum(axis=0) - len(inside) * laplacian[p]
            best = field[p] - (smoothness * slope / curvature if curvature else 0.0)
            along = best @ LIGHT
            target = np.clip(along, energy.lower[p], energy.upper[p])
            best = best + rho * (target - along) / (curvature + rho) * LIGHT
            best = field[p] + relaxation * (best - field[p])
            best[2] = max(best[2], 0.0)
            field[p] = best / np.linalg.norm(best)
    return field


@pytest.mark.parametrize("sweeps", [1, 2, 5])
def test_staggered_sweeps_are_sweeps_one_after_the_other(sweeps):
    energy = smoothing_problem(3)
    field, report = run(3, relaxation=1.5, max_sweeps=sweeps, tolerance=0.0)
    assert report.iterations == sweeps
    assert np.allclose(field, plain_sweeps(energy, sweeps, 1.5), atol=1e-12)

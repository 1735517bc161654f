import numpy as np
import pytest
from scipy.optimize import minimize

from tests.analytic import LIGHT, blob_mask
from toonkit.estimation.creases import crease_links
from toonkit.estimation.energy import ChangeEnergy, ShadingTerm
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.membrane import Membrane
from toonkit.numerics.unit_field import UnitFieldProblem, solve_unit_field
from toonkit.numerics.unit_field_kernels import best_unit_vector


def random_problem(seed: int, size: int = 16) -> tuple[UnitFieldProblem, ChangeEnergy]:
    random = np.random.default_rng(seed)
    grid = MaskedGrid(blob_mask(seed, size=size))
    start = random.normal(size=(grid.size, 3)) * 0.4 + [0, 0, 1.2]
    start[:, 2] = np.abs(start[:, 2]) + 0.3
    start /= np.linalg.norm(start, axis=1, keepdims=True)
    lower = np.clip(start @ LIGHT + random.uniform(-0.4, 0.3, grid.size), -0.9, 0.85)
    upper = lower + 0.1
    ties = random.uniform(0, 1, grid.size) * grid.rim
    links = crease_links(grid, start, 20.0)
    membrane = Membrane(grid, links, ties)
    energy = ChangeEnergy(grid, ShadingTerm(LIGHT, lower, upper), start, membrane, 0.7, 0.9)
    problem = UnitFieldProblem(
        grid=grid, start=start, direction=LIGHT, lower=lower, upper=upper, weight=np.ones(grid.size),
        links=links, ties=ties, change_weight=0.7**2, integrability_weight=0.9**2,
    )  # fmt: skip
    return problem, energy


def reference_minimum(energy: ChangeEnergy, start: np.ndarray) -> float:
    """The readable reference: the same energy over two angles a pixel, by a general-purpose minimizer."""

    def vectors(angles):
        turn, rise = angles.reshape(2, -1)
        return np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=1)

    def value_and_slope(angles):
        turn, rise = angles.reshape(2, -1)
        gradient = energy.gradient(vectors(angles))
        by_turn = np.stack([-np.cos(rise) * np.sin(turn), np.cos(rise) * np.cos(turn), 0 * turn], axis=1)
        by_rise = np.stack([-np.sin(rise) * np.cos(turn), -np.sin(rise) * np.sin(turn), np.cos(rise)], axis=1)
        slope = np.concatenate([np.sum(gradient * by_turn, axis=1), np.sum(gradient * by_rise, axis=1)])
        return energy.value(vectors(angles)), slope

    angles = np.concatenate([np.arctan2(start[:, 1], start[:, 0]), np.arcsin(start[:, 2])])
    found = minimize(
        value_and_slope, angles, jac=True, method="L-BFGS-B", options={"maxiter": 5000, "maxfun": 20000}
    )
    return float(found.fun)


@pytest.mark.parametrize("seed", range(6))
def test_the_solver_reaches_the_energy_of_a_general_minimizer(seed):
    problem, energy = random_problem(seed)
    _, report = solve_unit_field(problem, energy=energy.value, sweeps=4000, tolerance=1e-9)
    reference = reference_minimum(energy, problem.start)
    assert report.converged
    assert report.energies[-1] <= reference * (1 + 1e-4)


@pytest.mark.parametrize("seed", range(6))
def test_no_sweep_raises_the_energy(seed):
    problem, energy = random_problem(seed)
    before = energy.value(problem.start)
    for sweeps in (1, 2, 5, 20):
        field, _ = solve_unit_field(problem, energy=energy.value, sweeps=sweeps, tolerance=0.0)
        after = energy.value(field)
        # The coarser grids' start may differ with the sweeps granted; the end is what must not rise.
        assert after <= before * (1 + 1e-3)
        before = after


def test_the_result_is_a_field_of_unit_vectors_that_face_the_viewer():
    problem, energy = random_problem(3)
    field, _ = solve_unit_field(problem, energy=energy.value)
    assert np.allclose(np.linalg.norm(field, axis=1), 1, atol=1e-12)
    assert (field[:, 2] >= 0).all()


def test_without_intervals_to_meet_and_curl_to_remove_the_start_stands():
    problem, energy = random_problem(2)
    free = UnitFieldProblem(
        problem.grid, problem.start, LIGHT, np.full(problem.grid.size, -1.0), np.ones(problem.grid.size),
        problem.weight, problem.links, problem.ties, problem.change_weight, 0.0,
    )  # fmt: skip
    field, report = solve_unit_field(free, energy=energy.value)
    # Twelve digits: the coarser grids contribute no change at all.
    assert np.allclose(field, problem.start, atol=1e-12)
    assert report.iterations == 1


def test_progress_rises_to_one_and_can_cancel():
    problem, energy = random_problem(1, size=40)
    seen = []
    solve_unit_field(problem, energy=energy.value, tolerance=0.0, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)

    def cancel(_fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve_unit_field(problem, energy=energy.value, progress=cancel)


@pytest.mark.parametrize("seed", range(20))
def test_the_pointwise_step_beats_a_dense_search(seed):
    random = np.random.default_rng(seed)
    pull = random.normal(size=3) * 10 ** random.uniform(-2, 2)
    lower = random.uniform(-1, 0.8)
    upper = lower + random.uniform(0, 0.2)
    weight = 10 ** random.uniform(-2, 2)
    best = np.array([0.0, 0.0, 1.0])
    best_unit_vector(pull, LIGHT, lower, upper, weight, best)

    def cost(vectors):
        light = vectors @ LIGHT
        return -vectors @ pull + weight * (light - np.clip(light, lower, upper)) ** 2

    candidates = random.normal(size=(200_000, 3))
    candidates /= np.linalg.norm(candidates, axis=1, keepdims=True)
    assert np.linalg.norm(best) == pytest.approx(1.0)
    assert cost(best[None])[0] <= cost(candidates).min() + 1e-9

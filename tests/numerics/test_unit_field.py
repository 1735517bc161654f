from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.analytic import LIGHT, blob_mask
from tests.reference_energies import energy_gradient, energy_value
from toonkit.estimation.edges import edge_links
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics import parallel, unit_field_cycle
from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.unit_field import solve_unit_field
from toonkit.numerics.unit_field_cycle import Level, cycle
from toonkit.numerics.unit_vectors import unit_vectors


def random_problem(seed: int, size: int = 16) -> ChangeEnergy:
    random = np.random.default_rng(seed)
    grid = MaskedGrid(blob_mask(seed, size=size))
    start = random.normal(size=(grid.size, 3)) * 0.4 + [0, 0, 1.2]
    start[:, 2] = np.abs(start[:, 2]) + 0.3
    start /= np.linalg.norm(start, axis=1, keepdims=True)
    lower = np.clip(start @ LIGHT + random.uniform(-0.4, 0.3, grid.size), -0.9, 0.85)
    upper = lower + 0.1
    screening = random.uniform(0, 1, grid.size) * grid.rim
    edge_weights = edge_links(grid, start, IlluminationInterval(lower, upper), turn=20.0, jump=0.3)
    return ChangeEnergy(
        grid=grid, start=start, direction=LIGHT, lower=lower, upper=upper, weight=np.ones(grid.size),
        edge_weights=edge_weights, screening=screening, change_weight=0.7**2, integrability_weight=0.9**2,
    )  # fmt: skip


def reference_minimum(energy: ChangeEnergy, start: np.ndarray) -> float:
    """The readable reference: the same energy over two angles a pixel, by a general-purpose minimizer."""

    def vectors(angles):
        turn, rise = angles.reshape(2, -1)
        return np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=1)

    def value_and_slope(angles):
        turn, rise = angles.reshape(2, -1)
        gradient = energy_gradient(energy, vectors(angles))
        by_turn = np.stack([-np.cos(rise) * np.sin(turn), np.cos(rise) * np.cos(turn), 0 * turn], axis=1)
        by_rise = np.stack([-np.sin(rise) * np.cos(turn), -np.sin(rise) * np.sin(turn), np.cos(rise)], axis=1)
        slope = np.concatenate([np.sum(gradient * by_turn, axis=1), np.sum(gradient * by_rise, axis=1)])
        return energy_value(energy, vectors(angles)), slope

    angles = np.concatenate([np.arctan2(start[:, 1], start[:, 0]), np.arcsin(start[:, 2])])
    found = minimize(
        value_and_slope, angles, jac=True, method="L-BFGS-B", options={"maxiter": 5000, "maxfun": 20000}
    )
    return float(found.fun)


@pytest.fixture
def several_grids(monkeypatch):
    """Coarser grids already for small problems."""
    monkeypatch.setattr(unit_field_cycle, "COARSEST_SIZE", 40)


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(20))
def test_the_solver_reaches_the_energy_of_a_general_minimizer_and_never_ends_above_the_start(seed):
    energy = random_problem(seed, size=20)
    field, report = solve_unit_field(energy)
    reference = reference_minimum(energy, energy.start)
    assert report.converged
    assert energy_value(energy, field) <= reference * (1 + 1e-4)
    assert (np.diff(report.energies) <= 0).all()
    assert report.energies[0] == pytest.approx(energy_value(energy, energy.start), rel=1e-12)
    assert report.energies[-1] == pytest.approx(energy_value(energy, field), rel=1e-12)


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(4))
def test_a_problem_stored_in_32_bits_has_the_answer_of_64(seed):
    energy = random_problem(seed)
    short = {
        name: getattr(energy, name).astype(np.float32)
        for name in ("start", "lower", "upper", "weight", "screening")
    }
    exact, _ = solve_unit_field(energy, tolerance=1e-3)
    stored, _ = solve_unit_field(replace(energy, **short), tolerance=1e-3)
    assert stored.dtype == np.float32
    turned = np.rad2deg(np.linalg.norm(exact - unit_vectors(stored), axis=1))
    assert turned.max() < 0.02


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(4))
def test_the_compiled_slope_is_that_of_the_energy_across_the_normals(seed):
    energy = random_problem(seed)
    field = energy.start
    slope = np.empty_like(field)
    value = energy.value_and_gradient(energy.terms, field, slope)
    gradient = energy_gradient(energy, field)
    across = gradient - np.sum(gradient * field, axis=1, keepdims=True) * field
    assert value == pytest.approx(energy_value(energy, field), rel=1e-12)
    assert np.allclose(slope, across, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_relaxing_lowers_the_energy_in_either_order(seed):
    energy = random_problem(seed)
    field = energy.start.copy()
    energies = [energy_value(energy, field)]
    for sweep in range(400):
        energy.sweep(energy.terms, field, backward=bool(sweep % 2))
        energies.append(energy_value(energy, field))
    assert (np.diff(energies) <= 1e-12 * energies[0]).all()
    # Plain Gauss-Seidel, the slow and readable way, ends where the multigrid does.
    assert energies[-1] <= solve_unit_field(energy)[1].energies[-1] * (1 + 1e-4)


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(4))
def test_coarse_grids_stand_still_where_the_fine_one_does(seed):
    energy = random_problem(seed, size=20)
    solved, _ = solve_unit_field(energy, tolerance=1e-13)
    again = solved.copy()
    level = Level.finest(energy)
    cycle(level, energy.terms, again)
    assert level.coarser is not None
    assert level.coarser.coarser is not None
    assert np.abs(again - solved).max() < 1e-3
    add_and_normalize, _ = solve_unit_field(energy, tolerance=1e-13, max_cycles=1)
    assert np.abs(add_and_normalize - solved).max() > 10 * np.abs(again - solved).max()


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(4))
def test_memory_that_is_kept_changes_nothing(seed, monkeypatch):
    energy = random_problem(seed, size=20)
    kept, report = solve_unit_field(energy, max_cycles=8)

    def new_workspace(level, _name):
        return np.full_like(level.problem.start, np.nan)

    def new_zeros(level, _name, count):
        return np.zeros((count, level.problem.grid.size))

    monkeypatch.setattr(Level, "workspace", new_workspace)
    monkeypatch.setattr(Level, "clear_workspace", new_zeros)
    new, its_report = solve_unit_field(energy, max_cycles=8)
    assert np.array_equal(new, kept)
    assert np.array_equal(its_report.energies, report.energies)


def test_a_guess_near_the_answer_takes_fewer_cycles():
    energy = random_problem(5, size=60)
    solved, cold = solve_unit_field(energy, tolerance=1e-5)
    brighter = replace(energy, lower=energy.lower + 0.01, upper=energy.upper + 0.01)
    _, again = solve_unit_field(brighter, tolerance=1e-5)
    _, warm = solve_unit_field(brighter, tolerance=1e-5, guess=solved)
    assert warm.iterations < again.iterations
    assert warm.energies[-1] <= again.energies[-1] * (1 + 1e-3)
    assert cold.converged


def test_the_answer_does_not_depend_on_the_number_of_cores(monkeypatch):
    energy = random_problem(3, size=190)
    assert len(energy.grid.chunks.spans) > 2
    answers = []
    for cores in (1, 2, 5):
        monkeypatch.setattr(parallel, "count_cores", lambda cores=cores: cores)
        answers.append(solve_unit_field(energy, max_cycles=2)[0])
    assert np.array_equal(answers[0], answers[1])
    assert np.array_equal(answers[0], answers[2])


def test_the_result_is_a_field_of_unit_vectors_that_face_the_viewer():
    energy = random_problem(3)
    field, _ = solve_unit_field(energy)
    assert np.allclose(np.linalg.norm(field, axis=1), 1, atol=1e-12)
    assert (field[:, 2] >= 0).all()


def test_without_intervals_to_meet_and_curl_to_remove_the_start_stands():
    energy = random_problem(2)
    free = ChangeEnergy(
        energy.grid, energy.start, LIGHT, np.full(energy.grid.size, -1.0), np.ones(energy.grid.size),
        energy.weight, energy.edge_weights, energy.screening, energy.change_weight, 0.0,
    )  # fmt: skip
    field, report = solve_unit_field(free)
    # Twelve digits: the coarser grids contribute no change at all.
    assert np.allclose(field, energy.start, atol=1e-12)
    assert report.iterations == 1


def test_progress_rises_to_one_and_can_cancel():
    energy = random_problem(1, size=40)
    seen = []
    solve_unit_field(energy, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)

    def cancel(_fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve_unit_field(energy, progress=cancel)

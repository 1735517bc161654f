import numpy as np
import pytest

from benchmarks import other_solvers
from tests.analytic import LIGHT, blob_mask
from tests.reference_energies import energy_gradient, energy_value
from toonkit.numerics import parallel, unit_field_cycle
from toonkit.numerics.gauss_seidel import over_relaxed_sweeps
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_field import solve_unit_field
from toonkit.numerics.unit_field_cycle import Level, cycle

RHO, LAMBDA = 20.0, 30.0


def problem_on(mask: np.ndarray, seed: int) -> SmoothnessEnergy:
    random = np.random.default_rng(seed)
    grid = MaskedGrid(mask)
    start = random.normal(size=(grid.size, 3)) * 0.4 + [0, 0, 1.2]
    start[:, 2] = np.abs(start[:, 2]) + 0.3
    start /= np.linalg.norm(start, axis=1, keepdims=True)
    lower = np.clip(start @ LIGHT + random.uniform(-0.4, 0.3, grid.size), -0.9, 0.85)
    upper = lower + 0.1
    return SmoothnessEnergy.on_pixels(grid, start, LIGHT, lower, upper, weight=RHO, smoothness=LAMBDA)


def random_problem(seed: int, size: int = 20) -> SmoothnessEnergy:
    return problem_on(blob_mask(seed, size=size), seed)


@pytest.fixture
def several_grids(monkeypatch):
    """Coarser grids already for small problems."""
    monkeypatch.setattr(unit_field_cycle, "COARSEST_SIZE", 40)


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(20))
def test_the_solver_reaches_the_energy_of_newtons_method_and_never_ends_above_the_start(seed):
    energy = random_problem(seed)
    # Lobes on necks one pixel thin turn almost free of energy: what is left to gain comes in many small steps.
    field, report = solve_unit_field(energy, tolerance=1e-9, max_cycles=3000)
    reference = other_solvers.newton(energy, -np.inf, 5.0, other_solvers.factorized)[2]
    assert energy_value(energy, field) <= energy_value(energy, reference) * (1 + 1e-4)
    assert (np.diff(report.energies) <= 0).all()
    assert report.energies[0] == pytest.approx(energy_value(energy, energy.start), rel=1e-12)
    assert report.energies[-1] == pytest.approx(energy_value(energy, field), rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_the_compiled_slope_is_that_of_the_energy_across_the_vectors(seed):
    energy = random_problem(seed)
    field = energy.start
    slope = np.empty_like(field)
    value = energy.value_and_gradient(energy.terms, field, slope)
    gradient = energy_gradient(energy, field)
    across = gradient - np.sum(gradient * field, axis=1, keepdims=True) * field
    assert value == pytest.approx(energy_value(energy, field), rel=1e-12)
    assert np.allclose(slope, across, atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_relaxing_lowers_the_energy_in_either_order(seed):
    energy = random_problem(seed)
    field = energy.start.copy()
    energies = [energy_value(energy, field)]
    for sweep in range(300):
        energy.sweep(energy.terms, field, backward=bool(sweep % 2))
        energies.append(energy_value(energy, field))
    assert (np.diff(energies) <= 1e-12 * energies[0]).all()
    assert energies[-1] < 0.1 * energies[0]


@pytest.mark.parametrize("size", [64, 128])
def test_blocks_have_the_energy_of_the_smooth_field_that_they_show(size):
    # Level at the square's edges, where there is no flow.
    def waves(grid: MaskedGrid, width: int) -> np.ndarray:
        across, down = (np.pi * (place + 0.5) / width for place in (grid.columns, grid.rows))
        field = np.stack([0.3 * np.cos(2 * across), 0.2 * np.cos(down), np.ones(grid.size)], axis=1)
        return field / np.linalg.norm(field, axis=1, keepdims=True)

    grid = MaskedGrid(np.ones((size, size), np.bool_))
    free = np.ones(grid.size)
    fine = SmoothnessEnergy.on_pixels(
        grid, waves(grid, size), LIGHT, -free, free, weight=RHO, smoothness=LAMBDA
    )
    coarse = fine.coarsen()
    energies = [
        energy.value_and_gradient(energy.terms, field, np.empty_like(field))
        for energy, field in ((fine, fine.start), (coarse, waves(coarse.grid, size // 2)))
    ]
    assert energies[1] == pytest.approx(energies[0], rel=0.02)  # both of second order in the pixel's side


@pytest.mark.usefixtures("several_grids")
@pytest.mark.parametrize("seed", range(4))
def test_coarse_grids_stand_still_where_the_fine_one_does(seed):
    energy = problem_on(np.ones((20, 20), np.bool_), seed)
    solved, _ = solve_unit_field(energy, tolerance=1e-14, max_cycles=2000)
    again = solved.copy()
    level = Level.finest(energy)
    cycle(level, energy.terms, again)
    assert level.coarser is not None
    assert level.coarser.coarser is not None
    first, _ = solve_unit_field(energy, max_cycles=1)
    assert np.abs(again - solved).max() < 1e-3 * np.abs(first - solved).max() + 1e-5


@pytest.mark.usefixtures("several_grids")
def test_a_few_cycles_end_below_thousands_of_the_papers_sweeps():
    # A hemisphere that is to show the bands of a flatter cap.
    down, across = (np.mgrid[:96, :96] - 47.5) / 46
    mask = across**2 + down**2 < 1
    height = np.sqrt(1 - across[mask] ** 2 - down[mask] ** 2)
    start = np.stack([across[mask], -down[mask], height], axis=1)
    flatter = start + np.array([0, 0, 0.5])
    lower = np.floor(4 * flatter @ LIGHT / np.linalg.norm(flatter, axis=1)) / 4
    energy = SmoothnessEnergy.on_pixels(
        MaskedGrid(mask), start, LIGHT, lower, lower + 0.25, weight=RHO, smoothness=LAMBDA
    )
    _, report = solve_unit_field(energy, tolerance=0.0, max_cycles=15)
    swept, _ = over_relaxed_sweeps(energy, relaxation=1.5, max_sweeps=3000, tolerance=0.0)
    assert report.energies[-1] <= energy_value(energy, swept)


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

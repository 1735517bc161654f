from dataclasses import replace

import numpy as np
import pytest

from tests.analytic import LIGHT, blob_mask, ellipse
from tests.reference_energies import energy_gradient, energy_value, integrability_residual, penalty
from toonkit.estimation.edges import edge_links
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.screened_poisson import uniform_edge_weights
from toonkit.numerics.smoothness_energy import SmoothnessEnergy


def random_fields(seed: int):
    random = np.random.default_rng(seed)
    grid = MaskedGrid(blob_mask(seed))
    normals = random.normal(size=(grid.size, 3))
    lower = random.uniform(-1, 0.5, grid.size)
    initial = random.normal(size=(grid.size, 3))
    return grid, normals, (lower, lower + 0.3), initial, random


def change_energy(
    grid, initial, interval, *, change=0.0, integrability=0.0, edge_weights=None, screening=None
):
    return ChangeEnergy(
        grid, initial, LIGHT, *interval, np.ones(grid.size),
        edge_weights=uniform_edge_weights(grid) if edge_weights is None else edge_weights,
        screening=np.ones(grid.size) if screening is None else screening,
        change_weight=change**2, integrability_weight=integrability**2,
    )  # fmt: skip


def assert_gradient_matches(energy, normals, random):
    direction = random.normal(size=normals.shape)
    step = 1e-6
    slope = (
        energy_value(energy, normals + step * direction) - energy_value(energy, normals - step * direction)
    ) / (2 * step)
    # Central differences of step 1e-6: rounding of 1e-16 over 1e-6, relative to energies of order 1e3.
    assert np.sum(energy_gradient(energy, normals) * direction) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_gradient_of_the_penalty(seed):
    grid, normals, interval, initial, random = random_fields(seed)
    assert_gradient_matches(change_energy(grid, initial, interval), normals, random)


@pytest.mark.parametrize("seed", range(4))
def test_gradient_of_the_smoothness_energy(seed):
    grid, normals, interval, initial, random = random_fields(seed)
    energy = SmoothnessEnergy.on_pixels(grid, initial, LIGHT, *interval, weight=20.0, smoothness=30.0)
    assert_gradient_matches(energy, normals, random)
    assert_gradient_matches(energy.coarsen(), normals[: energy.coarsen().grid.size], random)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lengths", [(2.0, 0.0), (0.0, 3.0), (1.5, 2.5)])
def test_gradient_of_the_change_energy(seed, lengths):
    grid, normals, interval, initial, random = random_fields(seed)
    edge_weights = edge_links(grid, initial, IlluminationInterval(*interval), turn=5.0, jump=0.3)
    energy = change_energy(
        grid, initial, interval, change=lengths[0], integrability=lengths[1],
        edge_weights=edge_weights, screening=random.uniform(0, 1, grid.size),
    )  # fmt: skip
    assert_gradient_matches(energy, normals, random)


def test_inside_the_interval_nothing_is_paid_and_outside_the_squared_distance():
    grid = MaskedGrid(np.ones((1, 3), bool))
    toward_viewer = replace(
        change_energy(grid, np.zeros((3, 3)), (np.full(3, 0.2), np.full(3, 0.5))),
        direction=np.array([0.0, 0, 1]),
    )
    normals = np.array([[0, 0, 0.3], [0, 0, 0.1], [0, 0, 0.9]])
    assert penalty(toward_viewer, normals) == pytest.approx(0.1**2 + 0.4**2)


@pytest.mark.parametrize("seed", range(3))
def test_the_laplacian_is_its_own_adjoint(seed):
    grid, a, _, b, _ = random_fields(seed)
    assert np.sum(grid.laplacian(a) * b) == pytest.approx(np.sum(a * grid.laplacian(b)), rel=1e-10)


def test_the_initial_normals_are_the_minimum_where_every_interval_is_wide():
    disc = ellipse(20, 20)
    grid = MaskedGrid(disc.mask)
    normals = disc.normals.vectors[disc.mask]
    wide = (np.full(grid.size, -1.0), np.ones(grid.size))
    assert energy_value(change_energy(grid, normals, wide, change=3.0), normals) == 0.0


def test_the_normals_of_a_surface_are_integrable_to_second_order():
    residual = {}
    for radius in (20, 40, 80):
        ball = ellipse(radius, radius)
        inner = ball.mask & (np.hypot(ball.x, ball.y) < 0.8 * radius)
        grid = MaskedGrid(inner)
        residual[radius] = np.abs(integrability_residual(grid, ball.normals.vectors[inner])).max() * radius
    # The residual is a derivative per pixel: times the radius it is per object length, and falls with its square.
    assert residual[40] < residual[20] / 3
    assert residual[80] < residual[40] / 3


def test_a_field_that_no_surface_has_is_not_integrable():
    row, x = np.mgrid[-10:11, -10:11].astype(float)
    y = -row
    swirl = np.stack([-y / 20, x / 20, np.sqrt(1 - (x**2 + y**2) / 400)], axis=-1)
    mask = np.ones(x.shape, dtype=bool)
    assert (np.abs(integrability_residual(MaskedGrid(mask), swirl[mask])) > 0.05).all()

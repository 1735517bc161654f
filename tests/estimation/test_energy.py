import numpy as np
import pytest

from tests.analytic import LIGHT, blob_mask, ellipse
from toonkit.estimation.edges import edge_links
from toonkit.estimation.energy import (
    ChangeEnergy,
    PrintedEnergy,
    ShadingTerm,
    integrability_residual,
)
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.membrane import Membrane, uniform_links


def random_terms(seed: int):
    random = np.random.default_rng(seed)
    grid = MaskedGrid(blob_mask(seed))
    normals = random.normal(size=(grid.size, 3))
    lower = random.uniform(-1, 0.5, grid.size)
    shading = ShadingTerm(LIGHT, lower, lower + 0.3)
    initial = random.normal(size=(grid.size, 3))
    return grid, normals, shading, initial, random


def assert_slope_matches(energy, normals, random):
    direction = random.normal(size=normals.shape)
    step = 1e-6
    slope = (energy.value(normals + step * direction) - energy.value(normals - step * direction)) / (2 * step)
    # Central differences of step 1e-6: rounding of 1e-16 over 1e-6, relative to energies of order 1e3.
    assert np.sum(energy.gradient(normals) * direction) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_gradient_of_the_shading_term(seed):
    _, normals, shading, _, random = random_terms(seed)
    assert_slope_matches(shading, normals, random)


@pytest.mark.parametrize("seed", range(4))
def test_gradient_of_the_printed_energy(seed):
    grid, normals, shading, _, random = random_terms(seed)
    assert_slope_matches(PrintedEnergy(grid, shading, 20.0, 30.0), normals, random)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lengths", [(2.0, 0.0), (0.0, 3.0), (1.5, 2.5)])
def test_gradient_of_the_change_energy(seed, lengths):
    grid, normals, shading, initial, random = random_terms(seed)
    painted = IlluminationInterval(shading.lower, shading.upper)
    links = edge_links(grid, initial, painted, turn=5.0, jump=0.3)
    membrane = Membrane(grid, links, random.uniform(0, 1, grid.size))
    energy = ChangeEnergy(grid, shading, initial, membrane, *lengths)
    assert_slope_matches(energy, normals, random)


def test_inside_the_interval_nothing_is_paid_and_outside_the_squared_distance():
    shading = ShadingTerm(np.array([0.0, 0, 1]), np.array([0.2, 0.2, 0.2]), np.array([0.5, 0.5, 0.5]))
    normals = np.array([[0, 0, 0.3], [0, 0, 0.1], [0, 0, 0.9]])
    assert shading.value(normals) == pytest.approx(0.1**2 + 0.4**2)


@pytest.mark.parametrize("seed", range(3))
def test_the_laplacian_is_its_own_adjoint(seed):
    grid, a, _, b, _ = random_terms(seed)
    assert np.sum(grid.laplacian(a) * b) == pytest.approx(np.sum(a * grid.laplacian(b)), rel=1e-10)


def test_the_initial_normals_are_the_minimum_where_every_interval_is_wide():
    disc = ellipse(20, 20)
    grid = MaskedGrid(disc.mask)
    normals = disc.normals.vectors[disc.mask]
    wide = ShadingTerm(LIGHT, np.full(grid.size, -1.0), np.ones(grid.size))
    membrane = Membrane(grid, uniform_links(grid), np.ones(grid.size))
    assert ChangeEnergy(grid, wide, normals, membrane, 3.0, 0.0).value(normals) == 0.0


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

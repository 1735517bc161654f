"""The energies of `toonkit.numerics` in plain array arithmetic: slow references for their compiled loops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, UP, MaskedGrid
from toonkit.numerics.screened_poisson import ScreenedPoisson
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_vectors import UnitVectorEnergy

CORNERS = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
"""(x, y) side of each corner of a 2 x 2 cell: lower left, lower right, upper left, upper right."""


def penalty(energy: UnitVectorEnergy, field: FloatArray) -> float:
    """Penalty on the component of vectors (P, 3)."""
    return float(np.sum(energy.weight * _excess(energy, field) ** 2))


def energy_value(energy: UnitVectorEnergy, field: FloatArray) -> float:
    """Energy of vectors (P, 3)."""
    if isinstance(energy, ChangeEnergy):
        change = field - energy.start
        coupled = np.sum(change * _change_term(energy).apply(change))
        integrability = np.sum(integrability_residual(energy.grid, field) ** 2)
        return (
            penalty(energy, field)
            + energy.change_weight * float(coupled)
            + energy.integrability_weight * float(integrability)
        )
    assert isinstance(energy, SmoothnessEnergy)
    bend = _laplacian(energy, field)
    return penalty(energy, field) + energy.smoothness * float(np.sum(bend**2 / energy.areas[:, None]))


def energy_gradient(energy: UnitVectorEnergy, field: FloatArray) -> FloatArray:
    """Gradient with respect to the vectors, shape (P, 3), before any constraint on their length."""
    gradient = (2.0 * energy.weight * _excess(energy, field))[:, None] * energy.direction
    if isinstance(energy, ChangeEnergy):
        gradient = gradient + 2.0 * energy.change_weight * _change_term(energy).apply(field - energy.start)
        return gradient + energy.integrability_weight * integrability_gradient(energy.grid, field)
    assert isinstance(energy, SmoothnessEnergy)
    # The Laplacian is its own adjoint.
    twice = _laplacian(energy, _laplacian(energy, field) / energy.areas[:, None])
    return gradient + 2.0 * energy.smoothness * twice


def _excess(energy: UnitVectorEnergy, field: FloatArray) -> FloatArray:
    """Signed distance of the component to its interval, zero inside, shape (P,)."""
    component = field @ energy.direction
    return component - np.clip(component, energy.lower, energy.upper)


def _laplacian(energy: SmoothnessEnergy, field: FloatArray) -> FloatArray:
    return -ScreenedPoisson(energy.grid, energy.edge_weights, np.zeros(energy.grid.size)).apply(field)


def _change_term(energy: ChangeEnergy) -> ScreenedPoisson:
    return ScreenedPoisson(energy.grid, energy.edge_weights, energy.screening)


def integrability_residual(grid: MaskedGrid, field: FloatArray) -> FloatArray:
    """
    Return the residual of integrability on every cell of 2 x 2 pixels.

    Parameters
    ----------
    grid : MaskedGrid
        The pixels.
    field : ndarray, shape (P, 3)
        Unit vectors n.

    Returns
    -------
    ndarray, shape (cells,)
        r = n3 ∂y n1 - n1 ∂y n3 - n3 ∂x n2 + n2 ∂x n3, which vanishes for the unit normals of a surface: it is n3² times
        ∂y(n1 / n3) - ∂x(n2 / n3), without the division. It is taken at the middle of the cell, where means and differences
        are both of second order, and is linear in each of the four vectors.
    """
    return _residual(field[_cells(grid)])


def integrability_gradient(grid: MaskedGrid, field: FloatArray) -> FloatArray:
    """Return the gradient of the sum of squared residuals with respect to the vectors, shape (P, 3)."""
    cells = _cells(grid)
    corners = field[cells]
    mean = corners.mean(axis=1)
    along_x, along_y = _differences(corners)
    twice = 2.0 * _residual(corners)[:, None]
    gradient = np.zeros_like(field)
    for corner, (x, y) in enumerate(CORNERS):
        slope = np.stack(
            [
                y / 2 * mean[:, 2] - along_y[:, 2] / 4,
                -x / 2 * mean[:, 2] + along_x[:, 2] / 4,
                (along_y[:, 0] - along_x[:, 1]) / 4 - y / 2 * mean[:, 0] + x / 2 * mean[:, 1],
            ],
            axis=1,
        )
        np.add.at(gradient, cells[:, corner], twice * slope)
    return gradient


def _residual(corners: FloatArray) -> FloatArray:
    """Residual of cells (n, 4, 3) whose corners are in the order of `CORNERS`."""
    mean = corners.mean(axis=1)
    along_x, along_y = _differences(corners)
    turn = along_y[:, 0] - along_x[:, 1]
    residual: FloatArray = mean[:, 2] * turn - mean[:, 0] * along_y[:, 2] + mean[:, 1] * along_x[:, 2]
    return residual


def _differences(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    side_x, side_y = CORNERS.T / 2.0
    return np.einsum("k,nkc->nc", side_x, corners), np.einsum("k,nkc->nc", side_y, corners)


def _cells(grid: MaskedGrid) -> NDArray[np.intp]:
    """Compact indices of the corners of all cells, shape (n, 4)."""
    right, up = grid.neighbors[:, RIGHT], grid.neighbors[:, UP]
    across = np.where(right != OUTSIDE, grid.neighbors[right, UP], OUTSIDE)
    here = np.flatnonzero((right != OUTSIDE) & (up != OUTSIDE) & (across != OUTSIDE))
    return np.stack([here, right[here], up[here], across[here]], axis=1).astype(np.intp)

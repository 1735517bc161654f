"""Integrability of a field of unit vectors: how far it is from the normals of a surface, in plain array arithmetic."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, UP, MaskedGrid

CORNERS = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
"""(x, y) side of each corner of a 2 x 2 cell: lower left, lower right, upper left, upper right."""


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

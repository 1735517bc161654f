"""What the refinement minimizes (Section 3.3): values and gradients, usable without any solver.

Two energies stand here. `PrintedEnergy` is Eq. 5 as the paper prints it. `ChangeEnergy` is ours: it keeps the intervals of
Eq. 6 and asks for a smooth *change* from the initial normals, and for a field that some surface could have.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, UP, MaskedGrid
from toonkit.numerics.membrane import Membrane

CORNERS = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
"""(x, y) side of each corner of a 2 x 2 cell: lower left, lower right, upper left, upper right."""


@dataclass(frozen=True, eq=False)
class ShadingTerm:
    """
    Penalty on illumination outside its interval (Eq. 6), summed over the object.

    Attributes
    ----------
    light : ndarray, shape (3,)
        Unit vector L.
    lower, upper : ndarray, shape (P,)
        Bounds of L · N per pixel.
    """

    light: FloatArray
    lower: FloatArray
    upper: FloatArray

    def excess(self, normals: FloatArray) -> FloatArray:
        """Signed distance of the illumination of normals (P, 3) to its interval, zero inside, shape (P,)."""
        value = normals @ self.light
        return value - np.clip(value, self.lower, self.upper)

    def value(self, normals: FloatArray) -> float:
        """Sum of squared excess."""
        return float(np.sum(self.excess(normals) ** 2))

    def gradient(self, normals: FloatArray) -> FloatArray:
        """Gradient with respect to the normals, shape (P, 3)."""
        return 2.0 * self.excess(normals)[:, None] * self.light


@dataclass(frozen=True, eq=False)
class PrintedEnergy:
    """
    Eq. 5: rho times the shading term plus lambda times the squared Laplacian of the normals.

    Attributes
    ----------
    grid : MaskedGrid
        The object.
    shading : ShadingTerm
        Intervals of illumination.
    rho, smoothness : float
        The paper's rho and lambda, per pixel.
    """

    grid: MaskedGrid
    shading: ShadingTerm
    rho: float
    smoothness: float

    def value(self, normals: FloatArray) -> float:
        """Energy of normals (P, 3)."""
        return self.rho * self.shading.value(normals) + self.smoothness * float(
            np.sum(self.grid.laplacian(normals) ** 2)
        )

    def gradient(self, normals: FloatArray) -> FloatArray:
        """Gradient with respect to the normals, shape (P, 3), before any unit-length constraint."""
        twice = self.grid.laplacian(self.grid.laplacian(normals))  # the Laplacian is its own adjoint
        return self.rho * self.shading.gradient(normals) + 2.0 * self.smoothness * twice


@dataclass(frozen=True, eq=False)
class ChangeEnergy:
    """
    Our energy: the shading term, the membrane of the change N - N0, and integrability.

    Attributes
    ----------
    grid : MaskedGrid
        The object.
    shading : ShadingTerm
        Intervals of illumination.
    initial : ndarray, shape (P, 3)
        N0, unit vectors.
    membrane : Membrane
        Links that keep the change smooth, and ties that hold rim pixels to N0, because the silhouette already says their
        normal.
    change_length, integrability_length : float
        Lengths in pixels over which the change is smooth and the field integrable, where the intervals pull.

    Notes
    -----
    With l the change length and m the integrability length, in pixels,

        E(N) = sum P(L · N) + l² (sum over neighbors k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r_p²,   d = N - N0,

    with the stiffness k of links (one, or less across an edge) and t of ties, and where
    r = n3 ∂y n1 - n1 ∂y n3 - n3 ∂x n2 + n2 ∂x n3 vanishes for the unit normals of a surface: it is n3² times
    ∂y(n1 / n3) - ∂x(n2 / n3), without the division. It is taken at the middle of each cell of 2 x 2 pixels, where means and
    differences are both of second order, and is linear in each of the four normals.

    Both sums over differences are free of scale in two dimensions, so stating l and m in object lengths makes the minimum
    independent of resolution.
    """

    grid: MaskedGrid
    shading: ShadingTerm
    initial: FloatArray
    membrane: Membrane
    change_length: float
    integrability_length: float

    def value(self, normals: FloatArray) -> float:
        """Energy of normals (P, 3)."""
        change = normals - self.initial
        membrane = float(np.sum(change * self.membrane.apply(change)))
        curl = float(np.sum(integrability_residual(self.grid, normals) ** 2))
        return (
            self.shading.value(normals)
            + self.change_length**2 * membrane
            + self.integrability_length**2 * curl
        )

    def gradient(self, normals: FloatArray) -> FloatArray:
        """Gradient with respect to the normals, shape (P, 3), before any unit-length constraint."""
        change = normals - self.initial
        membrane = self.membrane.apply(change)
        curl = _integrability_gradient(self.grid, normals)
        return (
            self.shading.gradient(normals)
            + 2.0 * self.change_length**2 * membrane
            + self.integrability_length**2 * curl
        )


def integrability_residual(grid: MaskedGrid, normals: FloatArray) -> FloatArray:
    """Residual r of `ChangeEnergy` on every cell of 2 x 2 object pixels, shape (number of cells,)."""
    return _cell_residual(normals[_cells(grid)])


def _cell_residual(corners: FloatArray) -> FloatArray:
    """Residual of cells (n, 4, 3) whose corners are in the order of `CORNERS`."""
    mean = corners.mean(axis=1)
    along_x, along_y = _cell_differences(corners)
    turn = along_y[:, 0] - along_x[:, 1]
    residual: FloatArray = mean[:, 2] * turn - mean[:, 0] * along_y[:, 2] + mean[:, 1] * along_x[:, 2]
    return residual


def _cell_differences(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    side_x, side_y = CORNERS.T / 2.0
    return np.einsum("k,nkc->nc", side_x, corners), np.einsum("k,nkc->nc", side_y, corners)


def _integrability_gradient(grid: MaskedGrid, normals: FloatArray) -> FloatArray:
    cells = _cells(grid)
    corners = normals[cells]
    mean = corners.mean(axis=1)
    along_x, along_y = _cell_differences(corners)
    twice = 2.0 * _cell_residual(corners)[:, None]
    gradient = np.zeros_like(normals)
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


def _cells(grid: MaskedGrid) -> NDArray[np.intp]:
    """Compact indices of the corners of all cells, shape (n, 4)."""
    right, up = grid.neighbors[:, RIGHT], grid.neighbors[:, UP]
    across = np.where(right != OUTSIDE, grid.neighbors[right, UP], OUTSIDE)
    here = np.flatnonzero((right != OUTSIDE) & (up != OUTSIDE) & (across != OUTSIDE))
    return np.stack([here, right[here], up[here], across[here]], axis=1).astype(np.intp)

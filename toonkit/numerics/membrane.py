"""Membrane systems on a masked grid: weighted links between neighbors, solved by multigrid-preconditioned gradients.

The system is A x = b with (A x)_p = d_p x_p + sum over neighbors q of w_pq (x_p - x_q): a Laplace or Poisson problem whose
links may have different stiffness and whose pixels may be tied to given values (d, b). A is symmetric and, where every
component has a tie, positive definite.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import OUTSIDE, IndexArray, MaskedGrid, block_sums
from toonkit.numerics.report import SolverReport

COARSEST_SIZE = 32
COARSE_STIFFNESS = 0.5
"""Two links of length h become one of length 2 h between blocks: half the stiffness of their sum."""


@dataclass(frozen=True, eq=False)
class Membrane:
    """
    Coefficients of a membrane system.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    links : ndarray, shape (P, 4)
        Weight of the link to each neighbor >= 0, the same seen from both ends; 0 where there is none.
    ties : ndarray, shape (P,)
        Weight d >= 0 that ties each pixel to a given value.
    """

    grid: MaskedGrid
    links: FloatArray
    ties: FloatArray

    def apply(self, field: FloatArray) -> FloatArray:
        """Return A x for x of shape (P, C)."""
        result = np.empty_like(field)
        _apply(self.grid.neighbors, self.links, self.ties, field, result)
        return result

    def coarsened(self) -> tuple[Membrane, IndexArray]:
        """Return the same problem on 2 x 2 blocks, and the block of each pixel."""
        coarse, parent = self.grid.coarsened()
        links = np.zeros((coarse.size, 4))
        for direction in range(4):
            there = self.grid.neighbors[:, direction]
            crossing = np.flatnonzero(there != OUTSIDE)
            crossing = crossing[parent[there[crossing]] != parent[crossing]]
            links[:, direction] = block_sums(parent[crossing], self.links[crossing, direction], coarse.size)
        ties = block_sums(parent, self.ties, coarse.size)
        return Membrane(coarse, COARSE_STIFFNESS * links, COARSE_STIFFNESS * ties), parent


def uniform_links(grid: MaskedGrid) -> FloatArray:
    """Weight 1 for every pair of neighbors on the grid, shape (P, 4)."""
    links: FloatArray = (grid.neighbors != OUTSIDE).astype(np.float64)
    return links


def solve_membrane(
    membrane: Membrane,
    right_side: FloatArray,
    *,
    start: FloatArray | None = None,
    tolerance: float = 1e-7,
    max_iterations: int = 200,
) -> tuple[FloatArray, SolverReport]:
    """
    Solve A x = b by conjugate gradients with one multigrid V-cycle as preconditioner.

    Parameters
    ----------
    membrane : Membrane
        The matrix A.
    right_side : ndarray, shape (P, C)
        C right sides, solved together.
    start : ndarray, shape (P, C), optional
        First guess; zero by default.
    tolerance : float, optional
        Residual norm to reach, relative to that of the right side.
    max_iterations : int, optional
        Iterations allowed.

    Returns
    -------
    field : ndarray, shape (P, C)
        The solution.
    report : SolverReport
        Its energies are those of the quadratic 1/2 x·Ax - b·x, summed over the right sides.

    Notes
    -----
    The V-cycle coarsens by 2 x 2 blocks, so that the coarse problem is again a membrane, whatever the outline.
    One Gauss-Seidel sweep down and the reversed sweep up keep the preconditioner symmetric.
    """
    levels = _levels(membrane)
    field = np.zeros_like(right_side) if start is None else start.copy()
    residual = right_side - membrane.apply(field)
    limit = tolerance * np.linalg.norm(right_side, axis=0)
    energies = [_energy(field, right_side, residual)]
    direction = np.zeros_like(field)
    previous = np.ones(field.shape[1])
    for iteration in range(max_iterations):
        if (np.linalg.norm(residual, axis=0) <= limit).all():
            return field, SolverReport(
                iteration, np.array(energies), "the residual met its tolerance", converged=True
            )
        improved = _v_cycle(levels, 0, residual)
        slope = np.einsum("pc,pc->c", residual, improved)
        direction = improved + (slope / previous if iteration else 0.0) * direction
        image = membrane.apply(direction)
        curvature = np.einsum("pc,pc->c", direction, image)
        step = np.divide(slope, curvature, out=np.zeros_like(slope), where=curvature > 0)
        field += step * direction
        residual -= step * image
        previous = np.where(slope > 0, slope, 1.0)
        energies.append(_energy(field, right_side, residual))
    return field, SolverReport(
        max_iterations, np.array(energies), "the iteration limit was reached", converged=False
    )


def _energy(field: FloatArray, right_side: FloatArray, residual: FloatArray) -> float:
    # 1/2 x·Ax - b·x with Ax = b - r
    return float(-0.5 * np.sum(field * (right_side + residual)))


def _levels(membrane: Membrane) -> list[tuple[Membrane, IndexArray | None]]:
    levels: list[tuple[Membrane, IndexArray | None]] = []
    while membrane.grid.size > COARSEST_SIZE:
        coarse, parent = membrane.coarsened()
        levels.append((membrane, parent))
        membrane = coarse
    return [*levels, (membrane, None)]


def _v_cycle(
    levels: list[tuple[Membrane, IndexArray | None]], depth: int, right_side: FloatArray
) -> FloatArray:
    membrane, parent = levels[depth]
    grid, links, ties = membrane.grid, membrane.links, membrane.ties
    field = np.zeros_like(right_side)
    if parent is None:
        for _ in range(8):
            _sweep(grid.neighbors, links, ties, right_side, field, False)
            _sweep(grid.neighbors, links, ties, right_side, field, True)
        return field
    _sweep(grid.neighbors, links, ties, right_side, field, False)
    coarse_size = levels[depth + 1][0].grid.size
    restricted = np.zeros((coarse_size, right_side.shape[1]))
    _restrict_residual(grid.neighbors, links, ties, right_side, field, parent, restricted)
    field += _v_cycle(levels, depth + 1, restricted)[parent]
    _sweep(grid.neighbors, links, ties, right_side, field, True)
    return field


@njit(cache=True, nogil=True)
def _apply(neighbors, links, ties, field, result):  # type: ignore[no-untyped-def]
    for p in range(field.shape[0]):
        for c in range(field.shape[1]):
            value = ties[p] * field[p, c]
            for k in range(4):
                q = neighbors[p, k]
                if q >= 0:
                    value += links[p, k] * (field[p, c] - field[q, c])
            result[p, c] = value


@njit(cache=True, nogil=True)
def _sweep(neighbors, links, ties, right_side, field, backward):  # type: ignore[no-untyped-def]
    size = field.shape[0]
    for i in range(size):
        p = size - 1 - i if backward else i
        stiffness = ties[p]
        for k in range(4):
            stiffness += links[p, k]
        if stiffness <= 0.0:
            continue  # a lone pixel without a tie: nothing determines it, its start stands
        for c in range(field.shape[1]):
            value = right_side[p, c]
            for k in range(4):
                q = neighbors[p, k]
                if q >= 0:
                    value += links[p, k] * field[q, c]
            field[p, c] = value / stiffness


@njit(cache=True, nogil=True)
def _restrict_residual(neighbors, links, ties, right_side, field, parent, restricted):  # type: ignore[no-untyped-def]
    for p in range(field.shape[0]):
        for c in range(field.shape[1]):
            value = right_side[p, c] - ties[p] * field[p, c]
            for k in range(4):
                q = neighbors[p, k]
                if q >= 0:
                    value -= links[p, k] * (field[p, c] - field[q, c])
            restricted[parent[p], c] += value

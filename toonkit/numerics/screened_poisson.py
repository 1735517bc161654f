"""Screened Poisson systems on a masked grid, solved by conjugate gradients with a multigrid preconditioner.

The system is A x = b with (A x)_p = d_p x_p + sum over neighbors q of w_pq (x_p - x_q), with edge weights w and a screening
d. A is symmetric, and positive definite if every connected component has a screened pixel. Two systems with the same A are
one with complex x and b.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.compiled import njit
from toonkit.numerics.masked_grid import OUTSIDE, Coarsening, EdgeWeights, MaskedGrid
from toonkit.numerics.parallel import inner_product, run_on_chunks
from toonkit.numerics.report import SolverReport

COARSEST_SIZE = 32
COARSEST_SWEEPS = 8
"""Sweeps on the coarsest grid, each way."""

LINEAR = 12
"""Iterations with linearly interpolated corrections. Edge weights that differ a hundredfold between neighbors may need more:
from then on corrections are constant on blocks, which converges more slowly but always."""

Field = NDArray[Any]
"""float64, or complex128 for two fields at once."""


@dataclass(frozen=True, eq=False)
class ScreenedPoisson:
    """
    Coefficients of a screened Poisson system.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    edge_weights : ndarray of float32, shape (P, 4)
        Weight of the edge to each neighbor >= 0, the same seen from both ends; 0 where there is none.
    screening : ndarray, shape (P,)
        Screening d >= 0 of each pixel.
    """

    grid: MaskedGrid
    edge_weights: EdgeWeights
    screening: FloatArray

    def apply(self, field: Field, out: Field | None = None) -> Field:
        """Return A x for x of shape (P,), float64 or complex128; in `out`, if that is given."""
        result = np.empty_like(field) if out is None else out
        self.grid.chunks.run(_apply, *self._arguments, field, result)
        return result

    def coarsen(self) -> ScreenedPoisson:
        """Return the same problem on 2 x 2 blocks."""
        step = self.grid.coarsening
        return ScreenedPoisson(
            step.coarse, step.coarsen_edge_weights(self.edge_weights), step.sum_blocks(self.screening)
        )

    @property
    def _arguments(self) -> tuple[Any, ...]:
        return self.grid.neighbors, self.edge_weights, self.screening

    def sweep(self, right_side: Field, field: Field, *, backward: bool) -> None:
        """Sweep once over the pixels, in place (Gauss-Seidel)."""
        self.grid.chunks.sweep(_sweep, *self._arguments, right_side, field, backward=backward)

    def sum_residuals(self, right_side: Field, field: Field, out: Field) -> None:
        """Write the residual b - A x, summed over 2 x 2 blocks."""
        out.fill(0.0)
        parent = self.grid.coarsening.parent
        self.grid.chunks.run(_sum_residuals, *self._arguments, right_side, field, parent, out)


def uniform_edge_weights(grid: MaskedGrid) -> EdgeWeights:
    """Weight 1 for every pair of neighbors on the grid, shape (P, 4)."""
    edge_weights: EdgeWeights = (grid.neighbors != OUTSIDE).astype(np.float32)
    return edge_weights


def solve_screened_poisson(
    system: ScreenedPoisson,
    right_side: Field,
    *,
    start: Field | None = None,
    tolerance: float = 1e-7,
    max_iterations: int = 200,
) -> tuple[Field, SolverReport]:
    """
    Solve A x = b by conjugate gradients with one multigrid V-cycle as preconditioner.

    Parameters
    ----------
    system : ScreenedPoisson
        The matrix A.
    right_side : ndarray, shape (P,)
        float64, or complex128 for two at once.
    start : ndarray, shape (P,), optional
        First guess; by default that of coarser grids.
    tolerance : float, optional
        Residual norm to reach, relative to that of the right side.
    max_iterations : int, optional
        Iterations allowed.

    Returns
    -------
    field : ndarray, shape (P,)
        Of the type of the right side.
    report : SolverReport
        Its energies are those of the quadratic 1/2 x·Ax - b·x, summed over the right sides.
    """
    levels = _levels(system, right_side.dtype)
    field = _iterate_nested(levels, right_side) if start is None else start.astype(right_side.dtype)
    image = system.apply(field)
    residual = np.subtract(right_side, image, out=levels[0].right_side)
    # 1/2 x·Ax - b·x with Ax = b - r
    energies = [-0.5 * (inner_product(field, right_side) + inner_product(field, residual))]
    limit = tolerance * np.sqrt(inner_product(right_side, right_side))
    direction = np.zeros_like(field)
    step, previous = 0.0, 1.0
    for iteration in range(max_iterations):
        if np.sqrt(inner_product(residual, residual)) <= limit:
            reason = "the residual met its tolerance"
            return field, SolverReport(iteration, np.array(energies), reason, converged=True)
        improved = _v_cycle(levels, 0, linear=iteration < LINEAR)
        # Polak and Ribière's share of the last direction: the preconditioner is not quite symmetric.
        share = 0.0 if iteration == LINEAR else max(-step * inner_product(image, improved) / previous, 0.0)
        run_on_chunks(_update_direction, len(field), direction, improved, share)
        system.apply(direction, image)
        curvature = inner_product(direction, image)
        along = inner_product(residual, direction)
        step = along / curvature if curvature > 0 else 0.0
        previous = along if along > 0 else 1.0
        run_on_chunks(_advance, len(field), field, residual, direction, image, step)
        energies.append(energies[-1] - 0.5 * step * along)
    reason = "the iteration limit was reached"
    return field, SolverReport(max_iterations, np.array(energies), reason, converged=False)


def _update_direction(direction: Field, improved: Field, share: float, chunk: slice) -> None:
    """Set a direction to an improvement plus a share of the last direction."""
    direction[chunk] *= share
    direction[chunk] += improved[chunk]


def _advance(
    field: Field, residual: Field, direction: Field, image: Field, step: float, chunk: slice
) -> None:
    """Make a step along a direction whose image is known."""
    field[chunk] += step * direction[chunk]
    residual[chunk] -= step * image[chunk]


@dataclass(frozen=True, eq=False)
class _Level:
    """A system on one of the grids, with reused memory for its right side and its solution."""

    system: ScreenedPoisson
    right_side: Field
    solution: Field

    @classmethod
    def of(cls, system: ScreenedPoisson, kind: np.dtype[Any]) -> _Level:
        return cls(system, *np.empty((2, system.grid.size), kind))


def _levels(system: ScreenedPoisson, kind: np.dtype[Any]) -> list[_Level]:
    levels = [_Level.of(system, kind)]
    while levels[-1].system.grid.size > COARSEST_SIZE:
        levels.append(_Level.of(levels[-1].system.coarsen(), kind))
    return levels


def _iterate_nested(levels: list[_Level], right_side: Field) -> Field:
    """Nested iteration: a cycle on each coarser grid, from the coarsest, each starting where the last one ended."""
    right_sides = [right_side]
    for level in levels[:-1]:
        right_sides.append(_block_sums(level.system.grid.coarsening, right_sides[-1]))
    levels[-1].right_side[:] = right_sides[-1]
    field = _v_cycle(levels, len(levels) - 1).copy()
    for depth in reversed(range(len(levels) - 1)):
        system = levels[depth].system
        field = _interpolate_from(system.grid.coarsening, field)
        if depth:
            np.subtract(right_sides[depth], system.apply(field), out=levels[depth].right_side)
            field += _v_cycle(levels, depth)
    return field


def _v_cycle(levels: list[_Level], depth: int, *, linear: bool = True) -> Field:
    """Return an approximate solution for a level's right side, in its memory."""
    level = levels[depth]
    system, right_side, field = level.system, level.right_side, level.solution
    field.fill(0.0)
    if depth == len(levels) - 1:
        for _ in range(COARSEST_SWEEPS):
            system.sweep(right_side, field, backward=False)
            system.sweep(right_side, field, backward=True)
        return field
    system.sweep(right_side, field, backward=False)
    system.sum_residuals(right_side, field, levels[depth + 1].right_side)
    correction = _v_cycle(levels, depth + 1, linear=linear)
    step = system.grid.coarsening
    if linear:
        step.interpolate(_parts(correction), _parts(field), adding=True)
    else:
        field += correction[step.parent]
    system.sweep(right_side, field, backward=True)
    return field


def _interpolate_from(step: Coarsening, field: Field) -> Field:
    out = np.empty(step.fine.size, field.dtype)
    step.interpolate(_parts(field), _parts(out))
    return out


def _block_sums(step: Coarsening, field: Field) -> Field:
    return step.sum_blocks(_parts(field)).view(field.dtype)[:, 0]


def _parts(field: Field) -> FloatArray:
    """View a field (P,) as real numbers (P, 1), or (P, 2) where it is complex."""
    return field.view(np.float64).reshape(len(field), -1)


@njit(cache=True, nogil=True, error_model="numpy")
def _apply(neighbors, edge_weights, screening, field, result, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        here = field[p]
        value = screening[p] * here
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                value += edge_weights[p, k] * (here - field[q])
        result[p] = value


@njit(cache=True, nogil=True, error_model="numpy")
def _sweep(neighbors, edge_weights, screening, right_side, field, backward, first, last):  # type: ignore[no-untyped-def]
    for i in range(first, last):
        p = first + last - 1 - i if backward else i
        stiffness = screening[p]
        value = right_side[p]
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                stiffness += edge_weights[p, k]
                value += edge_weights[p, k] * field[q]
        if stiffness > 0.0:  # nothing determines an isolated pixel without screening, so it keeps its value
            field[p] = value * (1.0 / stiffness)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_residuals(neighbors, edge_weights, screening, right_side, field, parent, sums, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        here = field[p]
        value = right_side[p] - screening[p] * here
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                value -= edge_weights[p, k] * (here - field[q])
        sums[parent[p]] += value

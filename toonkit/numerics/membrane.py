"""Membrane systems on a masked grid: weighted links between neighbors, solved by multigrid-preconditioned gradients.

The system is A x = b with (A x)_p = d_p x_p + sum over neighbors q of w_pq (x_p - x_q): a Laplace or Poisson problem whose
links may have different stiffness and whose pixels may be tied to given values (d, b). A is symmetric and, where every
component has a tie, positive definite. Two problems with the same A are one with complex x and b.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.bands import inner, run_in_pieces
from toonkit.numerics.compiled import njit
from toonkit.numerics.masked_grid import OUTSIDE, Coarsening, Links, MaskedGrid
from toonkit.numerics.report import SolverReport

COARSEST_SIZE = 32
COARSEST_SWEEPS = 8
"""Sweeps on the coarsest grid, each way."""

LINEAR = 12
"""Iterations with corrections that are interpolated linearly. Links that differ a hundredfold from one to the next may need
more: then block by block, which makes the cycle symmetric and slower but sure."""

Field = NDArray[Any]
"""float64, or complex128 for two fields at once."""


@dataclass(frozen=True, eq=False)
class Membrane:
    """
    Coefficients of a membrane system.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    links : ndarray of float32, shape (P, 4)
        Weight of the link to each neighbor >= 0, the same seen from both ends; 0 where there is none.
    ties : ndarray, shape (P,)
        Weight d >= 0 that ties each pixel to a given value.
    """

    grid: MaskedGrid
    links: Links
    ties: FloatArray

    def apply(self, field: Field, out: Field | None = None) -> Field:
        """Return A x for x of shape (P,), float64 or complex128; in `out`, if that is given."""
        result = np.empty_like(field) if out is None else out
        self.grid.bands.run(_apply, *self._arguments, field, result)
        return result

    def coarsened(self) -> Membrane:
        """Return the same problem on 2 x 2 blocks."""
        step = self.grid.coarsening
        return Membrane(step.coarse, step.links(self.links), step.sums(self.ties))

    @property
    def _arguments(self) -> tuple[Any, ...]:
        return self.grid.neighbors, self.links, self.ties

    def relax(self, right_side: Field, field: Field, *, backward: bool) -> None:
        """Sweep once, in place: every pixel takes the value that its own equation asks for."""
        self.grid.bands.sweep(_relax, *self._arguments, right_side, field, backward=backward)

    def sum_residuals(self, right_side: Field, field: Field, out: Field) -> None:
        """Write the residual b - A x, summed over 2 x 2 blocks."""
        out.fill(0.0)
        parent = self.grid.coarsening.parent
        self.grid.bands.run(_sum_residuals, *self._arguments, right_side, field, parent, out)


def uniform_links(grid: MaskedGrid) -> Links:
    """Weight 1 for every pair of neighbors on the grid, shape (P, 4)."""
    links: Links = (grid.neighbors != OUTSIDE).astype(np.float32)
    return links


def solve_membrane(
    membrane: Membrane,
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
    membrane : Membrane
        The matrix A.
    right_side : ndarray, shape (P,)
        float64, or complex128 for two right sides that are solved together.
    start : ndarray, shape (P,), optional
        First guess; by default that of coarser grids.
    tolerance : float, optional
        Residual norm to reach, relative to that of the right side.
    max_iterations : int, optional
        Iterations allowed.

    Returns
    -------
    field : ndarray, shape (P,)
        The solution, of the type of the right side.
    report : SolverReport
        Its energies are those of the quadratic 1/2 x·Ax - b·x, summed over the right sides.

    Notes
    -----
    The V-cycle coarsens by 2 x 2 blocks, so that the coarse problem is again a membrane, whatever the outline. Residuals are
    summed and corrections interpolated linearly, which is not quite symmetric: the directions are made conjugate by the
    formula of Polak and Ribière, which does not ask for that.
    """
    levels = _levels(membrane, right_side.dtype)
    field = _from_coarse_grids(levels, right_side) if start is None else start.astype(right_side.dtype)
    image = membrane.apply(field)
    residual = np.subtract(right_side, image, out=levels[0].asked)
    # 1/2 x·Ax - b·x with Ax = b - r
    energies = [-0.5 * (inner(field, right_side) + inner(field, residual))]
    limit = tolerance * np.sqrt(inner(right_side, right_side))
    direction = np.zeros_like(field)
    step, previous = 0.0, 1.0
    for iteration in range(max_iterations):
        if np.sqrt(inner(residual, residual)) <= limit:
            return field, SolverReport(
                iteration, np.array(energies), "the residual met its tolerance", converged=True
            )
        improved = _v_cycle(levels, 0, linear=iteration < LINEAR)
        # Polak and Ribière's share of the last direction, by whose image the residual has changed.
        share = 0.0 if iteration == LINEAR else max(-step * inner(image, improved) / previous, 0.0)
        run_in_pieces(_turn, len(field), direction, improved, share)
        membrane.apply(direction, image)
        curvature = inner(direction, image)
        along = inner(residual, direction)
        step = along / curvature if curvature > 0 else 0.0
        previous = along if along > 0 else 1.0
        run_in_pieces(_advance, len(field), field, residual, direction, image, step)
        energies.append(energies[-1] - 0.5 * step * along)
    return field, SolverReport(
        max_iterations, np.array(energies), "the iteration limit was reached", converged=False
    )


def _turn(direction: Field, improved: Field, share: float, piece: slice) -> None:
    """Let a direction follow an improvement, and a share of what it was."""
    direction[piece] *= share
    direction[piece] += improved[piece]


def _advance(
    field: Field, residual: Field, direction: Field, image: Field, step: float, piece: slice
) -> None:
    """Go a step along a direction, whose image is known."""
    field[piece] += step * direction[piece]
    residual[piece] -= step * image[piece]


@dataclass(frozen=True, eq=False)
class _Level:
    """A membrane on one of the grids, and memory for what a cycle is asked there and answers: new memory is slow."""

    membrane: Membrane
    asked: Field
    answer: Field

    @classmethod
    def of(cls, membrane: Membrane, kind: np.dtype[Any]) -> _Level:
        return cls(membrane, *np.empty((2, membrane.grid.size), kind))


def _levels(membrane: Membrane, kind: np.dtype[Any]) -> list[_Level]:
    levels = [_Level.of(membrane, kind)]
    while levels[-1].membrane.grid.size > COARSEST_SIZE:
        levels.append(_Level.of(levels[-1].membrane.coarsened(), kind))
    return levels


def _from_coarse_grids(levels: list[_Level], right_side: Field) -> Field:
    """Nested iteration: a cycle on each coarser grid, from the coarsest, each starting where the last one ended."""
    right_sides = [right_side]
    for level in levels[:-1]:
        right_sides.append(_block_sums(level.membrane.grid.coarsening, right_sides[-1]))
    levels[-1].asked[:] = right_sides[-1]
    field = _v_cycle(levels, len(levels) - 1).copy()
    for depth in reversed(range(len(levels) - 1)):
        membrane = levels[depth].membrane
        field = _interpolated(membrane.grid.coarsening, field)
        if depth:
            np.subtract(right_sides[depth], membrane.apply(field), out=levels[depth].asked)
            field += _v_cycle(levels, depth)
    return field


def _v_cycle(levels: list[_Level], depth: int, *, linear: bool = True) -> Field:
    """Return about the solution of what a level is asked, in its memory."""
    level = levels[depth]
    membrane, right_side, field = level.membrane, level.asked, level.answer
    field.fill(0.0)
    if depth == len(levels) - 1:
        for _ in range(COARSEST_SWEEPS):
            membrane.relax(right_side, field, backward=False)
            membrane.relax(right_side, field, backward=True)
        return field
    membrane.relax(right_side, field, backward=False)
    membrane.sum_residuals(right_side, field, levels[depth + 1].asked)
    correction = _v_cycle(levels, depth + 1, linear=linear)
    step = membrane.grid.coarsening
    if linear:
        step.interpolated(_parts(correction), _parts(field), adding=True)
    else:
        field += correction[step.parent]
    membrane.relax(right_side, field, backward=True)
    return field


def _interpolated(step: Coarsening, field: Field) -> Field:
    out = np.empty(step.fine.size, field.dtype)
    step.interpolated(_parts(field), _parts(out))
    return out


def _block_sums(step: Coarsening, field: Field) -> Field:
    return step.sums(_parts(field)).view(field.dtype)[:, 0]


def _parts(field: Field) -> FloatArray:
    """View a field (P,) as real numbers (P, 1), or (P, 2) where it is complex."""
    return field.view(np.float64).reshape(len(field), -1)


@njit(cache=True, nogil=True, error_model="numpy")
def _apply(neighbors, links, ties, field, result, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        here = field[p]
        value = ties[p] * here
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                value += links[p, k] * (here - field[q])
        result[p] = value


@njit(cache=True, nogil=True, error_model="numpy")
def _relax(neighbors, links, ties, right_side, field, backward, first, last):  # type: ignore[no-untyped-def]
    for i in range(first, last):
        p = first + last - 1 - i if backward else i
        stiffness = ties[p]
        value = right_side[p]
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                stiffness += links[p, k]
                value += links[p, k] * field[q]
        if stiffness > 0.0:  # nothing determines a lone pixel without a tie: its start stands
            field[p] = value * (1.0 / stiffness)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_residuals(neighbors, links, ties, right_side, field, parent, sums, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        here = field[p]
        value = right_side[p] - ties[p] * here
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                value -= links[p, k] * (here - field[q])
        sums[parent[p]] += value

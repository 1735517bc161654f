"""Unit-vector fields by coarse-to-fine pointwise minimization.

Minimizes, over unit vectors with z >= 0 on a masked grid,

    sum w_p P(L · n_p) + l² (sum over links k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r_p²,      d = n - n0,

where P is the squared distance of L · n to an interval and r the integrability residual of a unit field.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import IndexArray, MaskedGrid, block_sums
from toonkit.numerics.membrane import Membrane
from toonkit.numerics.report import SolverReport
from toonkit.numerics.unit_field_kernels import sweep_unit_field

COARSEST_SIZE = 64


@dataclass(frozen=True, eq=False)
class UnitFieldProblem:
    """
    One problem on one grid.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    start : ndarray, shape (P, 3)
        n0, unit vectors from which the change is measured.
    direction : ndarray, shape (3,)
        Unit vector L.
    lower, upper : ndarray, shape (P,)
        Interval of L · n.
    weight : ndarray, shape (P,)
        Weight w of the interval penalty.
    links : ndarray, shape (P, 4)
        Stiffness k of the link to each neighbor, the same seen from both ends.
    ties : ndarray, shape (P,)
        Stiffness t that holds a pixel to n0.
    change_weight, integrability_weight : float
        l² and m².
    """

    grid: MaskedGrid
    start: FloatArray
    direction: FloatArray
    lower: FloatArray
    upper: FloatArray
    weight: FloatArray
    links: FloatArray
    ties: FloatArray
    change_weight: float
    integrability_weight: float

    def coarsened(self) -> tuple[UnitFieldProblem, IndexArray]:
        """Return the same problem on 2 x 2 blocks, and the block of each pixel."""
        membrane, parent = Membrane(self.grid, self.links, self.ties).coarsened()
        grid = membrane.grid
        weight = block_sums(parent, self.weight, grid.size)

        def mean(values: FloatArray) -> FloatArray:
            return block_sums(parent, self.weight * values, grid.size) / weight

        start = np.stack([mean(component) for component in self.start.T], axis=1)
        return replace(
            self,
            grid=grid,
            start=_normalized(start),
            lower=mean(self.lower),
            upper=mean(self.upper),
            weight=weight,
            links=membrane.links,
            ties=membrane.ties,
        ), parent


def solve_unit_field(
    problem: UnitFieldProblem,
    *,
    energy: Callable[[FloatArray], float],
    sweeps: int = 40,
    tolerance: float = 1e-4,
    progress: Callable[[float], None] | None = None,
) -> tuple[FloatArray, SolverReport]:
    """
    Minimize, from the coarsest grid to the given one.

    Parameters
    ----------
    problem : UnitFieldProblem
        The problem on the finest grid.
    energy : callable
        Energy of a field (P, 3) on the finest grid, for the report.
    sweeps : int, optional
        Gauss-Seidel sweeps allowed on each grid.
    tolerance : float, optional
        Root mean square change in one sweep, in radians, below which a grid is done.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the solver.

    Returns
    -------
    field : ndarray, shape (P, 3)
        Unit vectors.
    report : SolverReport
        Iterations are sweeps on the finest grid; energies are those of n0, of the field that the coarser grids gave, and of
        the result.

    Notes
    -----
    A step puts one pixel where its own energy is least, its neighbors fixed: exactly for the membrane and the interval,
    through an upper bound of equal value and slope for the integrability. The energy never rises.
    """
    levels = [problem]
    parents: list[IndexArray] = []
    while levels[-1].grid.size > COARSEST_SIZE:
        coarse, parent = levels[-1].coarsened()
        levels.append(coarse)
        parents.append(parent)
    total = float(sum(level.grid.size for level in levels))
    done = 0.0
    change = np.zeros_like(levels[-1].start)
    energies = [energy(problem.start)]
    for depth in range(len(levels) - 1, -1, -1):
        level = levels[depth]
        field = _normalized(level.start + change)
        if depth == 0:
            energies.append(energy(field))
        share = level.grid.size / total
        for sweep in range(1, sweeps + 1):
            moved = _sweep_level(level, field)
            if progress is not None:
                progress(done + share * sweep / sweeps)
            if moved < tolerance:
                break
        done += share
        change = field - level.start
        if depth:
            change = change[parents[depth - 1]]
    energies.append(energy(field))
    finished = moved < tolerance
    reason = (
        f"a sweep moved the normals by {np.rad2deg(moved):.2g} degrees"
        if finished
        else "the sweep limit was reached"
    )
    return field, SolverReport(sweep, np.array(energies), reason, converged=finished)


def _normalized(field: FloatArray) -> FloatArray:
    """Return unit vectors with z >= 0; a vanishing sum faces the viewer."""
    field = field.copy()
    field[:, 2] = np.maximum(field[:, 2], 0.0)
    length = np.linalg.norm(field, axis=1, keepdims=True)
    return np.where(length > 1e-9, field / np.maximum(length, 1e-9), [0.0, 0.0, 1.0])


def _sweep_level(level: UnitFieldProblem, field: FloatArray) -> float:
    """Sweep once, in place; return the root mean square move."""
    squared = sweep_unit_field(
        level.grid.neighbors, level.start, level.direction, level.lower, level.upper, level.weight,
        level.links, level.ties, level.change_weight, level.integrability_weight, field,
    )  # fmt: skip
    return float(np.sqrt(squared / level.grid.size))

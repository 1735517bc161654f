"""
Multigrid V-cycles for unit-vector fields, with the full approximation scheme (FAS).

Each coarse problem has the same form plus a linear term (the tau correction), so that a fine-grid stationary point is also
stationary on the coarse grid. Where a component lies outside its interval, the coarse problem keeps the same penalty
curvature.

The scheme is that of A. Brandt, "Multi-level adaptive solutions to boundary-value problems", Math. Comp. 31 (1977),
doi:10.1090/S0025-5718-1977-0431719-X.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from toonkit.numerics.change_kernels import gather_blocks, retract
from toonkit.numerics.parallel import inner_product
from toonkit.numerics.unit_vectors import Stored, Terms, UnitVectorEnergy, add_and_normalize

COARSEST_SIZE = 1000
"""Maximum size of the coarsest grid, in pixels. On coarser grids one vector would represent too much of the curvature."""

COARSEST_SWEEPS = 5
"""Forward and backward sweeps on the coarsest grid."""

LONGEST_CORRECTION = 2.0
"""Maximum step length along a coarse-grid correction; 1 applies it unscaled."""


@dataclass(frozen=True, eq=False)
class Level:
    """
    A problem on one of the grids.

    Attributes
    ----------
    problem : UnitVectorEnergy
        The problem on this grid.
    coarser : Level or None
        The next coarser level, None on the coarsest grid.
    """

    problem: UnitVectorEnergy
    coarser: Level | None
    _buffers: dict[str, Stored] = field(default_factory=dict)

    @classmethod
    def finest(cls, problem: UnitVectorEnergy) -> Level:
        """Build the level for this problem and all coarser levels below it."""
        if problem.grid.size <= COARSEST_SIZE:
            return cls(problem, None)
        return cls(problem, cls.finest(problem.coarsen()))

    def workspace(self, name: str) -> Stored:
        """Return a reused buffer for a vector field. Allocating a new one would cost more than the computation."""
        if name not in self._buffers:
            self._buffers[name] = np.empty_like(self.problem.start)
        return self._buffers[name]

    def exchange(self, name: str, memory: Stored | None) -> None:
        """Replace a buffer, because the caller keeps the old one; None allocates a new one on demand."""
        self._buffers.pop(name, None)
        if memory is not None:
            self._buffers[name] = memory

    def clear_workspace(self, name: str, count: int) -> Stored:
        """Return a reused buffer of shape (count, P), set to zero."""
        if name not in self._buffers:
            self._buffers[name] = np.empty((count, self.problem.grid.size), self.problem.start.dtype)
        self._buffers[name].fill(0.0)
        return self._buffers[name]

    def retract(self, field: Stored, step: Stored, length: float, out: Stored) -> Stored:
        """Write the unit vectors of `field + length * step` to `out`, and return it; it may be one of the two."""
        self.problem.grid.chunks.run(retract, field, step, length, out)
        return out


def iterate_nested(level: Level, guess: Stored) -> Stored:
    """
    Return a guess (P, 3) improved by nested iteration.

    From the coarsest level to the finest, each coarser level runs one cycle, and the change is interpolated.
    """
    coarse = level.coarser
    if coarse is None:
        return guess.copy()
    step = level.problem.grid.coarsening
    sums = step.sum_blocks(guess)
    its_guess = add_and_normalize(coarse.problem.grid, sums, sums)
    field = iterate_nested(coarse, its_guess)
    cycle(coarse, coarse.problem.terms, field)
    change = step.interpolate(field - its_guess, np.empty_like(guess))
    return level.retract(guess, change, 1.0, change)


def cycle(level: Level, terms: Terms, field: Stored) -> None:
    """Improve a field in place: pre-smooth, apply the coarse-grid correction, post-smooth in the opposite order."""
    if level.coarser is None:
        for _ in range(COARSEST_SWEEPS):
            level.problem.sweep(terms, field, backward=False)
            level.problem.sweep(terms, field, backward=True)
        return
    level.problem.sweep(terms, field, backward=False)
    gradient = level.workspace("slopes")
    energy = level.problem.value_and_gradient(terms, field, gradient)
    correct(level, terms, field, gradient, energy)


def correct(level: Level, terms: Terms, field: Stored, gradient: Stored, energy: float) -> None:
    """Apply the coarse-grid correction to a field whose gradient is known, in place, then post-smooth."""
    coarse = level.coarser
    if coarse is None:
        cycle(level, terms, field)
        return
    start, its_terms = _restrict(level, coarse, terms, field, gradient)
    change = coarse.workspace("change")
    change[:] = start
    cycle(coarse, its_terms, change)
    change -= start
    fits = len(field) >= level.problem.fitting_from
    # If its length is not looked for, the gradient has done its work.
    buffer = level.workspace("slopes" if fits else "step")
    step = level.problem.grid.coarsening.interpolate(change, buffer)
    length = 1.0 if fits else _fit_step_length(level, terms, field, step, gradient, energy)
    level.retract(field, step, length, field)
    level.problem.sweep(terms, field, backward=True)


def _restrict(
    level: Level, coarse: Level, terms: Terms, field: Stored, gradient: Stored
) -> tuple[Stored, Terms]:
    """Return the unit mean vectors of the blocks, and the coarse terms with the tau correction."""
    direction = level.problem.direction.astype(field.dtype)
    hold, target, lower, upper, weight = coarse.clear_workspace("components", 5)
    start, slopes = coarse.workspace("start"), coarse.workspace("slopes")
    start.fill(0.0)
    slopes.fill(0.0)
    level.problem.grid.chunks.run(
        gather_blocks, level.problem.grid.coarsening.parent, direction, field, gradient, terms.hold, terms.lower,
        terms.upper, terms.weight, start, slopes, hold, lower, upper, weight,
    )  # fmt: skip
    coarse.retract(start, start, 0.0, start)
    np.einsum("pc,c->p", start, direction, out=target)
    # Block interval: weighted mean over pixels inside their intervals, widened to contain the component; [-1, 1] if none is.
    free = weight == 0.0
    for bound, widest, wider in ((lower, -1.0, np.minimum), (upper, 1.0, np.maximum)):
        np.divide(bound, weight, out=bound, where=~free)
        wider(bound, target, out=bound)
        bound[free] = widest
    terms = Terms(lower, upper, weight, hold, target, terms.tau[:0])
    tau = coarse.workspace("tau")
    coarse.problem.value_and_gradient(terms, start, tau)
    tau -= slopes
    return start, replace(terms, tau=tau)


def _fit_step_length(
    level: Level, terms: Terms, field: Stored, step: Stored, gradient: Stored, energy: float
) -> float:
    """
    Return the step length that minimizes a parabola, at most `LONGEST_CORRECTION`.

    It is fitted to the energy and its slope at length 0 and to the energy at length 1.
    """
    along = inner_product(gradient, step)
    end = level.retract(field, step, 1.0, level.workspace("end"))
    bend = level.problem.value_and_gradient(terms, end, level.workspace("end's gradient")) - energy - along
    return float(np.clip(-along / (2.0 * bend), 0.0, LONGEST_CORRECTION)) if bend > 0.0 else 1.0

"""
Multigrid V-cycles for unit-vector fields, with the full approximation scheme (FAS).

Each coarse problem has the same form plus a linear term (the tau correction), so that a fine-grid stationary point is also
stationary on the coarse grid. Where a component lies outside its interval, the coarse problem keeps the same penalty
curvature.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from toonkit.numerics.bands import inner
from toonkit.numerics.change_kernels import gather_blocks, retract
from toonkit.numerics.unit_vectors import Stored, Terms, UnitVectorEnergy, moved

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
    _workspace: dict[str, Stored] = field(default_factory=dict)

    @classmethod
    def finest(cls, problem: UnitVectorEnergy) -> Level:
        """Build the level for this problem and all coarser levels below it."""
        if problem.grid.size <= COARSEST_SIZE:
            return cls(problem, None)
        return cls(problem, cls.finest(problem.coarsened()))

    def room(self, name: str) -> Stored:
        """Return a reused buffer for a vector field. Allocating a new one would cost more than the computation."""
        if name not in self._workspace:
            self._workspace[name] = np.empty_like(self.problem.start)
        return self._workspace[name]

    def exchange(self, name: str, memory: Stored | None) -> None:
        """Replace a buffer, because the caller keeps the old one; None allocates a new one on demand."""
        self._workspace.pop(name, None)
        if memory is not None:
            self._workspace[name] = memory

    def cleared(self, name: str, count: int) -> Stored:
        """Return a reused buffer of shape (count, P), set to zero."""
        if name not in self._workspace:
            self._workspace[name] = np.empty((count, self.problem.grid.size), self.problem.start.dtype)
        self._workspace[name].fill(0.0)
        return self._workspace[name]

    def retracted(self, field: Stored, step: Stored, length: float, out: Stored) -> Stored:
        """Write the unit vectors of `field + length * step` to `out`, and return it; it may be one of the two."""
        self.problem.grid.bands.run(retract, field, step, length, out)
        return out


def from_coarser_grids(level: Level, guess: Stored) -> Stored:
    """
    Return a guess (P, 3) improved by nested iteration.

    From the coarsest level to the finest, each coarser level runs one cycle, and the change is interpolated.
    """
    coarse = level.coarser
    if coarse is None:
        return guess.copy()
    step = level.problem.grid.coarsening
    sums = step.sums(guess)
    its_guess = moved(coarse.problem.grid, sums, sums)
    field = from_coarser_grids(coarse, its_guess)
    cycle(coarse, coarse.problem.posed, field)
    change = step.interpolated(field - its_guess, np.empty_like(guess))
    return level.retracted(guess, change, 1.0, change)


def cycle(level: Level, terms: Terms, field: Stored) -> None:
    """Improve a field in place: pre-smooth, apply the coarse-grid correction, post-smooth in the opposite order."""
    if level.coarser is None:
        for _ in range(COARSEST_SWEEPS):
            level.problem.relax(terms, field, backward=False)
            level.problem.relax(terms, field, backward=True)
        return
    level.problem.relax(terms, field, backward=False)
    gradient = level.room("slopes")
    energy = level.problem.value_and_gradient(terms, field, gradient)
    correct(level, terms, field, gradient, energy)


def correct(level: Level, terms: Terms, field: Stored, gradient: Stored, energy: float) -> None:
    """Apply the coarse-grid correction to a field whose gradient is known, in place, then post-smooth."""
    coarse = level.coarser
    if coarse is None:
        cycle(level, terms, field)
        return
    start, its_terms = _restricted(level, coarse, terms, field, gradient)
    change = coarse.room("change")
    change[:] = start
    cycle(coarse, its_terms, change)
    change -= start
    fits = len(field) >= level.problem.fitting_from
    # If its length is not looked for, the gradient has done its work.
    room = level.room("slopes" if fits else "step")
    step = level.problem.grid.coarsening.interpolated(change, room)
    length = 1.0 if fits else _fitting_length(level, terms, field, step, gradient, energy)
    level.retracted(field, step, length, field)
    level.problem.relax(terms, field, backward=True)


def _restricted(
    level: Level, coarse: Level, terms: Terms, field: Stored, gradient: Stored
) -> tuple[Stored, Terms]:
    """Return the unit mean vectors of the blocks, and the coarse terms including the tau correction."""
    direction = level.problem.direction.astype(field.dtype)
    hold, target, lower, upper, weight = coarse.cleared("components", 5)
    start, slopes = coarse.room("start"), coarse.room("slopes")
    start.fill(0.0)
    slopes.fill(0.0)
    level.problem.grid.bands.run(
        gather_blocks, level.problem.grid.coarsening.parent, direction, field, gradient, terms.hold, terms.lower,
        terms.upper, terms.weight, start, slopes, hold, lower, upper, weight,
    )  # fmt: skip
    coarse.retracted(start, start, 0.0, start)
    np.einsum("pc,c->p", start, direction, out=target)
    # Block interval: weighted mean over pixels inside their intervals, widened to contain the component; [-1, 1] if none is.
    free = weight == 0.0
    for bound, widest, wider in ((lower, -1.0, np.minimum), (upper, 1.0, np.maximum)):
        np.divide(bound, weight, out=bound, where=~free)
        wider(bound, target, out=bound)
        bound[free] = widest
    terms = Terms(lower, upper, weight, hold, target, terms.source[:0])
    source = coarse.room("source")
    coarse.problem.value_and_gradient(terms, start, source)
    source -= slopes
    return start, replace(terms, source=source)


def _fitting_length(
    level: Level, terms: Terms, field: Stored, step: Stored, gradient: Stored, energy: float
) -> float:
    """
    Return the step length that minimizes a parabola, at most `LONGEST_CORRECTION`.

    It is fitted to the energy and its slope at length 0 and to the energy at length 1.
    """
    along = inner(gradient, step)
    end = level.retracted(field, step, 1.0, level.room("end"))
    bend = level.problem.value_and_gradient(terms, end, level.room("end's gradient")) - energy - along
    return float(np.clip(-along / (2.0 * bend), 0.0, LONGEST_CORRECTION)) if bend > 0.0 else 1.0

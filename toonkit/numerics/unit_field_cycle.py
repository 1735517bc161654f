"""
Cycles of the solver for unit vectors over ever coarser grids: the full approximation scheme.

Coarse grids see the same kind of problem, with a linear term that makes them stand still where the fine grid does, and with
the components that are outside their intervals held as firmly as they are there.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.bands import inner
from toonkit.numerics.change_kernels import gather_blocks, retract
from toonkit.numerics.unit_vectors import NO_SOURCE, Terms, UnitVectorEnergy, moved

COARSEST_SIZE = 1000
"""Pixels of the coarsest grid at most: on still coarser ones one vector stands for too much of an object's curvature."""

COARSEST_SWEEPS = 5
"""Sweeps there, each way."""

LONGEST_CORRECTION = 2.0
"""How far a coarser grid's correction is followed at most, in units of itself."""


@dataclass(frozen=True, eq=False)
class Level:
    """
    A problem on one of the grids.

    Attributes
    ----------
    problem : UnitVectorEnergy
        The problem there.
    coarser : Level or None
        The next one, None on the coarsest grid.
    """

    problem: UnitVectorEnergy
    coarser: Level | None
    _rooms: dict[str, FloatArray] = field(default_factory=dict)

    @classmethod
    def finest(cls, problem: UnitVectorEnergy) -> Level:
        """Return the level of a problem as it is posed, with those of all coarser grids behind it."""
        if problem.grid.size <= COARSEST_SIZE:
            return cls(problem, None)
        return cls(problem, cls.finest(problem.coarsened()))

    def room(self, name: str) -> FloatArray:
        """Return memory for a field of vectors, kept: new memory costs more than what is done in it."""
        if name not in self._rooms:
            self._rooms[name] = np.empty_like(self.problem.start)
        return self._rooms[name]

    def exchange(self, name: str, memory: FloatArray | None) -> None:
        """Put other memory, or new one, in a room's place: what it holds is to stay."""
        self._rooms.pop(name, None)
        if memory is not None:
            self._rooms[name] = memory

    def cleared(self, name: str, count: int) -> FloatArray:
        """Return memory for so many numbers a pixel, (count, P), kept and set to zero."""
        if name not in self._rooms:
            self._rooms[name] = np.empty((count, self.problem.grid.size))
        self._rooms[name].fill(0.0)
        return self._rooms[name]

    def retracted(self, field: FloatArray, step: FloatArray, length: float, out: FloatArray) -> FloatArray:
        """Write the unit vectors of `field + length * step` to `out`, and return it; it may be one of the two."""
        self.problem.grid.bands.run(retract, field, step, length, out)
        return out


def from_coarser_grids(level: Level, guess: FloatArray) -> FloatArray:
    """Return a guess (P, 3) as the coarser grids change it: each makes a cycle from what those beyond it made of theirs."""
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


def cycle(level: Level, terms: Terms, field: FloatArray) -> None:
    """Improve a field in place: relax, let the coarser grids correct it, relax in the opposite order."""
    if level.coarser is None:
        for _ in range(COARSEST_SWEEPS):
            level.problem.relax(terms, field, backward=False)
            level.problem.relax(terms, field, backward=True)
        return
    level.problem.relax(terms, field, backward=False)
    gradient = level.room("gradient")
    energy = level.problem.value_and_gradient(terms, field, gradient)
    correct(level, terms, field, gradient, energy)


def correct(level: Level, terms: Terms, field: FloatArray, gradient: FloatArray, energy: float) -> None:
    """Let the coarser grids correct a field whose gradient is known, in place, and relax it."""
    coarse = level.coarser
    if coarse is None:
        cycle(level, terms, field)
        return
    start, its_terms = _restricted(level, coarse, terms, field, gradient)
    change = coarse.room("change")
    change[:] = start
    cycle(coarse, its_terms, change)
    change -= start
    step = level.problem.grid.coarsening.interpolated(change, level.room("step"))
    fits = len(field) >= level.problem.fitting_from
    length = 1.0 if fits else _fitting_length(level, terms, field, step, gradient, energy)
    level.retracted(field, step, length, field)
    level.problem.relax(terms, field, backward=True)


def _restricted(
    level: Level, coarse: Level, terms: Terms, field: FloatArray, gradient: FloatArray
) -> tuple[FloatArray, Terms]:
    """Return the mean vectors of the blocks, and the terms under which the coarse level stands still where this one does."""
    direction = level.problem.direction
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
    # Within an interval that contains the component, the means; without any, whatever there is.
    free = weight == 0.0
    for bound, widest, wider in ((lower, -1.0, np.minimum), (upper, 1.0, np.maximum)):
        np.divide(bound, weight, out=bound, where=~free)
        wider(bound, target, out=bound)
        bound[free] = widest
    terms = Terms(lower, upper, weight, hold, target, NO_SOURCE)
    source = coarse.room("source")
    coarse.problem.value_and_gradient(terms, start, source)
    source -= slopes
    return start, replace(terms, source=source)


def _fitting_length(
    level: Level, terms: Terms, field: FloatArray, step: FloatArray, gradient: FloatArray, energy: float
) -> float:
    """Return the length of a step at which a parabola is least: through the energy and its slope here, and at its end."""
    along = inner(gradient, step)
    end = level.retracted(field, step, 1.0, level.room("end"))
    bend = level.problem.value_and_gradient(terms, end, level.room("end's gradient")) - energy - along
    return float(np.clip(-along / (2.0 * bend), 0.0, LONGEST_CORRECTION)) if bend > 0.0 else 1.0

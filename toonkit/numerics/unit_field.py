"""
Fields of unit vectors by multigrid on the masked grid.

Minimizes, over unit vectors with z >= 0,

    sum w_p P(L · n_p) + l² (sum over links k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r_p²,      d = n - n0,

where P is the squared distance of L · n to an interval and r the integrability residual of a unit field.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.bands import inner
from toonkit.numerics.masked_grid import Coarsening, Links, MaskedGrid
from toonkit.numerics.report import SolverReport
from toonkit.numerics.unit_field_kernels import (
    finish_blocks,
    gather_blocks,
    relax,
    retract,
    slope,
)

COARSEST_SIZE = 1000
"""Pixels of the coarsest grid at most: on still coarser ones one vector stands for too much of an object's curvature."""

COARSEST_SWEEPS = 5
"""Sweeps there, each way."""

SMALL = 16 * COARSEST_SIZE
"""Pixels below which a coarser grid's correction is as long as suits this one; on finer grids it fits as it is."""

LEVEL, TRIALS = 0.3, 4
"""Share of the first slope that is left where a step is long enough, and how many lengths are tried."""

LONGEST_STEP = 2.0
"""How far a coarse grid's correction is followed at most, in units of itself."""

_NONE = np.zeros(0)
_NO_SOURCE = np.zeros((0, 3))


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
    links : ndarray of float32, shape (P, 4)
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
    links: Links
    ties: FloatArray
    change_weight: float
    integrability_weight: float

    def coarsened(self, step: Coarsening) -> UnitFieldProblem:
        """Return the same problem on 2 x 2 blocks: of intervals and vectors the means, of links what is as stiff."""
        start = step.sums(self.weight[:, None] * self.start)
        weight = step.sums(self.weight)
        return replace(
            self,
            grid=step.coarse,
            start=moved(step.coarse, start, start),
            lower=step.sums(self.weight * self.lower) / weight,
            upper=step.sums(self.weight * self.upper) / weight,
            weight=weight,
            links=step.links(self.links),
            ties=step.sums(self.ties),
        )


def solve_unit_field(
    problem: UnitFieldProblem,
    *,
    guess: FloatArray | None = None,
    tolerance: float = 1e-6,
    negligible: float = 0.0,
    max_cycles: int = 100,
    progress: Callable[[float], None] | None = None,
) -> tuple[FloatArray, SolverReport]:
    """
    Minimize from n0, or from a guess that coarser grids have improved: whichever has the lower energy.

    Parameters
    ----------
    problem : UnitFieldProblem
        The problem.
    guess : ndarray, shape (P, 3), optional
        Unit vectors near the answer, such as the answer to a problem like this one; n0 by default.
    tolerance : float, optional
        Relative decrease of the energy in one cycle below which nothing is left to gain.
    negligible : float, optional
        Decrease of the energy in one cycle, per pixel, that does not count as a gain either.
    max_cycles : int, optional
        Cycles allowed.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the solver.

    Returns
    -------
    field : ndarray, shape (P, 3)
        Unit vectors.
    report : SolverReport
        Iterations are cycles; energies are those of n0, of where the first cycle starts, and after each cycle.

    Notes
    -----
    A cycle is a V-cycle of the full approximation scheme [1]_: coarse grids see the same kind of problem, with a linear term
    that makes them stand still where the fine grid does, and with the illuminations that are outside their intervals held as
    firmly as they are there. On the finest grid, whose gradient is known, nothing is relaxed before: that would take a third
    of the time and gain less where a few cycles are enough. Its correction preconditions nonlinear conjugate gradients,
    whose step is the exact one of a parabola. The energy never rises above that of n0.

    References
    ----------
    .. [1] A. Brandt, "Multi-level adaptive solutions to boundary-value problems", Math. Comp. 31 (1977),
       doi:10.1090/S0025-5718-1977-0431719-X
    """
    tell = progress if progress is not None else _ignored
    levels = _levels(problem)
    finest = levels[0]
    near = problem.start if guess is None else moved(problem.grid, guess, guess)
    starts = [problem.start, _from_coarse_grids(levels, near)]
    gradients = np.empty((2, *problem.start.shape))
    energies = [finest.slope(*pair) for pair in zip(starts, gradients, strict=True)]
    best = int(np.argmin(energies))
    energies[1] = energies[best]
    tell(0.2)
    field = starts[1] if best else problem.start.copy()
    descent = _Descent(levels, field, gradients[best], gradients[1 - best], energies[1])
    gained = True
    while gained and len(energies) - 2 < max_cycles:
        descent.advance()
        enough = tolerance * energies[-1] + negligible * problem.grid.size
        gained = energies[-1] - descent.energy > enough
        energies.append(descent.energy)
        cycles = len(energies) - 2
        tell(1.0 - 0.8 * 0.7**cycles if gained else 1.0)
    tell(1.0)
    lost = (energies[-2] - energies[-1]) / max(energies[-2], np.finfo(np.float64).tiny)
    reason = "the cycle limit was reached" if gained else f"a cycle lowered the energy by {lost:.1g} of it"
    return descent.field, SolverReport(cycles, np.array(energies), reason, converged=not gained)


class _Descent:
    """Conjugate gradients, preconditioned by a V-cycle, on the finest grid."""

    def __init__(
        self,
        levels: list[_Level],
        field: FloatArray,
        gradient: FloatArray,
        spare: FloatArray,
        energy: float,
    ) -> None:
        self.levels, self.field, self.gradient, self.energy = levels, field, gradient, energy
        self._trial = np.empty_like(field)
        self._step: FloatArray | None = None
        self._gradient_before = spare
        self._slope_before = 0.0

    def advance(self) -> None:
        """Make one step; stay where no step lowers the energy."""
        finest = self.levels[0]
        if self._step is not None and self._step is finest.room(
            "step"
        ):  # it stays, the next one takes another room
            finest.rooms.update({"step": finest.room("other step"), "other step": self._step})
        improved = self._trial
        improved[:] = self.field
        _correct(self.levels, 0, finest.data, _NO_SOURCE, improved, self.gradient, self.energy)
        step = np.subtract(improved, self.field, out=finest.room("step"))
        along = inner(self.gradient, step)
        first = along
        if self._step is not None:
            # Polak and Ribière's share of the last step: none if the two gradients have nothing to do with each other.
            share = max((along - inner(self._gradient_before, step)) / self._slope_before, 0.0)
            self._step *= share
            self._step += step
            along = inner(self.gradient, self._step)
            if along < 0.0:
                step = self._step
            else:
                along = first
        if along >= 0.0:
            return
        trial, slopes = improved, self._gradient_before

        def tried(length: float) -> float:
            finest.retracted(self.field, step, length, trial)
            return finest.slope(trial, slopes)

        length, best, lowest = 1.0, 0.0, self.energy
        for _ in range(TRIALS):
            last, energy = length, tried(length)
            if energy < lowest:
                best, lowest = length, energy
            now = inner(slopes, step)
            if energy < self.energy and abs(now) <= LEVEL * -along:
                break
            # Where a parabola through both slopes is level; half the length where there is none or it did not help.
            level = length * along / (along - now) if now > along else LONGEST_STEP * length
            length = (
                min(level, LONGEST_STEP) if energy < self.energy or level < 0.5 * length else 0.5 * length
            )
        if best == 0.0:
            return
        if last != best:
            tried(best)
        self._gradient_before, self.gradient = self.gradient, slopes
        self._step = step
        self._slope_before = first
        self.field, self._trial, self.energy = trial, self.field, lowest


@dataclass(frozen=True, eq=False)
class _Data:
    """What a level knows of illumination: intervals, and how firmly it is held at a target (empty on the finest level)."""

    hold: FloatArray
    target: FloatArray
    lower: FloatArray
    upper: FloatArray
    weight: FloatArray


@dataclass(frozen=True, eq=False)
class _Level:
    """A problem on one of the grids, and the way to the next coarser one (none on the coarsest)."""

    problem: UnitFieldProblem
    step: Coarsening | None
    rooms: dict[str, FloatArray] = field(default_factory=dict)

    def room(self, name: str) -> FloatArray:
        """Memory for a field of vectors, kept: new memory costs more than what is done in it."""
        if name not in self.rooms:
            self.rooms[name] = np.empty_like(self.problem.start)
        return self.rooms[name]

    def cleared(self, name: str, count: int) -> FloatArray:
        """Memory for so many numbers a pixel, (count, P), kept and set to zero."""
        if name not in self.rooms:
            self.rooms[name] = np.empty((count, self.problem.grid.size))
        self.rooms[name].fill(0.0)
        return self.rooms[name]

    @property
    def data(self) -> _Data:
        problem = self.problem
        return _Data(_NONE, _NONE, problem.lower, problem.upper, problem.weight)

    def _arguments(self, data: _Data, source: FloatArray) -> tuple[Any, ...]:
        problem = self.problem
        return (
            problem.grid.neighbors, problem.start, problem.direction, data.hold, data.target, data.lower, data.upper,
            data.weight, problem.links, problem.ties, problem.change_weight, problem.integrability_weight, source,
        )  # fmt: skip

    def relax(self, data: _Data, source: FloatArray, field: FloatArray, *, backward: bool) -> None:
        bands = self.problem.grid.bands
        bands.sweep(relax, *self._arguments(data, source), field, backward=backward)

    def slope(
        self,
        field: FloatArray,
        out: FloatArray,
        data: _Data | None = None,
        source: FloatArray = _NO_SOURCE,
    ) -> float:
        """Return the energy of a field; write its gradient."""
        arguments = self._arguments(self.data if data is None else data, source)
        return float(sum(self.problem.grid.bands.run(slope, *arguments, field, out)))

    def retracted(self, field: FloatArray, step: FloatArray, length: float, out: FloatArray) -> FloatArray:
        self.problem.grid.bands.run(retract, field, step, length, out)
        return out

    def restrict(
        self, data: _Data, field: FloatArray, gradient: FloatArray, coarse: _Level
    ) -> tuple[FloatArray, FloatArray, _Data]:
        """Mean vectors, summed slopes and illumination of the blocks, as the coarser level sees them; in its rooms."""
        assert self.step is not None
        light = self.problem.direction
        mean, slopes = coarse.room("start"), coarse.room("slopes")
        mean.fill(0.0)
        slopes.fill(0.0)
        hold, lower, upper, weight, lit = coarse.cleared("illumination", 5)
        self.problem.grid.bands.run(
            gather_blocks, self.step.parent, light, field, gradient, data.hold, data.lower, data.upper, data.weight,
            mean, slopes, hold, lower, upper, weight,
        )  # fmt: skip
        coarse.problem.grid.bands.run(finish_blocks, light, mean, lower, upper, weight, lit)
        return mean, slopes, _Data(hold, lit, lower, upper, weight)


def _levels(problem: UnitFieldProblem) -> list[_Level]:
    levels: list[_Level] = []
    for step in problem.grid.coarsenings(COARSEST_SIZE):
        levels.append(_Level(problem, step))
        problem = problem.coarsened(step)
    return [*levels, _Level(problem, None)]


def _from_coarse_grids(levels: list[_Level], guess: FloatArray) -> FloatArray:
    """Nested iteration: a cycle on each coarser grid, whose change of the guess the next finer one starts with."""
    guesses = [guess]
    for level in levels[:-1]:
        assert level.step is not None
        sums = level.step.sums(guesses[-1])
        guesses.append(moved(level.step.coarse, sums, sums))
    field = guesses[-1].copy()
    for depth in reversed(range(1, len(levels))):
        level, finer = levels[depth], levels[depth - 1]
        _cycle(levels, depth, level.data, _NO_SOURCE, field)
        assert finer.step is not None
        change = finer.step.interpolated(field - guesses[depth], np.empty_like(guesses[depth - 1]))
        field = finer.retracted(guesses[depth - 1], change, 1.0, change)
    return field


def _cycle(levels: list[_Level], depth: int, data: _Data, source: FloatArray, field: FloatArray) -> None:
    """Improve a field in place: relax, let the coarser grids correct it, relax in the opposite order."""
    level = levels[depth]
    if level.step is None:
        for _ in range(COARSEST_SWEEPS):
            level.relax(data, source, field, backward=False)
            level.relax(data, source, field, backward=True)
        return
    level.relax(data, source, field, backward=False)
    gradient = level.room("gradient")
    energy = level.slope(field, gradient, data, source)
    _correct(levels, depth, data, source, field, gradient, energy)


def _correct(
    levels: list[_Level],
    depth: int,
    data: _Data,
    source: FloatArray,
    field: FloatArray,
    gradient: FloatArray,
    energy: float,
) -> None:
    """Let the coarser grids correct a field whose gradient is known, in place, and relax it."""
    level = levels[depth]
    if level.step is None:
        _cycle(levels, depth, data, source, field)
        return
    coarse = levels[depth + 1]
    coarse_start, slopes, coarse_data = level.restrict(data, field, gradient, coarse)
    # What makes the coarse grid stand still where this one does.
    standing = coarse.room("standing")
    coarse.slope(coarse_start, standing, coarse_data)
    standing -= slopes
    change = coarse.room("change")
    change[:] = coarse_start
    _cycle(levels, depth + 1, coarse_data, standing, change)
    change -= coarse_start
    step = level.step.interpolated(change, level.room("step"))
    length = 1.0
    if len(field) < SMALL:
        along = inner(gradient, step)
        trial, slopes = level.room("trial"), level.room("trial slopes")
        level.retracted(field, step, 1.0, trial)
        bend = level.slope(trial, slopes, data, source) - energy - along
        length = float(np.clip(-along / (2.0 * bend), 0.0, LONGEST_STEP)) if bend > 0.0 else 1.0
    level.retracted(field, step, length, field)
    level.relax(data, source, field, backward=True)


def moved(grid: MaskedGrid, field: FloatArray, step: FloatArray) -> FloatArray:
    """Return the unit vectors (P, 3) of a field plus a step, z >= 0; one that vanishes faces the viewer."""
    out = np.empty_like(field)
    grid.bands.run(retract, field, step, 1.0, out)
    return out


def _ignored(_fraction: float) -> None:
    """Stand in for a progress callable."""

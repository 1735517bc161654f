"""Fields of unit vectors by multigrid on the masked grid: conjugate gradients, preconditioned by a cycle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toonkit.numerics.parallel import inner_product
from toonkit.numerics.report import SolverReport
from toonkit.numerics.unit_field_cycle import Level, correct, iterate_nested
from toonkit.numerics.unit_vectors import Stored, UnitVectorEnergy, add_and_normalize

LEVEL, TRIALS = 0.3, 4
"""Share of the first slope that is left where a step is long enough, and how many lengths are tried."""

LONGEST_STEP = 2.0
"""How far a cycle's step is followed at most, in units of itself."""


def solve_unit_field(
    problem: UnitVectorEnergy,
    *,
    guess: Stored | None = None,
    tolerance: float = 1e-6,
    negligible: float = 0.0,
    max_cycles: int = 100,
    progress: Callable[[float], None] | None = None,
) -> tuple[Stored, SolverReport]:
    """
    Minimize from the start, or from a guess that coarser grids have improved: whichever has the lower energy.

    Parameters
    ----------
    problem : UnitVectorEnergy
        What is minimized.
    guess : ndarray, shape (P, 3), optional
        Unit vectors near the answer; the start by default.
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
        Unit vectors, in the precision of the start.
    report : SolverReport
        Iterations are cycles; energies are those of the start, of where the first cycle starts, and after each cycle.

    Notes
    -----
    A V-cycle (`toonkit.numerics.unit_field_cycle`) preconditions nonlinear conjugate gradients. On the finest grid there is
    no sweep before the cycle: it would take a third of the time and gain less.
    """
    tell = progress if progress is not None else _ignore_progress
    finest = Level.finest(problem)
    descent, energies = _start_descent(finest, guess)
    tell(0.2)
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


def _start_descent(finest: Level, guess: Stored | None) -> tuple[_Descent, list[float]]:
    """Start where the energy is lower, and return the energies of the problem's start and of that place."""
    problem = finest.problem
    kind = problem.start.dtype
    near = problem.start
    if guess is not None:
        near = add_and_normalize(problem.grid, *2 * (guess.astype(kind, copy=False),))
    starts = [problem.start, iterate_nested(finest, near)]
    gradients = np.empty((2, *problem.start.shape), kind)
    energies = [
        problem.value_and_gradient(problem.terms, *pair) for pair in zip(starts, gradients, strict=True)
    ]
    best = int(np.argmin(energies))
    field = starts[1]
    if best == 0:
        field[:] = problem.start
    descent = _Descent(finest, field, gradients[best], gradients[1 - best], energies[best])
    return descent, [energies[0], energies[best]]


class _Descent:
    """Conjugate gradients, preconditioned by a V-cycle, on the finest grid."""

    def __init__(self, finest: Level, field: Stored, gradient: Stored, spare: Stored, energy: float) -> None:
        self.finest, self.field, self.gradient, self.energy = finest, field, gradient, energy
        self._trial = np.empty_like(field)
        self._step: Stored | None = None
        self._gradient_before = spare
        self._slope_before = 0.0

    def advance(self) -> None:
        """Make one step; stay where no step lowers the energy."""
        finest = self.finest
        improved = self._trial
        improved[:] = self.field
        correct(finest, finest.problem.terms, improved, self.gradient, self.energy)
        step = np.subtract(improved, self.field, out=finest.workspace("slopes"))
        along = inner_product(self.gradient, step)
        first = along
        if self._step is not None:
            # Polak and Ribière's share of the last step: none if the two gradients have nothing to do with each other.
            share = max((along - inner_product(self._gradient_before, step)) / self._slope_before, 0.0)
            self._step *= share
            self._step += step
            along = inner_product(self.gradient, self._step)
            if along < 0.0:
                step = self._step
            else:
                along = first
        if along >= 0.0:
            return
        trial, slopes = improved, self._gradient_before

        def evaluate(length: float) -> float:
            finest.retract(self.field, step, length, trial)
            return finest.problem.value_and_gradient(finest.problem.terms, trial, slopes)

        length, best, lowest = 1.0, 0.0, self.energy
        for _ in range(TRIALS):
            last, energy = length, evaluate(length)
            if energy < lowest:
                best, lowest = length, energy
            now = inner_product(slopes, step)
            if energy < self.energy and abs(now) <= LEVEL * -along:
                break
            # Where a parabola through both slopes is level; half the length where there is none or it did not help.
            level = length * along / (along - now) if now > along else LONGEST_STEP * length
            helped = energy < self.energy
            length = min(level, LONGEST_STEP) if helped or level < 0.5 * length else 0.5 * length
        if best == 0.0:
            return
        if last != best:
            evaluate(best)
        self._gradient_before, self.gradient = self.gradient, slopes
        if step is not self._step:
            finest.exchange("slopes", self._step)
            self._step = step
        self._slope_before = first
        self.field, self._trial, self.energy = trial, self.field, lowest


def _ignore_progress(_fraction: float) -> None:
    """Stand in for a progress callable."""

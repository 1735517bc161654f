"""SolverReport: what an iterative solver did, and why it stopped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toonkit._validation import FloatArray


@dataclass(frozen=True, eq=False)
class SolverReport:
    """
    Account of an iterative minimization.

    Attributes
    ----------
    iterations : int
        Iterations or sweeps made.
    energies : ndarray, shape (n,)
        Energy at the start and at each checkpoint, the last one at the end.
    reason : str
        Why it stopped, in words.
    converged : bool
        True if it stopped because nothing was left to gain.
    """

    iterations: int
    energies: FloatArray
    reason: str
    converged: bool

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        count = "1 iteration" if self.iterations == 1 else f"{self.iterations} iterations"
        ends = f", energy {self.energies[0]:.4g} to {self.energies[-1]:.4g}" if len(self.energies) else ""
        return f"SolverReport({count}, {state}{ends}: {self.reason})"


def join_reports(reports: Sequence[SolverReport]) -> SolverReport:
    """Account for problems that were solved one after the other: energies are their sums, iterations the most of any."""
    if len(reports) == 1:
        return reports[0]
    longest = max(len(report.energies) for report in reports)
    energies = [np.pad(report.energies, (0, longest - len(report.energies)), "edge") for report in reports]
    worst = next((report for report in reports if not report.converged), reports[0])
    return SolverReport(
        max(report.iterations for report in reports),
        np.sum(energies, axis=0),
        worst.reason,
        converged=worst.converged,
    )


NOT_REFINED = SolverReport(0, np.zeros(0), "nothing was refined", converged=True)
"""The report of a method that ends where it starts."""

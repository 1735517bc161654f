"""SolverReport: what an iterative solver did, and why it stopped."""

from __future__ import annotations

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


NOT_REFINED = SolverReport(0, np.zeros(0), "nothing was refined", converged=True)
"""The report of a method that ends where it starts."""

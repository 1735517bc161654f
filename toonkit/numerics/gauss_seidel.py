"""Plain Gauss-Seidel with over-relaxation, one pixel at a time, renormalizing: the readable reference (Section 3.3).

Minimizes rho * sum P(L · n_p) + lambda * sum |Laplacian n|² over unit vectors, as the paper describes it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.report import SolverReport

CHECK_EVERY = 10
"""Sweeps between two looks at the energy, which costs as much as a sweep."""


def over_relaxed_sweeps(
    grid: MaskedGrid,
    start: FloatArray,
    direction: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    *,
    rho: float,
    smoothness: float,
    relaxation: float,
    max_sweeps: int,
    tolerance: float,
    energy: Callable[[FloatArray], float],
    progress: Callable[[float], None] | None = None,
) -> tuple[FloatArray, SolverReport]:
    """
    Sweep until the energy stands still or the sweeps are used up.

    Parameters
    ----------
    grid : MaskedGrid
        The pixels.
    start : ndarray, shape (P, 3)
        First unit vectors.
    direction : ndarray, shape (3,)
        Unit vector L.
    lower, upper : ndarray, shape (P,)
        Interval of L · n.
    rho, smoothness : float
        Weights of the interval penalty and of the squared Laplacian.
    relaxation : float
        Over-relaxation factor, 1 to 2.
    max_sweeps : int
        Sweeps allowed.
    tolerance : float
        Relative decrease of the energy in one sweep below which it stands still.
    energy : callable
        Energy of a field (P, 3), looked at every `CHECK_EVERY` sweeps.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the solver.

    Returns
    -------
    field : ndarray, shape (P, 3)
        Unit vectors, z >= 0.
    report : SolverReport
        Sweeps, energies and why it stopped.
    """
    field = start.copy()
    energies = [energy(field)]
    sweeps = 0
    while sweeps < max_sweeps:
        # Recomputed now and then: updates alone would let rounding pile up.
        laplacian = grid.laplacian(field)
        block = min(CHECK_EVERY, max_sweeps - sweeps)
        for _ in range(block):
            _sweep(grid.neighbors, direction, lower, upper, rho, smoothness, relaxation, field, laplacian)
        sweeps += block
        energies.append(energy(field))
        if progress is not None:
            progress(sweeps / max_sweeps)
        if abs(energies[-2] - energies[-1]) <= tolerance * block * abs(energies[-1]):
            return field, SolverReport(sweeps, np.array(energies), "the energy stands still", converged=True)
    return field, SolverReport(sweeps, np.array(energies), "the sweep limit was reached", converged=False)


@njit(cache=True, nogil=True)
def _sweep(neighbors, direction, lower, upper, rho, smoothness, relaxation, field, laplacian):  # type: ignore[no-untyped-def]
    best = np.empty(3)
    for p in range(field.shape[0]):
        count = 0
        for k in range(4):
            if neighbors[p, k] >= 0:
                count += 1
        # The pixel stands in its own Laplacian `count` times and once in that of each neighbor.
        curvature = smoothness * (count * count + count)
        if curvature + rho == 0.0:
            continue
        along = 0.0
        for c in range(3):
            slope = -count * laplacian[p, c]
            for k in range(4):
                q = neighbors[p, k]
                if q >= 0:
                    slope += laplacian[q, c]
            best[c] = field[p, c]
            if curvature > 0.0:
                best[c] -= smoothness * slope / curvature
            along += best[c] * direction[c]
        target = min(max(along, lower[p]), upper[p])
        pushed = rho * (target - along) / (curvature + rho)
        length = 0.0
        for c in range(3):
            best[c] += pushed * direction[c]
            best[c] = field[p, c] + relaxation * (best[c] - field[p, c])
            if c == 2 and best[c] < 0.0:
                best[c] = 0.0
            length += best[c] * best[c]
        length = np.sqrt(length)
        if length < 1e-12:
            continue
        for c in range(3):
            step = best[c] / length - field[p, c]
            field[p, c] += step
            laplacian[p, c] -= count * step
            for k in range(4):
                q = neighbors[p, k]
                if q >= 0:
                    laplacian[q, c] += step

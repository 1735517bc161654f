"""Plain Gauss-Seidel with over-relaxation, one pixel at a time, renormalizing: slow, and easy to read."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.compiled import njit
from toonkit.numerics.masked_grid import OUTSIDE, IndexArray, MaskedGrid
from toonkit.numerics.report import SolverReport
from toonkit.numerics.smoothness_energy import SmoothnessEnergy

CHECK_EVERY = 10
"""Sweeps between two evaluations of the energy, each of which costs as much as a sweep."""


def over_relaxed_sweeps(
    energy: SmoothnessEnergy,
    *,
    relaxation: float,
    max_sweeps: int,
    tolerance: float,
    progress: Callable[[float], None] | None = None,
) -> tuple[FloatArray, SolverReport]:
    """
    Minimize from the energy's start until the energy hardly changes or the sweeps are used up.

    Parameters
    ----------
    energy : SmoothnessEnergy
        The energy, of the same weight on all pixels and with unit edge weights.
    relaxation : float
        Over-relaxation factor, 1 to 2.
    max_sweeps : int
        Sweeps allowed.
    tolerance : float
        Relative change of the energy in one sweep at which the solver stops.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the solver.

    Returns
    -------
    field : ndarray, shape (P, 3)
        Unit vectors, z >= 0.
    report : SolverReport
        Sweeps, energies and why it stopped.
    """
    solver = OverRelaxation(energy, relaxation)
    field = energy.start.copy()
    energies = [energy.value(field)]
    sweeps = 0
    while sweeps < max_sweeps:
        block = min(CHECK_EVERY, max_sweeps - sweeps)
        solver.sweep(field, block)
        sweeps += block
        energies.append(energy.value(field))
        if progress is not None:
            progress(sweeps / max_sweeps)
        if abs(energies[-2] - energies[-1]) <= tolerance * block * abs(energies[-1]):
            return field, SolverReport(sweeps, np.array(energies), "the energy stands still", converged=True)
    return field, SolverReport(sweeps, np.array(energies), "the sweep limit was reached", converged=False)


class OverRelaxation:
    """
    Sweeps over the pixels of an energy, set up once.

    Parameters
    ----------
    energy : SmoothnessEnergy
        The energy, of the same weight on all pixels and with unit edge weights.
    relaxation : float
        Over-relaxation factor, 1 to 2.
    """

    def __init__(self, energy: SmoothnessEnergy, relaxation: float) -> None:
        self._grid = energy.grid
        self._stencil, self._lag = _stencil(energy.grid), _lag(energy.grid)
        self._interval = (energy.direction, energy.lower, energy.upper)
        self._weights = (*_weights(float(energy.weight[0]), energy.smoothness), relaxation)

    def sweep(self, field: FloatArray, count: int) -> None:
        """Sweep so many times over a field (P, 3) of unit vectors, in place."""
        while count > 0:
            # Recomputed now and then: updates alone would let rounding pile up. The row more is the dummy neighbor's.
            laplacian = np.concatenate([self._grid.laplacian(field), np.zeros((1, 3))])
            block = min(CHECK_EVERY, count)
            for _ in range(block // 2):
                _two_sweeps(self._stencil, self._interval, self._weights, field, laplacian, self._lag)
            if block % 2:
                _one_sweep(self._stencil, self._interval, self._weights, field, laplacian)
            count -= block


def _stencil(grid: MaskedGrid) -> tuple[IndexArray, NDArray[np.intp]]:
    """Return the neighbors, with a dummy pixel P in place of those outside, and how many are inside."""
    inside = grid.neighbors != OUTSIDE
    return np.where(inside, grid.neighbors, np.int32(grid.size)), inside.sum(axis=1)


def _weights(weight: float, smoothness: float) -> tuple[FloatArray, FloatArray]:
    """
    Return the step against the smoothness' slope, and the share of an excess that is taken back, by neighbors.

    A pixel with n neighbors stands n times in its own Laplacian and once in that of each neighbor: n² + n in all.
    """
    neighbors = np.arange(5.0)
    curvature = smoothness * (neighbors**2 + neighbors)
    step = np.divide(smoothness, curvature, out=np.zeros(5), where=curvature > 0)
    share = np.divide(weight, curvature + weight, out=np.zeros(5), where=curvature + weight > 0)
    return step, share


def _lag(grid: MaskedGrid) -> int:
    """Return a number of pixels that is more than any three rows of the picture hold together."""
    per_row = np.bincount(grid.rows, minlength=3)
    return min(int(np.convolve(per_row, np.ones(3, dtype=np.intp)).max()) + 1, grid.size)


@njit(cache=True, nogil=True, error_model="numpy")
def _two_sweeps(stencil, interval, weights, field, laplacian, lag):  # type: ignore[no-untyped-def]
    """
    Sweep twice, the second sweep `lag` pixels behind the first.

    An update touches the rows beside its own, so three rows apart two updates know nothing of each other: the outcome is
    that of one sweep after the other. But the processor, which within a sweep waits for each pixel before it can do the
    next, works on both at once.
    """
    size = field.shape[0]
    for p in range(lag):
        _update(p, stencil, interval, weights, field, laplacian)
    for p in range(lag, size):
        _update(p, stencil, interval, weights, field, laplacian)
        _update(p - lag, stencil, interval, weights, field, laplacian)
    for p in range(size - lag, size):
        _update(p, stencil, interval, weights, field, laplacian)


@njit(cache=True, nogil=True, error_model="numpy")
def _one_sweep(stencil, interval, weights, field, laplacian):  # type: ignore[no-untyped-def]
    for p in range(field.shape[0]):
        _update(p, stencil, interval, weights, field, laplacian)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _update(p, stencil, interval, weights, field, laplacian):  # type: ignore[no-untyped-def]
    """Move one pixel to the least energy of its own, and beyond by the over-relaxation; written out for speed."""
    neighbors, count = stencil
    direction, lower, upper = interval
    step, share, relaxation = weights
    a, b, c, d = neighbors[p, 0], neighbors[p, 1], neighbors[p, 2], neighbors[p, 3]
    n = count[p]
    x, y, z = field[p, 0], field[p, 1], field[p, 2]
    to_x = x - step[n] * (
        laplacian[a, 0] + laplacian[b, 0] + laplacian[c, 0] + laplacian[d, 0] - n * laplacian[p, 0]
    )
    to_y = y - step[n] * (
        laplacian[a, 1] + laplacian[b, 1] + laplacian[c, 1] + laplacian[d, 1] - n * laplacian[p, 1]
    )
    to_z = z - step[n] * (
        laplacian[a, 2] + laplacian[b, 2] + laplacian[c, 2] + laplacian[d, 2] - n * laplacian[p, 2]
    )
    along = to_x * direction[0] + to_y * direction[1] + to_z * direction[2]
    pushed = share[n] * (min(max(along, lower[p]), upper[p]) - along)
    to_x = x + relaxation * (to_x + pushed * direction[0] - x)
    to_y = y + relaxation * (to_y + pushed * direction[1] - y)
    to_z = max(z + relaxation * (to_z + pushed * direction[2] - z), 0.0)
    length = np.sqrt(to_x * to_x + to_y * to_y + to_z * to_z)
    if length < 1e-12:
        return
    scale = 1.0 / length
    move_x, move_y, move_z = to_x * scale - x, to_y * scale - y, to_z * scale - z
    field[p, 0] = x + move_x
    field[p, 1] = y + move_y
    field[p, 2] = z + move_z
    laplacian[p, 0] -= n * move_x
    laplacian[p, 1] -= n * move_y
    laplacian[p, 2] -= n * move_z
    laplacian[a, 0] += move_x
    laplacian[a, 1] += move_y
    laplacian[a, 2] += move_z
    laplacian[b, 0] += move_x
    laplacian[b, 1] += move_y
    laplacian[b, 2] += move_z
    laplacian[c, 0] += move_x
    laplacian[c, 1] += move_y
    laplacian[c, 2] += move_z
    laplacian[d, 0] += move_x
    laplacian[d, 1] += move_y
    laplacian[d, 2] += move_z
    for component in range(3):
        laplacian[field.shape[0], component] = 0.0  # what flowed to the dummy pixel

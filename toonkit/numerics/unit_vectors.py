"""Energies of unit vectors that face the viewer, one a pixel: what minimizers ask of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.change_kernels import retract
from toonkit.numerics.masked_grid import Coarsening, MaskedGrid
from toonkit.numerics.parallel import run_on_chunks

Stored = NDArray[Any]
"""float64, or float32: a solver reads and writes so much that half the memory takes less time, too. Loops compute with what
they store, and add up energies in float64."""


@dataclass(frozen=True, eq=False)
class Terms:
    """
    The terms of the energy on one of the grids of the multigrid solver.

    Attributes
    ----------
    lower, upper, weight : ndarray, shape (P,)
        Interval of the component along the direction, and the weight of its penalty.
    hold, target : ndarray, shape (P,)
        Weight and value at which that component is held; of shape (0,) if it is not.
    tau : ndarray, shape (P, 3)
        Linear term, the tau correction of a coarser grid; of shape (0, 3) if there is none.
    """

    lower: Stored
    upper: Stored
    weight: Stored
    hold: Stored
    target: Stored
    tau: Stored


@dataclass(frozen=True, eq=False)
class UnitVectorEnergy(ABC):
    """
    An energy of unit vectors with z >= 0: a penalty on one component of each, and a coupling between neighbors.

    The penalty is w_p times the squared distance of u · n_p to an interval, summed over the pixels. All arrays of pixels but
    the edge weights are of the type of `start`, and so are the fields that minimizers ask about.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    start : ndarray, shape (P, 3)
        Unit vectors at which a minimizer may start.
    direction : ndarray, shape (3,)
        Unit vector u.
    lower, upper : ndarray, shape (P,)
        Interval of u · n.
    weight : ndarray, shape (P,)
        Weight w of the penalty.
    fitting_from : float
        On grids of at least so many pixels the correction is applied as it is; on smaller ones its length is fitted.
    """

    fitting_from: ClassVar[float]

    grid: MaskedGrid
    start: Stored
    direction: FloatArray
    lower: Stored
    upper: Stored
    weight: Stored

    @property
    def terms(self) -> Terms:
        """The terms of the energy itself."""
        not_held, no_tau = np.empty(0, self.start.dtype), np.empty((0, 3), self.start.dtype)
        return Terms(self.lower, self.upper, self.weight, not_held, not_held, no_tau)

    @abstractmethod
    def value_and_gradient(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient (P, 3), as far as unit vectors with z >= 0 may follow it."""

    @abstractmethod
    def sweep(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Sweep once over the vectors, in place; `backward` reverses the order."""

    @abstractmethod
    def coarsen(self) -> UnitVectorEnergy:
        """Return the same energy on blocks of 2 x 2 pixels."""

    def average_on_blocks(self, step: Coarsening) -> dict[str, Any]:
        """Return what all energies have, on blocks: of vectors and intervals the means, of weights the sums."""
        start = step.sum_blocks(self.weight[:, None] * self.start)
        weight = step.sum_blocks(self.weight)
        lower, upper = (step.sum_blocks(self.weight * bound) / weight for bound in (self.lower, self.upper))
        return {
            "grid": step.coarse,
            "start": add_and_normalize(step.coarse, start, start),
            "lower": lower,
            "upper": upper,
            "weight": weight,
        }


def add_and_normalize(grid: MaskedGrid, field: Stored, step: Stored) -> Stored:
    """Return the unit vectors (P, 3) of a field plus a step, z >= 0; one that vanishes becomes (0, 0, 1)."""
    out = np.empty_like(field)
    grid.chunks.run(retract, field, step, 1.0, out)
    return out


def unit_vectors(field: Stored) -> FloatArray:
    """Return a field (P, 3) of unit vectors that are stored with less precision as such of float64."""
    vectors = np.empty(field.shape)
    run_on_chunks(_normalize, len(field), field, vectors)
    return vectors


def _normalize(field: Stored, vectors: FloatArray, piece: slice) -> None:
    exact = field[piece].astype(np.float64)
    vectors[piece] = exact / np.linalg.norm(exact, axis=1, keepdims=True)

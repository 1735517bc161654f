"""Energies of unit vectors that face the viewer, one a pixel: what minimizers ask of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.bands import run_in_pieces
from toonkit.numerics.change_kernels import retract
from toonkit.numerics.masked_grid import Coarsening, MaskedGrid

Stored = NDArray[Any]
"""float64, or float32: a solver reads and writes so much that half the memory takes less time, too. Loops compute with what
they store, and add up energies in float64."""


@dataclass(frozen=True, eq=False)
class Terms:
    """
    What pulls at the vectors of one of a multigrid's grids: as the energy says, or as a finer grid asks.

    Attributes
    ----------
    lower, upper, weight : ndarray, shape (P,)
        Interval of the component along the direction, and the weight of its penalty.
    hold, target : ndarray, shape (P,)
        How firmly that component is held, and where; of shape (0,) where an energy is as it was posed.
    source : ndarray, shape (P, 3)
        Linear term; of shape (0, 3) where there is none.
    """

    lower: Stored
    upper: Stored
    weight: Stored
    hold: Stored
    target: Stored
    source: Stored


@dataclass(frozen=True, eq=False)
class UnitVectorEnergy(ABC):
    """
    An energy of unit vectors with z >= 0: a penalty on one component of each, and what holds them together.

    The penalty is w_p times the squared distance of u · n_p to an interval, summed over the pixels. `value` and `gradient`
    are there to be read and to check others against; minimizers use the compiled methods. All arrays of pixels but links are
    of the type of `start`, and so are the fields that minimizers ask about.

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
        Pixels of a grid from which on a coarser grid's correction fits as it is; on smaller grids its length is looked for.
    """

    fitting_from: ClassVar[float]

    grid: MaskedGrid
    start: Stored
    direction: FloatArray
    lower: Stored
    upper: Stored
    weight: Stored

    @property
    def posed(self) -> Terms:
        """The terms of the energy itself."""
        not_held, no_source = np.empty(0, self.start.dtype), np.empty((0, 3), self.start.dtype)
        return Terms(self.lower, self.upper, self.weight, not_held, not_held, no_source)

    def excess(self, field: FloatArray) -> FloatArray:
        """Signed distance of the component of vectors (P, 3) to its interval, zero inside, shape (P,)."""
        component = field @ self.direction
        return component - np.clip(component, self.lower, self.upper)

    def penalty(self, field: FloatArray) -> float:
        """Penalty on the component of vectors (P, 3)."""
        return float(np.sum(self.weight * self.excess(field) ** 2))

    def penalty_gradient(self, field: FloatArray) -> FloatArray:
        """Gradient of the penalty with respect to the vectors, shape (P, 3)."""
        return (2.0 * self.weight * self.excess(field))[:, None] * self.direction

    @abstractmethod
    def value(self, field: FloatArray) -> float:
        """Energy of vectors (P, 3), readable rather than fast."""

    @abstractmethod
    def gradient(self, field: FloatArray) -> FloatArray:
        """Gradient with respect to the vectors, shape (P, 3), before any constraint on their length; readable."""

    @abstractmethod
    def value_and_gradient(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient (P, 3), as far as unit vectors with z >= 0 may follow it."""

    @abstractmethod
    def relax(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Turn one vector after the other to where its own energy is least, in place; `backward` is the opposite order."""

    @abstractmethod
    def coarsened(self) -> UnitVectorEnergy:
        """Return the same energy on blocks of 2 x 2 pixels."""

    def on_blocks(self, step: Coarsening) -> dict[str, Any]:
        """Return what all energies have, on blocks: of vectors and intervals the means, of weights the sums."""
        start = step.sums(self.weight[:, None] * self.start)
        weight = step.sums(self.weight)
        lower, upper = (step.sums(self.weight * bound) / weight for bound in (self.lower, self.upper))
        return {
            "grid": step.coarse,
            "start": moved(step.coarse, start, start),
            "lower": lower,
            "upper": upper,
            "weight": weight,
        }


def moved(grid: MaskedGrid, field: Stored, step: Stored) -> Stored:
    """Return the unit vectors (P, 3) of a field plus a step, z >= 0; one that vanishes becomes (0, 0, 1)."""
    out = np.empty_like(field)
    grid.bands.run(retract, field, step, 1.0, out)
    return out


def unit_vectors(field: Stored) -> FloatArray:
    """Return a field (P, 3) of unit vectors that are stored with less precision as such of float64."""
    vectors = np.empty(field.shape)
    run_in_pieces(_normalize, len(field), field, vectors)
    return vectors


def _normalize(field: Stored, vectors: FloatArray, piece: slice) -> None:
    exact = field[piece].astype(np.float64)
    vectors[piece] = exact / np.linalg.norm(exact, axis=1, keepdims=True)

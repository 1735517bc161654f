"""Problems whose unknowns are unit vectors that face the viewer, one a pixel: what the solver of them all asks of each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import Coarsening, MaskedGrid
from toonkit.numerics.unit_field_kernels import retract

NOT_HELD, NO_SOURCE = np.zeros(0), np.zeros((0, 3))
"""What stands in `Terms` where nothing is held, and where there is no linear term."""


@dataclass(frozen=True, eq=False)
class Terms:
    """
    What draws at the vectors of one of the solver's grids: as the problem says, or as a finer grid asks.

    Attributes
    ----------
    lower, upper, weight : ndarray, shape (P,)
        Interval of L · n, and the weight of its penalty.
    hold, target : ndarray, shape (P,)
        How firmly L · n is held, and where; of shape (0,) where a problem is as it was posed.
    source : ndarray, shape (P, 3)
        Linear term; of shape (0, 3) where there is none.
    """

    lower: FloatArray
    upper: FloatArray
    weight: FloatArray
    hold: FloatArray
    target: FloatArray
    source: FloatArray


@dataclass(frozen=True, eq=False)
class UnitVectorProblem(ABC):
    """
    To be minimized over unit vectors with z >= 0: intervals of illumination, and what holds the vectors together.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    start : ndarray, shape (P, 3)
        Unit vectors at which the solver may start.
    direction : ndarray, shape (3,)
        Unit vector L.
    lower, upper : ndarray, shape (P,)
        Interval of L · n.
    weight : ndarray, shape (P,)
        Weight of the squared distance of L · n to its interval.
    fitting_from : float
        Pixels of a grid from which on a coarser grid's correction fits as it is; on smaller grids its length is looked for.
    """

    fitting_from: ClassVar[float]

    grid: MaskedGrid
    start: FloatArray
    direction: FloatArray
    lower: FloatArray
    upper: FloatArray
    weight: FloatArray

    @property
    def posed(self) -> Terms:
        """The terms of the problem itself."""
        return Terms(self.lower, self.upper, self.weight, NOT_HELD, NOT_HELD, NO_SOURCE)

    @abstractmethod
    def coarsened(self) -> UnitVectorProblem:
        """Return the same problem on blocks of 2 x 2 pixels."""

    @abstractmethod
    def relax(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Turn one vector after the other to where its own energy is least, in place; `backward` is the opposite order."""

    @abstractmethod
    def slope(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient (P, 3), as far as unit vectors with z >= 0 may follow it."""

    def block_means(self, step: Coarsening) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return start, lower, upper and weight of blocks: the means of their pixels, and the sum of the weights."""
        start = step.sums(self.weight[:, None] * self.start)
        weight = step.sums(self.weight)
        lower, upper = (step.sums(self.weight * bound) / weight for bound in (self.lower, self.upper))
        return moved(step.coarse, start, start), lower, upper, weight


def moved(grid: MaskedGrid, field: FloatArray, step: FloatArray) -> FloatArray:
    """Return the unit vectors (P, 3) of a field plus a step, z >= 0; one that vanishes faces the viewer."""
    out = np.empty_like(field)
    grid.bands.run(retract, field, step, 1.0, out)
    return out

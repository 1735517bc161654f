"""
Smoothing of unit vectors within intervals of illumination (Eq. 5), and how the problem looks on coarser grids.

To be minimized, over unit vectors with z >= 0, is

    rho sum P(L · n_p) + lambda sum |Laplacian n|_p²,

where P is the squared distance of L · n to an interval. On blocks the Laplacian is the sum over links k_pq (n_q - n_p)
across their sides, and its square counts per area: two links of length h are one of length 2 h, half as stiff as both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.bands import Bands
from toonkit.numerics.masked_grid import Links, MaskedGrid
from toonkit.numerics.membrane import uniform_links
from toonkit.numerics.smoothing_kernels import laplacian, relax_smooth, slope_smooth
from toonkit.numerics.unit_vectors import Terms, UnitVectorProblem


@dataclass(frozen=True, eq=False)
class SmoothingProblem(UnitVectorProblem):
    """
    One problem on one grid.

    At a rim the Laplacian is a slope, which costs by length and not by area: the coarser a grid, the less it sees of that,
    and the shorter its corrections have to be. So their length is looked for on every grid.

    Attributes
    ----------
    smoothness : float
        lambda, per pixel.
    links : ndarray of float32, shape (P, 4)
        Stiffness k of the link to each neighbor, the same seen from both ends.
    areas : ndarray, shape (P,)
        Pixels of the finest grid that each one stands for.
    """

    fitting_from: ClassVar[float] = np.inf

    smoothness: float
    links: Links
    areas: FloatArray

    @classmethod
    def as_printed(
        cls,
        grid: MaskedGrid,
        start: FloatArray,
        direction: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        *,
        rho: float,
        smoothness: float,
    ) -> SmoothingProblem:
        """Return the problem of the pixels themselves, with the paper's rho and lambda; arrays as in the base class."""
        ones = np.ones(grid.size)
        return cls(grid, start, direction, lower, upper, rho * ones, smoothness, uniform_links(grid), ones)

    def coarsened(self) -> SmoothingProblem:
        """Return the same problem on 2 x 2 blocks: of intervals and vectors the means, of links what is as stiff."""
        step = self.grid.coarsening
        start, lower, upper, weight = self.block_means(step)
        return replace(
            self,
            grid=step.coarse,
            start=start,
            lower=lower,
            upper=upper,
            weight=weight,
            links=step.links(self.links),
            areas=step.sums(self.areas),
        )

    def relax(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Turn one vector after the other to where its own energy is least, and somewhat beyond, in place."""
        self._bands.sweep(relax_smooth, *self._arguments(terms), field, backward=backward)

    def slope(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient."""
        bands = self.grid.bands
        bands.run(laplacian, self.grid.neighbors, self.links, field, self._turns)
        return float(sum(bands.run(slope_smooth, *self._arguments(terms), field, self._turns, out)))

    @cached_property
    def _turns(self) -> FloatArray:
        """Memory for the Laplacian, kept: new memory costs more than what is done in it."""
        return np.empty_like(self.start)

    @cached_property
    def _bands(self) -> Bands:
        """Bands between which lie two rows: a vector's own energy reaches as far."""
        return Bands.of(self.grid.rows // 2)

    def _arguments(self, terms: Terms) -> tuple[Any, ...]:
        return (
            self.grid.neighbors, self.links, self.areas, self.direction, terms.hold, terms.target, terms.lower,
            terms.upper, terms.weight, self.smoothness, terms.source,
        )  # fmt: skip

"""The energy of a field of unit vectors that is smooth itself: its squared Laplacian."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.bands import Bands
from toonkit.numerics.masked_grid import Links, MaskedGrid
from toonkit.numerics.membrane import uniform_links
from toonkit.numerics.smoothness_kernels import laplacian, relax_smooth, smooth_value_and_gradient
from toonkit.numerics.unit_vectors import Terms, UnitVectorEnergy


@dataclass(frozen=True, eq=False)
class SmoothnessEnergy(UnitVectorEnergy):
    """
    The penalty, and the squared Laplacian.

    Attributes
    ----------
    smoothness : float
        Weight of the squared Laplacian, per pixel.
    links : ndarray of float32, shape (P, 4)
        Stiffness k of the link to each neighbor, the same seen from both ends.
    areas : ndarray, shape (P,)
        Pixels of the finest grid that each one stands for.

    Notes
    -----
    With P the squared distance of u · n to its interval, and the Laplacian the sum over links k_pq (n_q - n_p),

        E(n) = sum w_p P(u · n_p) + smoothness sum |Laplacian n|_p² / area_p.

    On a block of 2 x 2 pixels two links of length h are one of length 2 h, half as stiff as both. At a rim the Laplacian is
    a slope, which costs by length and not by area: the coarser a grid, the less it sees of that, and the shorter its
    corrections have to be. So their length is looked for on every grid.
    """

    fitting_from: ClassVar[float] = np.inf

    smoothness: float
    links: Links
    areas: FloatArray

    @classmethod
    def on_pixels(
        cls,
        grid: MaskedGrid,
        start: FloatArray,
        direction: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        *,
        weight: float,
        smoothness: float,
    ) -> SmoothnessEnergy:
        """Return the energy on pixels, all alike, whose links are of unit stiffness; arrays as in the base class."""
        ones = np.ones(grid.size)
        return cls(grid, start, direction, lower, upper, weight * ones, smoothness, uniform_links(grid), ones)

    def value(self, field: FloatArray) -> float:
        """Energy of vectors (P, 3), readable rather than fast."""
        turns = self._laplacian(field)
        return self.penalty(field) + self.smoothness * float(np.sum(turns**2 / self.areas[:, None]))

    def gradient(self, field: FloatArray) -> FloatArray:
        """Gradient with respect to the vectors, shape (P, 3), before any constraint on their length; readable."""
        twice = self._laplacian(
            self._laplacian(field) / self.areas[:, None]
        )  # the Laplacian is its own adjoint
        return self.penalty_gradient(field) + 2.0 * self.smoothness * twice

    def coarsened(self) -> SmoothnessEnergy:
        """Return the same energy on 2 x 2 blocks: of intervals and vectors the means, of links what is as stiff."""
        step = self.grid.coarsening
        return replace(
            self, **self.on_blocks(step), links=step.links(self.links), areas=step.sums(self.areas)
        )

    def relax(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Turn one vector after the other to where its own energy is least, and somewhat beyond, in place."""
        self._bands.sweep(relax_smooth, *self._arguments(terms), field, backward=backward)

    def value_and_gradient(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient."""
        turns = self._laplacian(field, self._turns)
        bands = self.grid.bands
        return float(sum(bands.run(smooth_value_and_gradient, *self._arguments(terms), field, turns, out)))

    def _laplacian(self, field: FloatArray, out: FloatArray | None = None) -> FloatArray:
        turns = np.empty_like(field) if out is None else out
        self.grid.bands.run(laplacian, self.grid.neighbors, self.links, field, turns)
        return turns

    @cached_property
    def _turns(self) -> FloatArray:
        """Memory for the Laplacian, kept: new memory costs more than what is done in it."""
        return np.empty_like(self.start)

    @cached_property
    def _bands(self) -> Bands:
        """Bands that are two rows apart, which is how far a vector's own energy reaches."""
        return Bands.of(self.grid.rows // 2)

    def _arguments(self, terms: Terms) -> tuple[Any, ...]:
        return (
            self.grid.neighbors, self.links, self.areas, self.direction, terms.hold, terms.target, terms.lower,
            terms.upper, terms.weight, self.smoothness, terms.source,
        )  # fmt: skip

"""The energy of a field of unit vectors that is smooth itself: its squared Laplacian."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import EdgeWeights, MaskedGrid
from toonkit.numerics.parallel import RowChunks
from toonkit.numerics.screened_poisson import uniform_edge_weights
from toonkit.numerics.smoothness_kernels import laplacian, smooth_value_and_gradient, sweep_smooth
from toonkit.numerics.unit_vectors import Terms, UnitVectorEnergy


@dataclass(frozen=True, eq=False)
class SmoothnessEnergy(UnitVectorEnergy):
    """
    The penalty, and the squared Laplacian.

    Attributes
    ----------
    smoothness : float
        Weight of the squared Laplacian, per pixel.
    edge_weights : ndarray of float32, shape (P, 4)
        Weight k of the edge to each neighbor, the same from both ends.
    areas : ndarray, shape (P,)
        Pixels of the finest grid that each one stands for.

    Notes
    -----
    With P the squared distance of u · n to its interval, and the Laplacian the sum over edges k_pq (n_q - n_p),

        E(n) = sum w_p P(u · n_p) + smoothness sum |Laplacian n|_p² / area_p.

    At the rim the Laplacian is a slope, whose energy scales with length and not with area. Coarser grids underestimate it,
    and their corrections have to be shorter, so the step length is fitted on every grid.
    """

    fitting_from: ClassVar[float] = np.inf

    smoothness: float
    edge_weights: EdgeWeights
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
        """Return the energy on pixels with unit edge weights; arrays as in the base class."""
        ones = np.ones(grid.size)
        return cls(
            grid, start, direction, lower, upper, weight * ones, smoothness, uniform_edge_weights(grid), ones
        )

    def value(self, field: FloatArray) -> float:
        """Return the energy of vectors (P, 3)."""
        component = field @ self.direction
        excess = component - np.clip(component, self.lower, self.upper)
        turns = self._laplacian(field)
        return float(np.sum(self.weight * excess**2)) + self.smoothness * float(
            np.sum(turns**2 / self.areas[:, None])
        )

    def coarsen(self) -> SmoothnessEnergy:
        """Return the same energy on 2 x 2 blocks."""
        step = self.grid.coarsening
        return replace(
            self,
            **self.average_on_blocks(step),
            edge_weights=step.coarsen_edge_weights(self.edge_weights),
            areas=step.sum_blocks(self.areas),
        )

    def sweep(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Sweep once over the vectors with over-relaxation, in place (Gauss-Seidel)."""
        self._chunks.sweep(sweep_smooth, *self._arguments(terms), field, backward=backward)

    def value_and_gradient(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient."""
        turns = self._laplacian(field, self._turns)
        chunks = self.grid.chunks
        return float(sum(chunks.run(smooth_value_and_gradient, *self._arguments(terms), field, turns, out)))

    def _laplacian(self, field: FloatArray, out: FloatArray | None = None) -> FloatArray:
        turns = np.empty_like(field) if out is None else out
        self.grid.chunks.run(laplacian, self.grid.neighbors, self.edge_weights, field, turns)
        return turns

    @cached_property
    def _turns(self) -> FloatArray:
        """A reused buffer for the Laplacian."""
        return np.empty_like(self.start)

    @cached_property
    def _chunks(self) -> RowChunks:
        """Chunks that are two rows apart, because the energy of a vector depends on vectors two rows away."""
        return RowChunks.of(self.grid.rows // 2)

    def _arguments(self, terms: Terms) -> tuple[Any, ...]:
        return (
            self.grid.neighbors, self.edge_weights, self.areas, self.direction, terms.hold, terms.target, terms.lower,
            terms.upper, terms.weight, self.smoothness, terms.tau,
        )  # fmt: skip

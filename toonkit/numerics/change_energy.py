"""The energy of a field of unit vectors that changes smoothly from where it starts, and is integrable."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from toonkit._validation import FloatArray
from toonkit.numerics.change_kernels import sweep_change, value_and_gradient
from toonkit.numerics.masked_grid import EdgeWeights
from toonkit.numerics.unit_vectors import Terms, UnitVectorEnergy


@dataclass(frozen=True, eq=False)
class ChangeEnergy(UnitVectorEnergy):
    """
    The penalty, a screened Poisson term of the change n - n0, and integrability; `start` is n0.

    Attributes
    ----------
    edge_weights : ndarray of float32, shape (P, 4)
        Weight k of the edge to each neighbor, the same from both ends.
    screening : ndarray, shape (P,)
        Screening t: how strongly a pixel is held to n0.
    change_weight, integrability_weight : float
        l² and m²: squares of the lengths, in pixels, over which the change is smooth and the field integrable where the
        intervals pull.

    Notes
    -----
    With P the squared distance of u · n to its interval, and the integrability residual

        r = n3 ∂y n1 - n1 ∂y n3 - n3 ∂x n2 + n2 ∂x n3

    at the middle of each cell of 2 x 2 pixels, where means and differences are of second order, the energy is

        E(n) = sum w_p P(u · n_p) + l² (sum over edges k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r²,    d = n - n0.

    Both sums over differences are free of scale in two dimensions, so that lengths in units of the object make the minimum
    independent of resolution.
    """

    fitting_from: ClassVar[float] = 16_000

    edge_weights: EdgeWeights
    screening: FloatArray
    change_weight: float
    integrability_weight: float

    def coarsen(self) -> ChangeEnergy:
        """Return the same energy on 2 x 2 blocks."""
        step = self.grid.coarsening
        return replace(
            self,
            **self.average_on_blocks(step),
            edge_weights=step.coarsen_edge_weights(self.edge_weights),
            screening=step.sum_blocks(self.screening),
        )

    def sweep(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Sweep once over the vectors, in place (Gauss-Seidel)."""
        self.grid.chunks.sweep(sweep_change, *self._arguments(terms), field, backward=backward)

    def value_and_gradient(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient."""
        return float(sum(self.grid.chunks.run(value_and_gradient, *self._arguments(terms), field, out)))

    def _arguments(self, terms: Terms) -> tuple[Any, ...]:
        return (
            self.grid.neighbors, self.start, self.direction, terms.hold, terms.target, terms.lower, terms.upper,
            terms.weight, self.edge_weights, self.screening, self.change_weight, self.integrability_weight, terms.tau,
        )  # fmt: skip

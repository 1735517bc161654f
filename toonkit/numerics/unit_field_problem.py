"""
The problem of a field of unit vectors on the masked grid, and how it looks on coarser ones.

To be minimized, over unit vectors with z >= 0, is

    sum w_p P(L · n_p) + l² (sum over links k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r_p²,      d = n - n0,

where P is the squared distance of L · n to an interval and r the integrability residual of a unit field.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import Links
from toonkit.numerics.unit_field_kernels import relax, slope
from toonkit.numerics.unit_vectors import Terms, UnitVectorProblem


@dataclass(frozen=True, eq=False)
class UnitFieldProblem(UnitVectorProblem):
    """
    One problem on one grid; `start` is n0, from which the change is measured.

    Attributes
    ----------
    links : ndarray of float32, shape (P, 4)
        Stiffness k of the link to each neighbor, the same seen from both ends.
    ties : ndarray, shape (P,)
        Stiffness t that holds a pixel to n0.
    change_weight, integrability_weight : float
        l² and m².
    """

    fitting_from: ClassVar[float] = 16_000

    links: Links
    ties: FloatArray
    change_weight: float
    integrability_weight: float

    def coarsened(self) -> UnitFieldProblem:
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
            ties=step.sums(self.ties),
        )

    def relax(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Turn one vector after the other to where its own energy is least, in place."""
        self.grid.bands.sweep(relax, *self._arguments(terms), field, backward=backward)

    def slope(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient."""
        return float(sum(self.grid.bands.run(slope, *self._arguments(terms), field, out)))

    def _arguments(self, terms: Terms) -> tuple[Any, ...]:
        return (
            self.grid.neighbors, self.start, self.direction, terms.hold, terms.target, terms.lower, terms.upper,
            terms.weight, self.links, self.ties, self.change_weight, self.integrability_weight, terms.source,
        )  # fmt: skip

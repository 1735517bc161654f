"""The energy of a field of unit vectors that changes smoothly from where it starts, and is integrable."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.change_kernels import relax, value_and_gradient
from toonkit.numerics.integrability import integrability_gradient, integrability_residual
from toonkit.numerics.masked_grid import Links
from toonkit.numerics.membrane import Membrane
from toonkit.numerics.unit_vectors import Terms, UnitVectorEnergy


@dataclass(frozen=True, eq=False)
class ChangeEnergy(UnitVectorEnergy):
    """
    The penalty, the membrane of the change n - n0, and integrability; `start` is n0.

    Attributes
    ----------
    links : ndarray of float32, shape (P, 4)
        Stiffness k of the link to each neighbor, the same seen from both ends.
    ties : ndarray, shape (P,)
        Stiffness t that holds a pixel to n0.
    change_weight, integrability_weight : float
        l² and m²: squares of the lengths, in pixels, over which the change is smooth and the field integrable where the
        intervals pull.

    Notes
    -----
    With the residual r of `toonkit.numerics.integrability`, and P the squared distance of u · n to its interval,

        E(n) = sum w_p P(u · n_p) + l² (sum over links k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r²,    d = n - n0.

    Both sums over differences are free of scale in two dimensions, so that lengths in units of the object make the minimum
    independent of resolution.
    """

    fitting_from: ClassVar[float] = 16_000

    links: Links
    ties: FloatArray
    change_weight: float
    integrability_weight: float

    def value(self, field: FloatArray) -> float:
        """Energy of vectors (P, 3), readable rather than fast."""
        change = field - self.start
        return (
            self.penalty(field)
            + self.change_weight * float(np.sum(change * self._membrane.apply(change)))
            + self.integrability_weight * float(np.sum(integrability_residual(self.grid, field) ** 2))
        )

    def gradient(self, field: FloatArray) -> FloatArray:
        """Gradient with respect to the vectors, shape (P, 3), before any constraint on their length; readable."""
        return (
            self.penalty_gradient(field)
            + 2.0 * self.change_weight * self._membrane.apply(field - self.start)
            + self.integrability_weight * integrability_gradient(self.grid, field)
        )

    def coarsened(self) -> ChangeEnergy:
        """Return the same energy on 2 x 2 blocks: of intervals and vectors the means, of links what is as stiff."""
        step = self.grid.coarsening
        return replace(self, **self.on_blocks(step), links=step.links(self.links), ties=step.sums(self.ties))

    def relax(self, terms: Terms, field: FloatArray, *, backward: bool) -> None:
        """Turn one vector after the other to where its own energy is least, in place."""
        self.grid.bands.sweep(relax, *self._arguments(terms), field, backward=backward)

    def value_and_gradient(self, terms: Terms, field: FloatArray, out: FloatArray) -> float:
        """Return the energy of a field; write its gradient."""
        return float(sum(self.grid.bands.run(value_and_gradient, *self._arguments(terms), field, out)))

    @property
    def _membrane(self) -> Membrane:
        return Membrane(self.grid, self.links, self.ties)

    def _arguments(self, terms: Terms) -> tuple[Any, ...]:
        return (
            self.grid.neighbors, self.start, self.direction, terms.hold, terms.target, terms.lower, terms.upper,
            terms.weight, self.links, self.ties, self.change_weight, self.integrability_weight, terms.source,
        )  # fmt: skip

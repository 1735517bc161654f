"""
The problem of a field of unit vectors on the masked grid, and how it looks on coarser ones.

To be minimized, over unit vectors with z >= 0, is

    sum w_p P(L · n_p) + l² (sum over links k_pq |d_p - d_q|² + sum t_p |d_p|²) + m² sum r_p²,      d = n - n0,

where P is the squared distance of L · n to an interval and r the integrability residual of a unit field.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import Links, MaskedGrid
from toonkit.numerics.unit_field_kernels import retract


@dataclass(frozen=True, eq=False)
class UnitFieldProblem:
    """
    One problem on one grid.

    Attributes
    ----------
    grid : MaskedGrid
        The pixels.
    start : ndarray, shape (P, 3)
        n0, unit vectors from which the change is measured.
    direction : ndarray, shape (3,)
        Unit vector L.
    lower, upper : ndarray, shape (P,)
        Interval of L · n.
    weight : ndarray, shape (P,)
        Weight w of the interval penalty.
    links : ndarray of float32, shape (P, 4)
        Stiffness k of the link to each neighbor, the same seen from both ends.
    ties : ndarray, shape (P,)
        Stiffness t that holds a pixel to n0.
    change_weight, integrability_weight : float
        l² and m².
    """

    grid: MaskedGrid
    start: FloatArray
    direction: FloatArray
    lower: FloatArray
    upper: FloatArray
    weight: FloatArray
    links: Links
    ties: FloatArray
    change_weight: float
    integrability_weight: float

    def coarsened(self) -> UnitFieldProblem:
        """Return the same problem on 2 x 2 blocks: of intervals and vectors the means, of links what is as stiff."""
        step = self.grid.coarsening
        start = step.sums(self.weight[:, None] * self.start)
        weight = step.sums(self.weight)
        return replace(
            self,
            grid=step.coarse,
            start=moved(step.coarse, start, start),
            lower=step.sums(self.weight * self.lower) / weight,
            upper=step.sums(self.weight * self.upper) / weight,
            weight=weight,
            links=step.links(self.links),
            ties=step.sums(self.ties),
        )


def moved(grid: MaskedGrid, field: FloatArray, step: FloatArray) -> FloatArray:
    """Return the unit vectors (P, 3) of a field plus a step, z >= 0; one that vanishes faces the viewer."""
    out = np.empty_like(field)
    grid.bands.run(retract, field, step, 1.0, out)
    return out

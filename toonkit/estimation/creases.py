"""Where a shape has creases, and how little the change of its normals is held together across them."""

from __future__ import annotations

import numpy as np

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid


def crease_links(grid: MaskedGrid, normals: FloatArray, turn: float) -> FloatArray:
    """
    Return the stiffness of the links between neighbors: one on smooth ground, next to nothing across a crease.

    Parameters
    ----------
    grid : MaskedGrid
        The object.
    normals : ndarray, shape (P, 3)
        Unit normals that show the creases.
    turn : float
        How much normals turn, in radians per sqrt(object area), where a link has half its stiffness; on a ball it is 1.8
        everywhere, and across an edge of 90 degrees that is a fiftieth of the object wide some 80.

    Returns
    -------
    ndarray, shape (P, 4)
        1 / (1 + (change of the normals / turn)²), the same seen from both ends; zero where there is no neighbor.
    """
    links = np.zeros(grid.neighbors.shape)
    for direction, there in enumerate(grid.neighbors.T):
        linked = there != OUTSIDE
        apart = normals[linked] - normals[there[linked]]
        bend = np.sum(apart**2, axis=1) * (grid.size / turn**2)
        links[linked, direction] = 1.0 / (1.0 + bend)
    return links

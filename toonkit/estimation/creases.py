"""Where a shape has creases, and how little the change of its normals is held together across them."""

from __future__ import annotations

import numpy as np
from numba import njit

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import Links, MaskedGrid


def crease_links(grid: MaskedGrid, normals: FloatArray, turn: float) -> Links:
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
    ndarray of float32, shape (P, 4)
        1 / (1 + (change of the normals / turn)²), the same seen from both ends; zero where there is no neighbor.
    """
    links = np.empty(grid.neighbors.shape, np.float32)
    grid.bands.run(_stiffness, grid.neighbors, normals, grid.size / turn**2, links)
    return links


@njit(cache=True, nogil=True, error_model="numpy")
def _stiffness(neighbors, normals, scale, links, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        for k in range(4):
            q = neighbors[p, k]
            links[p, k] = 0.0
            if q >= 0:
                bend = 0.0
                for c in range(3):
                    bend += (normals[p, c] - normals[q, c]) ** 2
                links[p, k] = 1.0 / (1.0 + scale * bend)

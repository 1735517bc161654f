"""Edges of a shape, across which the change of the normals is not smoothed."""

from __future__ import annotations

import numpy as np

from toonkit._validation import FloatArray
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics.compiled import njit
from toonkit.numerics.masked_grid import EdgeWeights, MaskedGrid


def edge_links(
    grid: MaskedGrid, normals: FloatArray, painted: IlluminationInterval, *, turn: float, jump: float
) -> EdgeWeights:
    """
    Return the weights of the links between neighbors: one on a smooth surface, nearly zero across an edge.

    Parameters
    ----------
    grid : MaskedGrid
        The object.
    normals : ndarray, shape (P, 3)
        Unit normals that show the creases.
    painted : IlluminationInterval
        Range of illumination that each pixel's color allows, of a mixed pixel that of the nearer band; bounds of shape (P,).
    turn : float
        Turn of the normals, in radians per sqrt(object area), at which a link has half its weight. On a ball normals
        turn by 1.8 everywhere. Across an edge of 90 degrees that is as wide as a fiftieth of the object they turn by
        about 80.
    jump : float
        Distance between the ranges of two neighbors, in illumination, at which their link has half its weight.

    Returns
    -------
    ndarray of float32, shape (P, 4)
        1 / (1 + (change of the normals / turn)²) / (1 + (distance of the ranges / jump)²), the same seen from both ends;
        zero where there is no neighbor.

    Notes
    -----
    The ranges of two bands that follow each other in the color map touch. If two colors meet in the picture although
    others lie between them in the color map, they are not bands of one smooth surface. There is a contour, where one
    part of the object ends in front of another, or a crease. The two sides of a drawn line count as neighbors, because
    the paint beneath a line continues the paint beside it. Edges also weaken where soft shading is so steep that
    neighbors skip a part of it, as near a rim.
    """
    links = np.empty(grid.neighbors.shape, np.float32)
    grid.chunks.run(
        _stiffness, grid.neighbors, normals, painted.lower, painted.upper, grid.size / turn**2, 1.0 / jump**2, links
    )  # fmt: skip
    return links


@njit(cache=True, nogil=True, error_model="numpy")
def _stiffness(neighbors, normals, lower, upper, by_turn, by_jump, links, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        for k in range(4):
            q = neighbors[p, k]
            links[p, k] = 0.0
            if q >= 0:
                bend = 0.0
                for c in range(3):
                    change = normals[p, c] - normals[q, c]
                    bend += change * change
                # Written out, for max takes long to compile.
                above, below = lower[p] - upper[q], lower[q] - upper[p]
                apart = above if above > 0.0 else below if below > 0.0 else 0.0
                links[p, k] = 1.0 / ((1.0 + by_turn * bend) * (1.0 + by_jump * apart * apart))

"""Interior contours from line art: lines inside the silhouette where one part of an object may hide another.

No method uses them: nothing tells a line that is a contour from one that is decoration, and a line across a ball costs more
than all the contours of a knot are worth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.tone_ranks import ToneRanks
from toonkit.illustration.mixed_pixels import MixedPixels
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid

APART, NARROWEST = 0.8, 2.5
"""A line runs between two pixels if the paint nearest to them is so far apart: in their distances from it, and in pixels."""

SAME_SIDE = 0.3
"""Cosine between the ways to a line from two pixels of one side of it, at least."""

FITS, BETTER_BY = 0.12, 0.1
"""Illumination by which a rim may miss its colors, on the mean of a side; and by how much less than the other side."""

SHORTEST = 0.04
"""Least length of a contour's side, in square roots of the object's area."""


@dataclass(frozen=True, eq=False)
class Contours:
    """
    Interior contours on a `MaskedGrid`.

    Attributes
    ----------
    cut : ndarray, shape (P, 4)
        bool, the links to neighbors that cross one.
    outward : ndarray, shape (P, 2)
        Unit vector (x, y) across the contour, for the pixels of its nearer side: (nx, ny) of the rim there. Zero elsewhere.
    """

    cut: BoolArray
    outward: FloatArray


def drawn_contours(
    ink: MixedPixels, tones: FloatArray, illumination: FloatArray, light: FloatArray, grid: MaskedGrid
) -> Contours | None:
    """
    Find the contours that the lines of a drawing show, where its colors tell which side is the nearer one.

    Parameters
    ----------
    ink : MixedPixels
        The pixels that lines touch.
    tones : ndarray, shape (P,)
        Tones of the paint, without the ink.
    illumination : ndarray, shape (P,)
        L · N0 of the shape inflated from the silhouette alone.
    light : ndarray, shape (3,)
        Unit vector L from the surface to the light.
    grid : MaskedGrid
        The object.

    Returns
    -------
    Contours or None
        None if there are none.

    Notes
    -----
    On the nearer side of a contour the shape has a rim: its normal lies in the image plane and faces across the contour, as
    it does on the silhouette, and its color must be one that rank matching allows for the illumination of such a normal. The
    farther side may have any color. A line both of whose sides could be rims, or neither, constrains nothing.
    """
    across = _way_from_paint(ink, grid)
    cut = _crossing(ink, grid)
    beside = np.flatnonzero(cut.any(axis=1))
    if beside.size == 0:
        return None
    ranks = ToneRanks.of(tones.astype(np.float32))
    ordered = np.sort(illumination)
    lit = across[beside] @ light[:2]
    missed = np.abs(lit - np.clip(lit, ordered[ranks.below[beside]], ordered[ranks.upto[beside] - 1]))
    side, count = _sides(beside, across, grid)
    opposite = _opposite_sides(beside, side, count, cut, grid)
    pixels = np.bincount(side, minlength=count)
    miss = np.bincount(side, missed, minlength=count) / pixels
    long = pixels >= SHORTEST * np.sqrt(grid.size)
    nearer = long & long[opposite] & (miss < FITS) & (miss[opposite] - miss > BETTER_BY)
    if not nearer.any():
        return None
    outward = np.zeros((grid.size, 2))
    rims = nearer[side] & (missed < FITS)
    outward[beside[rims]] = across[beside[rims]]
    decided = np.zeros(grid.size, np.bool_)
    decided[beside] = (nearer | nearer[opposite])[side]
    return Contours(cut_both_ways(grid, cut & decided[:, None]), outward)


def cut_both_ways(grid: MaskedGrid, cut: BoolArray) -> BoolArray:
    """Cut each link (P, 4) from both ends; changes and returns what it is given."""
    for direction, there in enumerate(grid.neighbors.T):
        crossing = np.flatnonzero(cut[:, direction] & (there != OUTSIDE))
        cut[there[crossing], (direction + 2) % 4] = True
    return cut


def _way_from_paint(ink: MixedPixels, grid: MaskedGrid) -> FloatArray:
    """Return the ways (P, 2) to inked pixels from their nearest paint: across the line, as seen from that side of it."""
    way = np.zeros((grid.size, 2))
    way[ink.pixels, 0] = grid.columns[ink.pixels] - grid.columns[ink.sources[:, 0]]
    way[ink.pixels, 1] = grid.rows[ink.sources[:, 0]] - grid.rows[ink.pixels]
    length: FloatArray = np.linalg.norm(way, axis=1, keepdims=True)
    return way / np.maximum(length, 1e-9)


def _crossing(ink: MixedPixels, grid: MaskedGrid) -> BoolArray:
    """Links (P, 4) in the middle of a line: the paint nearest to their ends lies on different sides of it."""
    row, column = grid.rows.astype(np.float64), grid.columns.astype(np.float64)
    row[ink.pixels], column[ink.pixels] = grid.rows[ink.sources[:, 0]], grid.columns[ink.sources[:, 0]]
    distance = np.hypot(row - grid.rows, column - grid.columns)
    cut = np.zeros(grid.neighbors.shape, np.bool_)
    for direction in range(4):
        here = ink.pixels[grid.neighbors[ink.pixels, direction] != OUTSIDE]
        there = grid.neighbors[here, direction]
        apart = np.hypot(row[here] - row[there], column[here] - column[there])
        cut[here, direction] = apart > np.maximum(APART * (distance[here] + distance[there]), NARROWEST)
    return cut_both_ways(grid, cut)


def _sides(beside: NDArray[np.intp], across: FloatArray, grid: MaskedGrid) -> tuple[NDArray[np.intp], int]:
    """Return the number of a line's side for each pixel (n,), and how many: from one side, the line lies the same way."""
    place = np.full(grid.size + 1, -1)  # of OUTSIDE, the last one, too
    place[beside] = np.arange(len(beside))
    framed = np.pad(grid.index, 1, constant_values=OUTSIDE)
    rows, columns = grid.rows[beside] + 1, grid.columns[beside] + 1
    pairs = []
    for down, along in ((0, 1), (1, -1), (1, 0), (1, 1)):
        other = place[framed[rows + down, columns + along]]
        here = np.flatnonzero(other >= 0)
        alike = np.einsum("nc,nc->n", across[beside[here]], across[beside[other[here]]]) > SAME_SIDE
        pairs.append(np.stack([here[alike], other[here[alike]]]))
    first, second = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(len(first)), (first, second)), (len(beside), len(beside)))
    count, side = connected_components(graph, directed=False)
    return side, int(count)


def _opposite_sides(
    beside: NDArray[np.intp], side: NDArray[np.intp], count: int, cut: BoolArray, grid: MaskedGrid
) -> NDArray[np.intp]:
    """For each side, the one that most of its cut links lead to; (count,)."""
    place = np.full(grid.size, -1)
    place[beside] = np.arange(len(beside))
    here, direction = np.nonzero(cut[beside])
    there = place[grid.neighbors[beside[here], direction]]
    met, links = np.unique(side[here] * count + side[there], return_counts=True)
    met = met[np.argsort(links, kind="stable")]
    opposite = np.zeros(count, np.intp)
    opposite[met // count] = met % count  # the last one written, met most often, stays
    return opposite

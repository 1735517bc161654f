"""MaskedGrid: the object's pixels as a compact array, and their neighbors.

The only place where fields cross between image form (H, W, ...) and compact form (P, ...), and where the row axis,
which points down, meets the frame's y, which points up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.numerics.compiled import njit
from toonkit.numerics.parallel import RowChunks

RIGHT, UP, LEFT, DOWN = 0, 1, 2, 3
STEPS = ((0, 1), (-1, 0), (0, -1), (1, 0))
"""(row, column) step to each neighbor: up is y + 1, hence row - 1."""

OUTSIDE = -1

EDGE_SHARE = 0.5
"""Two edges of length h become one of length 2 h between blocks, with half the sum of their weights."""

IndexArray = NDArray[np.int32]

Box = tuple[slice, slice]
"""Rows and columns."""

EdgeWeights = NDArray[np.float32]
"""Weight of the edge from each pixel to each neighbor, (P, 4). Single precision: solvers read little else as often."""


class MaskedGrid:
    """
    Compact index of the True pixels of a mask, in row-major order.

    Parameters
    ----------
    mask : ndarray, shape (H, W)
        bool.

    Attributes
    ----------
    mask : ndarray, shape (H, W)
        bool.
    size : int
        Number of pixels P.
    rows, columns : ndarray, shape (P,)
        Position of each pixel.
    index : ndarray, shape (H, W)
        Compact index of each pixel of the picture; `OUTSIDE` off the mask.
    """

    def __init__(self, mask: BoolArray) -> None:
        self.mask = mask
        height, width = mask.shape
        place = np.flatnonzero(mask)
        self.size = len(place)
        row, column = np.divmod(place, width)
        self.rows, self.columns = row.astype(np.int32), column.astype(np.int32)
        self._framed: IndexArray = np.full((height + 2, width + 2), OUTSIDE, dtype=np.int32)
        self.index: IndexArray = self._framed[1:-1, 1:-1]
        # Flat indices do the same several times as fast as pairs of them.
        place += 2 * row + (width + 3)
        self._framed.ravel()[place] = np.arange(self.size, dtype=np.int32)

    @cached_property
    def neighbors(self) -> IndexArray:
        """Compact index of the right, upper, left and lower neighbor, (P, 4); `OUTSIDE` where that is not on the mask."""
        flat, stride = self._framed.ravel(), self._framed.shape[1]
        place = self.rows.astype(np.intp) * stride + self.columns + (stride + 1)
        neighbors: IndexArray = np.empty((self.size, len(STEPS)), np.int32)
        for direction, (down, along) in enumerate(STEPS):
            neighbors[:, direction] = flat[place + (down * stride + along)]
        return neighbors

    def release(self) -> None:
        """Free what solvers need and what can be made again: the neighbors and the coarser grids."""
        for name in ("neighbors", "coarsening"):
            self.__dict__.pop(name, None)

    @cached_property
    def rim(self) -> BoolArray:
        """Pixels that touch the background through a side, shape (P,)."""
        return rim_mask(self.mask)[self.mask]

    @cached_property
    def chunks(self) -> RowChunks:
        """The pixels cut into chunks of rows, for loops on all cores."""
        return RowChunks.of(self.rows)

    def gather(self, image: NDArray[Any]) -> NDArray[Any]:
        """Image form (H, W, ...) to compact form (P, ...)."""
        pixels = image.reshape(-1, *image.shape[2:])
        return np.asarray(np.take(pixels, np.flatnonzero(self.mask), axis=0))

    def scatter(self, compact: FloatArray, fill: float = np.nan) -> FloatArray:
        """Compact form (P, ...) to image form (H, W, ...), with `fill` outside the mask."""
        image = np.full(self.mask.shape + compact.shape[1:], fill)
        image[self.mask] = compact
        return image

    def laplacian(self, field: FloatArray) -> FloatArray:
        """Return the 5-point Laplacian of a field (P, C): no flow across the outline. It is its own adjoint."""
        result: FloatArray = _laplacian(self.neighbors, field)
        return result

    @cached_property
    def coarsening(self) -> Coarsening:
        """The way to the grid of half the resolution."""
        height, width = self.mask.shape
        even = np.pad(self.mask, ((0, height % 2), (0, width % 2)))
        blocks = even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2)
        coarse = MaskedGrid(np.asarray(blocks.any(axis=(1, 3))))
        return Coarsening(self, coarse, coarse.index[self.rows // 2, self.columns // 2])


@dataclass(frozen=True, eq=False)
class Coarsening:
    """
    A grid and that of its 2 x 2 blocks.

    Attributes
    ----------
    fine, coarse : MaskedGrid
        A block is on the coarse grid if any of its pixels is on the fine one.
    parent : ndarray, shape (P,)
        Compact index, in the coarse grid, of each pixel's block.
    """

    fine: MaskedGrid
    coarse: MaskedGrid
    parent: IndexArray

    def sum_blocks(self, values: FloatArray) -> FloatArray:
        """Sum values, (P,) or (P, C), over each block, in their own precision."""
        columns = values.reshape(len(values), -1)
        sums = np.zeros((self.coarse.size, columns.shape[1]), columns.dtype)
        self.fine.chunks.run(_add_to_blocks, self.parent, columns, sums)
        return sums.reshape(-1, *values.shape[1:])

    def coarsen_edge_weights(self, edge_weights: EdgeWeights) -> EdgeWeights:
        """Return the weights (P, 4) of the edges between blocks, from those between pixels."""
        fine, stiffness = self.fine, np.zeros((self.coarse.size, 4), np.float32)
        fine.chunks.run(_add_crossing, fine.rows, fine.columns, self.parent, edge_weights, stiffness)
        return stiffness

    def interpolate(self, field: FloatArray, out: FloatArray, *, adding: bool = False) -> FloatArray:
        """
        Interpolate a coarse field (coarse size, C) linearly between block centers, and write it, or add it, to `out` (P, C).

        Where a block is missing, the pixel's own stands in.
        """
        fine = self.fine
        fine.chunks.run(
            _interpolate, fine.rows, fine.columns, self.parent, self.coarse.neighbors, field, out, adding
        )
        return out


def bounding_box(mask: BoolArray) -> Box:
    """Return the rows and columns that the True pixels of a mask (H, W) span; there is at least one."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def rim_mask(mask: BoolArray) -> BoolArray:
    """Pixels of a mask that touch the background, or the picture's edge, through a side: shape (H, W)."""
    framed = np.pad(mask, 1)
    inside = framed[:-2, 1:-1] & framed[2:, 1:-1] & framed[1:-1, :-2] & framed[1:-1, 2:]
    rim: BoolArray = mask & ~inside
    return rim


@njit(cache=True, nogil=True)
def _laplacian(neighbors, field):  # type: ignore[no-untyped-def]
    result = np.zeros_like(field)
    for p in range(field.shape[0]):
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                for c in range(field.shape[1]):
                    result[p, c] += field[q, c] - field[p, c]
    return result


def block_sums(index: NDArray[np.integer], values: FloatArray, count: int) -> FloatArray:
    """Sum values that share an index: shape (count,), 0 where none has it."""
    return np.bincount(index, weights=values, minlength=count).astype(np.float64, copy=False)


@njit(cache=True, nogil=True, error_model="numpy")
def _add_to_blocks(parent, values, sums, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        for c in range(values.shape[1]):
            sums[parent[p], c] += values[p, c]


@njit(cache=True, nogil=True, error_model="numpy")
def _add_crossing(rows, columns, parent, edge_weights, stiffness, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        along, up_or_down = 0 if columns[p] & 1 else 2, 3 if rows[p] & 1 else 1  # where the block ends
        stiffness[parent[p], along] += EDGE_SHARE * edge_weights[p, along]
        stiffness[parent[p], up_or_down] += EDGE_SHARE * edge_weights[p, up_or_down]


@njit(cache=True, nogil=True, error_model="numpy")
def _interpolate(rows, columns, parent, neighbors, field, out, adding, first, last):  # type: ignore[no-untyped-def]
    for p in range(first, last):
        own = parent[p]
        along = neighbors[own, 0 if columns[p] & 1 else 2]
        up_or_down = 3 if rows[p] & 1 else 1
        above = neighbors[own, up_or_down]
        across = neighbors[along, up_or_down] if along >= 0 else OUTSIDE
        if along < 0:
            along = own
        if above < 0:
            above = own
        if across < 0:
            across = own
        for c in range(field.shape[1]):
            beside = field[along, c] + field[above, c]
            value = 0.5625 * field[own, c] + 0.1875 * beside + 0.0625 * field[across, c]
            out[p, c] = out[p, c] + value if adding else value

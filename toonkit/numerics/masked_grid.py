"""MaskedGrid: the object's pixels as a compact array, their neighbors, and difference operators.

The only place where fields cross between image form (H, W, ...) and compact form (P, ...), and where the row axis,
which points down, meets the frame's y, which points up.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray

RIGHT, UP, LEFT, DOWN = 0, 1, 2, 3
STEPS = ((0, 1), (-1, 0), (0, -1), (1, 0))
"""(row, column) step to each neighbor: up is y + 1, hence row - 1."""

OUTSIDE = -1

IndexArray = NDArray[np.int32]


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
    neighbors : ndarray, shape (P, 4)
        Compact index of the right, upper, left and lower neighbor; `OUTSIDE` where that is not on the mask.
    """

    def __init__(self, mask: BoolArray) -> None:
        self.mask = mask
        self.rows, self.columns = np.nonzero(mask)
        self.size = len(self.rows)
        framed = np.full((mask.shape[0] + 2, mask.shape[1] + 2), OUTSIDE, dtype=np.int32)
        framed[1:-1, 1:-1][mask] = np.arange(self.size, dtype=np.int32)
        self.index: IndexArray = framed[1:-1, 1:-1]
        self.neighbors: IndexArray = np.stack(
            [framed[self.rows + 1 + down, self.columns + 1 + along] for down, along in STEPS], axis=1
        )

    @cached_property
    def rim(self) -> BoolArray:
        """Pixels that touch the background through a side, shape (P,)."""
        return rim_mask(self.mask)[self.mask]

    def gather(self, image: NDArray[np.generic]) -> NDArray[np.generic]:
        """Image form (H, W, ...) to compact form (P, ...)."""
        return image[self.mask]

    def scatter(self, compact: FloatArray, fill: float = np.nan) -> FloatArray:
        """Compact form (P, ...) to image form (H, W, ...), with `fill` outside the mask."""
        image = np.full(self.mask.shape + compact.shape[1:], fill)
        image[self.mask] = compact
        return image

    def differences(self, field: FloatArray) -> FloatArray:
        """
        Forward differences toward x (right) and y (up), zero where that neighbor is outside.

        Parameters
        ----------
        field : ndarray, shape (P,)
            A scalar field.

        Returns
        -------
        ndarray, shape (P, 2)
            Differences per pixel step.
        """
        result = np.zeros((self.size, 2))
        for axis, direction in enumerate((RIGHT, UP)):
            there = self.neighbors[:, direction]
            linked = there != OUTSIDE
            result[linked, axis] = field[there[linked]] - field[linked]
        return result

    def differences_adjoint(self, flow: FloatArray) -> FloatArray:
        """Adjoint of `differences`: (P, 2) to (P,), minus the divergence of the flow."""
        result = np.zeros(self.size)
        for axis, direction in enumerate((RIGHT, UP)):
            there = self.neighbors[:, direction]
            linked = there != OUTSIDE
            result[linked] -= flow[linked, axis]
            result += block_sums(there[linked], flow[linked, axis], self.size)
        return result

    def laplacian(self, field: FloatArray) -> FloatArray:
        """
        Sum over neighbors of (neighbor - pixel): no flow across the outline. It is its own adjoint.

        Parameters
        ----------
        field : ndarray, shape (P, C)
            A field of C components.

        Returns
        -------
        ndarray, shape (P, C)
            The 5-point Laplacian, per pixel step squared.
        """
        result: FloatArray = _laplacian(self.neighbors, field)
        return result

    def coarsened(self) -> tuple[MaskedGrid, IndexArray]:
        """
        Return the grid of 2 x 2 blocks and the block of each pixel.

        Returns
        -------
        grid : MaskedGrid
            A block is on it if any of its pixels is on this grid.
        parent : ndarray, shape (P,)
            Compact index, in the coarse grid, of each pixel's block.
        """
        height, width = self.mask.shape
        mask = np.zeros(((height + 1) // 2, (width + 1) // 2), dtype=np.bool_)
        mask[self.rows // 2, self.columns // 2] = True
        index = np.full(mask.shape, OUTSIDE, dtype=np.int32)
        index[mask] = np.arange(int(mask.sum()), dtype=np.int32)
        return MaskedGrid(mask), index[self.rows // 2, self.columns // 2]


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

"""A drawing reduced to about the resolution that the networks see, so that they see the same at any size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array
from toonkit.estimation.reading import Reading
from toonkit.estimation.working_square import WorkingSquare
from toonkit.numerics.masked_grid import OUTSIDE, Coarsening, MaskedGrid

LONGEST = 320
"""Pixels of the object's longer side at most: three or less to a pixel of the working square."""


@dataclass(frozen=True, eq=False)
class Overview:
    """
    An object in blocks of 2^k x 2^k pixels.

    Attributes
    ----------
    grid : MaskedGrid
        The blocks of which the object covers at least half.
    factor : int
        Pixels to a block's side.
    tones : ndarray, shape (Q,)
        Plain tone at the middle of each block, or its mean if the object is not there.
    initial : ndarray, shape (Q, 3)
        Mean of N0 in each block, unit vectors.
    """

    grid: MaskedGrid
    factor: int
    tones: FloatArray
    initial: FloatArray

    @classmethod
    def of(cls, read: Reading, initial: FloatArray) -> Overview:
        """Reduce a drawing and its N0 (P, 3)."""
        steps = _halvings(read.grid)
        factor = 2 ** len(steps)
        grid = steps[-1].coarse if steps else read.grid
        tones = _block_means(steps, read.tones.plain)
        height, width = read.grid.mask.shape
        down, right = factor * grid.rows + factor // 2, factor * grid.columns + factor // 2
        middle = read.grid.index[np.minimum(down, height - 1), np.minimum(right, width - 1)]
        tones[middle != OUTSIDE] = read.tones.plain[middle[middle != OUTSIDE]]
        vectors = np.stack([_block_means(steps, part) for part in initial.T], axis=1)
        vectors /= np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)
        area = np.ones(read.grid.size)
        for step in steps:
            area = step.sums(area)
        filled = 2 * area >= factor**2
        if not filled.any():  # nothing but lines
            filled = np.ones_like(filled)
        mask = np.zeros_like(grid.mask)
        mask[grid.rows[filled], grid.columns[filled]] = True
        return cls(MaskedGrid(mask), factor, tones[filled], vectors[filled])

    def seen_from(self, square: WorkingSquare) -> tuple[BoolArray, Array, Array]:
        """Mask, tones and N0 on a square of the overview; zero beside the object."""
        blocks = square.sampled_pixels(self.grid)
        mask = blocks != OUTSIDE
        tones, vectors = np.zeros(mask.shape, np.float32), np.zeros((*mask.shape, 3), np.float32)
        tones[mask], vectors[mask] = self.tones[blocks[mask]], self.initial[blocks[mask]]
        return mask, tones, vectors


def _halvings(grid: MaskedGrid) -> list[Coarsening]:
    steps: list[Coarsening] = []
    while max(np.ptp(grid.rows), np.ptp(grid.columns)) >= LONGEST:
        steps.append(grid.coarsening)
        grid = grid.coarsening.coarse
    return steps


def _block_means(steps: list[Coarsening], values: FloatArray) -> FloatArray:
    weight = np.ones(len(values))
    total = values.copy()
    for step in steps:
        total, weight = step.sums(total), step.sums(weight)
    return total / weight

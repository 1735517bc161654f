"""A drawing reduced to about the resolution that the networks see, so that they see the same at any size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.estimation.reading import Reading
from toonkit.estimation.working_square import WorkingSquare
from toonkit.numerics.bands import run_in_bands
from toonkit.numerics.masked_grid import OUTSIDE, Coarsening, IndexArray, MaskedGrid

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
    steps : list of Coarsening
        The way to blocks of this size.
    filled : ndarray, shape (Q',)
        bool, which of those blocks are on the grid.
    tones : ndarray, shape (Q,)
        Median tone of each block, plain: a narrow transition is taken for a mixture if it is one at this size.
    ink : ndarray, shape (Q,)
        bool, the blocks of whose object ink touches at least half.
    initial : ndarray, shape (Q, 3)
        Mean of N0 in each block, unit vectors.
    """

    grid: MaskedGrid
    steps: list[Coarsening]
    filled: BoolArray
    tones: FloatArray
    ink: BoolArray
    initial: FloatArray

    @classmethod
    def of(cls, read: Reading, initial: FloatArray) -> Overview:
        """Reduce a drawing and its N0 (P, 3)."""
        steps = _halvings(read.grid)
        factor = 2 ** len(steps)
        grid = steps[-1].coarse if steps else read.grid
        area = _block_sums(steps, np.ones(read.grid.size))
        filled = 2 * area >= factor**2
        if not filled.any():  # nothing but lines
            filled = np.ones_like(filled)
        mask = np.zeros_like(grid.mask)
        mask[grid.rows[filled], grid.columns[filled]] = True
        reduced = MaskedGrid(mask)
        tones = read.tones.plain
        if steps:
            medians = _block_medians(read, grid.mask.shape, factor)[mask]
            tones = PaintedTones.of(np.repeat(medians[:, None], 3, axis=1), reduced).plain  # as grays
        ink = np.zeros(reduced.size, np.bool_)
        if read.line_art is not None:
            touched = np.zeros(read.grid.size)
            touched[read.line_art.pixels] = 1.0
            ink = (2 * _block_sums(steps, touched) >= area)[filled]
        return cls(reduced, steps, filled, tones, ink, _directions(steps, initial)[filled])

    @property
    def factor(self) -> int:
        """Pixels to a block's side."""
        return 1 << len(self.steps)

    def seen_from(self, square: WorkingSquare) -> tuple[BoolArray, BoolArray, Array, Array]:
        """Mask, ink, tones and N0 on a square of the overview; zero beside the object."""
        blocks = square.sampled_pixels(self.grid)
        ink = _sampled(self.ink, blocks) > 0
        return blocks != OUTSIDE, ink, _sampled(self.tones, blocks), _sampled(self.initial, blocks)


def _halvings(grid: MaskedGrid) -> list[Coarsening]:
    steps: list[Coarsening] = []
    while max(np.ptp(grid.rows), np.ptp(grid.columns)) >= LONGEST:
        steps.append(grid.coarsening)
        grid = grid.coarsening.coarse
    return steps


def _block_sums(steps: list[Coarsening], values: FloatArray) -> FloatArray:
    for step in steps:
        values = step.sums(values)
    return values


def _block_medians(read: Reading, shape: tuple[int, ...], factor: int) -> FloatArray:
    """Median tone of the object in each block of a picture of so many blocks; of an even number the darker middle one."""
    height, width = shape
    framed = np.full((height * factor, width * factor), np.nan)
    framed[read.grid.rows, read.grid.columns] = read.tones.tone
    medians = np.empty(shape)
    run_in_bands(_find_medians, framed.reshape(height, factor, width, factor), medians)
    return medians


def _find_medians(blocks: FloatArray, medians: FloatArray, first: int, last: int) -> None:
    """Write the medians of some rows of blocks (h, n, w, n); NaN of those that hold NaN alone."""
    ordered = np.sort(
        np.moveaxis(blocks[first:last], 2, 1).reshape(last - first, blocks.shape[2], -1), axis=2
    )
    count = np.isfinite(ordered).sum(axis=2, keepdims=True)  # NaN comes last
    medians[first:last] = np.take_along_axis(ordered, np.maximum(count - 1, 0) // 2, axis=2)[..., 0]


def _directions(steps: list[Coarsening], vectors: FloatArray) -> FloatArray:
    """Mean direction of the vectors in each block."""
    total = _block_sums(steps, vectors)
    length: FloatArray = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.maximum(length, 1e-9)


def _sampled(values: FloatArray | BoolArray, blocks: IndexArray) -> Array:
    """Values (Q, ...) of blocks (S, S); zero where there is none."""
    there = blocks != OUTSIDE
    sampled = np.zeros((*blocks.shape, *values.shape[1:]), np.float32)
    sampled[there] = values[blocks[there]]
    return sampled

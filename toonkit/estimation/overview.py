"""A drawing reduced to about the resolution that the networks see, so that they see the same at any size."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.estimation.reading import Reading
from toonkit.estimation.working_square import WorkingSquare
from toonkit.model.luminance import REC709, linear_to_srgb
from toonkit.numerics.masked_grid import OUTSIDE, Coarsening, IndexArray, MaskedGrid

LONGEST = 320
"""Pixels of the object's longer side at most: three or less to a pixel of the working square."""


@dataclass(frozen=True, eq=False)
class ReducedPaint:
    """
    A drawing in blocks of 2^k x 2^k pixels.

    Attributes
    ----------
    grid : MaskedGrid
        The blocks of which the object covers at least half.
    steps : list of Coarsening
        The way to blocks of this size.
    filled : ndarray, shape (Q',)
        bool, which of those blocks are on the grid.
    tones : ndarray, shape (Q,)
        Tone of each block's mean light, plain: what the same drawing shows that was reduced before it was given.
    ink : ndarray, shape (Q,)
        bool, the blocks of whose object ink touches at least half.
    """

    grid: MaskedGrid
    steps: list[Coarsening]
    filled: BoolArray
    tones: FloatArray
    ink: BoolArray


@dataclass(frozen=True, eq=False)
class Overview(ReducedPaint):
    """
    A drawing in blocks, with its inflated shape.

    Attributes
    ----------
    initial : ndarray, shape (Q, 3)
        Mean of N0 in each block, unit vectors.
    """

    initial: FloatArray

    @classmethod
    def of(cls, read: Reading, initial: FloatArray) -> Overview:
        """Reduce a drawing and its N0 (P, 3); the drawing once, however often it is asked for."""
        paint = _KNOWN.get(read)
        if paint is None:
            paint = _KNOWN[read] = _reduced(read)
        directions = _directions(paint.steps, initial)[paint.filled]
        return cls(paint.grid, paint.steps, paint.filled, paint.tones, paint.ink, directions)

    @property
    def factor(self) -> int:
        """Pixels to a block's side."""
        return 1 << len(self.steps)

    def seen_from(self, square: WorkingSquare) -> tuple[BoolArray, BoolArray, Array, Array]:
        """Mask, ink, tones and N0 on a square of the overview; zero beside the object."""
        blocks = square.sampled_pixels(self.grid)
        ink = _sampled(self.ink, blocks) > 0
        return blocks != OUTSIDE, ink, _sampled(self.tones, blocks), _sampled(self.initial, blocks)


_KNOWN: WeakKeyDictionary[Reading, ReducedPaint] = WeakKeyDictionary()
"""Drawings that were reduced, each as long as its reading lives."""


def _reduced(read: Reading) -> ReducedPaint:
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
        light = (_block_sums(steps, read.tones.light) / area[:, None])[filled]
        tones = PaintedTones.between(light, linear_to_srgb(light @ REC709), reduced).plain
    ink = np.zeros(reduced.size, np.bool_)
    if read.line_art is not None:
        touched = np.zeros(read.grid.size)
        touched[read.line_art.pixels] = 1.0
        ink = (2 * _block_sums(steps, touched) >= area)[filled]
    return ReducedPaint(reduced, steps, filled, tones, ink)


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

"""A drawing reduced to about the resolution that the networks see, so that they see the same at any size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array
from toonkit.estimation.painted_tones import find_mixtures
from toonkit.estimation.working_square import WorkingSquare
from toonkit.model.luminance import linear_to_srgb
from toonkit.numerics.masked_grid import OUTSIDE, Coarsening, IndexArray, MaskedGrid

LONGEST = 320
"""Most pixels of the object's longer side. At most three of them fall into a pixel of the working square."""


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
        Plain tone of the mean light of each block: the tone that the drawing would have had at this size.
    ink : ndarray, shape (Q,)
        bool, the blocks of whose object ink touches at least half.
    labels : ndarray, shape (Q,)
        int, the material of a pixel of each block.
    """

    grid: MaskedGrid
    steps: list[Coarsening]
    filled: BoolArray
    tones: FloatArray
    ink: BoolArray
    labels: IndexArray

    @property
    def factor(self) -> int:
        """Side of a block, in pixels."""
        return 1 << len(self.steps)


class Seen(NamedTuple):
    """
    What a square shows of a drawing, as arrays of shape (SIZE, SIZE) or (SIZE, SIZE, 3), zero beside the object.

    Attributes
    ----------
    mask, ink : ndarray of bool
        The object, and where its paint shows no shading.
    labels : ndarray of float32
        Numbers of the materials.
    tones : ndarray of float32
        The paint's tones.
    initial : ndarray of float32
        N0.
    """

    mask: BoolArray
    ink: BoolArray
    labels: Array
    tones: Array
    initial: Array


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
    def of(cls, paint: ReducedPaint, initial: FloatArray) -> Overview:
        """Add N0 (P, 3) to a drawing that has been reduced."""
        directions = _directions(paint.steps, initial)[paint.filled]
        return cls(paint.grid, paint.steps, paint.filled, paint.tones, paint.ink, paint.labels, directions)

    def seen_from(self, square: WorkingSquare) -> Seen:
        """Look at the overview on a square."""
        blocks = square.sampled_pixels(self.grid)
        fields = (self.labels, self.tones, self.initial)
        labels, tones, initial = (_sampled(field, blocks) for field in fields)
        return Seen(blocks != OUTSIDE, _sampled(self.ink, blocks) > 0, labels, tones, initial)


def reduce_paint(
    grid: MaskedGrid, light: FloatArray, tones: FloatArray, inked: BoolArray, labels: IndexArray
) -> ReducedPaint:
    """
    Reduce an object's paint to blocks, `LONGEST` to its longer side at most.

    Parameters
    ----------
    grid : MaskedGrid
        The object.
    light : ndarray, shape (P,)
        Its luminance, linear.
    tones : ndarray, shape (P,)
        Its tones without mixtures.
    inked : ndarray of bool, shape (P,)
        Where ink touches the pixel.
    labels : ndarray of int, shape (P,)
        Numbers of its materials.

    Returns
    -------
    ReducedPaint
        The object in blocks.
    """
    steps = _halvings(grid)
    factor = 2 ** len(steps)
    coarse = steps[-1].coarse if steps else grid
    area = _block_sums(steps, np.ones(grid.size))
    filled = 2 * area >= factor**2
    if not filled.any():  # nothing but lines
        filled = np.ones_like(filled)
    mask = np.zeros_like(coarse.mask)
    mask[coarse.rows[filled], coarse.columns[filled]] = True
    reduced = MaskedGrid(mask)
    if steps:
        tones = linear_to_srgb((_block_sums(steps, light) / area)[filled])
        mixtures = find_mixtures(tones, reduced.rows, reduced.columns)
        tones = mixtures.replaced(tones, mixtures.nearer)
    ink = (2 * _block_sums(steps, inked.astype(np.float64)) >= area)[filled]
    for step in steps:
        of_block = np.empty(step.coarse.size, labels.dtype)
        of_block[step.parent] = labels
        labels = of_block
    return ReducedPaint(reduced, steps, filled, tones, ink, labels[filled] if steps else labels)


def _halvings(grid: MaskedGrid) -> list[Coarsening]:
    steps: list[Coarsening] = []
    while max(np.ptp(grid.rows), np.ptp(grid.columns)) >= LONGEST:
        steps.append(grid.coarsening)
        grid = grid.coarsening.coarse
    return steps


def _block_sums(steps: list[Coarsening], values: FloatArray) -> FloatArray:
    for step in steps:
        values = step.sum_blocks(values)
    return values


def _directions(steps: list[Coarsening], vectors: FloatArray) -> FloatArray:
    """Mean direction of the vectors in each block."""
    total = _block_sums(steps, vectors)
    length: FloatArray = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.maximum(length, 1e-9)


def _sampled(values: FloatArray | BoolArray | IndexArray, blocks: IndexArray) -> Array:
    """Values (Q, ...) of blocks (S, S); zero where there is none."""
    there = blocks != OUTSIDE
    sampled = np.zeros((*blocks.shape, *values.shape[1:]), np.float32)
    sampled[there] = values[blocks[there]]
    return sampled

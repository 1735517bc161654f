"""Islands: parts of an object that do not touch, each cropped to its bounding box and analyzed as an object of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects, label

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.silhouette import Silhouette, trace_silhouette
from toonkit.estimation.turn import AS_DRAWN, Turn
from toonkit.numerics.masked_grid import Box, IndexArray, MaskedGrid, bounding_box

LEAST_PIXELS = 64
"""Pixels of an island that is analyzed by itself. Smaller ones, such as the dots of a dithered drawing, form one object."""

MOST = 100
"""Islands of one view of an object that are analyzed by themselves, at most: the largest ones."""


@dataclass(frozen=True, eq=False)
class Island:
    """
    A part of an object that touches no other, on its bounding box.

    Attributes
    ----------
    grid : MaskedGrid
        Its pixels.
    coverage : ndarray, shape (h + 2, w + 2)
        Alpha of the box and of the pixels around it.
    pixels : ndarray of int, shape (p,), or slice
        Which of the whole object's pixels they are, in the same order.
    turn : Turn
        How it lies here, compared with the picture.
    """

    grid: MaskedGrid
    coverage: FloatArray
    pixels: IndexArray | slice
    turn: Turn = AS_DRAWN

    @cached_property
    def silhouette(self) -> Silhouette:
        """The outline, between the pixels."""
        return trace_silhouette(self.grid, self.coverage)

    def moment(self, brightness: FloatArray) -> FloatArray:
        """Return where the island is bright, by numbers (P,) of the object's pixels: (x, y) from the middle of its box."""
        own = brightness[self.pixels]
        height, width = self.grid.mask.shape
        along = own @ (2.0 * self.grid.columns - (width - 1))
        up = own @ (height - 1 - 2.0 * self.grid.rows)
        return np.array([along, up])

    def turned(self, turn: Turn) -> Island:
        """Turn an island that lies as drawn."""
        if turn.is_identity:
            return self
        grid = MaskedGrid(turn.picture(self.grid.mask))
        order = turn.picture(self.grid.index)[grid.mask]
        pixels = order if isinstance(self.pixels, slice) else self.pixels[order]
        return Island(grid, turn.picture(self.coverage), pixels, turn)

    def own_vectors(self, vectors: FloatArray) -> FloatArray:
        """Take vectors (P, 3) of the whole object at the island's pixels, and turn them as it lies, (p, 3)."""
        return self.turn.vectors(vectors[self.pixels])


def with_surroundings(image: NDArray[Any], box: Box) -> NDArray[Any]:
    """Return an image (H, W) on a box and the pixels around it, (h + 2, w + 2); zero beyond the picture."""
    framed = np.zeros([side.stop - side.start + 2 for side in box], image.dtype)
    inner = [slice(max(side.start - 1, 0), side.stop + 1) for side in box]
    taken = image[inner[0], inner[1]]
    down, along = (int(side.start == 0) for side in box)
    framed[down : down + taken.shape[0], along : along + taken.shape[1]] = taken
    return framed


def islands_of(mask: BoolArray, coverage: FloatArray) -> tuple[Island, ...]:
    """Crop the object of a picture to its bounding box and split it; mask and coverage are of shape (H, W)."""
    box = bounding_box(mask)
    return find_islands(MaskedGrid(np.ascontiguousarray(mask[box])), with_surroundings(coverage, box))


def join(islands: tuple[Island, ...], fields: Sequence[FloatArray]) -> FloatArray:
    """Put fields (p, ...) of an object's islands together to one of the whole object, (P, ...)."""
    if isinstance(islands[0].pixels, slice):
        return fields[0]
    whole = np.empty((sum(map(len, fields)), *fields[0].shape[1:]), fields[0].dtype)
    for island, field in zip(islands, fields, strict=True):
        whole[island.pixels] = field
    return whole


def join_vectors(islands: tuple[Island, ...], fields: Sequence[FloatArray]) -> FloatArray:
    """Put vectors (p, 3) of an object's islands, turned as these lie, together to those of the whole object, (P, 3)."""
    return join(
        islands, [island.turn.vectors_back(field) for island, field in zip(islands, fields, strict=True)]
    )


def find_islands(grid: MaskedGrid, coverage: FloatArray, *, most: int = MOST) -> tuple[Island, ...]:
    """
    Split an object into islands.

    Parameters
    ----------
    grid : MaskedGrid
        The object on its bounding box.
    coverage : ndarray, shape (H + 2, W + 2)
        Alpha of the box and of the pixels around it.
    most : int, optional
        Islands that are analyzed by themselves, at most.

    Returns
    -------
    tuple of Island
        In row-major order of their first pixels; pixels that touch at a corner are on one island. The last one may be all
        that is too small to be analyzed by itself.
    """
    labels, count = label(grid.mask, np.ones((3, 3), np.bool_))
    if count == 1:
        return (Island(grid, coverage, slice(None)),)
    areas = np.bincount(labels.ravel(), minlength=count + 1)
    areas[0] = 0
    alone = np.flatnonzero(areas >= LEAST_PIXELS)
    if len(alone) > most:
        alone = np.sort(alone[np.argsort(-areas[alone], kind="stable")[:most]])
    boxes = find_objects(labels)
    parts = [(boxes[number - 1], labels[boxes[number - 1]] == number) for number in alone]
    rest = grid.mask & ~np.isin(labels, alone)
    if rest.any():
        box = bounding_box(rest)
        parts.append((box, rest[box]))
    return tuple(
        Island(
            MaskedGrid(mask),
            coverage[rows.start : rows.stop + 2, columns.start : columns.stop + 2],
            grid.index[rows, columns][mask],
        )
        for (rows, columns), mask in parts
    )

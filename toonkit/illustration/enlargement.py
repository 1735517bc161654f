"""Pictures whose pixels were each enlarged to a square block, as pixel art is exported and shared."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.model.image import ToonImage
from toonkit.numerics.masked_grid import Box, bounding_box

FEWEST_BLOCKS = 16
"""Least number of blocks along either side of an enlarged object. An object of fewer blocks may be a drawing of rectangles,
and reducing it would lose its smallest parts: these are recognized from four pixels on."""

FEWEST_EDGES = 0.5
"""Least share of the lines between blocks along which colors change somewhere."""

SAMPLED_ROWS = 16
"""Number of rows that are examined first. They almost always suffice to recognize a drawing that is not enlarged."""


@dataclass(frozen=True, eq=False)
class Enlargement:
    """
    How a picture was enlarged.

    Attributes
    ----------
    factor : int
        Side of a block, in pixels: 2 or more.
    place : (slice, slice)
        Rows and columns of the object with its fringe: whole blocks.
    image : ToonImage
        The picture before it was enlarged: one pixel for each block at that place.
    sources : ndarray of int32, shape (P,)
        For each of the object's pixels, the compact index of its block in `image`.
    """

    factor: int
    place: Box
    image: ToonImage
    sources: NDArray[np.int32]

    def reduce(self, values: NDArray[Any]) -> NDArray[Any] | None:
        """Return values (H, W) of the picture as one for each block; None if they differ within a block of the object."""
        inside = values[self.place]
        reduced = inside[:: self.factor, :: self.factor]
        enlarged = reduced.repeat(self.factor, axis=0).repeat(self.factor, axis=1)
        mask = self.image.mask.repeat(self.factor, axis=0).repeat(self.factor, axis=1)
        return reduced if np.array_equal(enlarged[mask], inside[mask]) else None

    def firsts(self) -> NDArray[np.intp]:
        """Return the compact index of the first pixel of each block, in the order of `image`'s pixels."""
        return np.unique(self.sources, return_index=True)[1]


def find_enlargement(image: ToonImage) -> Enlargement | None:
    """
    Find out whether a picture was enlarged by a whole factor without interpolation.

    The object may lie anywhere in the picture.

    Parameters
    ----------
    image : ToonImage
        The picture.

    Returns
    -------
    Enlargement or None
        The enlargement by the largest such factor; None if the picture was not enlarged.

    Examples
    --------
    >>> color = np.random.default_rng(0).random((16, 16, 3))
    >>> large = color.repeat(4, axis=0).repeat(4, axis=1)
    >>> find_enlargement(ToonImage(large, np.ones((64, 64), bool))).factor
    4
    """
    place = bounding_box(image.alpha > 0)
    if _factor(_edges(_sampled_rows(image, place), axis=1)) == 1:
        return None
    content = _content(image, place)
    edges = [_edges(content, axis) for axis in (0, 1)]
    factor = math.gcd(*(_factor(edge) for edge in edges))
    for edge in edges:
        blocks = edge[-1] // factor
        if factor == 1 or blocks < FEWEST_BLOCKS or len(edge) - 1 < FEWEST_EDGES * (blocks - 1):
            return None
    small = content[::factor, ::factor]
    mask = small[..., 4] > 0
    reduced = ToonImage(
        np.where(mask[..., None], small[..., :3], 0.0), mask, alpha=small[..., 3], fringe=small[..., :3]
    )
    number = np.zeros(mask.shape, np.int32)
    number[mask] = np.arange(len(reduced.pixels))
    enlarged = number.repeat(factor, axis=0).repeat(factor, axis=1)
    return Enlargement(factor, place, reduced, enlarged[image.mask[place]])


def _content(image: ToonImage, place: Box) -> FloatArray:
    """Return color, alpha and mask of a part of a picture as one array (h, w, 5)."""
    content = np.zeros((*image.mask[place].shape, 5))
    content[..., 3], content[..., 4] = image.alpha[place], image.mask[place]
    content[..., :3][image.mask[place]] = image.pixels
    rows, columns = image.fringe_places
    content[rows - place[0].start, columns - place[1].start, :3] = image.fringe_colors
    return content


def _sampled_rows(image: ToonImage, place: Box) -> FloatArray:
    """Return color, alpha and mask of some rows (n, w, 5); fringe pixels have alpha alone."""
    first = np.concatenate([[0], np.cumsum(np.count_nonzero(image.mask, axis=1))])
    rows = np.unique(np.linspace(place[0].start, place[0].stop - 1, SAMPLED_ROWS).astype(int))
    content = np.zeros((len(rows), image.mask[:, place[1]].shape[1], 5))
    for row, own in zip(rows, content, strict=True):
        mask = image.mask[row, place[1]]
        own[:, 3], own[:, 4] = image.alpha[row, place[1]], mask
        own[mask, :3] = image.pixels[first[row] : first[row + 1]]
    return content


def _edges(content: FloatArray, axis: int) -> NDArray[np.intp]:
    """Return the positions along an axis at which content (h, w, 5) changes, and that of its end."""
    content = np.moveaxis(content, axis, 0)
    changes = (content[1:] != content[:-1]).any(axis=(1, 2))
    return np.append(np.flatnonzero(changes) + 1, len(content))


def _factor(edges: NDArray[np.intp]) -> int:
    """Return the greatest common divisor of the distances of all edges from the start."""
    return int(np.gcd.reduce(edges))

"""The surface seen through each subpixel of a picture, and its means over pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.synthetic.model import INK, Model
from toonkit.synthetic.tracing import Frame, Hits, Tracer
from toonkit.synthetic.tracing_kernels import NOTHING

SUBPIXELS = 3
"""Samples along each side of a pixel. Coverage has steps of one ninth."""

MARGIN = 0.05
"""Free share of the picture's width on each side of the longer extent of what is drawn."""


@dataclass(frozen=True, eq=False)
class Samples:
    """
    The subpixels through which something is seen, n of them.

    Attributes
    ----------
    size : int
        Width and height of the picture in pixels.
    spacing : float
        Distance between neighboring samples, in units of the model.
    hits : Hits
        What the grid of all subpixels meets.
    pixel : ndarray of int, shape (n,)
        Row-major index of the pixel of each sample.
    normals, positions : ndarray, shape (n, 3)
        Unit normal and place on the surface, in the axes of the picture.
    material : ndarray of int, shape (n,)
        Index into `names`.
    marked : ndarray of bool, shape (n,)
        Where a pattern is drawn in ink.
    names : tuple of str
        Names of the materials that show.
    """

    size: int
    spacing: float
    hits: Hits
    pixel: NDArray[np.intp]
    normals: FloatArray
    positions: FloatArray
    material: NDArray[np.intp]
    marked: BoolArray
    names: tuple[str, ...]

    @property
    def seen(self) -> BoolArray:
        """Which subpixels are samples, shape (m, m)."""
        return np.asarray(self.hits.part != NOTHING)

    def on_grid(self, values: NDArray[np.int64], *, outside: int) -> NDArray[np.int64]:
        """Return integers of the samples (n,) on the grid of subpixels (m, m)."""
        grid = np.full(self.seen.shape, outside, np.int64)
        grid[self.seen] = values
        return grid

    def coverage(self) -> FloatArray:
        """Share of each pixel (H, W) through which something is seen."""
        return self._summed(np.ones(len(self.pixel))) / SUBPIXELS**2

    def share(self, chosen: BoolArray) -> FloatArray:
        """Share of chosen samples among those of each pixel (H, W); 0 where there are none."""
        count = self._summed(np.ones(len(self.pixel)))
        return self._summed(chosen.astype(np.float64)) / np.maximum(count, 1.0)

    def mean(self, values: FloatArray, weights: FloatArray | None = None) -> FloatArray:
        """Mean of vectors (n, 3) over the samples of each pixel (H, W, 3); NaN where there are none of any weight."""
        heavy = np.ones(len(self.pixel)) if weights is None else weights
        total = np.stack([self._summed(values[:, k] * heavy) for k in range(3)], axis=-1)
        count = self._summed(heavy)[..., None]
        return np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)

    def labels(self) -> NDArray[np.int64]:
        """Material of most samples of each pixel (H, W), -1 where there are none."""
        count = len(self.names)
        votes = np.bincount(self.pixel * count + self.material, minlength=self.size**2 * count)
        votes = votes.reshape(self.size, self.size, count)
        return np.where(votes.any(axis=-1), votes.argmax(axis=-1), -1)

    def _summed(self, values: FloatArray) -> FloatArray:
        total = np.bincount(self.pixel, values, minlength=self.size**2)
        return np.asarray(total.reshape(self.size, self.size))


def sample_model(model: Model, size: int) -> Samples:
    """Look at a model through the subpixels of a square picture that it fills up to `MARGIN`."""
    tracer = Tracer([part.solid for part in model.parts], model.view)
    tight = tracer.enclosing_frame()
    frame = Frame(tight.center, tight.width / (1 - 2 * MARGIN))
    count = size * SUBPIXELS
    hits = tracer.trace(frame, count)
    rows, columns = np.nonzero(hits.part != NOTHING)
    spacing = frame.width / count
    x = frame.center[0] + (columns + 0.5 - count / 2) * spacing
    y = frame.center[1] - (rows + 0.5 - count / 2) * spacing
    positions = np.column_stack([x, y, hits.depth[rows, columns]])
    material, marked, names = _materials(model, hits.part[rows, columns], positions)
    pixel = (rows // SUBPIXELS) * size + columns // SUBPIXELS
    return Samples(
        size, spacing, hits, pixel, hits.normals[rows, columns], positions, material, marked, names
    )


def _materials(
    model: Model, part: NDArray[np.int16], positions: FloatArray
) -> tuple[NDArray[np.intp], BoolArray, tuple[str, ...]]:
    """Return the material of each sample, whether a pattern inks it, and the names of the materials that show."""
    points = positions @ model.view  # row vectors: the inverse of the view's rotation
    known = list(model.paints)
    material = np.zeros(len(part), np.intp)
    marked = np.zeros(len(part), np.bool_)
    for number, piece in enumerate(model.parts):
        own = np.flatnonzero(part == number)
        material[own] = known.index(piece.material)
        for pattern in piece.patterns:
            covered = own[pattern.where(points[own])] if own.size else own
            if pattern.material == INK:
                marked[covered] = True
            else:
                material[covered] = known.index(pattern.material)
    shown, material = np.unique(material, return_inverse=True)
    return material, marked, tuple(known[index] for index in shown)

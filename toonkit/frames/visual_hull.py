"""The visual hull of an object that turns about its upright axis: the largest shape within all its silhouettes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter, map_coordinates

from toonkit._validation import BoolArray, FloatArray

SIZE = 96
"""Approximate number of pixels along the longer side of the silhouettes from which a hull is carved."""

ROUNDED = 1.0
"""Standard deviation, in pixels of the lattice, over which a hull's edges are rounded: it is flat between silhouettes."""

BESIDE = -1e3
"""Depth of pixels beside the hull, in pixels of the lattice: behind everything."""


def turned(angle: float, across: NDArray[Any], depth: NDArray[Any]) -> tuple[FloatArray, FloatArray]:
    """Turn places x, z about the upright axis by an angle in radians; return their new x and z, shape (...)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * across + sine * depth, cosine * depth - sine * across


def turned_vectors(angle: float, vectors: FloatArray) -> FloatArray:
    """Turn vectors (..., 3) about the upright axis by an angle in radians."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    x, z = turned(angle, x, z)
    return np.stack([x, y, z], axis=-1)


@dataclass(frozen=True, eq=False)
class VisualHull:
    """
    A visual hull on its own lattice.

    Attributes
    ----------
    inside : ndarray, shape (rows, n, n)
        How far inside each point is, in pixels of the lattice, negative outside. The axes are: rows from the top, z from the
        back, x from the left; z and x are centered on the axis of the turn.
    axis : float
        Column of the axis in the pictures.
    step : int
        Pixels of the pictures for each pixel of the lattice.
    """

    inside: FloatArray
    axis: float
    step: int

    @classmethod
    def carved(cls, masks: Sequence[BoolArray], angles: Sequence[float]) -> VisualHull:
        """
        Carve a hull.

        Parameters
        ----------
        masks : sequence of ndarray of bool, shape (h, w)
            Silhouettes, from all around.
        angles : sequence of float
            By how much the object is turned in each silhouette, in radians.

        Returns
        -------
        VisualHull
            The hull; its axis is the middle column of all silhouettes together.
        """
        columns = np.flatnonzero(np.any(masks, axis=(0, 1)))
        axis = float(columns[0] + columns[-1]) / 2
        step = max(1, round(max(masks[0].shape) / SIZE))
        half = int((columns[-1] - columns[0]) / (2 * step)) + 2
        across, depth = _lattice(half)
        inside = np.full((len(masks[0][step // 2 :: step]), 2 * half + 1, 2 * half + 1), np.inf)
        for mask, angle in zip(masks, angles, strict=True):
            within = _signed_distances(mask[step // 2 :: step, step // 2 :: step])
            x, _ = turned(angle, across, depth)
            np.minimum(inside, _along_rows(within, x + (axis - step // 2) / step), out=inside)
        return cls(inside, axis, step)

    @property
    def half(self) -> int:
        """Index of the axis in the lattice."""
        return int(self.inside.shape[1]) // 2

    @cached_property
    def rounded(self) -> FloatArray:
        """The same as `inside`, with rounded edges."""
        return np.asarray(gaussian_filter(self.inside, ROUNDED))

    def shows(self, mask: BoolArray, angle: float) -> float:
        """Return the share, 0 to 1, of a silhouette (h, w) that the hull fills when it is turned by an angle in radians."""
        seen = mask[self.step // 2 :: self.step, self.step // 2 :: self.step]
        filled = self._front(self.inside + 1.0, angle, seen.shape[1]) > BESIDE  # within one pixel
        return float(filled[seen].mean()) if seen.any() else 1.0

    def depth(self, mask: BoolArray, angle: float) -> FloatArray:
        """Return z of the turned hull's front, in pixels of the pictures, where a mask (h, w) is True; 0 elsewhere."""
        shape = [len(range(self.step // 2, side, self.step)) for side in mask.shape]
        front = self._front(self.rounded, angle, shape[1])
        beside = front == BESIDE
        front = front[tuple(distance_transform_edt(beside, return_distances=False, return_indices=True))]
        rows, columns = np.nonzero(mask)
        depth = np.zeros(mask.shape)
        places = [(rows - self.step // 2) / self.step, (columns - self.step // 2) / self.step]
        depth[mask] = self.step * map_coordinates(front, places, order=1, mode="nearest")
        return depth

    def normals(self, mask: BoolArray, depth: FloatArray, angle: float) -> FloatArray:
        """Return unit normals (P, 3) of the hull's front when it is turned by an angle, at the pixels of a mask (h, w)."""
        rows, columns = np.nonzero(mask)
        x, z = turned(-angle, columns - self.axis, depth[mask])
        places = [(rows - self.step // 2) / self.step, z / self.step + self.half, x / self.step + self.half]
        down, toward, right = (
            map_coordinates(slope, places, order=1, mode="nearest") for slope in self._slopes
        )
        outward = turned_vectors(angle, np.stack([-right, down, -toward], axis=-1))
        unit: FloatArray = outward / np.maximum(np.linalg.norm(outward, axis=-1, keepdims=True), 1e-9)
        return unit

    @cached_property
    def _slopes(self) -> tuple[FloatArray, ...]:
        """Derivatives of `rounded`, along its three axes."""
        return tuple(np.gradient(self.rounded))

    def _front(self, inside: FloatArray, angle: float, width: int) -> FloatArray:
        """Return z of the foremost point inside, in pixels of the lattice, (rows, width); `BESIDE` where there is none."""
        count = 2 * self.half + 1
        depths = np.arange(self.half, -self.half - 1, -1.0)
        seen_from = np.arange(width) - (self.axis - self.step // 2) / self.step
        x, z = turned(-angle, *np.meshgrid(seen_from, depths))
        within = (np.abs(x) <= self.half) & (np.abs(z) <= self.half)
        along = inside.reshape(len(inside), -1)
        i = np.clip((z + self.half).astype(np.intp), 0, count - 2)
        j = np.clip((x + self.half).astype(np.intp), 0, count - 2)
        down, right = z + self.half - i, x + self.half - j
        value = np.where(
            within,
            (1 - down) * ((1 - right) * along[:, i * count + j] + right * along[:, i * count + j + 1])
            + down
            * ((1 - right) * along[:, (i + 1) * count + j] + right * along[:, (i + 1) * count + j + 1]),
            -1.0,
        )
        first = np.argmax(value > 0, axis=1)
        after = np.take_along_axis(value, first[:, None], axis=1)[:, 0]
        before = np.take_along_axis(value, np.maximum(first - 1, 0)[:, None], axis=1)[:, 0]
        back = np.where(before < 0, after / np.maximum(after - before, 1e-9), 0.0)
        return np.where(after > 0, self.half - first + np.clip(back, 0.0, 1.0), BESIDE)


def _lattice(half: int) -> tuple[FloatArray, FloatArray]:
    """Return x and z of the points of a lattice, shape (n, n): rows from behind, columns from the left."""
    along = np.arange(-half, half + 1.0)
    across, depth = np.meshgrid(along, along)
    return across, depth


def _signed_distances(mask: BoolArray) -> FloatArray:
    """Return how far inside a silhouette each pixel is, negative outside."""
    framed = np.pad(mask, 1)
    distances = distance_transform_edt(framed) - distance_transform_edt(~framed)
    return np.asarray(distances[1:-1, 1:-1])


def _along_rows(image: FloatArray, columns: NDArray[np.floating]) -> FloatArray:
    """Interpolate each row of an image (h, w) at columns (...), shape (h, ...); beyond its edges it is far outside."""
    width = image.shape[1]
    first = np.clip(columns.astype(np.intp), 0, width - 2)
    share = columns - first
    value = (1 - share) * image[:, first] + share * image[:, first + 1]
    return np.where((columns < -0.5) | (columns > width - 0.5), -1.0, value)

"""Regions of a picture that a hand draws: along a brush's path, within a loop, or all that is connected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray, as_array, is_number, refuse

WIDEST_BRUSH = 4096
"""Pixels from the middle of a brush to its edge, at most."""

LONGEST_STROKE = 20_000
"""Points of a stroke at most: what a hand draws in minutes."""


def path_of(path: Sequence[Sequence[float]]) -> FloatArray:
    """Check a path of 1 to `LONGEST_STROKE` places: column and row in pixels, 0.5 in the middle of the first one."""
    points = as_array("path", path, (None, 2))
    if not 1 <= len(points) <= LONGEST_STROKE:
        raise refuse("path", f"must have 1 to {LONGEST_STROKE:,} points", len(points))
    if not np.isfinite(points).all():
        raise refuse("path", "must be places in the picture", "a point that is not finite")
    return points


def stroke(points: FloatArray, radius: float, shape: tuple[int, ...]) -> BoolArray:
    """Mark the pixels (H, W) whose middles are at most a radius from a path (n, 2)."""
    if not is_number(radius) or not 0 < radius <= WIDEST_BRUSH:
        raise refuse("radius", f"must be above 0, and at most {WIDEST_BRUSH} pixels", radius)
    covered = np.zeros(shape, np.bool_)
    for (x, y), (to_x, to_y) in zip(points, points[[*range(1, len(points)), -1]], strict=True):
        top, left = (max(int(min(pair) - radius), 0) for pair in ((y, to_y), (x, to_x)))
        bottom, right = (max(int(max(pair) + radius) + 1, 0) for pair in ((y, to_y), (x, to_x)))
        part = covered[top:bottom, left:right]
        if part.size:
            rows, columns = np.ogrid[: part.shape[0], : part.shape[1]]
            part |= _near(columns + left + 0.5 - x, rows + top + 0.5 - y, to_x - x, to_y - y, radius)
    return covered


def loop(points: FloatArray, shape: tuple[int, ...]) -> BoolArray:
    """Mark the pixels (H, W) whose middles lie within a closed path (n, 2), by the even-odd rule."""
    height, width = shape
    inside = np.zeros(shape, np.bool_)
    ends = np.roll(points, -1, axis=0)
    for row in range(max(int(points[:, 1].min()), 0), min(int(points[:, 1].max()) + 1, height)):
        middle = row + 0.5
        crossing = (points[:, 1] <= middle) != (ends[:, 1] <= middle)
        start, end = points[crossing], ends[crossing]
        share = (middle - start[:, 1]) / (end[:, 1] - start[:, 1])
        columns = np.sort(start[:, 0] + share * (end[:, 0] - start[:, 0]))
        first = np.clip(np.ceil(columns - 0.5), 0, width).astype(np.intp)
        for left, right in zip(first[::2], first[1::2], strict=True):
            inside[row, left:right] = True
    return inside


def connected(values: NDArray[np.integer], place: Sequence[float]) -> BoolArray:
    """Mark the pixels (H, W) of one value that are connected, along their sides, to the one at a place."""
    (column, row), (height, width) = as_array("place", place, (2,)), values.shape
    if not (0 <= column < width and 0 <= row < height):
        raise refuse("place", "must lie in the picture", [float(column), float(row)])
    at = int(row), int(column)
    pieces, _ = ndimage.label(values == values[at])
    region: BoolArray = pieces == pieces[at]
    return region


def _near(x: FloatArray, y: FloatArray, dx: float, dy: float, radius: float) -> BoolArray:
    """Mark the places at most a radius from the way from (0, 0) to (dx, dy)."""
    along = np.clip((x * dx + y * dy) / max(dx * dx + dy * dy, 1e-12), 0.0, 1.0)
    near: BoolArray = (x - along * dx) ** 2 + (y - along * dy) ** 2 <= radius**2
    return near

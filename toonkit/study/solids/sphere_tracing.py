"""Orthographic rays against a signed distance: where each first meets the solid, and the normal there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.study.registry import BOUND, Shape

STEP_FACTOR = 0.8
"""Share of the distance that a ray advances: ellipsoids and tapered tubes overestimate theirs a little."""

SURFACE_TOLERANCE = 1e-6
"""Distance at which a ray has arrived; solids are about 2 across, so a 1000th of a pixel at 4K."""

DIFFERENCE_STEP = 1e-4
"""Step of the central differences: their error, its square times the curvature, stays below 1e-6."""

_CELL_WIDTHS = (0.16, 0.02, 0.004)  # bundles of rays that start together, coarse to fine
_CHUNK = 8192  # points at a time, so that the intermediate arrays of a distance stay in the cache
_MAX_STEPS = 300  # the slowest, which run along one surface and on to another, take some 100
_CLOSE = 2e-3  # half a pixel at 512: within it a surface is nearly a plane
_MAX_RELAXATION = 4.0  # what a longer step could miss is a chord of 0.008, less than a 100th of a pixel high
_GRAZING = 0.1  # slope of a ray that runs along the surface
_GRAZING_STEP = 1e-3  # lest it creep: a chord that short is 4e-6 high on a ball of radius 0.03
_BRACKET_STEPS = 8
_MIN_ADVANCE = 0.02  # of its cell's width; a bundle that would advance less has arrived
_MIN_BUNDLE = 4  # rays; smaller bundles cost more than they save

Field = Callable[[FloatArray], FloatArray]


class DistanceSolid:
    """A solid given by its distance, turned into a view."""

    def __init__(self, shape: Shape, turn: FloatArray) -> None:
        self._shape = shape
        self._turn = turn

    def first_hit(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z, shape (n,), of the nearest surface point behind each (x, y); NaN where there is none."""
        start = np.full(len(x), BOUND)
        for width in _CELL_WIDTHS:
            start = self._advance_bundles(x, y, start, width)
        depth = np.full(len(x), np.nan)
        possible = start > -BOUND
        depth[possible] = self._march(x[possible], y[possible], start[possible])
        return depth

    def normals(self, points: FloatArray) -> FloatArray:
        """Return the outward unit normals, shape (n, 3), at surface points, both in the view's axes; 0 if none."""
        gradient = np.empty_like(points)
        for axis in range(3):
            offset = np.zeros(3)
            offset[axis] = DIFFERENCE_STEP
            gradient[:, axis] = self._distance(points + offset) - self._distance(points - offset)
        length = np.linalg.norm(gradient, axis=1, keepdims=True)
        return gradient / np.where(length > 0, length, 1.0)

    def parts(self, points: FloatArray) -> NDArray[np.intp]:
        """Return the material index, shape (n,), of surface points."""
        if self._shape.part is None:
            return np.zeros(len(points), dtype=np.intp)
        return self._shape.part(points @ self._turn)

    def _distance(self, points: FloatArray) -> FloatArray:
        values = np.empty(len(points))
        for first in range(0, len(points), _CHUNK):
            chunk = slice(first, first + _CHUNK)
            # Row vectors: p R is the inverse of the view's rotation.
            values[chunk] = self._shape.distance(points[chunk] @ self._turn)
        return values

    def _advance_bundles(self, x: FloatArray, y: FloatArray, start: FloatArray, width: float) -> FloatArray:
        """Advance rays together by square cells of `width`, as far as their whole bundle is in free space."""
        column, row = np.floor(x / width).astype(np.intp), np.floor(y / width).astype(np.intp)
        columns = 2 * int(np.abs(column).max()) + 3
        cells, member = np.unique(row * columns + column, return_inverse=True)
        if len(x) < _MIN_BUNDLE * len(cells):
            return start
        row_of = np.floor_divide(cells + columns // 2, columns)
        column_of = cells - row_of * columns
        center_x, center_y = (column_of + 0.5) * width, (row_of + 0.5) * width
        depth = np.full(len(cells), -np.inf)
        np.maximum.at(depth, member, start)
        active = np.flatnonzero(depth > -BOUND)
        for _ in range(_MAX_STEPS):
            if len(active) == 0:
                break
            points = np.column_stack([center_x[active], center_y[active], depth[active]])
            advance = STEP_FACTOR * self._distance(points) - width / np.sqrt(2)
            depth[active] -= np.maximum(advance, 0.0)
            active = active[(advance > _MIN_ADVANCE * width) & (depth[active] > -BOUND)]
        return np.asarray(np.minimum(start, depth[member]))

    def _march(self, x: FloatArray, y: FloatArray, start: FloatArray) -> FloatArray:
        """Advance single rays until they arrive (z), step inside (bracketed) or leave (NaN)."""
        found = np.full(len(x), np.nan)
        active, depth = np.arange(len(x)), start
        last, before = start + 1e-9, np.full(len(x), np.inf)
        for _ in range(_MAX_STEPS):
            value = self._distance(np.column_stack([x[active], y[active], depth]))
            step = last - depth
            # A leap is sound if the balls free of surface around both of its ends touch.
            back = (before > _CLOSE) & (np.abs(value) + before < step)
            inside = (value < -SURFACE_TOLERANCE) & ~back
            arrived = (np.abs(value) <= SURFACE_TOLERANCE) & ~back
            found[active[arrived]] = depth[arrived]
            if inside.any():
                rays = active[inside]
                found[rays] = self._between(
                    x[rays], y[rays], last[inside], depth[inside], before[inside], value[inside]
                )
            going = ~arrived & ~inside & (back | (depth > -BOUND))
            if not going.any():
                break
            slope = np.where(back, 1.0, (before - value) / step)[going]
            active, back = active[going], back[going]
            last = np.where(back, last[going], depth[going])
            before = np.where(back, before[going], value[going])
            depth = last - np.where(back, STEP_FACTOR * before, _stride(before, slope))
        return found

    def _between(
        self,
        x: FloatArray,
        y: FloatArray,
        outside: FloatArray,
        inside: FloatArray,
        high: FloatArray,
        low: FloatArray,
    ) -> FloatArray:
        """Find the surface between a depth outside and one inside, by false position (the Illinois variant)."""
        middle = inside
        high = np.where(np.isfinite(high), high, -low)  # a ray that starts inside has no value outside
        for _ in range(_BRACKET_STEPS):
            middle = (outside * low - inside * high) / (low - high)
            value = self._distance(np.column_stack([x, y, middle]))
            within = value < 0
            # An end that stays has its value halved, so that the other end moves too.
            high, low = np.where(within, high / 2, value), np.where(within, value, low / 2)
            inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
        return np.asarray(middle)


def _stride(value: FloatArray, slope: FloatArray) -> FloatArray:
    """
    Return how far to advance from a distance that has been falling by `slope` per unit.

    Far off, to where a ball free of surface is expected to touch the one here: 2 v / (1 + s). Close by, to where
    the surface itself is expected: v / s.
    """
    leap = np.clip(2 / np.maximum(1 + slope, 1e-9), 1.0, _MAX_RELAXATION) * STEP_FACTOR
    newton = np.clip(1 / np.maximum(slope, 1e-9), STEP_FACTOR, _MAX_RELAXATION)
    stride = value * np.where(value < _CLOSE, newton, leap)
    return np.asarray(np.where(slope < _GRAZING, np.maximum(stride, _GRAZING_STEP), stride))

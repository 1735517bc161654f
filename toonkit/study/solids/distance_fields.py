"""
Signed distances, from which the shapes of the study are composed.

A distance is a function of points, (n, 3) -> (n,), negative inside. All are exact on the surface: value zero and
gradient of unit length along the normal. Off the surface they may under- or overestimate a little, which the
renderer's step factor allows for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from toonkit._validation import FloatArray
from toonkit.study.solids.curves import Curve

Distance = Callable[[FloatArray], FloatArray]
Vector = Sequence[float]


def sphere(center: Vector, radius: float) -> Distance:
    """Return the distance from a sphere."""
    middle = np.asarray(center, dtype=np.float64)
    return lambda points: np.asarray(_length(points - middle) - radius)


def ellipsoid(center: Vector, radii: Vector) -> Distance:
    """Return a first-order distance from an ellipsoid whose axes lie along x, y and z."""
    middle, semi = np.asarray(center, dtype=np.float64), np.asarray(radii, dtype=np.float64)

    def distance(points: FloatArray) -> FloatArray:
        scaled = (points - middle) / semi
        level = _length(scaled)
        slope = _length(scaled / semi)
        first_order = level * (level - 1) / np.maximum(slope, 1e-12)
        return np.asarray(np.maximum(first_order, -semi.min()))  # no point lies deeper

    return distance


def capsule(start: Vector, end: Vector, start_radius: float, end_radius: float | None = None) -> Distance:
    """Return the distance from a segment with round ends, whose radius may change along it."""
    origin = np.asarray(start, dtype=np.float64)
    axis = np.asarray(end, dtype=np.float64) - origin
    growth = (start_radius if end_radius is None else end_radius) - start_radius
    squared = float(axis @ axis)
    steepness = np.sqrt(1 + growth**2 / squared)

    def distance(points: FloatArray) -> FloatArray:
        offset = points - origin
        along = np.clip(offset @ axis / squared, 0.0, 1.0)
        return np.asarray(
            (_length(offset - along[:, None] * axis) - start_radius - growth * along) / steepness
        )

    return distance


def rounded_box(center: Vector, half_size: Vector, radius: float = 0.0) -> Distance:
    """Return the distance from a box, rounded inward by a radius at edges and corners."""
    middle = np.asarray(center, dtype=np.float64)
    core = np.asarray(half_size, dtype=np.float64) - radius

    def distance(points: FloatArray) -> FloatArray:
        beyond = np.abs(points - middle) - core
        outside = _length(np.maximum(beyond, 0.0))
        return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0) - radius)

    return distance


def torus(center: Vector, major: float, minor: float) -> Distance:
    """Return the distance from a ring around the y axis."""
    middle = np.asarray(center, dtype=np.float64)

    def distance(points: FloatArray) -> FloatArray:
        offset = points - middle
        ring = np.hypot(offset[:, 0], offset[:, 2]) - major
        return np.asarray(np.hypot(ring, offset[:, 1]) - minor)

    return distance


def cylinder(center: Vector, radius: float, half_height: float, rounding: float = 0.0) -> Distance:
    """Return the distance from an upright cylinder with flat caps; its edges may be rounded inward."""
    middle = np.asarray(center, dtype=np.float64)

    def distance(points: FloatArray) -> FloatArray:
        offset = points - middle
        side = np.hypot(offset[:, 0], offset[:, 2]) - (radius - rounding)
        cap = np.abs(offset[:, 1]) - (half_height - rounding)
        outside = np.hypot(np.maximum(side, 0.0), np.maximum(cap, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(side, cap), 0.0) - rounding)

    return distance


def capped_cone(
    base: float, top: float, base_radius: float, top_radius: float, rounding: float = 0.0
) -> Distance:
    """Return the distance from a cone frustum around the y axis, from height `base` to `top`."""
    middle, half = (base + top) / 2, (top - base) / 2 - rounding
    low, high = base_radius - rounding, max(top_radius - rounding, 0.0)
    slant = np.array([high - low, 2 * half])

    def distance(points: FloatArray) -> FloatArray:
        out, up = np.hypot(points[:, 0], points[:, 2]), points[:, 1] - middle
        cap_out = out - np.minimum(out, np.where(up < 0, low, high))
        cap_up = np.abs(up) - half
        share = np.clip(((out - low) * slant[0] + (up + half) * slant[1]) / (slant @ slant), 0.0, 1.0)
        side_out, side_up = out - low - share * slant[0], up + half - share * slant[1]
        inside = (side_out < 0) & (cap_up < 0)
        nearest = np.sqrt(np.minimum(cap_out**2 + cap_up**2, side_out**2 + side_up**2))
        return np.asarray(np.where(inside, -nearest, nearest) - rounding)

    return distance


def tube(knots: Sequence[Vector], radii: float | Sequence[float], *, closed: bool = False) -> Distance:
    """Return the distance from a smooth curve through knots, thickened by a radius that varies along it."""
    places = np.asarray(knots, dtype=np.float64)
    thickness = np.broadcast_to(np.asarray(radii, dtype=np.float64), len(places))
    curve = Curve(places, closed=closed)
    if closed:
        thickness = np.append(thickness, thickness[0])
    radius = CubicSpline(np.arange(len(thickness)), thickness, bc_type="periodic" if closed else "natural")

    def distance(points: FloatArray) -> FloatArray:
        foot, away, _ = curve.feet(points)
        return np.asarray(_length(away) - radius(foot))

    return distance


def revolve(profile: Sequence[Vector]) -> Distance:
    """
    Return the distance from a solid of revolution around the y axis.

    The profile is a list of (radius, height) from the bottom of the axis up the outside to the top of the axis (or,
    of a vessel, over the rim and down its inside). A smooth closed curve passes through it and its mirror image.
    """
    right = np.asarray(profile, dtype=np.float64)
    inner = right[1:-1] if right[0, 0] == right[-1, 0] == 0 else right
    left = inner[::-1] * np.array([-1.0, 1.0])
    curve = Curve(np.concatenate([right, left]), closed=True)

    def distance(points: FloatArray) -> FloatArray:
        flat = np.column_stack([np.hypot(points[:, 0], points[:, 2]), points[:, 1]])
        _, away, along = curve.feet(flat)
        # The curve runs counter-clockwise (up the right side): its outside is on the right of its velocity.
        side = along[:, 1] * away[:, 0] - along[:, 0] * away[:, 1]
        return np.asarray(np.copysign(_length(away), side))

    return distance


def union(*distances: Distance) -> Distance:
    """Return the distance from several solids together, creased where they meet."""
    return lambda points: np.asarray(np.min([distance(points) for distance in distances], axis=0))


def smooth_union(width: float, *distances: Distance) -> Distance:
    """Return the distance from several solids, filleted where their distances differ by less than `width`."""

    def distance(points: FloatArray) -> FloatArray:
        joined = distances[0](points)
        for further in distances[1:]:
            joined = _smooth_minimum(joined, further(points), width)
        return joined

    return distance


def smooth_subtract(width: float, solid: Distance, *cuts: Distance) -> Distance:
    """Return the distance from a solid with others cut out of it, the cut's edge rounded over `width`."""

    def distance(points: FloatArray) -> FloatArray:
        rest = solid(points)
        for cut in cuts:
            rest = -_smooth_minimum(-rest, cut(points), width)
        return rest

    return distance


def intersect(*distances: Distance) -> Distance:
    """Return the distance from what several solids have in common."""
    return lambda points: np.asarray(np.max([distance(points) for distance in distances], axis=0))


def place(
    distance: Distance, at: Vector = (0, 0, 0), *, x: float = 0.0, y: float = 0.0, z: float = 0.0
) -> Distance:
    """Return a solid turned by degrees about the x, then the y, then the z axis, and moved to `at`."""
    turn = rotation(x=x, y=y, z=z)
    offset = np.asarray(at, dtype=np.float64)
    # Row vectors: (p - offset) R is the inverse rotation of each point.
    return lambda points: distance((points - offset) @ turn)


def mirror(distance: Distance) -> Distance:
    """Return a solid that lies at x > 0 together with its mirror image at x < 0."""
    return lambda points: distance(np.column_stack([np.abs(points[:, 0]), points[:, 1], points[:, 2]]))


def rotation(*, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> FloatArray:
    """Return the (3, 3) matrix that turns column vectors by degrees about the x, then the y, then the z axis."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.deg2rad([x, y, z])), np.sin(np.deg2rad([x, y, z]))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def _smooth_minimum(first: FloatArray, second: FloatArray, width: float) -> FloatArray:
    """Minimum of two distances, rounded by a parabola where they differ by less than `width`."""
    nearness = np.maximum(width - np.abs(first - second), 0.0)
    return np.asarray(np.minimum(first, second) - nearness**2 / (4 * width))


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))

"""Primitives of solids: ellipsoids, boxes, capsules, rings and cones, which are placed, turned and joined to parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from toonkit._validation import FloatArray

ELLIPSOID, BOX, CAPSULE, TORUS, FRUSTUM = range(5)
"""Kinds of primitives."""

Vector = Sequence[float] | FloatArray


@dataclass(frozen=True, eq=False)
class Primitive:
    """
    One primitive of a solid.

    Attributes
    ----------
    kind : int
        `ELLIPSOID`, `BOX`, `CAPSULE`, `TORUS` or `FRUSTUM`.
    center : ndarray, shape (3,)
        Where it stands.
    turn : ndarray, shape (3, 3)
        Its own axes, one a row.
    sizes : ndarray, shape (4,)
        Ellipsoid: three radii. Box: three half sides, rounding. Capsule along y: half length, radii below and above.
        Torus around y: radii of the ring and of the tube. Frustum around y: half height, radii below and above, rounding.
    fillet : float
        Width over which it passes into the primitives before it in its part; 0 is a crease.
    cut : bool
        Whether it is cut out of the primitives before it.
    """

    kind: int
    center: FloatArray
    turn: FloatArray
    sizes: FloatArray
    fillet: float = 0.0
    cut: bool = False

    @property
    def bound(self) -> float:
        """Radius of a ball around the center that holds it."""
        a, b, c, _ = self.sizes
        if self.kind == ELLIPSOID:
            return float(max(a, b, c))
        if self.kind == BOX:
            return float(np.linalg.norm(self.sizes[:3]))
        if self.kind == CAPSULE:
            return float(a + max(b, c))
        return float(a + b) if self.kind == TORUS else float(np.hypot(a, max(b, c)))


Solid = tuple[Primitive, ...]
"""Primitives joined to one solid, in this order."""


def ellipsoid(center: Vector, radii: Vector) -> Solid:
    """Return an ellipsoid whose axes lie along x, y and z."""
    return (_primitive(ELLIPSOID, center, radii),)


def ball(center: Vector, radius: float) -> Solid:
    """Return a sphere."""
    return ellipsoid(center, (radius, radius, radius))


def box(center: Vector, half_sides: Vector, rounding: float = 0.02) -> Solid:
    """Return a box whose edges and corners are rounded."""
    return (_primitive(BOX, center, (*half_sides, rounding)),)


def capsule(start: Vector, end: Vector, start_radius: float, end_radius: float | None = None) -> Solid:
    """Return a segment with round ends, whose radius may change along it."""
    radii = (start_radius, start_radius if end_radius is None else end_radius)
    return (_along(CAPSULE, start, end, radii),)


def frustum(
    start: Vector, end: Vector, start_radius: float, end_radius: float, rounding: float = 0.01
) -> Solid:
    """Return a cone with flat ends around a segment; a cylinder if its radii are equal."""
    return (_along(FRUSTUM, start, end, (start_radius, end_radius, rounding)),)


def ring(center: Vector, radius: float, thickness: float) -> Solid:
    """Return a torus around the y axis."""
    return (_primitive(TORUS, center, (radius, thickness)),)


def tube(knots: Sequence[Vector], radii: float | Sequence[float], *, pieces: int = 4) -> Solid:
    """Return a smooth curve through knots, as capsules whose radius varies along it."""
    places = np.asarray(knots, dtype=np.float64)
    thickness = np.broadcast_to(np.asarray(radii, dtype=np.float64), len(places))
    # Catmull-Rom: the tangent at a knot is parallel to the line between its neighbors.
    before, after = 2 * places[0] - places[1], 2 * places[-1] - places[-2]
    framed = np.vstack([before, places, after])
    t = np.linspace(0.0, 1.0, pieces, endpoint=False)[:, None]
    curve, width = [], []
    for i in range(len(places) - 1):
        p, q, r, s = framed[i : i + 4]
        tangent, cubic = r - p, 3 * q - p - 3 * r + s
        curve.append(q + 0.5 * (tangent * t + (2 * p - 5 * q + 4 * r - s) * t**2 + cubic * t**3))
        width.append(thickness[i] + (thickness[i + 1] - thickness[i]) * t[:, 0])
    points = np.vstack([*curve, places[-1:]])
    sizes = np.append(np.concatenate(width), thickness[-1])
    links = zip(points[:-1], points[1:], sizes[:-1], sizes[1:], strict=True)
    return tuple(piece for start, end, r0, r1 in links for piece in capsule(start, end, r0, r1))


def lathe(profile: Sequence[tuple[float, float]], fillet: float = 0.04) -> Solid:
    """Return a solid of revolution around the y axis, as cones between (radius, height) from bottom to top."""
    stack: Solid = ()
    for (low, base), (high, top) in pairwise(profile):
        stack += frustum((0, base, 0), (0, top, 0), low, high, 0.004)
    return joined(fillet, stack)


def joined(fillet: float, *solids: Solid) -> Solid:
    """Return solids as one, filleted where they meet."""
    return tuple(piece if piece.cut else replace(piece, fillet=fillet) for solid in solids for piece in solid)


def carved(solid: Solid, *cuts: Solid, fillet: float = 0.01) -> Solid:
    """Return a solid out of which others are cut."""
    return solid + tuple(replace(piece, cut=True, fillet=fillet) for cut in cuts for piece in cut)


def placed(solid: Solid, at: Vector = (0, 0, 0), *, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Solid:
    """Return a solid turned by degrees about the x, then the y, then the z axis, and moved."""
    turn, offset = rotation(x=x, y=y, z=z), np.asarray(at, dtype=np.float64)
    return tuple(replace(p, center=turn @ p.center + offset, turn=p.turn @ turn.T) for p in solid)


def scaled(solid: Solid, factor: float) -> Solid:
    """Return a solid enlarged about the origin."""
    return tuple(
        replace(p, center=p.center * factor, sizes=p.sizes * factor, fillet=p.fillet * factor) for p in solid
    )


def flipped(solid: Solid) -> Solid:
    """Return the mirror image of a solid at x = 0. Every primitive is its own mirror image in its own axes."""
    flip = np.array([-1.0, 1.0, 1.0])
    return tuple(replace(p, center=p.center * flip, turn=p.turn * flip) for p in solid)


def both_sides(solid: Solid) -> Solid:
    """Return a solid that lies at x > 0 together with its mirror image."""
    return solid + flipped(solid)


def rotation(*, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> FloatArray:
    """Return the (3, 3) matrix that turns column vectors by degrees about the x, then the y, then the z axis."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.deg2rad([x, y, z])), np.sin(np.deg2rad([x, y, z]))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def _primitive(kind: int, center: Vector, sizes: Vector, turn: FloatArray | None = None) -> Primitive:
    full = np.zeros(4)
    full[: len(sizes)] = sizes
    return Primitive(kind, np.asarray(center, dtype=np.float64), np.eye(3) if turn is None else turn, full)


def _along(kind: int, start: Vector, end: Vector, sizes: Vector) -> Primitive:
    """Return a primitive around the segment between two points, as its y axis."""
    first, last = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    length = float(np.linalg.norm(last - first))
    up = (last - first) / length if length > 0 else np.array([0.0, 1.0, 0.0])
    side = np.cross(up, [0.0, 0.0, 1.0] if abs(up[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    return _primitive(
        kind, (first + last) / 2, (max(length / 2, 1e-6), *sizes), np.array([side, up, np.cross(side, up)])
    )

"""Random solids: smooth and creased unions of a few primitives, from which the shape prior learns."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray

ELLIPSOID, BOX, CAPSULE, TORUS, CONE = range(5)
"""Kinds of primitives; each has four sizes, of which it uses some."""

MARGIN = 0.04
"""Free share of the picture's width on each side of the silhouette's longer extent."""

SUBPIXELS = 3
"""Rays along each side of an outline pixel: coverage in steps of a ninth."""

STEP_FACTOR = 0.8
"""Share of the distance that a ray advances: ellipsoids and waves overestimate theirs a little."""

REACH = 3.0
"""Half the width of the cube that every solid stays in."""

_FRAMING = 64  # rays along each side of the square in which the silhouette is looked for
_MAX_STEPS = 100
_ARRIVED = 0.02  # of a pixel
_LEAST_STEP = 4.0  # times that: a chord so short along a grazed surface is lower than a 10000th of a pixel
_DIFFERENCE = 2e-4


@dataclass(frozen=True, eq=False)
class Solid:
    """
    A union of primitives, some of them cut out instead.

    Attributes
    ----------
    kinds : ndarray of int, shape (n,)
        Which primitive.
    turns : ndarray, shape (n, 3, 3)
        Rotation of each, rows its own axes.
    centers : ndarray, shape (n, 3)
        Where each stands.
    sizes : ndarray, shape (n, 4)
        Ellipsoid: three radii. Box: three half sides, rounding. Capsule: half length, two radii. Torus: the radii
        of the ring and of the tube. Cone: half height, radii below and above, rounding.
    widths : ndarray, shape (n,)
        Width of the fillet where it meets those before it; a tiny one is a crease. Negative for a cut.
    mirrored : bool
        Whether the half at x < 0 is the mirror image of the other.
    waves : ndarray, shape (m, 5)
        Wave vector, phase and height of waves on the surface.
    view : ndarray, shape (3, 3)
        Rotation of the whole; its rows are the axes of the picture.
    """

    kinds: NDArray[np.int64]
    turns: FloatArray
    centers: FloatArray
    sizes: FloatArray
    widths: FloatArray
    mirrored: bool
    waves: FloatArray
    view: FloatArray


@dataclass(frozen=True, eq=False)
class Rendered:
    """
    A solid seen along -z.

    Attributes
    ----------
    normals : ndarray, shape (size, size, 3)
        Unit vectors with z >= 0 on the object, zero beside it.
    mask : ndarray of bool, shape (size, size)
        Where a pixel's center meets the object.
    coverage : ndarray, shape (size, size)
        Share of each pixel that the object covers, at least one half exactly on the mask.
    """

    normals: FloatArray
    mask: BoolArray
    coverage: FloatArray


def random_solid(rng: np.random.Generator) -> Solid:
    """Draw a solid: a lone primitive now and then, mostly a body with limbs, sometimes symmetric, carved or wavy."""
    draw = rng.random()
    if draw < 0.08:
        return _assembled(rng, [_lone_ellipsoid(rng)], mirrored=False)
    if draw < 0.24:
        parts = [_primitive(rng, int(rng.integers(1, 5)), np.zeros(3), rng.uniform(0.6, 1.0))]
        if rng.random() < 0.5:
            parts.append(_attached(rng, parts, rng.uniform(0.4, 0.9)))
        return _assembled(rng, parts, mirrored=False)
    mirrored = bool(rng.random() < 0.45)
    parts = [_primitive(rng, _body_kind(rng), np.zeros(3), rng.uniform(0.7, 1.0))]
    limbs = int(rng.integers(1, 6 if mirrored else 9))
    shrink = rng.uniform(0.35, 0.95)
    for _ in range(limbs):
        parts.append(_attached(rng, parts, rng.uniform(0.6, 1.2) * shrink))
    if rng.random() < 0.4:  # features: eyes, buttons, dents
        scale = rng.uniform(0.08, 0.25)
        for _ in range(int(rng.integers(2, 8))):
            parts.append(_attached(rng, parts[: limbs + 1], scale * rng.uniform(0.6, 1.5), front=True))
            if rng.random() < 0.25:
                parts[-1] = (*parts[-1][:4], -abs(parts[-1][4]))
    return _assembled(rng, parts, mirrored=mirrored)


_Part = tuple[int, FloatArray, FloatArray, FloatArray, float]


def _body_kind(rng: np.random.Generator) -> int:
    return int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.5, 0.12, 0.15, 0.05, 0.18]))


def _lone_ellipsoid(rng: np.random.Generator) -> _Part:
    radii = np.ones(3) if rng.random() < 0.4 else rng.uniform(0.35, 1.0, 3)
    return ELLIPSOID, _rotation(rng), np.zeros(3), np.append(radii, 0.0), 0.1


def _primitive(rng: np.random.Generator, kind: int, center: FloatArray, scale: float) -> _Part:
    if kind == ELLIPSOID:
        sizes = [*(scale * rng.uniform(0.45, 1.0, 3)), 0.0]
    elif kind == BOX:
        half = scale * rng.uniform(0.35, 0.9, 3)
        sizes = [*half, half.min() * (rng.uniform(0.0, 0.9) if rng.random() < 0.6 else 0.02)]
    elif kind == CAPSULE:
        first = scale * rng.uniform(0.2, 0.55)
        sizes = [scale * rng.uniform(0.4, 1.0), first, first * rng.uniform(0.4, 1.3), 0.0]
    elif kind == TORUS:
        ring = scale * rng.uniform(0.5, 0.8)
        sizes = [ring, ring * rng.uniform(0.2, 0.6), 0.0, 0.0]
    else:
        below = scale * rng.uniform(0.35, 0.8)
        above = below * rng.choice([0.0, rng.uniform(0.0, 1.0), 1.0])
        sizes = [
            scale * rng.uniform(0.3, 0.9),
            below,
            above,
            scale * 0.2 * rng.random() * (rng.random() < 0.5),
        ]
    width = 0.01 if rng.random() < 0.3 else scale * rng.uniform(0.02, 0.4)
    return kind, _rotation(rng), center, np.asarray(sizes, dtype=np.float64), float(width)


def _attached(rng: np.random.Generator, parts: list[_Part], scale: float, *, front: bool = False) -> _Part:
    """Draw a part whose center lies near the surface of one that is there."""
    _, turn, center, sizes, _ = parts[int(rng.integers(len(parts)))]
    direction = rng.normal(size=3)
    if front:
        direction[2] = abs(direction[2]) + 0.5
    direction /= np.linalg.norm(direction)
    local = turn @ direction
    extent = np.maximum(sizes[:3], 0.15)
    place = center + turn.T @ (local * extent) * rng.uniform(0.6, 1.05)
    kind = int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.45, 0.1, 0.3, 0.03, 0.12]))
    return _primitive(rng, kind, place, scale)


def _assembled(rng: np.random.Generator, parts: list[_Part], *, mirrored: bool) -> Solid:
    kinds, turns, centers, sizes, widths = zip(*parts, strict=True)
    waves = np.zeros((0, 5))
    if len(parts) > 1 and rng.random() < 0.2:
        count = int(rng.integers(1, 4))
        vectors = rng.normal(size=(count, 3)) * rng.uniform(2.0, 7.0)
        heights = rng.uniform(0.02, 0.12, (count, 1)) / np.maximum(
            np.linalg.norm(vectors, axis=1, keepdims=True), 2.0
        )
        waves = np.concatenate([vectors, rng.uniform(0, 2 * np.pi, (count, 1)), heights * 2], axis=1)
    if mirrored and rng.random() < 0.6:  # seen from somewhere before it, as drawings mostly do
        yaw, pitch, roll = rng.normal(0, 0.6), rng.normal(0, 0.3), rng.normal(0, 0.25)
        view = _about(2, roll) @ _about(0, pitch) @ _about(1, yaw)
    else:
        view = _rotation(rng)
    return Solid(
        kinds=np.asarray(kinds, dtype=np.int64),
        turns=np.asarray(turns, dtype=np.float64),
        centers=np.asarray(centers, dtype=np.float64),
        sizes=np.asarray(sizes, dtype=np.float64),
        widths=np.asarray(widths, dtype=np.float64),
        mirrored=mirrored,
        waves=waves,
        view=view,
    )


def _rotation(rng: np.random.Generator) -> FloatArray:
    """Draw a rotation: anyhow, or about one axis only, as upright things stand."""
    if rng.random() < 0.3:
        return _about(int(rng.integers(3)), rng.uniform(-np.pi, np.pi))
    turn, upper = np.linalg.qr(rng.normal(size=(3, 3)))
    turn = turn * np.sign(np.diag(upper))
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def _about(axis: int, angle: float) -> FloatArray:
    turn = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[first, second], turn[second, first] = -np.sin(angle), np.sin(angle)
    return turn


def render_solid(solid: Solid, size: int) -> Rendered | None:
    """
    Render a solid into a square picture that it fills up to `MARGIN`.

    Parameters
    ----------
    solid : Solid
        What to render.
    size : int
        Width and height in pixels.

    Returns
    -------
    Rendered or None
        None if hardly anything is to be seen.
    """
    bounds = np.linalg.norm(solid.sizes[:, :3], axis=1) + solid.sizes.max(axis=1)  # of a ball around each
    solid_parts = (solid.kinds, solid.turns, solid.centers, solid.sizes, solid.widths)
    fields = (*solid_parts, bounds, solid.mirrored, solid.waves, solid.view)
    line = np.linspace(-REACH, REACH, _FRAMING)
    known = np.isfinite(_depths(*np.meshgrid(line, line), 2e-3, *fields))
    if known.sum() < 4:
        return None
    step = line[1] - line[0]
    extents = [line[known.any(axis=axis)][[0, -1]] for axis in (0, 1)]
    for axis in (0, 1):
        extents[axis] = _edges(axis, extents, step, fields)
    (left, right), (low, high) = extents
    width = max(right - left, high - low) / (1 - 2 * MARGIN)
    pixel = width / size
    offset = (np.arange(size) - (size - 1) / 2) * pixel
    x, y = np.meshgrid((left + right) / 2 + offset, (low + high) / 2 - offset)
    z = _depths(x, y, _ARRIVED * pixel, *fields)
    mask = np.isfinite(z)
    if mask.sum() < 0.03 * size * size:
        return None
    normals = _normals(x, y, z, *fields)
    return Rendered(normals, mask, _coverage(x, y, pixel, mask, fields))


def _edges(axis: int, extents: list[FloatArray], step: float, fields: tuple[object, ...]) -> FloatArray:
    """Refine where the silhouette ends along an axis: the framing rays left a step of doubt on each side."""
    across = np.linspace(extents[1 - axis][0] - step, extents[1 - axis][1] + step, _FRAMING)
    ends = []
    for end, sign in zip(extents[axis], (-1, 1), strict=True):
        along = end + sign * step * np.linspace(0, 1, 9)
        grid = np.meshgrid(along, across) if axis == 0 else np.meshgrid(across, along)
        hit = np.isfinite(_depths(*grid, 1e-3, *fields)).any(axis=axis)
        ends.append(along[hit][-1] if hit.any() else end)
    return np.asarray(ends)


def _coverage(
    x: FloatArray, y: FloatArray, pixel: float, mask: BoolArray, fields: tuple[object, ...]
) -> FloatArray:
    inner = np.pad(mask, 1, mode="edge")
    shifts = [
        inner[1 + a : 1 + a + len(mask), 1 + b : 1 + b + len(mask)] for a in (-1, 0, 1) for b in (-1, 0, 1)
    ]
    outline = np.any(shifts, axis=0) & ~np.all(shifts, axis=0)
    step = ((np.arange(SUBPIXELS) + 0.5) / SUBPIXELS - 0.5) * pixel
    right, down = (offset.ravel() for offset in np.meshgrid(step, step))
    fine_x, fine_y = x[outline][:, None] + right, y[outline][:, None] + down
    share = np.isfinite(_depths(fine_x, fine_y, 2 * _ARRIVED * pixel, *fields)).mean(axis=1)
    coverage = mask.astype(np.float64)
    coverage[outline] = np.where(mask[outline], np.maximum(share, 0.5), np.minimum(share, 0.499))
    return coverage


@numba.njit(cache=True, fastmath=True)
def _primitive_distance(kind, turns, sizes, i, ox, oy, oz):  # type: ignore[no-untyped-def]  # pragma: no cover
    x = turns[i, 0, 0] * ox + turns[i, 0, 1] * oy + turns[i, 0, 2] * oz
    y = turns[i, 1, 0] * ox + turns[i, 1, 1] * oy + turns[i, 1, 2] * oz
    z = turns[i, 2, 0] * ox + turns[i, 2, 1] * oy + turns[i, 2, 2] * oz
    if kind == 0:  # ellipsoid, to first order
        ax, ay, az = x / sizes[i, 0], y / sizes[i, 1], z / sizes[i, 2]
        level = np.sqrt(ax * ax + ay * ay + az * az)
        slope = np.sqrt((ax / sizes[i, 0]) ** 2 + (ay / sizes[i, 1]) ** 2 + (az / sizes[i, 2]) ** 2)
        inner = -min(sizes[i, 0], sizes[i, 1], sizes[i, 2])
        return max(level * (level - 1.0) / max(slope, 1e-9), inner)
    if kind == 1:  # rounded box
        bx, by, bz = (
            abs(x) - sizes[i, 0] + sizes[i, 3],
            abs(y) - sizes[i, 1] + sizes[i, 3],
            abs(z) - sizes[i, 2] + sizes[i, 3],
        )
        out = np.sqrt(max(bx, 0.0) ** 2 + max(by, 0.0) ** 2 + max(bz, 0.0) ** 2)
        return out + min(max(bx, by, bz), 0.0) - sizes[i, 3]
    if kind == 2:  # capsule along y, whose radius changes
        along = min(max((y + sizes[i, 0]) / (2 * sizes[i, 0]), 0.0), 1.0)
        away = np.sqrt(x * x + z * z + (y + sizes[i, 0] - 2 * sizes[i, 0] * along) ** 2)
        growth = sizes[i, 2] - sizes[i, 1]
        return (away - sizes[i, 1] - growth * along) / np.sqrt(1 + (growth / (2 * sizes[i, 0])) ** 2)
    if kind == 3:  # torus around y
        ring = np.sqrt(x * x + z * z) - sizes[i, 0]
        return np.sqrt(ring * ring + y * y) - sizes[i, 1]
    half, low, high = sizes[i, 0], max(sizes[i, 1] - sizes[i, 3], 0.0), max(sizes[i, 2] - sizes[i, 3], 0.0)
    out = np.sqrt(x * x + z * z)  # cone frustum around y
    limit = low if y < 0 else high
    cap_out, cap_up = out - min(out, limit), abs(y) - half
    slant_out, slant_up = high - low, 2 * half
    share = ((out - low) * slant_out + (y + half) * slant_up) / (slant_out * slant_out + slant_up * slant_up)
    share = min(max(share, 0.0), 1.0)
    side_out, side_up = out - low - share * slant_out, y + half - share * slant_up
    nearest = np.sqrt(min(cap_out * cap_out + cap_up * cap_up, side_out * side_out + side_up * side_up))
    if side_out < 0 and cap_up < 0:
        nearest = -nearest
    return nearest - sizes[i, 3]


@numba.njit(cache=True, fastmath=True)
def _distance(px, py, pz, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view):  # type: ignore[no-untyped-def]  # pragma: no cover
    x = view[0, 0] * px + view[1, 0] * py + view[2, 0] * pz
    y = view[0, 1] * px + view[1, 1] * py + view[2, 1] * pz
    z = view[0, 2] * px + view[1, 2] * py + view[2, 2] * pz
    if mirrored:
        x = abs(x)
    total = 1e9
    for i in range(len(kinds)):
        ox, oy, oz = x - centers[i, 0], y - centers[i, 1], z - centers[i, 2]
        width = abs(widths[i])
        if (
            widths[i] > 0
            and ox * ox + oy * oy + oz * oz > (total + width + bounds[i]) ** 2
            and total + width > 0
        ):
            continue  # too far away to matter
        value = _primitive_distance(kinds[i], turns, sizes, i, ox, oy, oz)
        if widths[i] > 0:
            nearness = max(width - abs(total - value), 0.0)
            total = min(total, value) - nearness * nearness / (4 * width)
        else:
            nearness = max(width - abs(total + value), 0.0)
            total = max(total, -value) + nearness * nearness / (4 * width)
    for i in range(len(waves)):
        total += waves[i, 4] * np.sin(waves[i, 0] * x + waves[i, 1] * y + waves[i, 2] * z + waves[i, 3])
    return total


@numba.njit(cache=True, fastmath=False)
def _depths(x, y, tolerance, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view):  # type: ignore[no-untyped-def]  # pragma: no cover
    depth = np.full(x.shape, np.nan)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            z = 3.0
            for _ in range(_MAX_STEPS):
                value = _distance(
                    x[i, j], y[i, j], z, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view
                )
                if value < tolerance:
                    depth[i, j] = z
                    break
                z -= max(STEP_FACTOR * value, _LEAST_STEP * tolerance)
                if z < -3.0:
                    break
    return depth


@numba.njit(cache=True, fastmath=False)
def _normals(x, y, z, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view):  # type: ignore[no-untyped-def]  # pragma: no cover
    normals = np.zeros((*x.shape, 3))
    step = np.zeros(3)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            if np.isnan(z[i, j]):
                continue
            for axis in range(3):
                step[:] = 0.0
                step[axis] = _DIFFERENCE
                ahead = _distance(
                    x[i, j] + step[0],
                    y[i, j] + step[1],
                    z[i, j] + step[2],
                    kinds,
                    turns,
                    centers,
                    sizes,
                    widths,
                    bounds,
                    mirrored,
                    waves,
                    view,
                )
                behind = _distance(
                    x[i, j] - step[0],
                    y[i, j] - step[1],
                    z[i, j] - step[2],
                    kinds,
                    turns,
                    centers,
                    sizes,
                    widths,
                    bounds,
                    mirrored,
                    waves,
                    view,
                )
                normals[i, j, axis] = ahead - behind
            normals[i, j, 2] = max(normals[i, j, 2], 0.0)
            length = np.sqrt(np.sum(normals[i, j] ** 2))
            if length > 0:
                normals[i, j] /= length
            else:
                normals[i, j, 2] = 1.0
    return normals

"""Rendering of random solids: rays along -z through a distance field, compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.training.solids import REACH, Solid

MARGIN = 0.04
"""Free share of the picture's width on each side of the silhouette's longer extent."""

SUBPIXELS = 3
"""Rays along each side of an outline pixel: coverage in steps of a ninth."""

STEP_FACTOR = 0.8
"""Share of the distance that a ray advances: ellipsoids overestimate theirs a little."""

_FRAMING = 64  # rays along each side of the square in which the silhouette is looked for
_MAX_STEPS = 400  # along steep waves that a ray grazes
_ARRIVED = 0.02  # of a pixel
_LEAST_STEP = 4.0  # times that: a chord so short along a grazed surface is lower than a 10000th of a pixel
_DIFFERENCE = 2e-4
_STEEPEST = (
    0.35  # smallest z of a normal by which the slope of a nearer side is taken: at its rim it has no end
)


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
    contours : ndarray of bool, shape (size, size)
        Pixels at which the object ends in front of another part of itself.
    parts : ndarray of int8, shape (size, size)
        Number of the primitive that is seen, -1 beside the object.
    """

    normals: FloatArray
    mask: BoolArray
    coverage: FloatArray
    contours: BoolArray
    parts: NDArray[np.int8]


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
    coverage, contours = _coverage(x, y, pixel, mask, fields), _contours(z / pixel, normals)
    return Rendered(
        normals, mask, coverage, contours, _parts(x, y, z, *solid_parts, solid.mirrored, solid.view)
    )


def _contours(depth: FloatArray, normals: FloatArray) -> BoolArray:
    """Tell where the depth, in pixels, falls to a neighbor by more than the slopes of both explain."""
    sideways = np.hypot(normals[..., 0], normals[..., 1])
    own, behind = (sideways / np.maximum(normals[..., 2], least) for least in (_STEEPEST, 1e-6))
    contours = np.zeros(depth.shape, np.bool_)
    for axis in (0, 1):
        first, last = (np.s_[:-1], np.s_[1:]) if axis == 0 else (np.s_[:, :-1], np.s_[:, 1:])
        for here, there in ((first, last), (last, first)):
            contours[here] |= depth[here] - depth[there] > own[here] + behind[there] + 1.0
    return contours


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
def _primitive_distance(kind, turns, sizes, i, ox, oy, oz):  # type: ignore[no-untyped-def]
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
def _distance(px, py, pz, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view):  # type: ignore[no-untyped-def]
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
    steepness = 1.0
    for i in range(len(waves)):
        total += waves[i, 4] * np.sin(waves[i, 0] * x + waves[i, 1] * y + waves[i, 2] * z + waves[i, 3])
        steepness += waves[i, 4] * np.sqrt(waves[i, 0] ** 2 + waves[i, 1] ** 2 + waves[i, 2] ** 2)
    return total / steepness  # waves that steep overestimate the distance so many times


@numba.njit(cache=True, fastmath=False)
def _depths(x, y, tolerance, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view):  # type: ignore[no-untyped-def]
    depth = np.full(x.shape, np.nan)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            z = REACH
            for _ in range(_MAX_STEPS):
                value = _distance(
                    x[i, j], y[i, j], z, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view
                )
                if value < tolerance:
                    depth[i, j] = z
                    break
                z -= max(STEP_FACTOR * value, _LEAST_STEP * tolerance)
                if z < -REACH:
                    break
    return depth


@numba.njit(cache=True, fastmath=False)
def _parts(x, y, z, kinds, turns, centers, sizes, widths, mirrored, view):  # type: ignore[no-untyped-def]
    """Tell to which primitive each visible point is nearest; what is cut out shows what it is cut from."""
    parts = np.full(x.shape, -1, np.int8)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            if np.isnan(z[i, j]):
                continue
            px = view[0, 0] * x[i, j] + view[1, 0] * y[i, j] + view[2, 0] * z[i, j]
            py = view[0, 1] * x[i, j] + view[1, 1] * y[i, j] + view[2, 1] * z[i, j]
            pz = view[0, 2] * x[i, j] + view[1, 2] * y[i, j] + view[2, 2] * z[i, j]
            if mirrored:
                px = abs(px)
            least = 1e9
            for k in range(len(kinds)):
                if widths[k] <= 0:
                    continue
                ox, oy, oz = px - centers[k, 0], py - centers[k, 1], pz - centers[k, 2]
                value = _primitive_distance(kinds[k], turns, sizes, k, ox, oy, oz)
                if value < least:
                    least = value
                    parts[i, j] = k
    return parts


@numba.njit(cache=True, fastmath=False)
def _normals(x, y, z, kinds, turns, centers, sizes, widths, bounds, mirrored, waves, view):  # type: ignore[no-untyped-def]
    normals = np.zeros((*x.shape, 3))
    step = np.zeros(3)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            if np.isnan(z[i, j]):
                continue
            for axis in range(3):
                step[:] = 0.0
                step[axis] = _DIFFERENCE
                for sign in (1.0, -1.0):
                    normals[i, j, axis] += sign * _distance(
                        x[i, j] + sign * step[0],
                        y[i, j] + sign * step[1],
                        z[i, j] + sign * step[2],
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
            normals[i, j, 2] = max(normals[i, j, 2], 0.0)
            length = np.sqrt(np.sum(normals[i, j] ** 2))
            if length > 0:
                normals[i, j] /= length
            else:
                normals[i, j, 2] = 1.0
    return normals

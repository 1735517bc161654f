"""Compiled loops of `synthetic.tracing`: rays against the distance from primitives."""

from __future__ import annotations

import numpy as np

from toonkit.numerics.compiled import njit

NOTHING = -1
"""Part that a ray meets which meets none."""

_TILE = 12  # rays along each side of a square whose rays look at the same primitives
_STEP_FACTOR = 0.85  # share of the distance that a ray advances: ellipsoids overestimate theirs a little
_MAX_STEPS = 1000  # a ray that grazes a surface takes several hundred
_ARRIVED, _SHORTEST = (
    0.05,
    0.1,
)  # distance at which a ray has met something, and its least step; of the spacing of rays
_DIFFERENCE = 2e-4
_FAR = 1e9


@njit(inline="always")
def _find_near(x_mid, y_mid, radius, kinds, centers, fillets, bounds, near):  # type: ignore[no-untyped-def]
    """Write the primitives that rays of a tile may meet; return their number, and the depths at which they start and end."""
    count, start, end = 0, -_FAR, _FAR
    for i in range(len(kinds)):
        reach = bounds[i] + fillets[i]
        if np.hypot(centers[i, 0] - x_mid, centers[i, 1] - y_mid) <= reach + radius:
            near[count] = i
            count += 1
            start, end = max(start, centers[i, 2] + reach), min(end, centers[i, 2] - reach)
    return count, start, end


@njit(inline="always")
def _find_members(near, count, part_of, part, own):  # type: ignore[no-untyped-def]
    """Write which of the near primitives belong to a part; return their number."""
    members = 0
    for c in range(count):
        if part_of[near[c]] == part:
            own[members] = near[c]
            members += 1
    return members


@njit(cache=True, error_model="numpy", fastmath=True)
def trace_rays(  # type: ignore[no-untyped-def]
    xs, ys, step, with_normals, kinds, part_of, centers, turns, sizes, fillets, cuts, bounds, part, depth, normals
):  # fmt: skip
    """Send rays along -z through a grid of x and y, and write what each meets first: see `Hits`."""
    near = np.empty(len(kinds), np.int64)
    own = np.empty(len(kinds), np.int64)
    for top in range(0, len(ys), _TILE):
        for left in range(0, len(xs), _TILE):
            bottom, right = min(top + _TILE, len(ys)), min(left + _TILE, len(xs))
            x_mid, y_mid = (xs[left] + xs[right - 1]) / 2, (ys[top] + ys[bottom - 1]) / 2
            radius = np.hypot(xs[right - 1] - xs[left], ys[bottom - 1] - ys[top]) / 2
            count, start, end = _find_near(x_mid, y_mid, radius, kinds, centers, fillets, bounds, near)
            if count == 0:
                continue
            for _ in range(_MAX_STEPS):  # all rays of the tile together, as far as none can have met anything
                value, _ = _nearest(
                    x_mid,
                    y_mid,
                    start,
                    near,
                    count,
                    kinds,
                    part_of,
                    centers,
                    turns,
                    sizes,
                    fillets,
                    cuts,
                    bounds,
                )
                advance = _STEP_FACTOR * value - radius
                if advance < radius or start < end:
                    break
                start -= advance
            if start < end:
                continue
            for row in range(top, bottom):
                for column in range(left, right):
                    x, y, z = xs[column], ys[row], start
                    for _ in range(_MAX_STEPS):
                        value, met = _nearest(
                            x, y, z, near, count, kinds, part_of, centers, turns, sizes, fillets, cuts, bounds
                        )
                        if value < _ARRIVED * step:
                            part[row, column], depth[row, column] = met, z
                            break
                        z -= max(_STEP_FACTOR * value, _SHORTEST * step)
                        if z < end:
                            break
                    met = part[row, column]
                    if met == NOTHING or not with_normals:
                        continue
                    members = _find_members(near, count, part_of, met, own)
                    _normal(
                        x, y, z, own, members, kinds, part_of, centers, turns, sizes, fillets, cuts, bounds,
                        normals[row, column],
                    )  # fmt: skip


@njit(cache=True, error_model="numpy", fastmath=True)
def _normal(  # type: ignore[no-untyped-def]
    x, y, z, near, count, kinds, part_of, centers, turns, sizes, fillets, cuts, bounds, normal
):
    """Write the unit gradient of the distance, by differences along the corners of a tetrahedron."""
    normal[:] = 0.0
    for corner in range(4):
        sx = 1.0 if corner in (0, 3) else -1.0
        sy = 1.0 if corner in (2, 3) else -1.0
        sz = 1.0 if corner in (1, 3) else -1.0
        value, _ = _nearest(
            x + sx * _DIFFERENCE, y + sy * _DIFFERENCE, z + sz * _DIFFERENCE,
            near, count, kinds, part_of, centers, turns, sizes, fillets, cuts, bounds,
        )  # fmt: skip
        normal[0] += sx * value
        normal[1] += sy * value
        normal[2] += sz * value
    normal[2] = max(normal[2], 0.0)
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if length > 0.0:
        normal /= length
    else:
        normal[2] = 1.0


@njit(cache=True, error_model="numpy", fastmath=True)
def _nearest(  # type: ignore[no-untyped-def]
    x, y, z, near, count, kinds, part_of, centers, turns, sizes, fillets, cuts, bounds
):
    """Return the distance from the nearest part, and which it is; the pieces of a part stand together."""
    best, met = _FAR, NOTHING
    total, current = _FAR, NOTHING
    for c in range(count):
        i = near[c]
        if part_of[i] != current:
            if total < best:
                best, met = total, current
            total, current = _FAR, part_of[i]
        ox, oy, oz = x - centers[i, 0], y - centers[i, 1], z - centers[i, 2]
        fillet = fillets[i]
        if not cuts[i]:
            limit = min(total, best + fillet) + fillet + bounds[i]
            if limit > 0.0 and ox * ox + oy * oy + oz * oz > limit * limit:
                continue  # too far away to matter
        ax = turns[i, 0, 0] * ox + turns[i, 0, 1] * oy + turns[i, 0, 2] * oz
        ay = turns[i, 1, 0] * ox + turns[i, 1, 1] * oy + turns[i, 1, 2] * oz
        az = turns[i, 2, 0] * ox + turns[i, 2, 1] * oy + turns[i, 2, 2] * oz
        value = _distance(kinds[i], sizes[i], ax, ay, az)
        if cuts[i]:
            blend = max(fillet - abs(total + value), 0.0)
            total = max(total, -value)
            if blend > 0.0:
                total += blend * blend / (4.0 * fillet)
        else:
            blend = max(fillet - abs(total - value), 0.0)
            total = min(total, value)
            if blend > 0.0:
                total -= blend * blend / (4.0 * fillet)
    if total < best:
        best, met = total, current
    return best, met


@njit(cache=True, error_model="numpy", fastmath=True)
def _distance(kind, sizes, x, y, z):  # type: ignore[no-untyped-def]
    """Return the distance from a primitive at the origin; see `Primitive` for its sizes."""
    if kind == 0:  # ellipsoid, to first order
        ax, ay, az = x / sizes[0], y / sizes[1], z / sizes[2]
        level = np.sqrt(ax * ax + ay * ay + az * az)
        slope = np.sqrt((ax / sizes[0]) ** 2 + (ay / sizes[1]) ** 2 + (az / sizes[2]) ** 2)
        return max(level * (level - 1.0) / max(slope, 1e-9), -min(sizes[0], sizes[1], sizes[2]))
    if kind == 1:  # rounded box
        bx, by, bz = abs(x) - sizes[0] + sizes[3], abs(y) - sizes[1] + sizes[3], abs(z) - sizes[2] + sizes[3]
        out = np.sqrt(max(bx, 0.0) ** 2 + max(by, 0.0) ** 2 + max(bz, 0.0) ** 2)
        return out + min(max(bx, by, bz), 0.0) - sizes[3]
    if kind == 2:  # capsule along y, whose radius changes
        along = min(max((y + sizes[0]) / (2 * sizes[0]), 0.0), 1.0)
        away = np.sqrt(x * x + z * z + (y + sizes[0] - 2 * sizes[0] * along) ** 2)
        growth = sizes[2] - sizes[1]
        return (away - sizes[1] - growth * along) / np.sqrt(1 + (growth / (2 * sizes[0])) ** 2)
    if kind == 3:  # torus around y
        from_ring = np.sqrt(x * x + z * z) - sizes[0]
        return np.sqrt(from_ring * from_ring + y * y) - sizes[1]
    # Cone frustum around y, shrunk by its rounding.
    half = max(sizes[0] - sizes[3], 1e-6)
    low, high = max(sizes[1] - sizes[3], 0.0), max(sizes[2] - sizes[3], 0.0)
    out = np.sqrt(x * x + z * z)
    limit = low if y < 0 else high
    cap_out, cap_up = out - min(out, limit), abs(y) - half
    slant_out, slant_up = high - low, 2 * half
    share = ((out - low) * slant_out + (y + half) * slant_up) / (slant_out * slant_out + slant_up * slant_up)
    share = min(max(share, 0.0), 1.0)
    side_out, side_up = out - low - share * slant_out, y + half - share * slant_up
    nearest = np.sqrt(min(cap_out * cap_out + cap_up * cap_up, side_out * side_out + side_up * side_up))
    if side_out < 0 and cap_up < 0:
        nearest = -nearest
    return nearest - sizes[3]

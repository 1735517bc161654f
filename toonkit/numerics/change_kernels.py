"""Compiled pixel loops of `ChangeEnergy`: one file, because Numba invalidates a cache only when its own file changes.

Each of them works on the pixels first to last of a grid and writes to those alone, so that bands can run in parallel.
"""

from __future__ import annotations

import numpy as np

from toonkit.numerics.compiled import njit

LEAST_CURVATURE = 0.3
"""Share of the pull's strength that its curvature has at least, so that a vector pulled the other way turns around."""


@njit(inline="always")
def _cell(field, nx, ny, nz, beside, above, across, sx, sy):  # type: ignore[no-untyped-def]
    """
    Return the integrability residual of a cell, and its gradient with respect to the vector n of one of its pixels.

    `sx` and `sy` are half of -1 where the cell lies to the right of that pixel, and above it; half of 1 elsewhere.
    """
    ux, uy, uz = field[beside, 0], field[beside, 1], field[beside, 2]
    vx, vy, vz = field[above, 0], field[above, 1], field[above, 2]
    wx, wy, wz = field[across, 0], field[across, 1], field[across, 2]
    own_x, own_z, other_x, other_z = nx + ux, nz + uz, vx + wx, vz + wz  # sums along the two rows
    mx = 0.25 * (own_x + other_x)
    my = 0.25 * (ny + uy + vy + wy)
    mz = 0.25 * (own_z + other_z)
    z_by_y = sy * (own_z - other_z)
    z_by_x = sx * (nz + vz - uz - wz)
    turn = sy * (own_x - other_x) - sx * (ny + vy - uy - wy)
    residual = mz * turn - mx * z_by_y + my * z_by_x
    return residual, sy * mz - 0.25 * z_by_y, 0.25 * z_by_x - sx * mz, 0.25 * turn - sy * mx + sx * my


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def relax(  # type: ignore[no-untyped-def]  # noqa: PLR0915 - one pixel's step, compiled as a whole
    neighbors, start, direction, hold, target, lower, upper, weight, links, ties, change_weight, curl_weight, source,
    field, backward, first, last,
):  # fmt: skip
    """
    Turn one vector after the other to where its own energy is least, in place: a Gauss-Seidel sweep.

    One Newton step in the tangent plane, on the convex part of the energy's second derivatives; the interval counts if the
    step would leave it. `source` (P, 3) is a linear term; `hold` and `target` (P,) are a quadratic one that pulls the
    component to its target. They are empty where there is none.
    """
    pulled, held = source.shape[0] > 0, hold.shape[0] > 0
    lx, ly, lz = direction[0], direction[1], direction[2]
    for i in range(first, last):
        p = first + last - 1 - i if backward else i
        nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
        # The membrane: its pull, and the curvature that is alike in all directions.
        stiffness = ties[p]
        fx = fy = fz = 0.0
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                link = links[p, k]
                stiffness += link
                fx += link * (field[q, 0] - start[q, 0])
                fy += link * (field[q, 1] - start[q, 1])
                fz += link * (field[q, 2] - start[q, 2])
        double = 2.0 * change_weight
        fx = double * (fx + stiffness * start[p, 0])
        fy = double * (fy + stiffness * start[p, 1])
        fz = double * (fz + stiffness * start[p, 2])
        if pulled:
            fx += source[p, 0]
            fy += source[p, 1]
            fz += source[p, 2]
        strength = np.sqrt(fx * fx + fy * fy + fz * fz)
        curvature = max(fx * nx + fy * ny + fz * nz, LEAST_CURVATURE * strength)
        # In the basis a = (1 - nx² share, -nx ny share, -nx), b = (-nx ny share, 1 - ny² share, -ny) of the tangent plane
        # (n looks at the viewer, so that 1 + nz >= 1) a vector g has the components
        # g·a = gx - tilt nx and g·b = gy - tilt ny with tilt = share (gx nx + gy ny) + gz.
        share = 1.0 / (1.0 + nz)
        # Integrability: slope and Gauss-Newton curvature of the four cells around.
        cx = cy = cz = haa = hab = hbb = 0.0
        for side in range(0, 4, 2):
            beside = neighbors[p, side]
            if beside < 0:
                continue
            for end in range(1, 4, 2):
                above = neighbors[p, end]
                if above < 0:
                    continue
                across = neighbors[beside, end]
                if across < 0:
                    continue
                residual, gx, gy, gz = _cell(
                    field, nx, ny, nz, beside, above, across, 0.5 * (side - 1.0), 0.5 * (end - 2.0)
                )
                cx += residual * gx
                cy += residual * gy
                cz += residual * gz
                tilt = share * (gx * nx + gy * ny) + gz
                ga = gx - tilt * nx
                gb = gy - tilt * ny
                haa += ga * ga
                hab += ga * gb
                hbb += gb * gb
        double = 2.0 * curl_weight
        curvature = max(curvature - double * (cx * nx + cy * ny + cz * nz), LEAST_CURVATURE * curvature)
        haa = double * haa + curvature
        hab = double * hab
        hbb = double * hbb + curvature
        gx, gy, gz = double * cx - fx, double * cy - fy, double * cz - fz
        tilt = share * (gx * nx + gy * ny) + gz
        ga, gb = gx - tilt * nx, gy - tilt * ny
        # The component: what holds it, then the interval if the step would leave it.
        component = lx * nx + ly * ny + lz * nz
        tilt = share * (lx * nx + ly * ny) + lz
        la, lb = lx - tilt * nx, ly - tilt * ny
        if held:
            firm = 2.0 * hold[p]
            ga += firm * (component - target[p]) * la
            gb += firm * (component - target[p]) * lb
            haa += firm * la * la
            hab += firm * la * lb
            hbb += firm * lb * lb
        scale = 1.0 / (haa * hbb - hab * hab)
        da = scale * (hab * gb - hbb * ga)
        db = scale * (hab * ga - haa * gb)
        after = component + la * da + lb * db
        if after < lower[p] or after > upper[p]:
            bound = lower[p] if after < lower[p] else upper[p]
            firm = 2.0 * weight[p]
            ga += firm * (component - bound) * la
            gb += firm * (component - bound) * lb
            haa += firm * la * la
            hab += firm * la * lb
            hbb += firm * lb * lb
            scale = 1.0 / (haa * hbb - hab * hab)
            da = scale * (hab * gb - hbb * ga)
            db = scale * (hab * ga - haa * gb)
        down = nx * da + ny * db
        nx += da - share * down * nx
        ny += db - share * down * ny
        nz = max(nz - down, 0.0)
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        if length > 1e-12:
            field[p, 0] = nx / length
            field[p, 1] = ny / length
            field[p, 2] = nz / length


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def value_and_gradient(  # type: ignore[no-untyped-def]  # noqa: PLR0915 - one pixel's share, compiled as a whole
    neighbors, start, direction, hold, target, lower, upper, weight, links, ties, change_weight, curl_weight, source,
    field, out, first, last,
):  # fmt: skip
    """
    Return the energy and write its gradient to `out` (P, 3), as far as unit vectors with z >= 0 may follow it.

    That is the part across each vector; one with z = 0 may not turn away.
    """
    pulled, held = source.shape[0] > 0, hold.shape[0] > 0
    lx, ly, lz = direction[0], direction[1], direction[2]
    energy = 0.0
    for p in range(first, last):
        nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
        dx, dy, dz = nx - start[p, 0], ny - start[p, 1], nz - start[p, 2]
        gx, gy, gz = ties[p] * dx, ties[p] * dy, ties[p] * dz
        membrane = gx * dx + gy * dy + gz * dz
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                link = links[p, k]
                ex = dx - field[q, 0] + start[q, 0]
                ey = dy - field[q, 1] + start[q, 1]
                ez = dz - field[q, 2] + start[q, 2]
                gx += link * ex
                gy += link * ey
                gz += link * ez
                membrane += 0.5 * link * (ex * ex + ey * ey + ez * ez)
        energy += change_weight * membrane
        double = 2.0 * change_weight
        gx *= double
        gy *= double
        gz *= double
        if pulled:
            energy -= source[p, 0] * nx + source[p, 1] * ny + source[p, 2] * nz
            gx -= source[p, 0]
            gy -= source[p, 1]
            gz -= source[p, 2]
        for side in range(0, 4, 2):
            beside = neighbors[p, side]
            if beside < 0:
                continue
            for end in range(1, 4, 2):
                above = neighbors[p, end]
                if above < 0:
                    continue
                across = neighbors[beside, end]
                if across < 0:
                    continue
                residual, cx, cy, cz = _cell(
                    field, nx, ny, nz, beside, above, across, 0.5 * (side - 1.0), 0.5 * (end - 2.0)
                )
                energy += 0.25 * curl_weight * residual * residual  # each cell is seen from its four corners
                residual *= 2.0 * curl_weight
                gx += residual * cx
                gy += residual * cy
                gz += residual * cz
        component = lx * nx + ly * ny + lz * nz
        excess = component - min(max(component, lower[p]), upper[p])
        energy += weight[p] * excess * excess
        pull = 2.0 * weight[p] * excess
        if held:
            away = component - target[p]
            energy += hold[p] * away * away
            pull += 2.0 * hold[p] * away
        gx += pull * lx
        gy += pull * ly
        gz += pull * lz
        along = gx * nx + gy * ny + gz * nz
        gz -= along * nz
        out[p, 0] = gx - along * nx
        out[p, 1] = gy - along * ny
        out[p, 2] = 0.0 if nz <= 0.0 and gz > 0.0 else gz
    return energy


@njit(cache=True, nogil=True, error_model="numpy")
def gather_blocks(  # type: ignore[no-untyped-def]
    parent,
    direction,
    field,
    gradient,
    hold,
    lower,
    upper,
    weight,
    mean,
    slopes,
    firm,
    low,
    high,
    loose,
    first,
    last,
):
    """
    Sum over each block what a coarse grid needs to know of its pixels, into arrays that hold zeros.

    A component outside its interval is held where it is, which keeps the curvature; the others may move within the mean of
    their intervals.
    """
    held = hold.shape[0] > 0
    for p in range(first, last):
        block = parent[p]
        component = 0.0
        for c in range(3):
            mean[block, c] += field[p, c]
            slopes[block, c] += gradient[p, c]
            component += direction[c] * field[p, c]
        if held:
            firm[block] += hold[p]
        if component < lower[p] or component > upper[p]:
            firm[block] += weight[p]
        else:
            loose[block] += weight[p]
            low[block] += weight[p] * lower[p]
            high[block] += weight[p] * upper[p]


@njit(cache=True, nogil=True, error_model="numpy")
def retract(field, step, length, out, first, last):  # type: ignore[no-untyped-def]
    """Write the unit vectors, z >= 0, of `field + length * step` to `out`, which may be one of the two; else (0, 0, 1)."""
    for p in range(first, last):
        x = field[p, 0] + length * step[p, 0]
        y = field[p, 1] + length * step[p, 1]
        z = max(field[p, 2] + length * step[p, 2], 0.0)
        norm = np.sqrt(x * x + y * y + z * z)
        if norm > 1e-12:
            out[p, 0], out[p, 1], out[p, 2] = x / norm, y / norm, z / norm
        else:
            out[p, 0], out[p, 1], out[p, 2] = 0.0, 0.0, 1.0

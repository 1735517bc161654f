"""Compiled pixel loops of `ChangeEnergy`: one file, because Numba invalidates a cache only when its own file changes.

Each of them works on the pixels first to last of a grid and writes to those alone: chunks of rows can run in parallel.
"""

from __future__ import annotations

import numpy as np

from toonkit.numerics.compiled import larger, njit, smaller

LEAST_CURVATURE = 0.3
"""Share of the pull's strength that its curvature has at least, so that a vector corrected the other way turns around."""


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


@njit(inline="always")
def _poisson_pull(neighbors, start, edge_weights, screening, field, p):  # type: ignore[no-untyped-def]
    """Return the curvature of the screened Poisson term, alike in all directions, and the pull of the neighbors' changes."""
    stiffness = screening[p]
    fx = fy = fz = 0.0
    for k in range(4):
        q = neighbors[p, k]
        if q >= 0:
            edge = edge_weights[p, k]
            stiffness += edge
            fx += edge * (field[q, 0] - start[q, 0])
            fy += edge * (field[q, 1] - start[q, 1])
            fz += edge * (field[q, 2] - start[q, 2])
    return stiffness, fx, fy, fz


@njit(inline="always")
def _integrability_terms(neighbors, field, nx, ny, nz, share, p):  # type: ignore[no-untyped-def]
    """
    Sum the squared residuals of the four cells around p.

    Returns the sum, half of its gradient (3 numbers), and the Gauss-Newton curvature in the tangent plane (3 numbers).
    """
    squares = cx = cy = cz = haa = hab = hbb = 0.0
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
            squares += residual * residual
            cx += residual * gx
            cy += residual * gy
            cz += residual * gz
            tilt = share * (gx * nx + gy * ny) + gz
            ga = gx - tilt * nx
            gb = gy - tilt * ny
            haa += ga * ga
            hab += ga * gb
            hbb += gb * gb
    return squares, cx, cy, cz, haa, hab, hbb


@njit(inline="always")
def _add_spring(firm, away, la, lb, ga, gb, haa, hab, hbb):  # type: ignore[no-untyped-def]
    """Add firm / 2 times the square of the component's distance `away` to a gradient and its second derivatives."""
    ga += firm * away * la
    gb += firm * away * lb
    haa += firm * la * la
    hab += firm * la * lb
    hbb += firm * lb * lb
    return ga, gb, haa, hab, hbb


@njit(inline="always")
def _newton_step(ga, gb, haa, hab, hbb):  # type: ignore[no-untyped-def]
    """Return the step in the tangent plane at which the gradient vanishes."""
    scale = 1.0 / (haa * hbb - hab * hab)
    return scale * (hab * gb - hbb * ga), scale * (hab * ga - haa * gb)


@njit(inline="always")
def _store_unit(field, p, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Write a vector of unit length; keep the old one if the new one vanishes."""
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length > 1e-12:
        field[p, 0] = nx / length
        field[p, 1] = ny / length
        field[p, 2] = nz / length


@njit(inline="always")
def _store_tangent(out, p, gx, gy, gz, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Write the part of a gradient across n; with z = 0, without what would turn n away."""
    along = gx * nx + gy * ny + gz * nz
    gz -= along * nz
    out[p, 0] = gx - along * nx
    out[p, 1] = gy - along * ny
    out[p, 2] = 0.0 if nz <= 0.0 and gz > 0.0 else gz


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def sweep_change(  # type: ignore[no-untyped-def]
    neighbors, start, direction, hold, target, lower, upper, weight, edge_weights, screening,
    change_weight, curl_weight, tau, field, backward, first, last,
):  # fmt: skip
    """
    Turn one vector after the other to where its own energy is least, in place: a Gauss-Seidel sweep.

    One Newton step in the tangent plane, on the convex part of the energy's second derivatives; the interval counts if the
    step would leave it. See `Terms` for `hold`, `target` and `tau`.
    """
    corrected, held = tau.shape[0] > 0, hold.shape[0] > 0
    lx, ly, lz = direction[0], direction[1], direction[2]
    for i in range(first, last):
        p = first + last - 1 - i if backward else i
        nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
        stiffness, fx, fy, fz = _poisson_pull(neighbors, start, edge_weights, screening, field, p)
        double = 2.0 * change_weight
        fx = double * (fx + stiffness * start[p, 0])
        fy = double * (fy + stiffness * start[p, 1])
        fz = double * (fz + stiffness * start[p, 2])
        if corrected:
            fx += tau[p, 0]
            fy += tau[p, 1]
            fz += tau[p, 2]
        strength = np.sqrt(fx * fx + fy * fy + fz * fz)
        curvature = larger(fx * nx + fy * ny + fz * nz, LEAST_CURVATURE * strength)
        # In the basis a = (1 - nx² share, -nx ny share, -nx), b = (-nx ny share, 1 - ny² share, -ny) of the tangent plane
        # (n looks at the viewer, so that 1 + nz >= 1) a vector g has the components
        # g·a = gx - tilt nx and g·b = gy - tilt ny with tilt = share (gx nx + gy ny) + gz.
        share = 1.0 / (1.0 + nz)
        _, cx, cy, cz, haa, hab, hbb = _integrability_terms(neighbors, field, nx, ny, nz, share, p)
        double = 2.0 * curl_weight
        curvature = larger(curvature - double * (cx * nx + cy * ny + cz * nz), LEAST_CURVATURE * curvature)
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
            ga, gb, haa, hab, hbb = _add_spring(
                2.0 * hold[p], component - target[p], la, lb, ga, gb, haa, hab, hbb
            )
        da, db = _newton_step(ga, gb, haa, hab, hbb)
        after = component + la * da + lb * db
        if after < lower[p] or after > upper[p]:
            bound = lower[p] if after < lower[p] else upper[p]
            ga, gb, haa, hab, hbb = _add_spring(
                2.0 * weight[p], component - bound, la, lb, ga, gb, haa, hab, hbb
            )
            da, db = _newton_step(ga, gb, haa, hab, hbb)
        down = nx * da + ny * db
        nx += da - share * down * nx
        ny += db - share * down * ny
        nz = larger(nz - down, 0.0)
        _store_unit(field, p, nx, ny, nz)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def value_and_gradient(  # type: ignore[no-untyped-def]
    neighbors, start, direction, hold, target, lower, upper, weight, edge_weights, screening,
    change_weight, curl_weight, tau, field, out, first, last,
):  # fmt: skip
    """
    Return the energy and write its gradient to `out` (P, 3), as far as unit vectors with z >= 0 may follow it.

    That is the part across each vector; one with z = 0 may not turn away.
    """
    corrected, held = tau.shape[0] > 0, hold.shape[0] > 0
    lx, ly, lz = direction[0], direction[1], direction[2]
    energy = 0.0
    for p in range(first, last):
        nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
        dx, dy, dz = nx - start[p, 0], ny - start[p, 1], nz - start[p, 2]
        gx, gy, gz = screening[p] * dx, screening[p] * dy, screening[p] * dz
        poisson = gx * dx + gy * dy + gz * dz
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                edge = edge_weights[p, k]
                ex = dx - field[q, 0] + start[q, 0]
                ey = dy - field[q, 1] + start[q, 1]
                ez = dz - field[q, 2] + start[q, 2]
                gx += edge * ex
                gy += edge * ey
                gz += edge * ez
                poisson += 0.5 * edge * (ex * ex + ey * ey + ez * ez)
        energy += change_weight * poisson
        double = 2.0 * change_weight
        gx *= double
        gy *= double
        gz *= double
        if corrected:
            energy -= tau[p, 0] * nx + tau[p, 1] * ny + tau[p, 2] * nz
            gx -= tau[p, 0]
            gy -= tau[p, 1]
            gz -= tau[p, 2]
        # The curvature is not asked for: without a use, the compiler leaves it out.
        squares, cx, cy, cz, _, _, _ = _integrability_terms(neighbors, field, nx, ny, nz, 0.0, p)
        energy += 0.25 * curl_weight * squares  # each cell is seen from its four corners
        double = 2.0 * curl_weight
        gx += double * cx
        gy += double * cy
        gz += double * cz
        component = lx * nx + ly * ny + lz * nz
        excess = component - smaller(larger(component, lower[p]), upper[p])
        energy += weight[p] * excess * excess
        pull = 2.0 * weight[p] * excess
        if held:
            away = component - target[p]
            energy += hold[p] * away * away
            pull += 2.0 * hold[p] * away
        gx += pull * lx
        gy += pull * ly
        gz += pull * lz
        _store_tangent(out, p, gx, gy, gz, nx, ny, nz)
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
        z = larger(field[p, 2] + length * step[p, 2], 0.0)
        norm = np.sqrt(x * x + y * y + z * z)
        if norm > 1e-12:
            out[p, 0], out[p, 1], out[p, 2] = x / norm, y / norm, z / norm
        else:
            out[p, 0], out[p, 1], out[p, 2] = 0.0, 0.0, 1.0

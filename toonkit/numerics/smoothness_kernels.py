"""Compiled pixel loops of `SmoothnessEnergy`: one file, because Numba invalidates a cache only when its own file changes.

Each of them works on the pixels first to last of a grid and writes to those alone: chunks of rows can run in parallel.
"""

from __future__ import annotations

import numpy as np

from toonkit.numerics.compiled import larger, njit, smaller

LEAST_CURVATURE = 0.3
"""Share of the pull's strength that its curvature has at least, so that a vector which looks the other way turns around."""

RELAXATION = 1.3
"""How far a vector is turned, in units of the step that is best for itself: the Laplacian squared wants more than one."""


@njit(inline="always")
def _turn(neighbors, edge_weights, field, p):  # type: ignore[no-untyped-def]
    """Return the Laplacian at p, and the sum of its edge weights."""
    x = y = z = total = 0.0
    nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
    for k in range(4):
        q = neighbors[p, k]
        if q >= 0:
            edge = edge_weights[p, k]
            total += edge
            x += edge * (field[q, 0] - nx)
            y += edge * (field[q, 1] - ny)
            z += edge * (field[q, 2] - nz)
    return x, y, z, total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def laplacian(neighbors, edge_weights, field, out, first, last):  # type: ignore[no-untyped-def]
    """Write the Laplacian of a field (P, 3)."""
    for p in range(first, last):
        out[p, 0], out[p, 1], out[p, 2], _ = _turn(neighbors, edge_weights, field, p)


@njit(inline="always")
def _bend(neighbors, edge_weights, areas, field, p):  # type: ignore[no-untyped-def]
    """Return half the gradient of the squared Laplacian with respect to the vector at p, and its curvature."""
    tx, ty, tz, total = _turn(neighbors, edge_weights, field, p)
    share = total / areas[p]
    gx, gy, gz = -share * tx, -share * ty, -share * tz
    stiffness = share * total
    for k in range(4):
        q = neighbors[p, k]
        if q >= 0:
            share = edge_weights[p, k] / areas[q]
            tx, ty, tz, _ = _turn(neighbors, edge_weights, field, q)
            gx += share * tx
            gy += share * ty
            gz += share * tz
            stiffness += share * edge_weights[p, k]
    return gx, gy, gz, stiffness


@njit(inline="always")
def _store_unit(field, p, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Write a vector of unit length; keep the old one if the new one vanishes."""
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length > 1e-12:
        field[p, 0] = nx / length
        field[p, 1] = ny / length
        field[p, 2] = nz / length


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def sweep_smooth(  # type: ignore[no-untyped-def]
    neighbors, edge_weights, areas, direction, hold, target, lower, upper, weight, smoothness, tau,
    field, backward, first, last,
):  # fmt: skip
    """
    Turn one vector after the other to where its own energy is least, and somewhat beyond, in place.

    One Newton step in the tangent plane: the curvature of the Laplacian's square is alike in all directions, so that the
    interval's adds to it along one alone. The interval counts if the step would leave it.
    """
    corrected, held = tau.shape[0] > 0, hold.shape[0] > 0
    lx, ly, lz = direction
    for i in range(first, last):
        p = first + last - 1 - i if backward else i
        nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
        gx, gy, gz, stiffness = _bend(neighbors, edge_weights, areas, field, p)
        # The pull: where the energy without the interval would be least for a vector of any length.
        double = 2.0 * smoothness
        fx = double * (stiffness * nx - gx)
        fy = double * (stiffness * ny - gy)
        fz = double * (stiffness * nz - gz)
        if corrected:
            fx += tau[p, 0]
            fy += tau[p, 1]
            fz += tau[p, 2]
        along = fx * nx + fy * ny + fz * nz
        curvature = larger(along, LEAST_CURVATURE * np.sqrt(fx * fx + fy * fy + fz * fz))
        if curvature <= 0.0:
            curvature = 1e-12 * smoothness + 1e-300
        gx, gy, gz = along * nx - fx, along * ny - fy, along * nz - fz
        # The component: what holds it, then the interval if the step would leave it.
        component = lx * nx + ly * ny + lz * nz
        ax, ay, az = lx - component * nx, ly - component * ny, lz - component * nz
        across = ax * ax + ay * ay + az * az
        down = ax * gx + ay * gy + az * gz
        firm = pull = 0.0
        if held:
            firm = 2.0 * hold[p]
            pull = firm * (component - target[p])
        after = component - (down + pull * across) / (curvature + firm * across)
        if after < lower[p] or after > upper[p]:
            bound = lower[p] if after < lower[p] else upper[p]
            firm += 2.0 * weight[p]
            pull += 2.0 * weight[p] * (component - bound)
        # (curvature + firm a aᵀ) step = -(g + pull a), by Sherman and Morrison.
        less = (pull * curvature - firm * down) / (curvature * (curvature + firm * across))
        nx -= RELAXATION * (gx / curvature + less * ax)
        ny -= RELAXATION * (gy / curvature + less * ay)
        nz = larger(nz - RELAXATION * (gz / curvature + less * az), 0.0)
        _store_unit(field, p, nx, ny, nz)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
def smooth_value_and_gradient(  # type: ignore[no-untyped-def]
    neighbors, edge_weights, areas, direction, hold, target, lower, upper, weight, smoothness, tau,
    field, turns, out, first, last,
):  # fmt: skip
    """
    Return the energy and write its gradient to `out` (P, 3), as far as the vectors may follow it.

    That is the part across each vector; one on the visible side's edge may not turn away. `turns` (P, 3) is the Laplacian.
    """
    corrected, held = tau.shape[0] > 0, hold.shape[0] > 0
    lx, ly, lz = direction
    energy = 0.0
    for p in range(first, last):
        nx, ny, nz = field[p, 0], field[p, 1], field[p, 2]
        tx, ty, tz = turns[p, 0] / areas[p], turns[p, 1] / areas[p], turns[p, 2] / areas[p]
        energy += smoothness * (tx * turns[p, 0] + ty * turns[p, 1] + tz * turns[p, 2])
        gx = gy = gz = 0.0
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                edge, area = edge_weights[p, k], areas[q]
                gx += edge * (turns[q, 0] / area - tx)
                gy += edge * (turns[q, 1] / area - ty)
                gz += edge * (turns[q, 2] / area - tz)
        gx *= 2.0 * smoothness
        gy *= 2.0 * smoothness
        gz *= 2.0 * smoothness
        if corrected:
            energy -= tau[p, 0] * nx + tau[p, 1] * ny + tau[p, 2] * nz
            gx -= tau[p, 0]
            gy -= tau[p, 1]
            gz -= tau[p, 2]
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
        along = gx * nx + gy * ny + gz * nz
        gz -= along * nz
        out[p, 0] = gx - along * nx
        out[p, 1] = gy - along * ny
        out[p, 2] = 0.0 if nz <= 0.0 and gz > 0.0 else gz
    return energy

"""The compiled pixel loop of the unit-field solver: one file, because a compiled cache does not see changes in another.

A step takes the pull of the neighbors and of the integrability on one pixel's vector, and puts it where that pull and the
interval penalty balance.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import IndexArray

NEWTON_STEPS = 40
"""Safeguarded Newton steps allowed for the convex one-dimensional problem; most pixels need three or four."""

COSINE_TOLERANCE = 1e-9
"""Newton is done when it moves the cosine by less: the energy is then exact to the square of it."""


@njit(cache=True, nogil=True)
def sweep_unit_field(
    neighbors: IndexArray,
    start: FloatArray,
    direction: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    weight: FloatArray,
    links: FloatArray,
    ties: FloatArray,
    change_weight: float,
    curl_weight: float,
    field: FloatArray,
) -> float:
    """Move every pixel once to where its own energy is least, in place; return the sum of the squared moves."""
    pull = np.empty(3)
    best = np.empty(3)
    moved = 0.0
    for p in range(field.shape[0]):
        stiffness = ties[p]
        for c in range(3):
            pull[c] = 0.0
        for k in range(4):
            q = neighbors[p, k]
            if q >= 0:
                stiffness += links[p, k]
                for c in range(3):
                    pull[c] += links[p, k] * (field[q, c] - start[q, c])
        for c in range(3):
            pull[c] = 2.0 * change_weight * (pull[c] + stiffness * start[p, c])
        if curl_weight > 0.0:
            _add_curl(neighbors, field, p, curl_weight, pull)
        for c in range(3):
            best[c] = field[p, c]
        best_unit_vector(pull, direction, lower[p], upper[p], weight[p], best)
        if best[2] < 0.0:
            # The visible side ends where z = 0: the nearest allowed vector is the projection onto that circle.
            length = np.sqrt(best[0] ** 2 + best[1] ** 2)
            best[0] /= length
            best[1] /= length
            best[2] = 0.0
        for c in range(3):
            moved += (best[c] - field[p, c]) ** 2
            field[p, c] = best[c]
    return moved


@njit(cache=True, nogil=True)
def _add_curl(neighbors, field, p, weight, pull):  # type: ignore[no-untyped-def]
    """Add to the pull the linear upper bound of weight * (sum of the squared residuals that pixel p takes part in)."""
    total = 0.0
    for horizontal in (0, 2):
        beside = neighbors[p, horizontal]
        if beside < 0:
            continue
        sx = -1.0 if horizontal == 0 else 1.0  # on which side of the cell pixel p is
        for vertical in (1, 3):
            above = neighbors[p, vertical]
            if above < 0 or neighbors[beside, vertical] < 0:
                continue
            sy = -1.0 if vertical == 1 else 1.0
            n, b, a, d = field[p], field[beside], field[above], field[neighbors[beside, vertical]]
            # Derivatives of the cell's residual with respect to n: n's own share in the sums below cancels out.
            mean_1 = 0.25 * (n[0] + b[0] + a[0] + d[0])
            mean_2 = 0.25 * (n[1] + b[1] + a[1] + d[1])
            mean_3 = 0.25 * (n[2] + b[2] + a[2] + d[2])
            dy_1 = 0.5 * sy * (n[0] + b[0] - a[0] - d[0])
            dy_3 = 0.5 * sy * (n[2] + b[2] - a[2] - d[2])
            dx_2 = 0.5 * sx * (n[1] + a[1] - b[1] - d[1])
            dx_3 = 0.5 * sx * (n[2] + a[2] - b[2] - d[2])
            residual = mean_3 * (dy_1 - dx_2) - mean_1 * dy_3 + mean_2 * dx_3
            gx = 0.5 * sy * mean_3 - 0.25 * dy_3
            gy = -0.5 * sx * mean_3 + 0.25 * dx_3
            gz = 0.25 * (dy_1 - dx_2) - 0.5 * sy * mean_1 + 0.5 * sx * mean_2
            pull[0] -= 2.0 * weight * residual * gx
            pull[1] -= 2.0 * weight * residual * gy
            pull[2] -= 2.0 * weight * residual * gz
            total += gx * gx + gy * gy + gz * gz
    for c in range(3):
        pull[c] += 2.0 * weight * total * field[p, c]


@njit(cache=True, nogil=True)
def best_unit_vector(
    pull: FloatArray, light: FloatArray, lower: float, upper: float, weight: float, result: FloatArray
) -> None:
    """
    Minimize -pull · n + weight * P(light · n) over unit vectors n; P is the squared distance to [lower, upper].

    Writes n to `result`, shape (3,). With n = u light + sqrt(1 - u²) t, where t is the direction of the pull across the
    light, the problem is convex in u alone.
    """
    strength = np.sqrt(pull[0] ** 2 + pull[1] ** 2 + pull[2] ** 2)
    if strength < 1e-300:
        return
    along = pull[0] * light[0] + pull[1] * light[1] + pull[2] * light[2]
    free = along / strength
    if lower <= free <= upper or weight == 0.0:
        for c in range(3):
            result[c] = pull[c] / strength
        return
    across = np.sqrt(max(strength * strength - along * along, 0.0))
    target = lower if free < lower else upper
    u = _best_cosine(along, across, free, target, weight)
    if across > 1e-12 * strength:
        scale = np.sqrt(max(1.0 - u * u, 0.0)) / across
        for c in range(3):
            result[c] = u * light[c] + scale * (pull[c] - along * light[c])
    else:
        _keep_direction(light, u, result)


@njit(cache=True, nogil=True)
def _best_cosine(along, across, free, target, weight):  # type: ignore[no-untyped-def]
    low, high = min(free, target), max(free, target)
    u = 0.5 * (low + high)
    for _ in range(NEWTON_STEPS):
        rest = max(1.0 - u * u, 1e-12)
        root = np.sqrt(rest)
        slope = -along + across * u / root + 2.0 * weight * (u - target)
        if slope > 0.0:
            high = u
        else:
            low = u
        step = slope / (across / (rest * root) + 2.0 * weight)
        if abs(step) < COSINE_TOLERANCE:
            break
        u -= step
        if not low < u < high:
            u = 0.5 * (low + high)
    return u


@njit(cache=True, nogil=True)
def _keep_direction(light, u, result):  # type: ignore[no-untyped-def]
    """Turn `result` about the light to the cosine u; the pull is parallel to the light and says no direction."""
    now = result[0] * light[0] + result[1] * light[1] + result[2] * light[2]
    length = np.sqrt(max(1.0 - now * now, 0.0))
    if length < 1e-9:
        return  # on the pole itself: any direction would be arbitrary
    scale = np.sqrt(max(1.0 - u * u, 0.0)) / length
    for c in range(3):
        result[c] = u * light[c] + scale * (result[c] - now * light[c])

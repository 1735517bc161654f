"""Smooth curves through knots, and the foot of the perpendicular from a point to one."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from toonkit._validation import FloatArray
from toonkit.numerics.compiled import njit

SAMPLES = 8
"""Samples between two knots; Newton's method starts from the nearest one."""


class Curve:
    """
    A cubic spline through knots, in the plane or in space, with one unit of its parameter between two.

    Parameters
    ----------
    knots : ndarray, shape (K, D)
        Points in D dimensions.
    closed : bool
        Whether it returns from the last knot to the first.
    """

    def __init__(self, knots: FloatArray, *, closed: bool) -> None:
        if closed:
            knots = np.concatenate([knots, knots[:1]])
        spans = len(knots) - 1
        spline = CubicSpline(np.arange(spans + 1), knots, bc_type="periodic" if closed else "natural")
        self._closed = closed
        # Powers of the local parameter, highest first: (span, power, dimension).
        self._coefficients = np.ascontiguousarray(spline.c.transpose(1, 0, 2))
        parameters = np.linspace(0, spans, SAMPLES * spans + 1)
        self._samples = np.ascontiguousarray(spline(parameters))

    def feet(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Find the nearest point of the curve to each of (n, D) points.

        Returns
        -------
        foot : ndarray, shape (n,)
            Its parameter.
        away : ndarray, shape (n, D)
            From it to the point.
        velocity : ndarray, shape (n, D)
            Derivative of the curve there.
        """
        foot, away, velocity = _feet(
            np.ascontiguousarray(points), self._samples, self._coefficients, SAMPLES, self._closed
        )
        return foot, away, velocity


@njit(cache=True)
def _feet(points, samples, coefficients, per_span, closed):  # type: ignore[no-untyped-def]
    count, dimensions = points.shape
    spans = len(coefficients)
    feet = np.empty(count)
    away = np.empty_like(points)
    velocity = np.empty_like(points)
    for i in range(count):
        nearest, least = 0, np.inf
        for j in range(len(samples)):
            squared = 0.0
            for k in range(dimensions):
                squared += (points[i, k] - samples[j, k]) ** 2
            if squared < least:
                nearest, least = j, squared
        foot = nearest / per_span
        for step in range(4):
            span = min(int(foot), spans - 1)
            t = foot - span
            slope, bend, squared = 0.0, 0.0, 0.0
            for k in range(dimensions):
                a, b, c, e = coefficients[span, :, k]
                offset = ((a * t + b) * t + c) * t + e - points[i, k]
                first = (3 * a * t + 2 * b) * t + c
                slope += offset * first
                squared += first * first
                bend += first * first + offset * (6 * a * t + 2 * b)
                away[i, k], velocity[i, k] = -offset, first
            if step == 3:  # the last round only evaluates
                break
            # Near a center of curvature Newton's step grows without bound; a shorter one still goes downhill.
            advance = slope / max(bend, 0.3 * squared)
            foot -= min(max(advance, -1 / per_span), 1 / per_span)
            foot = foot % spans if closed else min(max(foot, 0.0), float(spans))
        feet[i] = foot
    return feet, away, velocity

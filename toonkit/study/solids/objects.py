"""Complex solids: mushroom, teapot, snowman, pear, knot, vase and drapery."""

from __future__ import annotations

import numpy as np

from toonkit._validation import FloatArray
from toonkit.study.registry import View, shape
from toonkit.study.solids import distance_fields as d
from toonkit.study.solids.distance_fields import Distance


def _spot(azimuth: float, elevation: float, radius: float) -> Distance:
    """Return a button on the mushroom's cap, as seen from the cap's center in degrees."""
    turn, rise = np.deg2rad(azimuth), np.deg2rad(elevation)
    direction = np.array([np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)])
    center = np.array([0, 0.06, 0]) + direction * (0.78 - 0.04 * np.sin(rise))
    button = d.ellipsoid((0, 0, 0), (radius, radius, 0.07))
    return d.place(button, tuple(center), x=-elevation, y=azimuth)


@shape("mushroom", "complex", View(yaw=15, pitch=14))
def _mushroom() -> dict[str, Distance]:
    stem = d.smooth_union(
        0.15,
        d.capsule((0, -0.55, 0), (0, 0.2, 0), 0.27, 0.19),
        d.ellipsoid((0, -0.68, 0), (0.36, 0.22, 0.36)),
        d.torus((0, -0.12, 0), 0.22, 0.045),
    )
    cap = d.revolve(
        [
            (0, 0.06),
            (0.4, 0.03),
            (0.72, -0.02),
            (0.82, 0.03),
            (0.79, 0.2),
            (0.62, 0.52),
            (0.34, 0.74),
            (0, 0.82),
        ]
    )
    directions = [(0, 78, 0.2), (10, 22, 0.19), (75, 28, 0.17), (-55, 30, 0.17), (40, 58, 0.13)]
    directions += [(-100, 45, 0.15), (150, 35, 0.18), (-25, 55, 0.1), (-22, 3, 0.1), (42, 5, 0.11)]
    return {"stem": stem, "cap": cap, "spots": d.union(*(_spot(*where) for where in directions))}


@shape("teapot", "complex", View(yaw=18, pitch=16))
def _teapot() -> Distance:
    pot = d.revolve(
        [
            (0, -0.58),
            (0.36, -0.58),
            (0.42, -0.52),
            (0.58, -0.36),
            (0.66, -0.1),
            (0.58, 0.18),
            (0.36, 0.36),
            (0, 0.4),
        ]
    )
    lid = d.smooth_union(
        0.05,
        d.ellipsoid((0, 0.36, 0), (0.36, 0.15, 0.36)),
        d.torus((0, 0.36, 0), 0.35, 0.035),
        d.capsule((0, 0.45, 0), (0, 0.55, 0), 0.05),
        d.ellipsoid((0, 0.62, 0), (0.11, 0.09, 0.11)),
    )
    spout = d.tube(
        [(0.5, -0.28, 0), (0.78, -0.16, 0), (0.92, 0.12, 0), (1.1, 0.32, 0)], [0.19, 0.14, 0.09, 0.08]
    )
    handle = d.tube(
        [(-0.5, 0.24, 0), (-0.78, 0.34, 0), (-1.04, 0.2, 0), (-1.0, -0.1, 0), (-0.58, -0.32, 0)],
        [0.07, 0.075, 0.08, 0.075, 0.065],
    )
    opening = d.capsule((1.06, 0.28, 0), (1.2, 0.43, 0), 0.045, 0.055)
    whole = d.smooth_union(0.06, d.smooth_union(0.03, pot, lid), handle)
    return d.smooth_union(0.1, whole, d.smooth_subtract(0.02, spout, opening))


@shape("snowman", "complex", View(yaw=-18, pitch=8))
def _snowman() -> dict[str, Distance]:
    snow = d.smooth_union(
        0.08, d.sphere((0, -0.62, 0), 0.5), d.sphere((0, 0.06, 0), 0.37), d.sphere((0, 0.58, 0), 0.28)
    )
    hat = d.smooth_union(
        0.03,
        d.cylinder((0, 0, 0), 0.32, 0.03, 0.025),
        d.place(d.capped_cone(0.0, 0.36, 0.2, 0.23, 0.03), (0, 0, 0)),
    )
    scarf = d.smooth_union(
        0.05,
        d.torus((0, 0.32, 0), 0.25, 0.085),
        d.capsule((0.14, 0.3, 0.25), (0.24, -0.06, 0.37), 0.075, 0.085),
    )
    coal = [
        d.sphere((0, height, depth), 0.045) for height, depth in ((0.15, 0.365), (0.0, 0.375), (-0.42, 0.47))
    ]
    arm = d.smooth_union(
        0.02,
        d.capsule((0.3, 0.12, 0), (0.84, 0.42, 0.05), 0.04, 0.03),
        d.capsule((0.66, 0.32, 0.03), (0.72, 0.52, 0.05), 0.028, 0.022),
        d.capsule((0.72, 0.35, 0.03), (0.9, 0.3, 0.1), 0.028, 0.022),
    )
    return {
        "snow": snow,
        "carrot": d.place(d.capsule((0, 0, 0), (0, 0, 0.34), 0.07, 0.015), (0, 0.57, 0.25)),
        "hat": d.place(hat, (0.02, 0.8, -0.02), z=-8, x=-4),
        "scarf": scarf,
        "coal": d.union(*coal, d.mirror(d.sphere((0.1, 0.67, 0.245), 0.042))),
        "arms": d.mirror(arm),
    }


@shape("pear", "complex", View(yaw=20, pitch=8))
def _pear() -> dict[str, Distance]:
    fruit = d.revolve(
        [
            (0, -0.78),
            (0.2, -0.84),
            (0.5, -0.66),
            (0.62, -0.3),
            (0.5, 0.06),
            (0.32, 0.36),
            (0.26, 0.6),
            (0.14, 0.74),
            (0, 0.7),
        ]
    )
    stem = d.tube([(0, 0.66, 0), (0.02, 0.86, 0.01), (0.1, 1.04, 0.03)], [0.04, 0.035, 0.055])
    blade = d.intersect(d.sphere((0, 0.24, 0), 0.38), d.sphere((0, -0.24, 0), 0.38))
    bent = d.intersect(
        blade, d.smooth_subtract(0.02, d.sphere((0, 0, -0.6), 0.68), d.sphere((0, 0, -0.6), 0.61))
    )
    leaf = d.place(bent, (0.27, 0.95, 0.03), x=-35, y=25, z=22)
    return {"fruit": fruit, "stem": stem, "leaf": leaf}


@shape("knot", "complex", View(yaw=0, pitch=-14))
def _knot() -> Distance:
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    trefoil = np.column_stack(
        [
            np.sin(turn) + 2 * np.sin(2 * turn),
            np.cos(turn) - 2 * np.cos(2 * turn),
            -1.35 * np.sin(3 * turn),
        ]
    )
    return d.tube((trefoil * 0.3).tolist(), 0.19, closed=True)


@shape("vase", "complex", View(yaw=0, pitch=22))
def _vase() -> Distance:
    body = d.revolve(
        [
            (0, -0.94),
            (0.26, -0.95),
            (0.34, -0.9),
            (0.3, -0.8),
            (0.42, -0.5),
            (0.56, -0.1),
            (0.5, 0.24),
            (0.28, 0.48),
            (0.22, 0.66),
            (0.3, 0.86),
            (0.4, 0.93),
            (0.36, 0.95),
            (0.24, 0.86),
            (0.16, 0.66),
            (0.2, 0.48),
            (0.38, 0.2),
            (0.4, -0.2),
            (0.2, -0.7),
            (0, -0.76),
        ]
    )
    handle = d.tube(
        [(0.22, 0.68, 0), (0.42, 0.78, 0), (0.62, 0.62, 0), (0.62, 0.36, 0), (0.44, 0.2, 0)],
        [0.05, 0.055, 0.06, 0.055, 0.05],
    )
    return d.smooth_union(0.05, body, d.mirror(handle))


@shape("drapery", "complex", View(yaw=12, pitch=24))
def _drapery() -> Distance:
    """Return a cloth over a ball on a post: a dome whose skirt falls into folds that deepen downward."""
    dome = d.revolve(
        [
            (0, -0.82),
            (0.5, -0.82),
            (0.84, -0.8),
            (0.88, -0.74),
            (0.78, -0.5),
            (0.66, -0.1),
            (0.6, 0.3),
            (0.44, 0.62),
            (0.22, 0.78),
            (0, 0.82),
        ]
    )

    def distance(points: FloatArray) -> FloatArray:
        around = np.arctan2(points[:, 0], points[:, 2])
        out = np.hypot(points[:, 0], points[:, 2])
        deep = np.clip((0.55 - points[:, 1]) / 1.35, 0.0, 1.0)
        wave = np.cos(9 * around + 0.9 * np.sin(2 * around) + 0.5 * deep) + 0.3 * np.cos(4 * around + 1)
        depth = 0.13 * deep**1.5
        folded = np.maximum(out - depth * wave, 1e-9) / np.maximum(out, 1e-9)
        moved = points * np.column_stack([folded, np.ones_like(out), folded])
        # Folds steepen the field: over a radius of 0.6, 9 waves of 0.13 have a slope of up to 2.
        return 0.45 * dome(moved)

    return distance

"""Seven primitive solids."""

from __future__ import annotations

from toonkit.study.registry import View, shape
from toonkit.study.solids import distance_fields as d
from toonkit.study.solids.distance_fields import Distance


@shape("sphere", "primitive")
def _sphere() -> Distance:
    return d.sphere((0, 0, 0), 1.0)


@shape("ellipsoid", "primitive", View(yaw=25, pitch=15, roll=20))
def _ellipsoid() -> Distance:
    return d.ellipsoid((0, 0, 0), (1.0, 0.65, 0.8))


@shape("cylinder", "primitive", View(pitch=28))
def _cylinder() -> Distance:
    return d.cylinder((0, 0, 0), 0.6, 0.75)


@shape("cone", "primitive", View(pitch=18))
def _cone() -> Distance:
    return d.capped_cone(-0.7, 0.8, 0.75, 0.0)


@shape("torus", "primitive", View(yaw=20, pitch=50))
def _torus() -> Distance:
    return d.torus((0, 0, 0), 0.68, 0.3)


@shape("rounded_box", "primitive", View(yaw=-35, pitch=28))
def _rounded_box() -> Distance:
    return d.rounded_box((0, 0, 0), (0.75, 0.6, 0.6), 0.15)


@shape("three_box", "primitive", View(yaw=-38, pitch=27))
def _three_box() -> Distance:
    # Each is sunk into the one below: where faces only touch, the distance has no gradient.
    return d.union(
        d.rounded_box((0, -0.5, 0), (0.85, 0.25, 0.85), 0.0),
        d.place(d.rounded_box((0, 0, 0), (0.5, 0.32, 0.5), 0.0), (-0.1, 0.03, -0.1), y=18),
        d.place(d.rounded_box((0, 0, 0), (0.3, 0.3, 0.3), 0.0), (-0.05, 0.61, -0.1), y=-20),
    )

"""Complex solids: cat, rabbit, fish, duck, head and hand. Heights and sizes are as seen from the front."""

from __future__ import annotations

from toonkit.study.registry import View, shape
from toonkit.study.solids import distance_fields as d
from toonkit.study.solids.distance_fields import Distance


@shape("cat", "complex", View(yaw=-20, pitch=6))
def _cat() -> dict[str, Distance]:
    ear = d.smooth_subtract(
        0.04,
        d.capsule((0.22, 0.7, 0.06), (0.36, 1.0, 0.04), 0.15, 0.03),
        d.ellipsoid((0.3, 0.84, 0.2), (0.07, 0.15, 0.09)),
    )
    head = d.smooth_union(
        0.08,
        d.ellipsoid((0, 0.5, 0.1), (0.44, 0.36, 0.36)),
        d.mirror(ear),
        d.mirror(d.ellipsoid((0.09, 0.38, 0.41), (0.12, 0.09, 0.09))),
        d.ellipsoid((0, 0.28, 0.38), (0.08, 0.06, 0.06)),
    )
    body = d.smooth_union(
        0.12,
        d.ellipsoid((0, -0.3, 0.0), (0.34, 0.55, 0.34)),
        d.mirror(d.capsule((0.14, -0.1, 0.24), (0.15, -0.75, 0.32), 0.1)),
        d.mirror(d.ellipsoid((0.15, -0.82, 0.4), (0.12, 0.09, 0.16))),
        d.mirror(d.ellipsoid((0.32, -0.6, 0.02), (0.2, 0.3, 0.34))),
        d.mirror(d.ellipsoid((0.38, -0.84, 0.24), (0.12, 0.08, 0.2))),
    )
    tail = d.tube(
        [
            (0.15, -0.78, -0.25),
            (0.55, -0.8, -0.2),
            (0.78, -0.55, -0.05),
            (0.72, -0.2, 0.02),
            (0.8, 0.1, 0.05),
        ],
        [0.1, 0.1, 0.09, 0.09, 0.08],
    )
    return {
        "fur": d.smooth_union(0.06, d.smooth_union(0.1, body, head), tail),
        "nose": d.ellipsoid((0, 0.45, 0.5), (0.055, 0.04, 0.04)),
        "eyes": d.mirror(d.ellipsoid((0.18, 0.56, 0.4), (0.075, 0.095, 0.06))),
    }


@shape("rabbit", "complex", View(yaw=28, pitch=6))
def _rabbit() -> dict[str, Distance]:
    ear = d.smooth_subtract(
        0.05,
        d.ellipsoid((0, 0.33, 0), (0.13, 0.4, 0.09)),
        d.ellipsoid((0, 0.33, 0.1), (0.07, 0.3, 0.07)),
    )
    head = d.smooth_union(
        0.07,
        d.ellipsoid((0, 0.3, 0.12), (0.36, 0.32, 0.33)),
        d.mirror(d.place(ear, (0.13, 0.5, 0.03), x=-8, z=-12)),
        d.mirror(d.sphere((0.09, 0.18, 0.4), 0.11)),
    )
    body = d.smooth_union(
        0.12,
        d.ellipsoid((0, -0.42, -0.02), (0.42, 0.5, 0.4)),
        d.mirror(d.ellipsoid((0.3, -0.62, 0.12), (0.22, 0.28, 0.32))),
        d.mirror(d.ellipsoid((0.27, -0.86, 0.38), (0.14, 0.09, 0.27))),
        d.mirror(d.capsule((0.2, -0.22, 0.3), (0.1, -0.42, 0.46), 0.1, 0.085)),
    )
    return {
        "fur": d.smooth_union(0.1, body, head),
        "nose": d.ellipsoid((0, 0.26, 0.49), (0.05, 0.035, 0.04)),
        "eyes": d.mirror(d.ellipsoid((0.17, 0.38, 0.4), (0.055, 0.08, 0.05))),
        "tail": d.sphere((-0.34, -0.72, -0.34), 0.19),
    }


@shape("fish", "complex", View(yaw=-22, pitch=8))
def _fish() -> dict[str, Distance]:
    body = d.smooth_union(
        0.3,
        d.ellipsoid((0.22, 0, 0), (0.62, 0.42, 0.27)),
        d.capsule((-0.1, 0.0, 0), (-0.68, 0.03, 0), 0.2, 0.06),
    )
    lips = d.place(d.torus((0, 0, 0), 0.07, 0.045), (0.82, -0.04, 0), z=90)
    fins = d.smooth_union(
        0.05,
        d.place(d.ellipsoid((-0.2, 0, 0), (0.3, 0.13, 0.05)), (-0.68, 0.06, 0), z=-40),
        d.place(d.ellipsoid((-0.2, 0, 0), (0.3, 0.13, 0.05)), (-0.68, 0.0, 0), z=40),
        d.place(d.ellipsoid((0, 0, 0), (0.36, 0.2, 0.05)), (0.1, 0.4, 0), z=-14),
        d.place(d.ellipsoid((0, 0, 0), (0.17, 0.12, 0.05)), (-0.05, -0.4, 0), z=35),
        d.place(d.ellipsoid((-0.17, 0, 0), (0.21, 0.12, 0.045)), (0.32, -0.1, 0.24), y=38, z=18),
    )
    return {
        "body": d.smooth_union(0.05, body, lips),
        "fins": fins,
        "eye": d.union(d.sphere((0.54, 0.12, 0.16), 0.1), d.sphere((0.54, 0.12, -0.16), 0.1)),
    }


@shape("duck", "complex", View(yaw=-52, pitch=10))
def _duck() -> dict[str, Distance]:
    # It looks along +z, as all of them do.
    body = d.smooth_union(
        0.18,
        d.ellipsoid((0, -0.35, -0.08), (0.5, 0.4, 0.66)),
        d.ellipsoid((0, -0.28, 0.3), (0.36, 0.36, 0.32)),
        d.capsule((0, -0.15, -0.5), (0, 0.14, -0.84), 0.2, 0.05),
        d.capsule((0, -0.1, 0.25), (0, 0.3, 0.24), 0.2),
    )
    head = d.ellipsoid((0, 0.42, 0.26), (0.37, 0.36, 0.37))
    wing = d.smooth_union(
        0.08,
        d.place(d.ellipsoid((0, 0, 0), (0.1, 0.22, 0.36)), (0.47, -0.27, -0.12), z=-14),
        d.capsule((0.46, -0.2, -0.3), (0.5, -0.08, -0.5), 0.1, 0.05),
    )
    beak = d.smooth_union(
        0.03,
        d.place(d.ellipsoid((0, 0, 0.03), (0.19, 0.075, 0.24)), (0, 0.38, 0.6), x=-14),
        d.place(d.ellipsoid((0, 0, 0.0), (0.15, 0.06, 0.18)), (0, 0.29, 0.57), x=10),
    )
    return {
        "feathers": d.smooth_union(0.05, d.smooth_union(0.12, body, head), d.mirror(wing)),
        "beak": beak,
        "eyes": d.mirror(d.ellipsoid((0.23, 0.52, 0.47), (0.06, 0.085, 0.065))),
    }


@shape("head", "complex", View(yaw=22, pitch=2))
def _head() -> Distance:
    skull = d.smooth_union(
        0.25,
        d.ellipsoid((0, 0.3, -0.08), (0.56, 0.6, 0.62)),
        d.ellipsoid((0, -0.22, 0.12), (0.42, 0.48, 0.42)),
        d.ellipsoid((0, -0.58, 0.34), (0.15, 0.12, 0.13)),
    )
    bust = d.smooth_union(
        0.12,
        skull,
        d.capsule((0, -0.5, -0.12), (0, -0.78, -0.16), 0.27, 0.3),
        d.mirror(d.ellipsoid((0.3, -0.12, 0.36), (0.13, 0.11, 0.1))),
    )
    sockets = d.smooth_subtract(0.14, bust, d.mirror(d.ellipsoid((0.21, 0.09, 0.56), (0.14, 0.09, 0.11))))
    nose = d.smooth_union(
        0.08,
        d.capsule((0, 0.12, 0.52), (0, -0.13, 0.69), 0.06, 0.1),
        d.mirror(d.sphere((0.08, -0.16, 0.58), 0.06)),
    )
    ear = d.smooth_subtract(
        0.05,
        d.place(d.ellipsoid((0, 0, 0), (0.07, 0.21, 0.14)), (0.56, 0.0, -0.1), y=-25),
        d.ellipsoid((0.66, 0.02, -0.04), (0.06, 0.12, 0.07)),
    )
    face = d.smooth_union(
        0.07,
        sockets,
        nose,
        d.mirror(d.tube([(0.07, 0.2, 0.55), (0.21, 0.27, 0.53), (0.37, 0.2, 0.42)], [0.055, 0.06, 0.04])),
        d.mirror(ear),
    )
    mouth = d.smooth_union(
        0.03,
        d.tube([(-0.17, -0.36, 0.43), (0, -0.33, 0.54), (0.17, -0.36, 0.43)], [0.02, 0.05, 0.02]),
        d.tube([(-0.15, -0.39, 0.43), (0, -0.425, 0.52), (0.15, -0.39, 0.43)], [0.02, 0.06, 0.02]),
    )
    eyes = d.mirror(d.sphere((0.2, 0.07, 0.4), 0.11))
    return d.smooth_union(0.025, d.smooth_union(0.04, face, mouth), eyes)


@shape("hand", "complex", View(yaw=-18, pitch=4, roll=-6))
def _hand() -> Distance:
    palm = d.smooth_union(
        0.2,
        d.rounded_box((0, -0.3, 0), (0.36, 0.36, 0.14), 0.13),
        d.ellipsoid((0.2, -0.42, 0.08), (0.2, 0.3, 0.14)),
        d.ellipsoid((-0.22, -0.42, 0.06), (0.16, 0.3, 0.12)),
        d.rounded_box((0, -0.85, -0.02), (0.25, 0.3, 0.15), 0.14),
    )
    fingers = (
        d.tube([(0.27, -0.02, 0), (0.35, 0.28, 0.04), (0.4, 0.56, 0.12)], [0.115, 0.105, 0.09]),
        d.tube([(0.1, 0.02, 0), (0.12, 0.4, 0.04), (0.13, 0.74, 0.14)], [0.115, 0.11, 0.095]),
        d.tube([(-0.09, 0.0, 0), (-0.13, 0.36, 0.04), (-0.17, 0.66, 0.14)], [0.11, 0.105, 0.09]),
        d.tube([(-0.26, -0.05, 0), (-0.36, 0.2, 0.04), (-0.44, 0.42, 0.12)], [0.1, 0.09, 0.075]),
    )
    thumb = d.tube(
        [(0.24, -0.48, 0.06), (0.5, -0.28, 0.14), (0.64, 0.02, 0.2)],
        [0.14, 0.13, 0.1],
    )
    return d.smooth_union(0.07, d.smooth_union(0.12, palm, thumb), *fingers)

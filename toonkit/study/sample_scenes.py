"""The inked samples: a cat, a witch, a toadstool, a doughnut and a rocket, each in several materials."""

from __future__ import annotations

import numpy as np

from toonkit._validation import FloatArray
from toonkit.study.inked_samples import SampleScene, Tones
from toonkit.synthetic.model import INK, Part, Pattern, near, oval, smile, stripes, stroke
from toonkit.synthetic.primitives import (
    Solid,
    ball,
    both_sides,
    box,
    capsule,
    carved,
    ellipsoid,
    frustum,
    joined,
    lathe,
    placed,
    ring,
    tube,
)


def _cat() -> tuple[Part, ...]:
    ear = joined(0.03, *(capsule((x, 0.7, 0.0), (0.4, 1.02, 0.02), 0.13, 0.025) for x in (0.2, 0.33)))
    head = joined(0.06, ellipsoid((0, 0.42, 0.08), (0.52, 0.41, 0.4)), both_sides(ear))
    inner = joined(0.02, *(capsule((x, 0.76, 0.12), (0.39, 0.95, 0.05), 0.055, 0.012) for x in (0.27, 0.34)))
    brow = [
        Pattern("stripes", stroke([(x, 0.9), (0.75 * x, 0.7 - 0.6 * abs(x))], 0.07)) for x in (-0.13, 0, 0.13)
    ]
    cheeks = [
        Pattern("stripes", stroke([(side * 0.6, y), (side * 0.4, y - 0.03)], 0.055))
        for side in (-1, 1)
        for y in (0.38, 0.26)
    ]
    muzzle = joined(
        0.05,
        both_sides(ellipsoid((0.085, 0.25, 0.42), (0.14, 0.105, 0.1))),
        ellipsoid((0, 0.17, 0.4), (0.1, 0.07, 0.08)),
    )
    mouth = [Pattern(INK, smile((side * 0.06, 0.24), 0.12, 0.035, 0.018)) for side in (-1, 1)]
    eye = ellipsoid((0.21, 0.45, 0.41), (0.105, 0.135, 0.06))
    pupils = Pattern(
        "dark", near([(side * 0.23, y, 0.465) for side in (-1, 1) for y in (0.41, 0.45, 0.49)], 0.052)
    )
    glints = Pattern("white", near([(x, 0.505, 0.465) for x in (-0.255, 0.205)], 0.036))
    body = joined(
        0.1,
        ellipsoid((0, -0.36, 0), (0.33, 0.5, 0.3)),
        both_sides(ellipsoid((0.27, -0.64, 0.04), (0.2, 0.25, 0.28))),
    )
    leg = both_sides(capsule((0.13, -0.3, 0.24), (0.13, -0.76, 0.34), 0.095, 0.1))
    paws = both_sides(ellipsoid((0.13, -0.82, 0.4), (0.12, 0.085, 0.14)))
    paws += both_sides(ellipsoid((0.38, -0.84, 0.22), (0.14, 0.08, 0.19)))
    tail = tube(
        [(0.3, -0.78, -0.12), (0.62, -0.78, -0.1), (0.78, -0.5, 0), (0.66, -0.22, 0), (0.76, 0.04, 0)],
        [0.1, 0.1, 0.1, 0.1, 0.09],
    )
    rings = Pattern("stripes", stripes((0.35, 1, 0), 0.2, 0.42, 0.1))
    collar = placed(ring((0, 0, 0), 0.25, 0.055), (0, 0.02, 0.06), x=14)
    bell = ball((0, -0.1, 0.36), 0.095)
    slot = Pattern(INK, stroke([(-0.06, -0.1), (0.06, -0.1)], 0.016))
    hole = Pattern(INK, stroke([(0, -0.12), (0, -0.16)], 0.02))
    return (
        Part(head, "fur", (*brow, *cheeks)),
        Part(both_sides(inner), "pink"),
        Part(muzzle, "cream", tuple(mouth)),
        Part(ellipsoid((0, 0.34, 0.51), (0.06, 0.04, 0.04)), "pink"),
        Part(both_sides(eye), "iris", (pupils, glints)),
        Part(body, "fur", (Pattern("cream", oval((0, -0.32), (0.2, 0.3))),)),
        Part(leg, "fur"),
        Part(paws, "cream"),
        Part(tail, "fur", (rings,)),
        Part(collar, "collar"),
        Part(bell, "gold", (slot, hole)),
    )


def _witch() -> tuple[Part, ...]:
    head = joined(0.03, ellipsoid((0, 0.3, 0), (0.41, 0.37, 0.37)), both_sides(ball((0.39, 0.16, 0), 0.07)))
    hair = carved(
        joined(
            0.08,
            ellipsoid((0, 0.28, -0.05), (0.48, 0.4, 0.42)),
            both_sides(capsule((0.38, 0.2, -0.06), (0.46, -0.12, 0.0), 0.15, 0.16)),
            both_sides(capsule((0.46, -0.12, 0.0), (0.4, -0.44, 0.08), 0.16, 0.03)),
        ),
        ellipsoid((0, 0.2, 0.4), (0.36, 0.32, 0.3)),
        fillet=0.05,
    )
    fringe = joined(
        0.03,
        *(
            capsule((0.8 * x, 0.5, 0.28), (1.15 * x, 0.36 - 0.2 * abs(x), 0.39 - 0.5 * x * x), 0.1, 0.03)
            for x in (-0.3, -0.15, 0.02, 0.17, 0.3)
        ),
    )
    brim = placed(ellipsoid((0, 0, 0), (0.74, 0.06, 0.6)), (0, 0.6, -0.02), z=-4, x=8)
    cone = tube(
        [(0.03, 0.88, -0.04), (0.1, 1.1, -0.04), (0.3, 1.26, 0), (0.5, 1.2, 0.05)],
        [0.26, 0.17, 0.09, 0.025],
    )
    cone += frustum((0, 0.58, -0.03), (0.03, 0.9, -0.04), 0.43, 0.25, 0.02)
    band = placed(frustum((0, -0.05, 0), (0, 0.06, 0), 0.425, 0.36, 0.02), (0.0, 0.72, -0.03), z=-2)
    buckle = placed(
        carved(box((0, 0, 0), (0.11, 0.085, 0.03), 0.02), box((0, 0, 0), (0.06, 0.035, 0.1), 0.01)),
        (-0.01, 0.735, 0.38),
        x=-20,
    )
    dress = lathe([(0.5, -0.92), (0.36, -0.6), (0.2, -0.25), (0.17, -0.05)], 0.12)
    sleeve = capsule((0.16, -0.16, 0.02), (0.43, -0.38, 0.16), 0.08, 0.13)
    cuffs = both_sides(frustum((0.43, -0.38, 0.16), (0.48, -0.42, 0.19), 0.13, 0.13, 0.02))
    hands = both_sides(ball((0.51, -0.44, 0.21), 0.085))
    collar = placed(frustum((0, -0.05, 0), (0, 0.05, 0), 0.24, 0.17, 0.02), (0, -0.1, 0.02))
    bow = both_sides(frustum((0.02, -0.16, 0.26), (0.15, -0.16, 0.26), 0.025, 0.085, 0.02))
    bow += ball((0, -0.16, 0.27), 0.045)
    hem = Pattern("gold", stripes((0, 1, 0), 4.0, 0.018, 0.21))
    shoes = both_sides(ellipsoid((0.17, -0.97, 0.22), (0.14, 0.09, 0.2)))
    eye = ellipsoid((0.17, 0.24, 0.345), (0.075, 0.11, 0.045))
    glints = Pattern("white", near([(x, 0.285, 0.385) for x in (-0.19, 0.145)], 0.033))
    cheeks = Pattern("blush", near([(s * 0.24, 0.12, 0.28) for s in (-1, 1)], 0.095))
    mouth = Pattern(INK, smile((0, 0.1), 0.13, 0.035, 0.017))
    return (
        Part(head, "skin", (cheeks, mouth)),
        Part(joined(0.04, hair, fringe), "hair"),
        Part(joined(0.05, cone, brim), "cloth"),
        Part(band, "ribbon"),
        Part(buckle, "gold"),
        Part(both_sides(eye), "iris", (glints,)),
        Part(dress, "cloth", (hem,)),
        Part(both_sides(sleeve), "cloth"),
        Part(cuffs, "white"),
        Part(hands, "skin"),
        Part(collar, "white"),
        Part(bow, "ribbon"),
        Part(shoes, "ribbon"),
    )


def _toadstool() -> tuple[Part, ...]:
    cap = carved(
        ellipsoid((0, 0.2, 0), (0.86, 0.62, 0.8)),
        ellipsoid((0, -0.36, 0), (1.1, 0.42, 1.1)),
        fillet=0.1,
    )
    spots = [(0.1, 0.66, 0.5), (-0.62, 0.28, 0.5), (0.56, 0.4, 0.5), (-0.12, 0.3, 0.78), (0.4, 0.76, 0.05)]
    spots += [(-0.42, 0.74, 0.0), (0.82, 0.22, 0.2)]
    white = Pattern("white", near(spots, 0.17))
    stem = joined(
        0.2, ellipsoid((0, -0.6, 0), (0.42, 0.34, 0.38)), capsule((0, -0.6, 0), (0, 0.1, 0), 0.34, 0.28)
    )
    eye = both_sides(ellipsoid((0.16, -0.46, 0.36), (0.06, 0.09, 0.05)))
    glints = Pattern("white", near([(x, -0.425, 0.405) for x in (-0.178, 0.143)], 0.03))
    blush = Pattern("blush", near([(s * 0.27, -0.59, 0.29) for s in (-1, 1)], 0.08))
    mouth = Pattern(INK, smile((0, -0.58), 0.13, 0.04, 0.02))
    grass = _tufts()
    sprout = frustum((0.62, -0.88, 0.2), (0.6, -0.62, 0.2), 0.07, 0.06, 0.02)
    little = carved(
        ellipsoid((0.6, -0.58, 0.2), (0.24, 0.2, 0.24)),
        ellipsoid((0.6, -0.75, 0.2), (0.4, 0.14, 0.4)),
        fillet=0.04,
    )
    dots = Pattern("white", near([(0.55, -0.45, 0.4), (0.74, -0.52, 0.36), (0.4, -0.54, 0.3)], 0.06))
    return (
        Part(cap, "cap", (white,)),
        Part(stem, "stem", (blush, mouth)),
        Part(eye, "dark", (glints,)),
        Part(sprout, "stem"),
        Part(little, "cap", (dots,)),
        Part(grass, "grass"),
    )


def _tufts() -> Solid:
    """Return grass: a flat hill with blades."""
    hill = ellipsoid((0.08, -0.98, 0.0), (0.95, 0.16, 0.6))
    blades: Solid = ()
    for x, lean, tall in ((-0.72, -0.1, 0.3), (-0.62, 0.0, 0.4), (-0.5, 0.1, 0.28), (0.92, 0.1, 0.22)):
        blades += capsule((x, -0.92, 0.15), (x + lean, -0.92 + tall, 0.15), 0.07, 0.012)
    return joined(0.04, hill, blades)


def _doughnut() -> tuple[Part, ...]:
    dough = ring((0, 0, 0), 0.52, 0.32)
    icing = ring((0, 0.07, 0), 0.52, 0.3)
    drips: Solid = ()
    for angle, out, size in zip(
        np.deg2rad(np.arange(0, 360, 40) + 8), (0.78, 0.8, 0.77, 0.8, 0.79, 0.78, 0.8, 0.77, 0.79),
        (0.12, 0.1, 0.13, 0.11, 0.12, 0.1, 0.13, 0.12, 0.1), strict=True,
    ):  # fmt: skip
        drips += ball((0.96 * out * np.cos(angle), 0.02, 0.96 * out * np.sin(angle)), size)
    rng = np.random.default_rng(11)
    sprinkles: dict[str, Solid] = {"lemon": (), "sky": (), "white": ()}
    places: list[FloatArray] = []
    while len(places) < 21:
        around, over = rng.uniform(0, 2 * np.pi), rng.uniform(np.deg2rad(25), np.deg2rad(155))
        out = 0.52 + 0.31 * np.cos(over)
        place = np.array([out * np.cos(around), 0.07 + 0.31 * np.sin(over), out * np.sin(around)])
        if any(np.linalg.norm(place - other) < 0.21 for other in places):
            continue
        turn = rng.uniform(0, np.pi)
        along = np.array([-np.sin(around), 0, np.cos(around)]) * np.cos(turn)
        across = np.array([np.cos(around) * np.sin(over), -np.cos(over), np.sin(around) * np.sin(over)])
        half = 0.062 * (along + across * np.sin(turn))
        sprinkles[list(sprinkles)[len(places) % 3]] += capsule(place - half, place + half, 0.04)
        places.append(place)
    return (
        Part(placed(dough, x=54), "dough"),
        Part(placed(joined(0.06, icing, drips), x=54), "icing"),
        *(Part(placed(solid, x=54), name) for name, solid in sprinkles.items()),
    )


def _rocket() -> tuple[Part, ...]:
    hull = carved(ellipsoid((0, 0, 0), (0.44, 0.95, 0.44)), box((0, -1.1, 0), (1, 0.5, 1), 0.0), fillet=0.03)
    nose = Pattern("red", lambda points: np.asarray(points[:, 1] > 0.5))
    belt = Pattern("red", stripes((0, 1, 0), 4.0, 0.02, 0.085))
    fin = joined(0.12, tube([(0.3, -0.2, 0), (0.56, -0.42, 0), (0.64, -0.8, 0)], [0.15, 0.11, 0.04]))
    fins = tuple(piece for turn in (30, 150, 270) for piece in placed(fin, y=turn))
    frame = placed(ring((0, 0, 0), 0.17, 0.05), (0, 0.15, 0.41), x=86)
    glass = ellipsoid((0, 0.15, 0.4), (0.16, 0.16, 0.09))
    glint = Pattern("white", stroke([(-0.09, 0.17), (-0.03, 0.24)], 0.045))
    nozzle = frustum((0, -0.76, 0), (0, -0.56, 0), 0.28, 0.2)
    flame = joined(
        0.06,
        ball((0, -0.84, 0), 0.2),
        *(
            capsule((x, -0.86, 0), (1.4 * x, low, 0), 0.12, 0.015)
            for x, low in ((-0.1, -1.15), (0, -1.34), (0.1, -1.15))
        ),
    )
    core = capsule((0, -0.84, 0.14), (0, -1.06, 0.12), 0.1, 0.015)
    return (
        Part(hull, "hull", (nose, belt)),
        Part(fins, "red"),
        Part(frame, "brass"),
        Part(glass, "glass", (glint,)),
        Part(nozzle, "brass"),
        Part(flame, "flame"),
        Part(core, "core"),
    )


CAT = SampleScene(
    _cat,
    {
        "fur": Tones(("#c27a3a", "#e29a4c", "#fbbf6b")),
        "stripes": Tones(("#6b2c33", "#8f3f35")),
        "cream": Tones(("#d3ab9c", "#fff3dc")),
        "pink": Tones(("#e88a92",)),
        "iris": Tones(("#6fc48a",)),
        "dark": Tones(("#2a1c2e",)),
        "white": Tones(("#ffffff",)),
        "collar": Tones(("#25517e", "#3c86c4")),
        "gold": Tones(("#c08a1e", "#ffd84d"), glossy=True),
    },
    ink="#33202b",
    yaw=-14,
    pitch=6,
)

WITCH = SampleScene(
    _witch,
    {
        "skin": Tones(("#eab09a", "#fee0c8")),
        "blush": Tones(("#f79a90",)),
        "hair": Tones(("#d46a34", "#f2923f")),
        "cloth": Tones(("#2f2560", "#7458b8"), softness=1.3),
        "ribbon": Tones(("#8d2348", "#d8476e")),
        "gold": Tones(("#b7832a", "#ffd65a")),
        "iris": Tones(("#2d4f55",)),
        "white": Tones(("#fffaf0",)),
    },
    ink="#241a33",
    yaw=-12,
    pitch=4,
)

TOADSTOOL = SampleScene(
    _toadstool,
    {
        "cap": Tones(("#9c2340", "#d93940", "#f26650")),
        "white": Tones(("#fff8ee",)),
        "stem": Tones(("#c7a08f", "#fbeacb"), softness=1.3),
        "blush": Tones(("#f0a08c",)),
        "dark": Tones(("#3a2230",)),
        "grass": Tones(("#2f7a58", "#6cbf55")),
    },
    ink="#3a1f2c",
    yaw=-8,
    pitch=6,
)

DONUT = SampleScene(
    _doughnut,
    {
        "dough": Tones(("#a8663a", "#e3a55f"), softness=1.1),
        "icing": Tones(("#d0608f", "#f283b0", "#fcb2d0"), glossy=True),
        "lemon": Tones(("#ffe066",)),
        "sky": Tones(("#73bdf5",)),
        "white": Tones(("#fffaf5",)),
    },
    ink="#4a2032",
)

ROCKET = SampleScene(
    _rocket,
    {
        "hull": Tones(("#cbbcb6", "#e9ded2", "#fffaf0")),
        "red": Tones(("#8e1f3d", "#e2434b")),
        "brass": Tones(("#c98a2a", "#f8c146")),
        "glass": Tones(("#4fb8e6",)),
        "white": Tones(("#ffffff",)),
        "flame": Tones(("#ff7a30",)),
        "core": Tones(("#ffe97a",)),
    },
    ink="#1d2038",
    yaw=24,
    pitch=8,
    roll=-24,
)

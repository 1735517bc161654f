"""Things: house, cactus, lamp, hat and sword."""

from __future__ import annotations

import numpy as np

from toonkit.synthetic.model import Model, Part, Pattern, near, scattered, sectors, stripes
from toonkit.synthetic.primitives import (
    ball,
    both_sides,
    box,
    capsule,
    carved,
    ellipsoid,
    frustum,
    joined,
    placed,
    ring,
    tube,
)
from toonkit.synthetic.recipes.registry import recipe, turned_view


@recipe
def house(rng: np.random.Generator) -> Model:
    """Draw a house with a tree."""
    u = rng.uniform
    w, h, d = u(0.42, 0.56), u(0.3, 0.4), u(0.36, 0.46)
    steep = u(38, 50)
    run = w + 0.1
    rise = run * np.tan(np.deg2rad(steep))
    slope = np.hypot(run, rise) / 2
    slab = placed(
        box((0, 0, 0), (slope + 0.03, 0.045, d + 0.1), 0.015), (run / 2, h + rise / 2 - 0.02, 0), z=-steep
    )
    out = np.array([np.sin(np.deg2rad(steep)), np.cos(np.deg2rad(steep)), 0.0])
    above = placed(
        box((0, 0, 0), (2, 0.5, 2), 0.0), np.array([run / 2, h + rise / 2, 0]) + 0.5 * out, z=-steep
    )
    gable = carved(
        box((0, h + rise / 2 - 0.02, 0), (w, rise / 2 + 0.02, d - 0.002), 0.0), both_sides(above), fillet=0.0
    )
    tiles = Pattern("door", stripes((0, 1, 0), 0.14, 0.35)) if rng.random() < 0.4 else None
    windows = tuple(piece for x in (-0.58, 0.58) for piece in box((w * x, 0.05, d), (0.1, 0.11, 0.02), 0.005))
    frames = tuple(
        piece for x in (-0.58, 0.58) for piece in box((w * x, 0.05, d - 0.005), (0.13, 0.14, 0.015), 0.005)
    )
    side = placed(box((0, 0, 0), (0.13, 0.13, 0.02), 0.005), (w, 0.05, 0), y=90) + placed(
        box((0, 0, 0), (0.13, 0.13, 0.02), 0.005), (-w, 0.05, 0), y=90
    )
    tree_x = (w + u(0.35, 0.45)) * rng.choice([-1.0, 1.0])
    crown = joined(
        0.05, *(ball((tree_x + u(-0.12, 0.12), u(0.15, 0.5), u(-0.1, 0.15)), u(0.2, 0.28)) for _ in range(5))
    )
    bush = joined(
        0.05, *(ball((-tree_x * 0.75 + 0.18 * i, -h + 0.06, d + 0.12), u(0.11, 0.16)) for i in (-1, 0, 1))
    )
    door = box((0, -h * 0.45, d), (0.12, h * 0.55, 0.025), 0.01)
    parts = (
        Part(gable + box((0, 0, 0), (w, h, d), 0.0), "wall"),
        Part(both_sides(slab), "roof", (tiles,) if tiles else ()),
        Part(box((w * 0.5, h + rise * 0.75, -d * 0.3), (0.09, 0.26, 0.09), 0.01), "brick"),
        Part(windows + side, "glass"),
        Part(frames, "frame"),
        Part(door, "door"),
        Part(ball((0.07, -h * 0.5, d + 0.03), 0.025), "frame"),
        Part(frustum((tree_x, -h, 0), (tree_x, 0.3, 0), 0.07, 0.05), "door"),
        Part(crown + bush, "leaf"),
        Part(frustum((0, -h - 0.08, 0.05), (0, -h, 0.05), 1.05, 1.0, 0.02), "lawn"),
    )
    paints = {
        "wall": "pale",
        "roof": "red" if rng.random() < 0.5 else "deep",
        "brick": "gray",
        "glass": "blue",
    }
    return Model(
        parts,
        paints | {"frame": "white", "door": "wood", "leaf": "green", "lawn": "green"},
        turned_view(rng, 38, (8, 24)),
    )


@recipe
def cactus(rng: np.random.Generator) -> Model:
    """Draw a cactus in a pot."""
    u = rng.uniform
    r, top = u(0.2, 0.28), u(0.45, 0.7)
    trunk = capsule((0, -0.3, 0), (0, top, 0), r * 1.05, r)
    arm_y, other_y = u(0.0, 0.25), u(-0.1, 0.15)
    arm = tube(
        [
            (r * 0.5, arm_y, 0),
            (r + 0.2, arm_y + 0.02, 0.05),
            (r + 0.27, arm_y + 0.2, 0.05),
            (r + 0.27, arm_y + u(0.3, 0.45), 0.05),
        ],
        0.12,
    )
    other = tube(
        [(-r * 0.5, other_y, 0), (-r - 0.17, other_y + 0.02, 0.1), (-r - 0.22, other_y + u(0.25, 0.4), 0.1)],
        0.11,
    )
    ribs = Pattern("rib", sectors(int(rng.integers(9, 14)), 0.3))
    spines = Pattern("rib", near(scattered(rng, (0, 0.1, 0), (r, 0.6, r), 40, apart=0.13), 0.026))
    pot = frustum((0, -0.92, 0), (0, -0.4, 0), u(0.26, 0.32), u(0.38, 0.44), 0.02)
    rim = frustum((0, -0.48, 0), (0, -0.34, 0), 0.45, 0.46, 0.03)
    petals = tuple(
        piece
        for turn in range(6)
        for piece in placed(
            ellipsoid((0.1, 0.05, 0), (0.12, 0.04, 0.065)), (0, top + r - 0.03, 0), y=60 * turn, z=0
        )
    )
    band = Pattern("band", stripes((0, 1, 0), 0.9, u(0.1, 0.2), 0.62))
    zigzag = Pattern("band", sectors(14, 0.5))
    parts = [
        Part(joined(0.05, trunk, arm, other), "green", ((ribs,), (spines,), ())[rng.integers(3)]),
        Part(pot, "pot", ((band,), (zigzag,), ())[rng.integers(3)]),
        Part(rim, "pot"),
        Part(frustum((0, -0.4, 0), (0, -0.325, 0), 0.4, 0.4), "soil"),
        Part(petals, "petal"),
        Part(ball((0, top + r + 0.03, 0), 0.06), "heart"),
    ]
    if rng.random() < 0.5:
        parts.append(
            Part(
                tuple(p for x in (-0.75, 0.7, 0.95) for p in ellipsoid((x, -0.86, 0.1), (0.13, 0.09, 0.12))),
                "stone",
            )
        )
    paints = {
        "green": "green",
        "rib": "pale",
        "pot": "orange" if rng.random() < 0.5 else "any",
        "band": "white",
    }
    return Model(
        tuple(parts),
        paints | {"soil": "brown", "petal": "pink", "heart": "yellow", "stone": "gray"},
        turned_view(rng, 30, (4, 22)),
    )


@recipe
def lamp(rng: np.random.Generator) -> Model:
    """Draw a desk lamp on a stack of books."""
    u = rng.uniform
    elbow, head = np.array([u(-0.5, -0.3), u(0.1, 0.3), 0.0]), np.array([u(0.1, 0.3), u(0.6, 0.8), 0.1])
    arms = capsule((0, -0.45, 0), elbow, 0.035) + capsule(elbow, head, 0.035)
    joints = ball(elbow, 0.075) + ball(head, 0.075)
    aim = np.array([0.45, -0.65, 0.35])
    aim /= np.linalg.norm(aim)
    shade = carved(
        frustum(head - 0.05 * aim, head + 0.42 * aim, 0.1, u(0.3, 0.38), 0.02),
        frustum(head + 0.1 * aim, head + 0.46 * aim, 0.1, 0.34, 0.01),
    )
    books = [("first", -0.62, 0.5, 0.09, u(-12, 12)), ("second", -0.82, 0.56, 0.11, u(-12, 12))]
    parts = [
        Part(arms, "steel"),
        Part(joints, "dark"),
        Part(shade, "shade"),
        Part(ball(head + 0.3 * aim, 0.13), "bulb"),
        Part(
            frustum((0, -0.53, 0), (0, -0.44, 0), 0.26, 0.22, 0.03), "shade" if rng.random() < 0.5 else "dark"
        ),
    ]
    for name, y, wide, thick, turn in books:
        cover = carved(
            box((0, 0, 0), (wide, thick, 0.38), 0.015), box((0.06, 0, 0.06), (wide, thick - 0.03, 0.4), 0.005)
        )
        parts.append(Part(placed(cover, (0.05, y, 0), y=turn), name))
        parts.append(
            Part(
                placed(box((0.0, 0, 0), (wide - 0.03, thick - 0.03, 0.35), 0.005), (0.05, y, 0), y=turn),
                "paper",
            )
        )
    paints = {
        "steel": "gray",
        "dark": "black",
        "shade": "vivid",
        "bulb": "yellow",
        "first": "any",
        "second": "deep",
    }
    return Model(tuple(parts), paints | {"paper": "white"}, turned_view(rng, 30, (6, 22)))


@recipe
def hat(rng: np.random.Generator) -> Model:
    """Draw a tall hat with a feather."""
    u = rng.uniform
    low, high, top = u(0.36, 0.44), u(0.34, 0.5), u(0.45, 0.75)
    crown = carved(
        frustum((0, -0.3, 0), (0, top, 0), low, high, 0.05),
        ellipsoid((0, top + 0.08, 0), (high * 0.7, 0.14, high * 0.7)),
        fillet=0.08,
    )
    brim = joined(
        0.05,
        ellipsoid((0, -0.3, 0), (u(0.75, 0.95), 0.06, 0.75)),
        both_sides(ellipsoid((0.72, -0.24, 0), (0.14, 0.09, 0.5))),
    )
    wide = u(0.08, 0.14)
    band = frustum(
        (0, -0.28, 0), (0, -0.28 + 2 * wide, 0), low + 0.025, low + 0.025 + (high - low) * 0.25, 0.01
    )
    buckle = carved(
        box((0, -0.28 + wide, low + 0.03), (0.12, wide + 0.03, 0.03), 0.01),
        box((0, -0.28 + wide, low + 0.03), (0.07, wide - 0.03, 0.1), 0.005),
    )
    plume = tube(
        [(0.34, -0.1, 0.2), (0.55, 0.35, 0.2), (0.72, 0.72, 0.12), (0.66, 1.0, 0.05)],
        [0.03, 0.11, 0.13, 0.02],
    )
    quill = tube([(0.34, -0.14, 0.26), (0.55, 0.32, 0.32), (0.71, 0.68, 0.24)], 0.016)
    patch = Pattern("patch", near([(-low * 0.5, 0.3, 0.36)], 0.15))
    parts = (
        Part(crown, "felt", (patch,) if rng.random() < 0.5 else ()),
        Part(brim, "felt"),
        Part(band, "band", (Pattern("patch", sectors(18, 0.4)),) if rng.random() < 0.3 else ()),
        Part(buckle, "gold"),
        Part(
            plume,
            "feather",
            (Pattern("second", stripes((0.4, 1, 0), 0.25, 0.4)),) if rng.random() < 0.4 else (),
        ),
        Part(quill, "quill"),
    )
    paints = {
        "felt": "deep" if rng.random() < 0.7 else "black",
        "patch": "any",
        "band": "vivid",
        "gold": "yellow",
    }
    return Model(
        parts, paints | {"feather": "any", "second": "pale", "quill": "white"}, turned_view(rng, 25, (6, 24))
    )


@recipe
def sword(rng: np.random.Generator) -> Model:
    """Draw a shield with a sword behind it."""
    u = rng.uniform
    lean = u(25, 40)
    blade = joined(
        0.01,
        box((0, 0.55, 0), (0.09, 0.75, 0.025), 0.02),
        placed(box((0, 0, 0), (0.064, 0.064, 0.024), 0.01), (0, 1.3, 0), z=45),
    )
    guard = capsule((-0.26, -0.22, 0), (0.26, -0.22, 0), 0.06) + both_sides(ball((0.28, -0.22, 0), 0.08))
    grip = frustum((0, -0.56, 0), (0, -0.2, 0), 0.06, 0.055)
    pieces = [(blade, "steel"), (guard, "gold"), (grip, "leather"), (ball((0, -0.62, 0), 0.095), "gem")]
    wound = Pattern("dark", stripes((0.5, 1, 0), 0.1, 0.4))
    arms = [
        Part(placed(solid, (0.25, -0.55, -0.3), z=lean), name, (wound,) if name == "leather" else ())
        for solid, name in pieces
    ]
    r = u(0.55, 0.65)
    face = ellipsoid((0, 0, 0), (r, r * u(1.0, 1.2), 0.2))
    rim = placed(ring((0, 0, 0), r * 0.97, 0.07), (0, 0, 0.02), x=90)
    quarter = Pattern("second", lambda p: np.asarray(p[:, 0] * p[:, 1] > 0))
    cross = Pattern("second", lambda p: np.asarray(np.minimum(np.abs(p[:, 0]), np.abs(p[:, 1])) < 0.1))
    studs = tuple(
        piece
        for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False).tolist()
        for piece in ball((0.97 * r * np.cos(angle), 0.97 * r * np.sin(angle), 0.09), 0.04)
    )
    parts = (
        *arms,
        Part(face, "field", ((quarter,), (cross,), ())[rng.integers(3)]),
        Part(rim, "steel"),
        Part(studs, "gold"),
        Part(ball((0, 0, 0.18), u(0.12, 0.18)), "gold"),
    )
    paints = {
        "steel": "gray",
        "gold": "yellow",
        "leather": "brown",
        "dark": "black",
        "gem": "vivid",
        "field": "deep",
    }
    return Model(parts, paints | {"second": "any"}, turned_view(rng, 25, (-6, 10)))

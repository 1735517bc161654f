"""Characters: child, robot, wizard and astronaut. Heights and sizes as seen from the front."""

from __future__ import annotations

import numpy as np

from toonkit.synthetic.model import INK, Model, Part, Pattern, near, scattered, smile, stripes
from toonkit.synthetic.primitives import (
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
from toonkit.synthetic.recipes.registry import eyes, recipe, turned_view


@recipe
def child(rng: np.random.Generator) -> Model:
    """Draw a child with a large head."""
    u = rng.uniform
    wide, tall, lift = u(0.36, 0.44), u(0.34, 0.42), u(0.1, 0.5)
    head = joined(
        0.03, ellipsoid((0, 0.62, 0), (wide, tall, 0.38)), both_sides(ball((wide - 0.01, 0.56, 0), 0.08))
    )
    cap = carved(
        ellipsoid((0, 0.7, -0.05), (wide + 0.05, tall + 0.04, 0.42)),
        ellipsoid((0, 0.52, 0.36), (wide * 0.95, tall * 0.8, 0.3)),
        fillet=0.06,
    )
    style = rng.integers(4)
    bunches = both_sides(ellipsoid((wide + 0.12, u(0.55, 0.95), -0.05), (0.15, u(0.15, 0.3), 0.14)))
    bob = both_sides(ellipsoid((wide * 0.9, 0.48, -0.08), (0.13, 0.32, 0.24)))
    bun = ball((0, 0.62 + tall + 0.14, -0.1), 0.17)
    fringe = tuple(
        piece
        for x in np.linspace(-0.26, 0.26, 5)
        for piece in capsule((x * 0.8, 0.98, 0.2), (x * 1.15, u(0.72, 0.82), 0.35), 0.1, 0.03)
    )
    hair = joined(0.05, cap, (bunches, bob, bun, fringe)[style], fringe if rng.random() < 0.5 else ())
    skirt = rng.random() < 0.4
    shirt = lathe([(0.2, -0.2), (0.24, -0.05), (0.2, 0.15), (0.12, 0.3)], 0.08)
    elbow, hand = (0.36, -0.02 + 0.2 * lift, 0.05), (0.5 - 0.1 * lift, -0.22 + lift, 0.12)
    sleeve = both_sides(capsule((0.17, 0.17, 0), elbow, 0.085, 0.095))
    leg = both_sides(capsule((0.1, -0.2, 0), (0.12, -0.6, 0), 0.1, 0.085))
    lower = (
        frustum((0, -0.48, 0), (0, -0.12, 0), 0.34, 0.2, 0.03)
        if skirt
        else joined(0.05, leg, ball((0, -0.2, 0), 0.2))
    )
    cheeks = Pattern("cheeks", near([(wide * 0.62, 0.48, 0.3), (-wide * 0.62, 0.48, 0.3)], 0.11))
    mouth = Pattern(INK, smile((0, 0.43), u(0.1, 0.2), u(0.02, 0.06), 0.016))
    bands = Pattern("white", stripes((0, 1, 0), u(0.1, 0.18)))
    parts = [
        Part(head, "skin", (cheeks, mouth)),
        Part(hair, "hair"),
        *eyes(rng, (0.16, 0.6, 0.335), u(0.055, 0.08), plain=0.8),
        Part(joined(0.06, shirt, sleeve), "shirt", (bands,) if rng.random() < 0.4 else ()),
        Part(both_sides(capsule(elbow, hand, 0.06) + ball(hand, 0.075)), "skin"),
        Part(lower, "skirt" if skirt else "shirt" if rng.random() < 0.2 else "trousers"),
        Part(both_sides(ellipsoid((0.13, -0.7, 0.06), (0.11, 0.085, 0.17))), "shoes"),
    ]
    if skirt:
        parts.append(Part(leg, "skin"))
    paints = {
        "skin": "skin",
        "cheeks": "pink",
        "hair": "hair",
        "dark": "black",
        "white": "white",
        "shirt": "any",
    }
    paints |= {"trousers": "deep", "skirt": "any", "shoes": "brown"}
    return Model(tuple(parts), paints, turned_view(rng, 30, (0, 10)))


@recipe
def robot(rng: np.random.Generator) -> Model:
    """Draw a boxy robot."""
    u = rng.uniform
    w, h, d = u(0.32, 0.46), u(0.3, 0.42), u(0.22, 0.3)
    hw, hh = u(0.26, 0.4), u(0.2, 0.28)
    top = h + 0.08 + 2 * hh
    body = box((0, 0, 0), (w, h, d), u(0.02, 0.12))
    head = box((0, h + 0.08 + hh, 0), (hw, hh, u(0.22, 0.28)), u(0.03, 0.14))
    reach = (w + 0.28, u(-0.3, 0.3), u(0.05, 0.25))
    arms = both_sides(capsule((w, h * 0.6, 0), reach, 0.07))
    leg = both_sides(frustum((w * 0.5, -h - 0.4, 0), (w * 0.5, -h + 0.02, 0), 0.09, 0.09))
    feet = both_sides(box((w * 0.55, -h - 0.45, 0.06), (0.16, 0.08, 0.24), 0.05))
    joints = both_sides(ball((w + 0.02, h * 0.6, 0), 0.12)) + frustum(
        (0, h - 0.02, 0), (0, h + 0.12, 0), 0.12, 0.12
    )
    lamps = both_sides(
        placed(
            frustum((0, -0.04, 0), (0, 0.06, 0), 0.085, 0.075), (hw * 0.45, h + 0.1 + hh * 1.2, 0.26), x=90
        )
    )
    panel = box((0, u(-0.1, 0.1), d), (w * 0.6, h * 0.4, 0.03), 0.02)
    buttons = both_sides(ball((w * 0.3, 0, d + 0.03), 0.055)) + ball((0, 0, d + 0.03), 0.055)
    mouth = Pattern(INK, smile((0, h + 0.08 + hh * 0.55), hw * 0.9, 0.0, 0.02))
    parts = (
        Part(body, "shell"),
        Part(head, "shell" if rng.random() < 0.6 else "second", (mouth,) if rng.random() < 0.7 else ()),
        Part(arms + leg, "steel"),
        Part(both_sides(ball(reach, 0.12)) + feet, "second"),
        Part(joints, "dark"),
        Part(lamps, "glow"),
        Part(panel, "panel"),
        Part(buttons, "button"),
        Part(frustum((0, top - 0.04, 0), (0, top + 0.18, 0), 0.02, 0.02), "steel"),
        Part(ball((0, top + 0.22, 0), u(0.06, 0.1)), "button"),
    )
    paints = {
        "shell": "any",
        "second": "any",
        "steel": "gray",
        "dark": "black",
        "glow": "yellow",
        "panel": "pale",
    }
    return Model(parts, paints | {"button": "red"}, turned_view(rng, 35, (2, 16)))


@recipe
def wizard(rng: np.random.Generator) -> Model:
    """Draw a wizard with a staff."""
    u = rng.uniform
    lean, wide, reach = u(-0.25, 0.25), u(0.42, 0.56), u(-0.05, 0.2)
    robe = lathe([(wide, -0.8), (wide * 0.8, -0.5), (0.27, 0.0), (0.2, 0.25)], 0.12)
    hand = (0.52, reach, 0.2)
    sleeve = capsule((0.2, 0.15, 0.02), (0.44, reach - 0.02, 0.14), 0.11, 0.15)
    other = capsule((-0.2, 0.15, 0.02), (-0.36, -0.2, 0.26), 0.11, 0.15)
    hat = tube([(0, 0.68, 0), (lean * 0.4, 0.98, -0.02), (lean, 1.3, 0)], [0.28, 0.17, 0.02])
    brim = ellipsoid((0, 0.64, 0), (u(0.46, 0.6), 0.05, 0.48))
    band = placed(frustum((0, -0.05, 0), (0, 0.05, 0), 0.3, 0.285), (0, 0.72, 0))
    beard = joined(
        0.08,
        *(
            capsule((x, 0.36, 0.24), (x * 0.5, u(-0.2, 0.0), 0.34), 0.1, 0.03)
            for x in np.linspace(-0.18, 0.18, 4).tolist()
        ),
        ellipsoid((0, 0.3, 0.2), (0.26, 0.14, 0.14)),
    )
    stars = Pattern(
        "gold", near(scattered(rng, (0, -0.3, 0), (0.45, 0.5, 0.45), 26, apart=0.24), u(0.05, 0.075))
    )
    staff = tube(
        [(0.56, -0.8, 0.22), (0.54, 0.0, 0.22), (0.58, 0.62, 0.22), (0.5, 0.78, 0.22)],
        [0.035, 0.04, 0.04, 0.05],
    )
    parts = (
        Part(joined(0.05, robe, sleeve, other), "robe", (stars,) if rng.random() < 0.5 else ()),
        Part(joined(0.05, hat, brim), "robe" if rng.random() < 0.6 else "hat"),
        Part(band, "gold"),
        Part(joined(0.03, ball((0, 0.48, 0.04), 0.28), ball((0, 0.44, 0.33), 0.075)), "skin"),
        Part(beard, "white"),
        *eyes(rng, (0.1, 0.53, 0.285), 0.045, plain=1.0),
        Part(ball(hand, 0.09) + ball((-0.37, -0.24, 0.32), 0.09), "skin"),
        Part(staff, "wood"),
        Part(ball((0.56, 0.88, 0.22), u(0.1, 0.15)), "orb"),
    )
    paints = {"robe": "deep", "hat": "deep", "gold": "yellow", "skin": "skin", "dark": "black"}
    return Model(
        parts, paints | {"white": "white", "wood": "wood", "orb": "vivid"}, turned_view(rng, 25, (0, 10))
    )


@recipe
def astronaut(rng: np.random.Generator) -> Model:
    """Draw an astronaut with a flag."""
    u = rng.uniform
    r = u(0.38, 0.46)
    suit = joined(
        0.08,
        lathe([(0.28, -0.25), (0.32, 0.0), (0.22, 0.25)], 0.08),
        box((0, -0.2, 0), (0.28, 0.14, 0.2), 0.12),
    )
    hand = (0.56, u(-0.05, 0.3), 0.15)
    limbs = capsule((0.24, 0.14, 0), hand, 0.12, 0.11) + capsule(
        (-0.24, 0.14, 0), (-0.5, -0.15, 0.1), 0.12, 0.11
    )
    limbs += both_sides(capsule((0.16, -0.3, 0), (0.2, -0.68, 0.04), 0.14, 0.13))
    gloves = ball(hand, 0.13) + ball((-0.52, -0.2, 0.1), 0.13)
    boots = both_sides(
        capsule((0.2, -0.68, 0.02), (0.21, -0.78, 0.06), 0.15)
        + ellipsoid((0.21, -0.84, 0.12), (0.15, 0.1, 0.24))
    )
    rings = ring((0, 0.27, 0), 0.25, 0.06) + placed(ring((0, 0, 0), r * 0.72, 0.04), (0, 0.6, 0.27), x=90)
    pack = box((0, 0.02, -0.28), (0.32, 0.34, 0.14), 0.06)
    chest = box((0, 0.0, 0.3), (0.15, 0.1, 0.06), 0.02)
    lights = ball((-0.07, 0.02, 0.36), 0.035) + ball((0.07, 0.02, 0.36), 0.035)
    pole = frustum((hand[0], -0.9, hand[2] + 0.06), (hand[0], 1.0, hand[2] + 0.06), 0.022, 0.022)
    flag = box((hand[0] + 0.24, 0.82, hand[2] + 0.06), (0.23, 0.16, 0.015), 0.01)
    parts = (
        Part(suit, "suit"),
        Part(limbs, "suit"),
        Part(ball((0, 0.6, 0), r), "suit"),
        Part(ellipsoid((0, 0.6, 0.14), (r * 0.72, r * 0.68, r * 0.82)), "visor"),
        Part(rings, "trim"),
        Part(gloves + boots, "trim"),
        Part(pack, "pack"),
        Part(chest, "pack"),
        Part(lights, "flag"),
        Part(pole, "pole"),
        Part(flag, "flag", (Pattern("suit", stripes((0, 1, 0), 0.11, 0.4)),)),
    )
    paints = {
        "suit": "white",
        "visor": "deep",
        "trim": "vivid",
        "pack": "gray",
        "flag": "red",
        "pole": "black",
    }
    return Model(parts, paints, turned_view(rng, 28, (0, 12)))

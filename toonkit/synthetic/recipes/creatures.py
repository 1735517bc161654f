"""Creatures: bear, monster and penguin. Heights and sizes as seen from the front."""

from __future__ import annotations

import numpy as np

from toonkit.synthetic.model import INK, Model, Part, Pattern, below, near, oval, scattered, smile, stripes
from toonkit.synthetic.primitives import (
    ball,
    both_sides,
    capsule,
    ellipsoid,
    frustum,
    joined,
    ring,
    tube,
)
from toonkit.synthetic.recipes.registry import eyes, recipe, turned_view


@recipe
def bear(rng: np.random.Generator) -> Model:
    """Draw a sitting toy bear."""
    u = rng.uniform
    r = u(0.36, 0.44)
    head = joined(
        0.05,
        ellipsoid((0, 0.55, 0.04), (r, r * 0.9, 0.36)),
        both_sides(ball((r * 0.8, 0.86, 0), u(0.13, 0.18))),
    )
    body = ellipsoid((0, -0.1, 0), (u(0.34, 0.44), 0.42, 0.34))
    arm = both_sides(capsule((0.28, 0.12, 0.08), (u(0.42, 0.58), u(-0.2, 0.2), 0.24), 0.13, 0.15))
    leg = both_sides(capsule((0.24, -0.38, 0.1), (0.38, -0.5, 0.42), 0.17, 0.18))
    soles = both_sides(ellipsoid((0.4, -0.5, 0.56), (0.13, 0.14, 0.06)))
    belly = Pattern("muzzle", oval((0, -0.12), (u(0.2, 0.26), u(0.22, 0.3))))
    bow = both_sides(frustum((0.03, 0.22, 0.34), (0.22, 0.22, 0.36), 0.035, 0.12, 0.02)) + ball(
        (0, 0.22, 0.36), 0.06
    )
    mouth = Pattern(INK, smile((0, 0.39), 0.13, 0.03, 0.016))
    inner = both_sides(ellipsoid((r * 0.8, 0.87, 0.12), (0.09, 0.1, 0.06)))
    parts = (
        Part(head, "fur"),
        Part(body, "fur", (belly,)),
        Part(arm, "fur"),
        Part(leg, "fur"),
        Part(soles + inner, "muzzle"),
        Part(ellipsoid((0, 0.45, 0.35), (0.17, 0.13, 0.12)), "muzzle", (mouth,)),
        Part(ellipsoid((0, 0.52, 0.45), (0.07, 0.05, 0.05)), "dark"),
        *eyes(rng, (0.15, 0.62, 0.36), u(0.04, 0.06), plain=0.9),
        Part(bow, "bow", (Pattern("white", stripes((1, 1, 0), 0.08, 0.35)),) if rng.random() < 0.4 else ()),
    )
    paints = {
        "fur": "brown" if rng.random() < 0.6 else "any",
        "muzzle": "pale",
        "dark": "black",
        "white": "white",
    }
    return Model(parts, paints | {"bow": "vivid"}, turned_view(rng, 30, (0, 14)))


@recipe
def monster(rng: np.random.Generator) -> Model:
    """Draw a round monster with horns and one or two eyes."""
    u = rng.uniform
    w, h = u(0.5, 0.7), u(0.55, 0.75)
    body = joined(
        0.15, ellipsoid((0, 0, 0), (w, h, 0.5)), ellipsoid((0, -0.35 * h, 0), (w * 1.05, h * 0.6, 0.5))
    )
    arm = both_sides(
        tube(
            [(w * 0.85, 0.0, 0.1), (w + 0.2, u(-0.1, 0.1), 0.2), (w + 0.25, u(0.1, 0.4), 0.25)],
            [0.12, 0.1, 0.11],
        )
    )
    feet = both_sides(ellipsoid((0.28, -h * 0.95, 0.15), (0.2, 0.12, 0.26)))
    horn = both_sides(
        tube([(w * 0.4, h * 0.8, 0), (w * 0.62, h + 0.12, 0), (w * 0.6, h + 0.3, 0)], [0.13, 0.08, 0.01])
    )
    one_eyed = rng.random() < 0.5
    spots = near(scattered(rng, (0, 0, 0), (w, h, 0.5), 14, apart=0.38), u(0.09, 0.15))
    mouth = ellipsoid((0, -0.2, 0.42), (u(0.22, 0.34), u(0.1, 0.16), 0.12))
    teeth = tuple(
        piece
        for x in (-0.14, 0.0, 0.14)
        for piece in frustum((x, -0.2, 0.53), (x, -0.1, 0.53), 0.01, 0.05, 0.005)
    )
    pupil = Pattern("dark", near([(u(-0.08, 0.08), 0.24, 0.7)], 0.14))
    looking: tuple[Part, ...] = (Part(ball((0, 0.25, 0.42), u(0.2, 0.26)), "white", (pupil,)),)
    if not one_eyed:
        looking = eyes(rng, (0.22, 0.28, 0.42), u(0.13, 0.17), plain=0.0)
    parts = (
        Part(joined(0.08, body, arm), "skin", (Pattern("spots", spots),) if rng.random() < 0.7 else ()),
        Part(feet, "skin"),
        Part(horn, "horn", (Pattern("spots", stripes((0, 1, 0), 0.13, 0.4)),) if rng.random() < 0.4 else ()),
        *looking,
        Part(mouth, "mouth"),
        Part(teeth, "white"),
    )
    paints = {
        "skin": "vivid",
        "spots": "any",
        "horn": "pale",
        "white": "white",
        "dark": "black",
        "mouth": "deep",
    }
    return Model(parts, paints, turned_view(rng, 22, (-4, 12)))


@recipe
def penguin(rng: np.random.Generator) -> Model:
    """Draw a penguin with a scarf and perhaps a hat."""
    u = rng.uniform
    w, top = u(0.4, 0.5), u(0.5, 0.62)
    body = joined(
        0.15, ellipsoid((0, -0.15, 0), (w, 0.6, 0.4)), ellipsoid((0, top, 0.02), (0.34, 0.32, 0.32))
    )
    belly = Pattern("belly", oval((0, -0.25), (w * 0.72, 0.46)))
    face = Pattern("belly", near([(0.12, top - 0.02, 0.32), (-0.12, top - 0.02, 0.32)], 0.17))
    flipper = both_sides(capsule((w * 0.85, 0.2, 0), (w + u(0.05, 0.25), u(-0.35, 0.1), 0.08), 0.12, 0.05))
    scarf = joined(
        0.05, ring((0, 0.3, 0.02), 0.29, 0.09), capsule((0.16, 0.28, 0.3), (0.2, -0.06, 0.42), 0.09, 0.1)
    )
    beak = frustum((0, top - 0.08, 0.28), (0, top - 0.11, 0.5), 0.1, 0.02, 0.01)
    feet = both_sides(ellipsoid((0.18, -0.74, 0.16), (0.15, 0.06, 0.22)))
    parts = [
        Part(body, "back", (belly, face)),
        Part(flipper, "back"),
        Part(beak + feet, "beak"),
        *eyes(rng, (0.13, top + 0.04, 0.29), 0.05, plain=1.0),
        Part(
            scarf, "scarf", (Pattern("belly", stripes((1, 0.6, 0), 0.14, 0.4)),) if rng.random() < 0.5 else ()
        ),
    ]
    if rng.random() < 0.6:
        hat = joined(0.03, ellipsoid((0, top + 0.26, 0.02), (0.3, 0.22, 0.28)))
        parts += [
            Part(hat, "hat", (Pattern("scarf", below(top + 0.25)),)),
            Part(ball((0, top + 0.5, 0.02), 0.1), "belly"),
        ]
    paints = {
        "back": "black" if rng.random() < 0.5 else "deep",
        "belly": "white",
        "beak": "orange",
        "dark": "black",
    }
    if paints["back"] == "black":
        paints["dark"] = "deep"
    return Model(
        tuple(parts),
        paints | {"white": "pale", "scarf": "vivid", "hat": "any"},
        turned_view(rng, 30, (0, 10)),
    )

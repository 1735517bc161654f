"""Several things together: chess pieces, a bowl of fruit, breakfast, sweets and potions."""

from __future__ import annotations

import numpy as np

from toonkit.synthetic.model import Model, Part, Pattern, below, near, oval, scattered, sectors, stripes
from toonkit.synthetic.primitives import (
    Solid,
    ball,
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
from toonkit.synthetic.recipes.registry import recipe, turned_view


@recipe
def chess(rng: np.random.Generator) -> Model:
    """Draw a pawn and a rook on a piece of board."""
    u = rng.uniform
    pawn = joined(
        0.05,
        lathe([(0.3, 0.0), (0.3, 0.08), (0.2, 0.16), (0.1, 0.45)], 0.06),
        ellipsoid((0, 0.48, 0), (0.17, 0.05, 0.17)),
        ball((0, 0.66, 0), u(0.16, 0.2)),
    )
    tall = u(0.75, 0.95)
    notches = tuple(
        piece
        for turn in (30, 90, 150)
        for piece in placed(box((0, tall + 0.12, 0), (0.05, 0.1, 0.5), 0.005), y=turn)
    )
    tower = joined(0.05, lathe([(0.34, 0.0), (0.34, 0.1), (0.24, 0.18), (0.2, tall - 0.1)], 0.06))
    head = carved(
        frustum((0, tall - 0.12, 0), (0, tall + 0.12, 0), 0.26, 0.28, 0.02),
        frustum((0, tall, 0), (0, tall + 0.3, 0), 0.19, 0.19),
        notches,
    )
    felt = frustum((0, -0.03, 0), (0, 0.03, 0), 0.31, 0.31)
    first, second = (-u(0.3, 0.4), 0, u(0.1, 0.25)), (u(0.28, 0.4), 0, -u(0.05, 0.2))
    board = box((0, -0.1, 0), (0.85, 0.07, 0.6), 0.02)
    squares = Pattern(
        "black square",
        lambda p: np.asarray((np.floor(p[:, 0] / 0.34 + 10) + np.floor(p[:, 2] / 0.34 + 10)) % 2 == 0),
    )
    parts = (
        Part(board, "square", (squares,)),
        Part(placed(pawn, first), "light piece"),
        Part(placed(tower, second), "dark piece"),
        Part(placed(head, second), "dark piece"),
        Part(placed(ring((0, 0.14, 0), 0.26, 0.03), second), "gold"),
        Part(placed(felt, first) + placed(felt, second), "felt"),
    )
    paints = {"square": "pale", "black square": "brown", "light piece": "white", "dark piece": "black"}
    if rng.random() < 0.5:
        paints |= {"light piece": "any", "dark piece": "deep"}
    return Model(parts, paints | {"gold": "yellow", "felt": "green"}, turned_view(rng, 35, (10, 26)))


def _apple(rng: np.random.Generator, x: float, y: float, z: float, r: float) -> tuple[Solid, Solid, Solid]:
    """Return flesh, stem and leaf of an apple."""
    u = rng.uniform
    flesh = carved(ellipsoid((x, y, z), (r, r * 0.92, r)), ball((x, y + r * 1.02, z), r * 0.3), fillet=0.08)
    stem = tube([(x, y + r * 0.6, z), (x + 0.02, y + r, z), (x + 0.06, y + r * 1.25, z)], [0.02, 0.02, 0.028])
    leaf = placed(
        ellipsoid((0.11, 0, 0), (0.13, 0.065, 0.025)),
        (x + 0.03, y + r * 1.05, z),
        z=u(10, 50),
        y=u(-30, 30),
    )
    return flesh, stem, leaf


@recipe
def fruit(rng: np.random.Generator) -> Model:
    """Draw a bowl of fruit."""
    u = rng.uniform
    bowl = carved(
        ellipsoid((0, 0, 0), (0.8, u(0.5, 0.6), 0.62)),
        box((0, 0.6, 0), (1, 0.6, 1), 0.01),
        ellipsoid((0, 0.06, 0), (0.74, 0.46, 0.56)),
    )
    foot = frustum((0, -0.66, 0), (0, -0.46, 0), 0.3, 0.2, 0.02)
    red, red_stem, red_leaf = _apple(rng, -0.3, 0.2, 0.18, u(0.26, 0.31))
    green, green_stem, _ = _apple(rng, u(0.0, 0.1), 0.36, -0.22, u(0.26, 0.3))
    banana = tube(
        [(0.12, 0.1, 0.36), (0.48, 0.08, 0.34), (0.75, 0.26, 0.26), (0.86, 0.5, 0.2)],
        [0.05, 0.12, 0.12, 0.04],
    )
    grapes = tuple(
        piece
        for row, count in enumerate((3, 3, 2, 1))
        for i in range(count)
        for piece in ball(
            (
                -0.72 + 0.13 * (i + row / 2) + u(-0.02, 0.02),
                -0.02 - 0.13 * row,
                0.52 - 0.02 * row + u(-0.04, 0.04),
            ),
            0.085,
        )
    )
    rim = Pattern("stripe", lambda p: np.asarray(p[:, 1] > -0.12))
    dots = Pattern("stripe", near(scattered(rng, (0, 0, 0), (0.8, 0.55, 0.62), 30, apart=0.26), 0.07))
    tip = Pattern("wood", near([(0.87, 0.52, 0.2), (0.1, 0.1, 0.37)], 0.07))
    parts = (
        Part(bowl, "bowl", ((rim,), (dots,), ())[rng.integers(3)]),
        Part(foot, "bowl"),
        Part(red, "apple"),
        Part(green, "pear"),
        Part(ball((0.38, 0.24, 0.04), u(0.26, 0.3)), "orange"),
        Part(joined(0.04, banana), "banana", (tip,)),
        Part(red_stem + green_stem, "wood"),
        Part(red_leaf, "pear"),
        Part(grapes, "grape") if rng.random() < 0.7 else Part(red_leaf, "pear"),
    )
    paints = {
        "bowl": "pale" if rng.random() < 0.5 else "any",
        "stripe": "blue",
        "apple": "red",
        "pear": "green",
    }
    paints |= {"orange": "orange", "banana": "yellow", "wood": "brown", "grape": "purple"}
    return Model(parts, paints, turned_view(rng, 25, (10, 24)))


@recipe
def breakfast(rng: np.random.Generator) -> Model:
    """Draw a mug beside a doughnut on a plate."""
    u = rng.uniform
    r, tall = u(0.3, 0.36), u(0.6, 0.75)
    wall = carved(
        frustum((0, 0, 0), (0, tall, 0), r * u(0.8, 1.0), r, 0.03),
        frustum((0, tall - 0.1, 0), (0, tall + 0.2, 0), r - 0.05, r - 0.05, 0.01),
    )
    grip = tube(
        [
            (r * 0.9, tall * 0.8, 0),
            (r + 0.2, tall * 0.75, 0),
            (r + 0.22, tall * 0.4, 0),
            (r * 0.9, tall * 0.2, 0),
        ],
        0.05,
    )
    band = Pattern("band", stripes((0, 1, 0), tall * 2, u(0.1, 0.2), -0.1))
    mark = Pattern("band", oval((0.0, tall * 0.5), (0.14, 0.14)))
    away = (u(-0.62, -0.5), 0, 0)
    decor = ((_moved(band, away),), (_moved(mark, away),), ())[rng.integers(3)]
    dough = placed(ring((0, 0, 0), 0.24, 0.15), (0.45, 0.16, 0.2))
    icing = placed(ring((0, 0, 0), 0.24, 0.152), (0.45, 0.19, 0.2))
    drip = tuple(
        piece
        for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False).tolist()
        for piece in ball((0.45 + 0.33 * np.cos(angle), 0.17, 0.2 + 0.33 * np.sin(angle)), u(0.06, 0.09))
    )
    sprinkles: Solid = ()
    for _ in range(16):
        around, over = u(0, 2 * np.pi), u(0.35, 1.3)
        out = 0.24 + 0.15 * np.cos(over) * rng.choice([-1, 1])
        place = np.array(
            [0.45 + out * np.cos(around), 0.19 + 0.15 * np.sin(over), 0.2 + out * np.sin(around)]
        )
        along = np.array([-np.sin(around + 0.6), 0, np.cos(around + 0.6)]) * 0.03
        sprinkles += capsule(place - along, place + along, 0.018)
    parts = (
        Part(placed(joined(0.03, grip) + wall, away, y=u(-40, 40)), "mug", decor),
        Part(placed(frustum((0, tall - 0.16, 0), (0, tall - 0.07, 0), r - 0.04, r - 0.045), away), "coffee"),
        Part(dough, "dough"),
        Part(joined(0.05, icing, drip), "icing"),
        Part(sprinkles, "sprinkle"),
        Part(placed(frustum((0, -0.05, 0), (0, 0.03, 0), 0.34, 0.58, 0.02), (0.45, 0, 0.2)), "plate"),
    )
    paints = {"mug": "any", "band": "white", "coffee": "brown", "dough": "orange", "icing": "pink"}
    paints |= {"sprinkle": "blue", "plate": "white" if rng.random() < 0.5 else "pale"}
    return Model(parts, paints, turned_view(rng, 25, (12, 30)))


@recipe
def sweets(rng: np.random.Generator) -> Model:
    """Draw an ice-cream cone and a cupcake."""
    u = rng.uniform
    cone = frustum((0, -0.9, 0), (0, 0, 0), 0.02, 0.3, 0.01)
    waffle = Pattern(
        "crust",
        lambda p: np.asarray(
            (np.mod((p[:, 0] + p[:, 1]) / 0.15, 1) < 0.22) | (np.mod((p[:, 0] - p[:, 1]) / 0.15, 1) < 0.22)
        ),
    )
    r = u(0.28, 0.33)
    scoops = [joined(0.04, ball((0, 0.1, 0), r), ring((0, 0.02, 0), r * 0.85, 0.07))]
    places = [(0.0, 0.48)] if rng.random() < 0.5 else [(-0.18, 0.42), (0.2, 0.46)]
    scoops += [ball((x, y, 0.0), r * 0.85) for x, y in places]
    chips = Pattern("crust", near(scattered(rng, (0, 0.1, 0), (r, r, r), 18, apart=0.14), 0.035))
    top = max(y for _, y in places) + r * 0.85
    cup = (u(0.7, 0.85), -0.75, 0.15)
    paper = frustum((0, 0, 0), (0, 0.35, 0), 0.22, 0.3, 0.01)
    swirl = joined(
        0.05,
        *(
            placed(ring((0, 0, 0), 0.22 - 0.06 * i, 0.1 - 0.012 * i), (0, 0.4 + 0.13 * i, 0))
            for i in range(3)
        ),
        ball((0, 0.5, 0), 0.18),
        frustum((0, 0.6, 0), (0, 0.9, 0), 0.12, 0.0, 0.01),
    )
    berry = ball((0, 0.88, 0.03), 0.09)
    parts = [
        Part(cone, "wafer", (waffle,)),
        Part(scoops[0], "first", (chips,) if rng.random() < 0.5 else ()),
        *(Part(scoop, name) for scoop, name in zip(scoops[1:], ("second", "third"), strict=False)),
        Part(ball((places[0][0], places[0][1] + r * 0.85 + 0.03, 0.03), 0.1), "cherry"),
        Part(
            tube(
                [
                    (places[0][0], top, 0),
                    (places[0][0] + 0.05, top + 0.2, 0),
                    (places[0][0] + 0.16, top + 0.28, 0),
                ],
                0.018,
            ),
            "crust",
        ),
        Part(placed(paper, cup), "paper", (_moved(Pattern("first", sectors(16, 0.5)), cup),)),
        Part(placed(swirl, cup), "second" if rng.random() < 0.5 else "cream"),
        Part(placed(berry, cup), "cherry"),
    ]
    paints = {
        "wafer": "orange",
        "crust": "brown",
        "first": "pink",
        "second": "any",
        "third": "pale",
        "cherry": "red",
    }
    return Model(tuple(parts), paints | {"paper": "vivid", "cream": "white"}, turned_view(rng, 20, (0, 16)))


@recipe
def potions(rng: np.random.Generator) -> Model:
    """Draw two or three bottles."""
    u = rng.uniform
    parts: list[Part] = []
    for index, x in enumerate((-0.5, 0.45, 1.2)[: rng.integers(2, 4)]):
        r, neck, at = u(0.3, 0.38), u(0.09, 0.12), (x, 0.0, u(-0.1, 0.1))
        shape = rng.integers(3)
        if shape == 0:
            glass = joined(0.1, ball((0, 0, 0), r), frustum((0, r * 0.7, 0), (0, r + 0.32, 0), neck, neck))
        elif shape == 1:
            glass = joined(
                0.08,
                frustum((0, -r, 0), (0, r * 0.4, 0), r * 1.1, neck * 1.3, 0.05),
                frustum((0, r * 0.3, 0), (0, r + 0.3, 0), neck, neck),
            )
        else:
            glass = joined(
                0.08,
                box((0, 0, 0), (r * 0.75, r, r * 0.6), 0.06),
                frustum((0, r * 0.8, 0), (0, r + 0.28, 0), neck, neck),
            )
        lip = r + 0.3
        level = Pattern(f"liquid {index % 2}", below(u(-0.05, 0.12), 0.015))
        parts += [
            Part(placed(glass, at), "glass", (_moved(level, at),)),
            Part(placed(ring((0, lip - 0.02, 0), neck, 0.035), at), "glass"),
            Part(
                placed(frustum((0, lip - 0.02, 0), (0, lip + 0.14, 0), neck * 0.85, neck * 1.1, 0.02), at),
                "cork",
            ),
        ]
        if rng.random() < 0.6:
            tag = placed(
                box((0, 0, 0), (0.14, 0.1, 0.02), 0.01),
                (at[0] + 0.05, r * 0.2, at[2] + r * 0.98),
                z=u(-12, 12),
            )
            parts.append(Part(tag, "label"))
            parts.append(Part(placed(ring((0, r * 0.95, 0), neck + 0.03, 0.025), at), "string"))
    paints = {
        "glass": "pale",
        "liquid 0": "vivid",
        "liquid 1": "vivid",
        "cork": "wood",
        "label": "white",
        "string": "red",
    }
    return Model(tuple(parts), paints, turned_view(rng, 20, (0, 16)))


def _moved(pattern: Pattern, offset: tuple[float, float, float]) -> Pattern:
    """Return a pattern that was described about the origin, for a part that was moved."""
    return Pattern(pattern.material, lambda points: pattern.where(points - np.asarray(offset)))

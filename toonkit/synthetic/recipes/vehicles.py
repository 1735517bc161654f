"""Vehicles: rocket, hot-air balloon and car."""

from __future__ import annotations

import numpy as np

from toonkit.synthetic.model import Model, Part, Pattern, sectors, stripes
from toonkit.synthetic.primitives import (
    Solid,
    ball,
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
def rocket(rng: np.random.Generator) -> Model:
    """Draw a rocket in flight."""
    u = rng.uniform
    r, tip = u(0.27, 0.36), u(0.2, 0.45)
    body = carved(ellipsoid((0, 0, 0), (r, 0.95, r)), box((0, -1.1, 0), (1, 0.5, 1), 0.0), fillet=0.03)
    count = int(rng.integers(3, 5))
    fin = tube([(r * 0.7, -0.25, 0), (r + 0.18, -0.5, 0), (r + 0.22, -0.82, 0)], [0.1, 0.08, 0.04])
    fins = tuple(piece for turn in range(count) for piece in placed(fin, y=360 / count * turn + 20))
    height = u(-0.1, 0.1)
    frame = placed(ring((0, 0, 0), 0.14, 0.04), (0, height, r * 0.95), x=90)
    nozzle = frustum((0, -0.72, 0), (0, -0.58, 0), r * 0.55, r * 0.42)
    flame = joined(
        0.06,
        ball((0, -0.8, 0), r * 0.5),
        capsule((0, -0.8, 0), (u(-0.05, 0.05), u(-1.4, -1.15), 0), r * 0.42, 0.02),
    )
    core = capsule((0, -0.74, r * 0.3), (0, -1.0, r * 0.4), r * 0.28, 0.02)
    nose = Pattern("second", lambda p: np.asarray(p[:, 1] > tip))
    band = Pattern("second", stripes((0, 1, 0), 2.0, u(0.04, 0.07), u(0.1, 0.2)))
    parts = (
        Part(body, "hull", (nose, band) if rng.random() < 0.5 else (nose,)),
        Part(fins, "second" if rng.random() < 0.6 else "fin"),
        Part(frame, "steel"),
        Part(ellipsoid((0, height, r * 0.92), (0.13, 0.13, 0.07)), "glass"),
        Part(nozzle, "steel"),
        Part(flame, "flame"),
        Part(core, "core"),
    )
    paints = {
        "hull": "white" if rng.random() < 0.5 else "any",
        "second": "red" if rng.random() < 0.5 else "vivid",
    }
    paints |= {"fin": "deep", "steel": "gray", "glass": "blue", "flame": "orange", "core": "yellow"}
    view = turned_view(rng, 40, (0, 14))
    turn = np.deg2rad(u(-35, 35))
    roll = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return Model(parts, paints, roll @ view)


@recipe
def balloon(rng: np.random.Generator) -> Model:
    """Draw a hot-air balloon and a cloud."""
    u = rng.uniform
    r = u(0.6, 0.7)
    skin = joined(
        0.2, ellipsoid((0, 0.35, 0), (r, r, r)), frustum((0, -0.5, 0), (0, 0.0, 0), 0.16, r * 0.8, 0.02)
    )
    count = int(rng.integers(6, 13))
    panels = (
        Pattern("second", sectors(count, 0.5, u(0, 1))),
        Pattern("third", stripes((0, 1, 0), 3.0, 0.08, 0.4)),
    )
    basket = frustum((0, -1.0, 0), (0, -0.76, 0), 0.15, 0.19, 0.02)
    ropes = tuple(
        piece
        for turn in range(4)
        for piece in placed(capsule((0.17, -0.8, 0), (0.15, -0.5, 0), 0.014), y=90 * turn + 45)
    )
    weave = Pattern("rope", stripes((0, 1, 0), 0.09, 0.35))
    cloud = joined(
        0.08,
        *(
            ellipsoid((-0.85 + 0.25 * i, -0.55 + 0.05 * (i % 2), 0.1), (0.24, u(0.13, 0.2), 0.16))
            for i in range(3)
        ),
    )
    far = joined(
        0.08, *(ellipsoid((0.7 + 0.22 * i, u(-0.1, 0.0), -0.5), (0.24, u(0.13, 0.2), 0.16)) for i in range(3))
    )
    parts = (
        Part(skin, "skin", panels[: rng.integers(1, 3)]),
        Part(ring((0, -0.5, 0), 0.15, 0.035), "third"),
        Part(basket, "wood", (weave,)),
        Part(ring((0, -0.76, 0), 0.18, 0.035), "rope"),
        Part(ropes, "rope"),
        Part(cloud + (far if rng.random() < 0.6 else ()), "cloud"),
    )
    paints = {
        "skin": "vivid",
        "second": "any",
        "third": "deep",
        "wood": "wood",
        "rope": "brown",
        "cloud": "white",
    }
    return Model(parts, paints, turned_view(rng, 40, (-12, 8)))


@recipe
def car(rng: np.random.Generator) -> Model:
    """Draw a toy car."""
    u = rng.uniform
    long, cabin = u(0.75, 0.9), u(0.38, 0.5)
    body = joined(
        0.04, box((0, -0.12, 0), (long, 0.17, 0.36), 0.1), box((-0.05, 0.0, 0), (long * 0.9, 0.12, 0.33), 0.1)
    )
    back = u(-0.2, 0.05)
    roof = box((back, 0.24, 0), (cabin, 0.2, 0.31), 0.12)
    panes = tuple(
        piece
        for x in (-0.5, 0.5)
        for piece in box((back + x * cabin, 0.25, 0), (cabin * 0.38, 0.115, 0.325), 0.03)
    )
    shields = box((back, 0.24, 0), (cabin + 0.012, 0.11, 0.24), 0.03)
    wheels: Solid = ()
    hubs: Solid = ()
    r = u(0.19, 0.23)
    for x in (-0.56 * long, 0.58 * long):
        wheels += placed(frustum((0, -0.4, 0), (0, 0.4, 0), r, r, 0.04), (x, -0.3, 0), x=90)
        hubs += placed(frustum((0, -0.42, 0), (0, 0.42, 0), r * 0.5, r * 0.5, 0.02), (x, -0.3, 0), x=90)
    lamps = ball((long - 0.03, -0.06, 0.22), 0.085) + ball((long - 0.03, -0.06, -0.22), 0.085)
    bumpers = box((long, -0.24, 0), (0.06, 0.05, 0.34), 0.03) + box(
        (-long, -0.24, 0), (0.06, 0.05, 0.34), 0.03
    )
    stripe = Pattern("stripe", lambda p: np.asarray(np.abs(p[:, 1] + 0.1) < 0.035))
    parts = (
        Part(body, "paint", (stripe,) if rng.random() < 0.5 else ()),
        Part(roof, "paint" if rng.random() < 0.6 else "stripe"),
        Part(panes + shields, "glass"),
        Part(wheels, "tire"),
        Part(hubs, "steel"),
        Part(bumpers, "steel"),
        Part(lamps, "lamp"),
    )
    paints = {
        "paint": "vivid",
        "stripe": "white",
        "glass": "blue",
        "tire": "black",
        "steel": "gray",
        "lamp": "yellow",
    }
    return Model(parts, paints, turned_view(rng, 45, (6, 22)))

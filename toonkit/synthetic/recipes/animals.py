"""Animals: songbird, turtle, bee, snail and elephant."""

from __future__ import annotations

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.synthetic.model import INK, Model, Part, Pattern, near, scattered, smile, stripes
from toonkit.synthetic.primitives import (
    ball,
    both_sides,
    capsule,
    ellipsoid,
    frustum,
    joined,
    placed,
    ring,
    tube,
)
from toonkit.synthetic.recipes.registry import eyes, recipe, turned_view


@recipe
def songbird(rng: np.random.Generator) -> Model:
    """Draw a bird on a branch, which looks to the right."""
    u = rng.uniform
    fat = u(0.34, 0.44)
    body = joined(
        0.15,
        placed(ellipsoid((0, 0, 0), (0.52, fat, fat)), (0, 0, 0), z=u(15, 35)),
        ball((0.36, 0.36, 0.02), u(0.27, 0.32)),
    )
    breast = Pattern("breast", near([(0.5, -0.02, 0.1)], u(0.4, 0.5)))
    wing = placed(ellipsoid((0, 0, 0), (0.36, 0.2, 0.08)), (-0.12, 0.02, fat * 0.95), z=u(10, 40), y=-8)
    feathers = Pattern("feathers", stripes((1, 0.3, 0), 0.2, 0.5, 0.2))
    tail = joined(
        0.02, *(capsule((-0.4, -0.2, z), (-0.9, u(-0.4, -0.2), z), 0.1, 0.08) for z in (-0.06, 0.06))
    )
    beak = frustum((0.58, 0.38, 0.05), (0.82, 0.35, 0.06), 0.09, 0.01)
    legs = capsule((0.05, -0.3, 0.1), (0.06, -0.56, 0.12), 0.03) + capsule(
        (-0.12, -0.3, 0.1), (-0.1, -0.56, 0.12), 0.03
    )
    branch = tube(
        [(-0.95, -0.7, 0), (-0.3, -0.6, 0.08), (0.3, -0.62, 0.08), (0.95, u(-0.6, -0.45), 0)],
        [0.07, 0.075, 0.065, 0.04],
    )
    leaves = tuple(
        piece
        for x in (-0.75, 0.5, 0.8)
        for piece in placed(
            ellipsoid((0.14, 0, 0), (0.16, 0.09, 0.03)), (x, -0.5, 0.05), z=u(20, 80), y=u(-30, 30)
        )
    )
    crest = (
        tube([(0.3, 0.6, 0), (0.22, 0.76, 0), (0.08, 0.82, 0)], [0.07, 0.05, 0.01])
        if rng.random() < 0.5
        else ()
    )
    pupil = ellipsoid((0.46, 0.43, 0.26), (0.05, 0.055, 0.05))
    parts = (
        Part(joined(0.05, body, crest), "plumage", (breast,)),
        Part(wing, "wing", (feathers,) if rng.random() < 0.5 else ()),
        Part(tail, "wing"),
        Part(beak + legs, "beak"),
        Part(pupil, "dark", (Pattern("breast", near([(0.475, 0.455, 0.31)], 0.02)),)),
        Part(branch, "wood"),
        Part(leaves, "leaf"),
    )
    paints = {"plumage": "vivid", "breast": "pale", "wing": "any", "feathers": "deep", "beak": "orange"}
    paints |= {"dark": "black", "white": "white", "wood": "wood", "leaf": "green"}
    return Model(parts, paints, turned_view(rng, 22, (-4, 12)))


@recipe
def turtle(rng: np.random.Generator) -> Model:
    """Draw a turtle from the side."""
    u = rng.uniform
    high = u(0.36, 0.5)
    shell = ellipsoid((0, 0, 0), (0.62, high, 0.5))
    plates = Pattern(
        "plates", near(scattered(rng, (0, 0, 0), (0.62, high, 0.5), 22, apart=0.3), u(0.11, 0.14))
    )
    rim = placed(ring((0, 0, 0), 0.57, 0.08), (0, -0.08, 0))
    head = joined(
        0.08,
        capsule((0.5, -0.08, 0.05), (0.78, u(0.05, 0.3), 0.1), 0.12, 0.14),
        ball((0.84, 0.2, 0.12), u(0.17, 0.21)),
    )
    legs = joined(
        0.02,
        capsule((0.36, -0.12, 0.28), (0.42, -0.42, 0.36), 0.14, 0.13),
        capsule((-0.36, -0.12, 0.28), (-0.42, -0.42, 0.36), 0.14, 0.13),
        capsule((0.3, -0.12, -0.3), (0.34, -0.4, -0.3), 0.13),
        capsule((-0.3, -0.12, -0.3), (-0.34, -0.4, -0.3), 0.13),
    )
    tail = frustum((-0.55, -0.12, 0), (-0.82, -0.2, 0), 0.09, 0.01)
    mouth = Pattern(INK, smile((0.9, 0.12), 0.16, 0.03, 0.014))
    spots = Pattern("toes", near(scattered(rng, (0.84, 0.2, 0.12), (0.2, 0.2, 0.2), 5, apart=0.12), 0.035))
    parts = (
        Part(shell, "shell", (plates,)),
        Part(rim + ellipsoid((0, -0.12, 0), (0.58, 0.2, 0.47)), "rim"),
        Part(head, "skin", (mouth, spots) if rng.random() < 0.4 else (mouth,)),
        Part(legs, "skin"),
        Part(tail, "skin"),
        Part(ball((0.84, 0.28, 0.28), 0.06), "white", (Pattern("dark", near([(0.86, 0.28, 0.34)], 0.035)),)),
    )
    paints = {"shell": "any", "plates": "any", "rim": "pale", "skin": "green", "toes": "deep"}
    return Model(parts, paints | {"white": "white", "dark": "black"}, turned_view(rng, 25, (4, 18)))


@recipe
def bee(rng: np.random.Generator) -> Model:
    """Draw a flying bee."""
    u = rng.uniform
    length = u(0.5, 0.62)
    body = ellipsoid((-0.25, -0.05, 0), (length, 0.38, 0.36))
    bands = Pattern("dark", stripes((1, 0.15, 0), u(0.24, 0.34), 0.45))
    head = ball((0.4, 0.1, 0.06), u(0.28, 0.33))
    wing = placed(ellipsoid((0, 0.3, 0), (0.2, u(0.3, 0.4), 0.05)), (-0.15, 0.24, 0.1), z=u(0, 30), x=-10)
    second = placed(ellipsoid((0, 0.24, 0), (0.15, 0.27, 0.05)), (-0.3, 0.22, 0.16), z=u(35, 60), x=-5)
    feelers = tube([(0.46, 0.36, 0.1), (0.55, 0.55, 0.12), (0.68, 0.6, 0.14)], 0.025) + ball(
        (0.7, 0.6, 0.14), 0.05
    )
    feelers += tube([(0.36, 0.38, 0.02), (0.38, 0.58, 0.02), (0.48, 0.68, 0.02)], 0.025) + ball(
        (0.5, 0.68, 0.02), 0.05
    )
    sting = frustum((-0.25 - length, -0.06, 0), (-0.42 - length, -0.08, 0), 0.07, 0.005)
    look = Pattern("dark", near([(0.5, 0.16, 0.37), (0.66, 0.16, 0.22)], 0.06))
    cheek = Pattern("cheeks", near([(0.42, 0.02, 0.38)], 0.075))
    mouth = Pattern(INK, smile((0.56, 0.05), 0.12, 0.03, 0.015))
    feet = tuple(
        piece
        for x in (-0.4, -0.15, 0.1)
        for piece in capsule((x, -0.36, 0.1), (x + 0.04, -0.48, 0.14), 0.035)
    )
    parts = (
        Part(body, "coat", (bands,)),
        Part(head, "coat" if rng.random() < 0.5 else "face", (look, cheek, mouth)),
        Part(wing, "wing"),
        Part(second, "wing"),
        Part(feelers + feet, "dark"),
        Part(sting, "dark"),
    )
    paints = {"coat": "yellow", "dark": "black", "face": "orange", "cheeks": "pink", "wing": "pale"}
    return Model(parts, paints, turned_view(rng, 25, (-4, 14)))


@recipe
def snail(rng: np.random.Generator) -> Model:
    """Draw a snail with a striped shell, and a flower beside it."""
    u = rng.uniform
    r = u(0.4, 0.5)
    foot = tube(
        [(-0.75, -0.5, 0), (-0.2, -0.46, 0), (0.4, -0.44, 0.05), (0.68, -0.1, 0.08), (0.74, 0.1, 0.1)],
        [0.05, 0.15, 0.16, 0.14, 0.16],
    )
    shell = joined(
        0.06,
        placed(ring((0, 0, 0), r * 0.62, r * 0.42), (-0.12, 0.02, 0), x=90),
        ball((-0.12, 0.02, 0.0), r * 0.6),
    )
    twist = u(1.0, 2.0)

    def spiral(points: FloatArray) -> BoolArray:
        x, y = points[:, 0] + 0.12, points[:, 1] - 0.02
        return np.asarray(np.mod(np.arctan2(y, x) / (2 * np.pi) + twist * np.hypot(x, y) / r, 1.0) < 0.36)

    stalks = tube([(0.7, 0.2, 0.14), (0.74, 0.4, 0.18), (0.8, 0.5, 0.2)], 0.035) + tube(
        [(0.8, 0.18, 0.06), (0.9, 0.36, 0.06), (0.98, 0.44, 0.06)], 0.035
    )
    balls = ball((0.81, 0.53, 0.21), 0.075) + ball((1.0, 0.47, 0.07), 0.075)
    pupils = Pattern("dark", near([(0.84, 0.54, 0.28), (1.03, 0.48, 0.14)], 0.04))
    mouth = Pattern(INK, smile((0.82, 0.06), 0.12, 0.03, 0.014))
    flower = placed(
        tuple(
            piece
            for turn in range(5)
            for piece in placed(ellipsoid((0, 0.14, 0), (0.09, 0.12, 0.04)), z=72 * turn)
        ),
        (-0.86, u(0.2, 0.45), 0.1),
    )
    at = flower[0].center
    heart = ball((-0.86, float(np.mean([p.center[1] for p in flower])), 0.14), 0.075)
    stem = tube([(-0.9, -0.6, 0.05), (-0.94, -0.2, 0.05), (-0.86, float(at[1]) - 0.14, 0.05)], 0.03)
    leaf = placed(ellipsoid((0.14, 0, 0), (0.16, 0.07, 0.03)), (-0.9, -0.45, 0.06), z=40)
    parts = (
        Part(foot + stalks, "skin", (mouth,)),
        Part(shell, "shell", (Pattern("spiral", spiral),)),
        Part(balls, "white", (pupils,)),
        Part(flower, "petal"),
        Part(heart, "heart"),
        Part(stem + leaf, "leaf"),
    )
    paints = {
        "skin": "pale" if rng.random() < 0.5 else "skin",
        "shell": "any",
        "spiral": "deep",
        "white": "white",
    }
    paints |= {"dark": "black", "petal": "vivid", "heart": "yellow", "leaf": "green"}
    return Model(parts, paints, turned_view(rng, 18, (0, 14)))


@recipe
def elephant(rng: np.random.Generator) -> Model:
    """Draw a standing elephant with a blanket."""
    u = rng.uniform
    body = ellipsoid((-0.1, 0.05, -0.3), (u(0.42, 0.5), 0.42, 0.55))
    legs = both_sides(frustum((0.24, -0.62, -0.02), (0.22, -0.1, -0.05), 0.15, 0.14, 0.04))
    toes = Pattern(
        "nails", lambda points: np.asarray((points[:, 1] < -0.54) & (np.mod(points[:, 0] * 14, 1) < 0.6))
    )
    head = ellipsoid((0, 0.36, 0.2), (u(0.32, 0.37), 0.34, 0.3))
    swing = u(-0.25, 0.25)
    trunk = tube(
        [(0, 0.28, 0.44), (0, 0.04, 0.6), (swing, -0.2, 0.62), (swing * 1.8, u(-0.3, -0.1), 0.7)],
        [0.14, 0.11, 0.09, 0.075],
    )
    ear = placed(ellipsoid((0.24, 0, 0), (u(0.26, 0.34), 0.34, 0.06)), (0.26, 0.38, 0.12), y=20)
    inner = placed(ellipsoid((0.25, -0.01, 0.05), (0.19, 0.24, 0.04)), (0.26, 0.38, 0.12), y=20)
    tusk = both_sides(tube([(0.13, 0.2, 0.42), (0.17, 0.06, 0.54), (0.16, 0.02, 0.64)], [0.055, 0.05, 0.015]))
    blanket = ellipsoid((-0.1, 0.07, -0.3), (0.53, 0.44, 0.3))
    cap = ellipsoid((0, 0.62, 0.16), (0.22, 0.11, 0.2))
    wrinkles = Pattern(INK, stripes((0, 1, 0), 0.09, 0.1))
    tassel = Pattern("gold", stripes((1, 0, 0), 0.12, 0.3))
    parts = (
        Part(joined(0.08, body), "hide"),
        Part(legs, "hide", (toes,)),
        Part(
            joined(0.06, head, trunk),
            "hide",
            (Pattern(INK, lambda p: wrinkles.where(p) & (p[:, 2] > 0.55)),) if rng.random() < 0.4 else (),
        ),
        Part(both_sides(ear), "hide"),
        Part(both_sides(inner), "inner"),
        Part(tusk, "nails"),
        *eyes(rng, (0.17, 0.44, 0.45), 0.045, plain=0.9),
        Part(blanket, "cloth"),
        Part(cap, "cloth", (tassel,)),
    )
    paints = {
        "hide": "gray" if rng.random() < 0.6 else "any",
        "nails": "white",
        "inner": "pink",
        "dark": "black",
    }
    return Model(
        parts, paints | {"white": "pale", "cloth": "vivid", "gold": "yellow"}, turned_view(rng, 35, (0, 12))
    )

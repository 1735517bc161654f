"""The families of solids that the priors learn from."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toonkit.training.living import draw_creature, draw_figure, draw_insect
from toonkit.training.solids import (
    BOX,
    CAPSULE,
    CONE,
    ELLIPSOID,
    SHARP,
    TORUS,
    UNTURNED,
    Part,
    Solid,
    assemble,
    attach_part,
    draw_body_kind,
    draw_front_features,
    fit_size,
    flatten,
    frontal_view,
    random_primitive,
    random_rotation,
    random_tube,
    random_waves,
    turn_about,
    upright_view,
)


def random_solid(rng: np.random.Generator) -> Solid:
    """
    Draw a solid of one of the `FAMILIES`.

    Parameters
    ----------
    rng : Generator
        Source of every choice.

    Returns
    -------
    Solid
        With its view.
    """
    families, shares = zip(*FAMILIES, strict=True)
    family: Family = families[int(rng.choice(len(families), p=shares))]
    return family(rng)


def draw_ellipsoid(rng: np.random.Generator) -> Solid:
    """Draw an ellipsoid, often a sphere."""
    radii = np.ones(3) if rng.random() < 0.4 else rng.uniform(0.35, 1.0, 3)
    part = Part(ELLIPSOID, random_rotation(rng), np.zeros(3), np.append(radii, 0.0), 0.1)
    return assemble([part], view=random_rotation(rng))


def draw_primitives(rng: np.random.Generator) -> Solid:
    """Draw one primitive that is no ellipsoid, or two primitives."""
    parts = [random_primitive(rng, int(rng.integers(1, 5)), np.zeros(3), rng.uniform(0.6, 1.0))]
    if rng.random() < 0.5:
        parts.append(attach_part(rng, parts, rng.uniform(0.4, 0.9)))
    return assemble(parts, view=random_rotation(rng))


def draw_assembly(rng: np.random.Generator) -> Solid:
    """Draw a body with limbs, sometimes symmetric, carved, flat or wavy."""
    mirrored = bool(rng.random() < 0.45)
    parts = [random_primitive(rng, draw_body_kind(rng), np.zeros(3), rng.uniform(0.7, 1.0))]
    limbs = int(rng.integers(1, 6 if mirrored else 9))
    shrink = rng.uniform(0.35, 0.95)
    for _ in range(limbs):
        parts.append(attach_part(rng, parts, rng.uniform(0.6, 1.2) * shrink))
    if rng.random() < 0.4:  # features: eyes, buttons, dents
        parts += draw_front_features(rng, parts)
    if rng.random() < 0.2:
        parts = flatten(parts, rng.uniform(0.25, 0.6))
    view = frontal_view(rng) if mirrored and rng.random() < 0.6 else random_rotation(rng)
    return assemble(
        parts, view=view, mirrored=mirrored, waves=random_waves(rng) if rng.random() < 0.2 else None
    )


def draw_lathe_body(rng: np.random.Generator) -> Solid:
    """Draw a body of revolution, stacked along its axis; now and then with a handle, a spout or a stalk."""
    parts: list[Part] = []
    height, radius = 0.0, rng.uniform(0.4, 0.8)
    width = SHARP if rng.random() < 0.5 else rng.uniform(0.03, 0.4)
    for _ in range(int(rng.integers(2, 6))):
        kind = int(rng.choice([ELLIPSOID, CONE, TORUS, CAPSULE], p=[0.55, 0.25, 0.08, 0.12]))
        half = rng.uniform(0.15, 0.6)
        sizes = {
            ELLIPSOID: (radius, radius * rng.uniform(0.8, 1.1) if rng.random() < 0.4 else half, radius, 0.0),
            CONE: (half, radius, radius * rng.uniform(0.1, 1.2), 0.1 * half * rng.random()),
            TORUS: (0.8 * radius, radius * rng.uniform(0.1, 0.3), 0.0, 0.0),
            CAPSULE: (half, 0.7 * radius, 0.7 * radius * rng.uniform(0.5, 1.3), 0.0),
        }[kind]
        parts.append(Part(kind, UNTURNED, np.array([0.0, height, 0.0]), np.array(sizes), width))
        height += max(half, sizes[1] if kind == ELLIPSOID else 0.0) * rng.uniform(0.5, 1.25)
        radius = float(np.clip(radius * rng.uniform(0.45, 1.5), 0.12, 1.0))
    if rng.random() < 0.3:
        start = np.array([radius * rng.uniform(0.3, 0.9), height * rng.uniform(0.0, 1.0), 0.0])
        thickness = rng.uniform(0.05, 0.15)
        away = np.array([rng.uniform(-0.2, 1.0), rng.uniform(0.0, 1.0), 0.0])
        parts += random_tube(
            rng, start, away, rng.uniform(0.4, 1.2), thickness, thickness * 0.7, 0.04, bend=0.5
        )
    if rng.random() < 0.4:
        parts += draw_front_features(rng, parts)
    return assemble(fit_size(parts), view=upright_view(rng) if rng.random() < 0.75 else random_rotation(rng))


def draw_hand(rng: np.random.Generator) -> Solid:
    """Draw a slab from whose edge nearly parallel fingers grow."""
    palm = np.array([0.45, rng.uniform(0.35, 0.55), rng.uniform(0.12, 0.25), 0.1])
    parts = [Part(int(rng.choice([ELLIPSOID, BOX])), UNTURNED, np.zeros(3), palm, 0.1)]
    count = int(rng.integers(2, 6))
    spread, thickness = rng.uniform(0, 0.6), rng.uniform(0.07, 0.14)
    for place in (np.arange(count) - (count - 1) / 2) / max(count - 1, 1):
        root = np.array([0.75 * place, 0.35, 0.0])
        away = np.array([spread * place + rng.normal(0, 0.06), 1.0, rng.normal(0, 0.2)])
        length = rng.uniform(0.4, 0.9)
        parts += random_tube(rng, root, away, length, thickness, 0.8 * thickness, 0.05, pieces=3, bend=0.15)
    if rng.random() < 0.7:
        root, away = np.array([0.4, -0.1, 0.05]), np.array([1.0, 0.6, 0.3])
        parts += random_tube(rng, root, away, 0.5, 1.2 * thickness, 0.9 * thickness, 0.05, pieces=3, bend=0.2)
    return assemble(fit_size(parts), view=upright_view(rng) if rng.random() < 0.7 else random_rotation(rng))


def draw_tubes(rng: np.random.Generator) -> Solid:
    """Draw one or two winding tubes."""
    parts: list[Part] = []
    for _ in range(int(rng.integers(1, 3))):
        root, away, length = rng.normal(0, 0.3, 3), rng.normal(size=3), rng.uniform(2.0, 4.0)
        ends = rng.uniform(0.12, 0.3), rng.uniform(0.08, 0.3)
        parts += random_tube(rng, root, away, length, *ends, 0.1, pieces=int(rng.integers(6, 12)))
    return assemble(fit_size(parts), view=random_rotation(rng))


def draw_sheet(rng: np.random.Generator) -> Solid:
    """Draw a wavy slab seen from the front: its outline is an edge, and no surface turns away there."""
    half = np.array([rng.uniform(0.7, 1.0), rng.uniform(0.5, 1.0), rng.uniform(0.15, 0.4)])
    if rng.random() < 0.7:
        part = Part(BOX, UNTURNED, np.zeros(3), np.append(half, 0.02), SHARP)
    else:
        disc = np.array([half[2], half[0], half[0], 0.0])
        part = Part(CONE, turn_about(0, np.pi / 2), np.zeros(3), disc, SHARP)
    count = int(rng.integers(1, 5))
    if rng.random() < 0.6:
        along = rng.normal(size=(count, 3)) * [1.0, 1.0, 0.1]
    else:  # folds that run alike
        along = rng.normal(size=3) + rng.normal(0, 0.2, (count, 3))
    lengths = np.exp(rng.uniform(np.log(2.0), np.log(12.0), (count, 1)))
    steepness = rng.dirichlet(np.ones(count))[:, None] * rng.uniform(0.4, 2.0)
    heights = np.minimum(steepness / lengths, 0.8 * half[2])
    vectors = along / np.linalg.norm(along, axis=1, keepdims=True) * lengths
    waves = np.concatenate([vectors, rng.uniform(0, 2 * np.pi, (count, 1)), heights], axis=1)
    return assemble([part], view=frontal_view(rng), waves=waves)


def draw_machine(rng: np.random.Generator) -> Solid:
    """Draw boxes and cylinders set against each other squarely, with wheels, rims, holes and screws."""
    parts: list[Part] = []
    place = np.zeros(3)
    for _ in range(int(rng.integers(1, 4))):
        half = rng.uniform(0.2, 0.8, 3)
        if rng.random() < 0.7:
            sizes = np.append(half, half.min() * rng.choice([0.02, rng.uniform(0.05, 0.6)]))
            parts.append(Part(BOX, UNTURNED, place.copy(), sizes, SHARP))
        else:
            turn = turn_about(int(rng.choice([0, 2])), np.pi / 2 * rng.integers(0, 2))
            narrow = half[0] * rng.choice([1.0, rng.uniform(0.5, 1.0)])
            parts.append(Part(CONE, turn, place.copy(), np.array([half[1], half[0], narrow, 0.02]), SHARP))
        axis = int(rng.integers(3))
        place[axis] += rng.choice([-1.0, 1.0]) * half[axis] * rng.uniform(0.7, 1.2)
    if rng.random() < 0.5:
        parts += _draw_wheels(rng, parts[0])
    for _ in range(int(rng.integers(0, 5))):  # knobs, lamps, screws and holes on the front or the right
        _, _, center, sizes, _ = parts[0]
        axis = int(rng.choice([0, 2]))
        spot = center + rng.uniform(-0.7, 0.7, 3) * np.maximum(sizes[:3], 0.1)
        spot[axis] = center[axis] + max(sizes[axis], 0.1)
        radius = rng.uniform(0.05, 0.25)
        turn = turn_about(2, np.pi / 2) if axis == 0 else turn_about(0, np.pi / 2)
        hole = rng.random() < 0.35
        disc = np.array([rng.uniform(0.03, 0.15), radius, radius * rng.uniform(0.7, 1.0), 0.01])
        parts.append(Part(CONE, turn, spot, disc, -SHARP if hole else SHARP))
    return assemble(fit_size(parts), view=upright_view(rng), mirrored=bool(rng.random() < 0.5))


def _draw_wheels(rng: np.random.Generator, body: Part) -> list[Part]:
    """Draw wheels at the sides of a body, with hubs."""
    radius, tire = rng.uniform(0.15, 0.35), rng.uniform(0.05, 0.12)
    flank, below = max(body.sizes[0], 0.2), max(body.sizes[1], 0.2)
    turn = turn_about(2, np.pi / 2)
    parts = []
    for along in np.linspace(-0.8, 0.8, int(rng.integers(2, 4))) * max(body.sizes[2], 0.3):
        place = body.center + np.array([flank, -below, along])
        parts += [
            Part(TORUS, turn, place, np.array([radius, tire, 0.0, 0.0]), SHARP),
            Part(CONE, turn, place, np.array([0.6 * tire, 0.9 * radius, 0.9 * radius, 0.01]), SHARP),
        ]
    return parts


def draw_crowd(rng: np.random.Generator) -> Solid:
    """Draw several things that stand beside and in front of each other."""
    parts = []
    reach = rng.uniform(0.5, 1.1)
    for _ in range(int(rng.integers(2, 8))):
        kind = int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.4, 0.2, 0.15, 0.05, 0.2]))
        place = rng.uniform(-1.0, 1.0, 3) * [reach, 0.7 * reach, reach]
        part = random_primitive(rng, kind, place, rng.uniform(0.25, 0.7))
        parts.append(part._replace(width=SHARP, turn=part.turn if rng.random() < 0.5 else UNTURNED))
    return assemble(fit_size(parts), view=upright_view(rng))


Family = Callable[[np.random.Generator], Solid]

FAMILIES: tuple[tuple[Family, float], ...] = (
    (draw_ellipsoid, 0.05),
    (draw_primitives, 0.1),
    (draw_assembly, 0.2),
    (draw_lathe_body, 0.13),
    (draw_creature, 0.12),
    (draw_hand, 0.03),
    (draw_tubes, 0.04),
    (draw_sheet, 0.05),
    (draw_figure, 0.13),
    (draw_machine, 0.07),
    (draw_insect, 0.03),
    (draw_crowd, 0.05),
)
"""What solids are drawn from, and the share of each."""

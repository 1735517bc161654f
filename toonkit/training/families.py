"""The families of solids that the priors learn from."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

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
    assembled,
    attached_part,
    body_kind,
    fitted,
    flattened,
    front_features,
    frontal_view,
    limb,
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


def lone_ellipsoid(rng: np.random.Generator) -> Solid:
    """Draw an ellipsoid, often a sphere."""
    radii = np.ones(3) if rng.random() < 0.4 else rng.uniform(0.35, 1.0, 3)
    part = Part(ELLIPSOID, random_rotation(rng), np.zeros(3), np.append(radii, 0.0), 0.1)
    return assembled([part], view=random_rotation(rng))


def plain_solid(rng: np.random.Generator) -> Solid:
    """Draw one primitive that is no ellipsoid, or two primitives."""
    parts = [random_primitive(rng, int(rng.integers(1, 5)), np.zeros(3), rng.uniform(0.6, 1.0))]
    if rng.random() < 0.5:
        parts.append(attached_part(rng, parts, rng.uniform(0.4, 0.9)))
    return assembled(parts, view=random_rotation(rng))


def assembly(rng: np.random.Generator) -> Solid:
    """Draw a body with limbs, sometimes symmetric, carved, flat or wavy."""
    mirrored = bool(rng.random() < 0.45)
    parts = [random_primitive(rng, body_kind(rng), np.zeros(3), rng.uniform(0.7, 1.0))]
    limbs = int(rng.integers(1, 6 if mirrored else 9))
    shrink = rng.uniform(0.35, 0.95)
    for _ in range(limbs):
        parts.append(attached_part(rng, parts, rng.uniform(0.6, 1.2) * shrink))
    if rng.random() < 0.4:  # features: eyes, buttons, dents
        parts += front_features(rng, parts)
    if rng.random() < 0.2:
        parts = flattened(parts, rng.uniform(0.25, 0.6))
    view = frontal_view(rng) if mirrored and rng.random() < 0.6 else random_rotation(rng)
    return assembled(
        parts, view=view, mirrored=mirrored, waves=random_waves(rng) if rng.random() < 0.2 else None
    )


def turned_on_a_lathe(rng: np.random.Generator) -> Solid:
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
        parts += front_features(rng, parts)
    return assembled(fitted(parts), view=upright_view(rng) if rng.random() < 0.75 else random_rotation(rng))


def creature(rng: np.random.Generator) -> Solid:
    """Draw a body with a head and with a snout, ears, limbs and a tail where the dice say so."""
    width = SHARP if rng.random() < 0.25 else rng.uniform(0.03, 0.25)
    body = rng.uniform(0.4, 0.7, 3)
    head_size = rng.uniform(0.25, 0.55)
    head = np.array([0.0, body[1] * rng.uniform(0.8, 1.3), body[2] * rng.uniform(-0.2, 0.9)])
    parts = [
        Part(ELLIPSOID, turn_about(0, rng.normal(0, 0.4)), np.zeros(3), np.append(body, 0.0), width),
        Part(ELLIPSOID, UNTURNED, head, np.append(head_size * rng.uniform(0.8, 1.2, 3), 0.0), width),
    ]
    if rng.random() < 0.7:
        snout = np.append(head_size * rng.uniform(0.25, 0.6, 3), 0.0)
        place = head + head_size * np.array([0.0, -0.1, 0.85])
        parts.append(Part(ELLIPSOID, UNTURNED, place, snout, width / 2))
    if rng.random() < 0.75:
        root = head + head_size * np.array([rng.uniform(0.3, 0.8), rng.uniform(0.6, 1.0), 0.0])
        tip = root + np.array([rng.uniform(0, 0.3), rng.uniform(0.1, 0.7), rng.normal(0, 0.1)])
        parts.append(limb(root, tip, 0.25 * head_size, head_size * rng.uniform(0.1, 0.35), 0.4 * width))
    for _ in range(int(rng.integers(1, 4))):
        root = body * np.array([rng.uniform(0.4, 0.9), rng.uniform(-0.9, 0.6), rng.uniform(-0.6, 0.8)])
        away = np.array([rng.uniform(0, 0.6), rng.uniform(-1.0, 0.2), rng.normal(0, 0.4)])
        tip = root + away * rng.uniform(0.4, 0.9)
        parts.append(limb(root, tip, rng.uniform(0.1, 0.22), rng.uniform(0.08, 0.2), 0.6 * width))
    if rng.random() < 0.4:
        root = body * np.array([0.0, -0.2, -0.8])
        length = rng.uniform(0.4, 1.0)
        parts += random_tube(
            rng, root, np.array([0.05, 0.3, -1.0]), length, rng.uniform(0.06, 0.15), 0.05, 0.05
        )
    if rng.random() < 0.15:
        parts = flattened(parts, rng.uniform(0.3, 0.6))
    return assembled(fitted(parts), view=upright_view(rng), mirrored=True)


def fingered(rng: np.random.Generator) -> Solid:
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
    return assembled(fitted(parts), view=upright_view(rng) if rng.random() < 0.7 else random_rotation(rng))


def tubes(rng: np.random.Generator) -> Solid:
    """Draw one or two winding tubes."""
    parts: list[Part] = []
    for _ in range(int(rng.integers(1, 3))):
        root, away, length = rng.normal(0, 0.3, 3), rng.normal(size=3), rng.uniform(2.0, 4.0)
        ends = rng.uniform(0.12, 0.3), rng.uniform(0.08, 0.3)
        parts += random_tube(rng, root, away, length, *ends, 0.1, pieces=int(rng.integers(6, 12)))
    return assembled(fitted(parts), view=random_rotation(rng))


def sheet(rng: np.random.Generator) -> Solid:
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
    return assembled([part], view=frontal_view(rng), waves=waves)


def figure(rng: np.random.Generator) -> Solid:
    """Draw a standing figure: a head with hair, ears or a hat and a face, clothes, arms and legs."""
    width = SHARP if rng.random() < 0.6 else rng.uniform(0.02, 0.1)
    head = rng.uniform(0.3, 0.55)
    middle, chest = -0.9 * head - rng.uniform(0.2, 0.45), rng.uniform(0.2, 0.45)
    waist = np.array([chest * rng.uniform(0.7, 1.4), rng.uniform(0.3, 0.5), chest * rng.uniform(0.5, 0.9)])
    clothes = rng.random()
    if clothes < 0.4:
        trunk = Part(ELLIPSOID, UNTURNED, np.array([0.0, middle, 0.0]), np.append(waist, 0.0), width)
    elif clothes < 0.75:  # a dress or a coat
        cone = np.array([waist[1], waist[0] * rng.uniform(1.0, 1.6), waist[0] * rng.uniform(0.4, 0.9), 0.05])
        trunk = Part(CONE, UNTURNED, np.array([0.0, middle, 0.0]), cone, width)
    else:
        trunk = Part(BOX, UNTURNED, np.array([0.0, middle, 0.0]), np.append(waist, 0.6 * waist.min()), width)
    skull = np.append(head * rng.uniform(0.85, 1.15, 3), 0.0)
    parts = [
        trunk,
        Part(ELLIPSOID, UNTURNED, np.zeros(3), skull, width),
        *_hair(rng, head),
        *_face(rng, head),
    ]
    if rng.random() < 0.3:
        parts += _hat(rng, head)
    shoulder = np.array([0.8 * waist[0], middle + 0.6 * waist[1], 0.0])
    hand = shoulder + np.array([rng.uniform(0.1, 0.6), rng.uniform(-0.6, 0.4), rng.uniform(-0.1, 0.4)])
    thick = rng.uniform(0.07, 0.15)
    hip = np.array([0.45 * waist[0], middle - 0.7 * waist[1], 0.0])
    foot = hip + np.array([rng.uniform(0.0, 0.2), -rng.uniform(0.3, 0.8), rng.uniform(-0.1, 0.2)])
    shoe = np.array([1.1, 0.8, rng.uniform(1.2, 2.0), 0.0]) * thick
    parts += [
        limb(shoulder, hand, thick, thick * rng.uniform(0.6, 1.2), width),
        Part(
            ELLIPSOID, UNTURNED, hand, np.array([1.3, 1.3, 1.3, 0.0]) * thick * rng.uniform(0.8, 1.2), SHARP
        ),
        limb(hip, foot, 1.2 * thick, thick, width),
        Part(ELLIPSOID, UNTURNED, foot + np.array([0.0, 0.0, 0.5 * shoe[2]]), shoe, SHARP),
    ]
    if rng.random() < 0.3:  # a belt or a collar
        ring = np.array([waist[0] * rng.uniform(0.7, 1.0), 0.06, 0.0, 0.0])
        parts.append(Part(TORUS, UNTURNED, np.array([0.0, middle, 0.0]), ring, SHARP))
    return assembled(fitted(parts), view=upright_view(rng), mirrored=True)


def _hair(rng: np.random.Generator, head: float) -> list[Part]:
    """Draw hair on a head: a cap, clumps that hang or stand, or none."""
    parts = []
    if rng.random() < 0.7:
        cap = np.append(head * rng.uniform(1.02, 1.25, 3), 0.0)
        place = head * np.array([0.0, rng.uniform(0.1, 0.35), rng.uniform(-0.5, -0.15)])
        parts.append(Part(ELLIPSOID, UNTURNED, place, cap, SHARP))
    if rng.random() < 0.5:
        for _ in range(int(rng.integers(2, 6))):
            root = head * np.array([rng.uniform(0.0, 0.9), rng.uniform(0.2, 1.0), rng.uniform(-0.2, 0.6)])
            tip = root + head * np.array(
                [rng.uniform(-0.2, 0.6), rng.normal(-0.4, 0.6), rng.uniform(-0.2, 0.3)]
            )
            parts.append(limb(root, tip, head * rng.uniform(0.12, 0.3), 0.03, SHARP))
    if rng.random() < 0.3:
        root = head * np.array([0.9, 0.2, -0.2])
        away = np.array([0.5, -1.0, rng.normal(0, 0.2)])
        parts += random_tube(rng, root, away, rng.uniform(0.4, 1.0), 0.35 * head, 0.1 * head, 0.05, pieces=4)
    return parts


def _face(rng: np.random.Generator, head: float) -> list[Part]:
    """Draw eyes, ears and a nose, or some of them."""
    parts = []
    if rng.random() < 0.7:
        eye = head * np.array([rng.uniform(0.1, 0.3), rng.uniform(0.1, 0.35), 0.12, 0.0])
        parts.append(
            Part(ELLIPSOID, UNTURNED, head * np.array([rng.uniform(0.25, 0.45), 0.0, 0.9]), eye, SHARP)
        )
    if rng.random() < 0.5:
        ear = head * np.array([rng.uniform(0.15, 0.4), rng.uniform(0.2, 0.7), 0.12, 0.0])
        place = head * np.array([0.85, rng.uniform(-0.1, 0.9), 0.0])
        parts.append(Part(ELLIPSOID, turn_about(2, rng.normal(0, 0.5)), place, ear, SHARP))
    if rng.random() < 0.4:
        nose = head * np.append(rng.uniform(0.08, 0.3, 3), 0.0)
        parts.append(Part(ELLIPSOID, UNTURNED, head * np.array([0.0, -0.25, 1.0]), nose, 0.02))
    return parts


def _hat(rng: np.random.Generator, head: float) -> list[Part]:
    """Draw a hat with a brim."""
    tall, wide = head * rng.uniform(0.2, 0.9), head * rng.uniform(0.7, 1.05)
    crown = np.array([tall, wide, wide * rng.choice([0.05, rng.uniform(0.4, 1.0)]), 0.02])
    brim = np.array([0.04, wide * rng.uniform(1.1, 1.9), wide * 1.1, 0.02])
    top = head * rng.uniform(0.45, 0.75)
    return [
        Part(CONE, UNTURNED, np.array([0.0, top + tall, 0.0]), crown, SHARP),
        Part(CONE, UNTURNED, np.array([0.0, top, 0.0]), brim, SHARP),
    ]


def machine(rng: np.random.Generator) -> Solid:
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
        parts += _wheels(rng, parts[0])
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
    return assembled(fitted(parts), view=upright_view(rng), mirrored=bool(rng.random() < 0.5))


def _wheels(rng: np.random.Generator, body: Part) -> list[Part]:
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


def insect(rng: np.random.Generator) -> Solid:
    """Draw a body in segments with thin, jointed legs and feelers."""
    parts: list[Part] = []
    place, sizes = 0.0, rng.uniform(0.15, 0.4, int(rng.integers(2, 5)))
    for size in sizes:
        radii = size * np.array([rng.uniform(0.7, 1.2), rng.uniform(0.6, 1.0), rng.uniform(0.9, 1.5), 0.0])
        parts.append(Part(ELLIPSOID, UNTURNED, np.array([0.0, 0.0, place]), radii, SHARP))
        place += size * rng.uniform(1.2, 2.0)
    thick = rng.uniform(0.03, 0.08)
    for root in np.linspace(0.0, place * 0.7, int(rng.integers(2, 5))):
        knee = np.array([rng.uniform(0.4, 0.7), rng.uniform(0.1, 0.6), root + rng.normal(0, 0.2)])
        foot = knee + np.array([rng.uniform(0.0, 0.4), -rng.uniform(0.4, 0.9), rng.normal(0, 0.2)])
        parts += [
            limb(np.array([0.1, 0.0, root]), knee, thick, thick, SHARP),
            limb(knee, foot, thick, 0.6 * thick, SHARP),
        ]
    if rng.random() < 0.5:
        start, away = np.array([0.08, 0.1, place * 0.9]), np.array([0.4, 0.6, 0.7])
        parts += random_tube(rng, start, away, rng.uniform(0.4, 0.9), 0.03, 0.02, 0.01, pieces=3)
    view = turn_about(0, rng.uniform(0.0, 1.4)) @ turn_about(1, rng.uniform(-np.pi, np.pi))
    return assembled(fitted(parts), view=view, mirrored=True)


def crowd(rng: np.random.Generator) -> Solid:
    """Draw several things that stand beside and in front of each other."""
    parts = []
    reach = rng.uniform(0.5, 1.1)
    for _ in range(int(rng.integers(2, 8))):
        kind = int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.4, 0.2, 0.15, 0.05, 0.2]))
        place = rng.uniform(-1.0, 1.0, 3) * [reach, 0.7 * reach, reach]
        part = random_primitive(rng, kind, place, rng.uniform(0.25, 0.7))
        parts.append(part._replace(width=SHARP, turn=part.turn if rng.random() < 0.5 else UNTURNED))
    return assembled(fitted(parts), view=upright_view(rng))


Family = Callable[[np.random.Generator], Solid]

FAMILIES: tuple[tuple[Family, float], ...] = (
    (lone_ellipsoid, 0.05),
    (plain_solid, 0.1),
    (assembly, 0.2),
    (turned_on_a_lathe, 0.13),
    (creature, 0.12),
    (fingered, 0.03),
    (tubes, 0.04),
    (sheet, 0.05),
    (figure, 0.13),
    (machine, 0.07),
    (insect, 0.03),
    (crowd, 0.05),
)
"""What solids are drawn from, and the share of each."""

"""The families of solids that are alive: creatures, figures and insects."""

from __future__ import annotations

import numpy as np

from toonkit.training.solids import (
    BOX,
    CONE,
    ELLIPSOID,
    SHARP,
    TORUS,
    UNTURNED,
    Part,
    Solid,
    assemble,
    fit_size,
    flatten,
    limb,
    random_tube,
    turn_about,
    upright_view,
)


def draw_creature(rng: np.random.Generator) -> Solid:
    """Draw a body with a head and with a snout, ears, limbs and a tail, each at random."""
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
        parts = flatten(parts, rng.uniform(0.3, 0.6))
    return assemble(fit_size(parts), view=upright_view(rng), mirrored=True)


def draw_figure(rng: np.random.Generator) -> Solid:
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
        *_draw_hair(rng, head),
        *_draw_face(rng, head),
    ]
    if rng.random() < 0.3:
        parts += _draw_hat(rng, head)
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
    return assemble(fit_size(parts), view=upright_view(rng), mirrored=True)


def _draw_hair(rng: np.random.Generator, head: float) -> list[Part]:
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


def _draw_face(rng: np.random.Generator, head: float) -> list[Part]:
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


def _draw_hat(rng: np.random.Generator, head: float) -> list[Part]:
    """Draw a hat with a brim."""
    tall, wide = head * rng.uniform(0.2, 0.9), head * rng.uniform(0.7, 1.05)
    crown = np.array([tall, wide, wide * rng.choice([0.05, rng.uniform(0.4, 1.0)]), 0.02])
    brim = np.array([0.04, wide * rng.uniform(1.1, 1.9), wide * 1.1, 0.02])
    top = head * rng.uniform(0.45, 0.75)
    return [
        Part(CONE, UNTURNED, np.array([0.0, top + tall, 0.0]), crown, SHARP),
        Part(CONE, UNTURNED, np.array([0.0, top, 0.0]), brim, SHARP),
    ]


def draw_insect(rng: np.random.Generator) -> Solid:
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
    return assemble(fit_size(parts), view=view, mirrored=True)

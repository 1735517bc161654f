"""Random solids: smooth and creased unions of a few primitives, from which the priors learn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray

ELLIPSOID, BOX, CAPSULE, TORUS, CONE = range(5)
"""Kinds of primitives; each has four sizes, of which it uses some."""

REACH = 3.0
"""Half the width of the cube that every solid stays in."""

_UNTURNED = np.eye(3)
_SHARP = 0.01  # over which parts pass into each other where they meet in a crease
_FULL_SIZE = 1.6  # how far from the center the parts of a family that grows at random may reach


@dataclass(frozen=True, eq=False)
class Solid:
    """
    A union of primitives, some of them cut out instead.

    Attributes
    ----------
    kinds : ndarray of int, shape (n,)
        Which primitive.
    turns : ndarray, shape (n, 3, 3)
        Rotation of each, rows its own axes.
    centers : ndarray, shape (n, 3)
        Where each stands.
    sizes : ndarray, shape (n, 4)
        Ellipsoid: three radii. Box: three half sides, rounding. Capsule: half length, two radii. Torus: the radii
        of the ring and of the tube. Cone: half height, radii below and above, rounding.
    widths : ndarray, shape (n,)
        Width of the fillet where it meets those before it; a tiny one is a crease. Negative for a cut.
    mirrored : bool
        Whether the half at x < 0 is the mirror image of the other.
    waves : ndarray, shape (m, 5)
        Wave vector, phase and height of waves on the surface.
    view : ndarray, shape (3, 3)
        Rotation of the whole; its rows are the axes of the picture.
    """

    kinds: NDArray[np.int64]
    turns: FloatArray
    centers: FloatArray
    sizes: FloatArray
    widths: FloatArray
    mirrored: bool
    waves: FloatArray
    view: FloatArray


class Part(NamedTuple):
    """A primitive: see `Solid` for its fields."""

    kind: int
    turn: FloatArray
    center: FloatArray
    sizes: FloatArray
    width: float


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
    part = Part(ELLIPSOID, _rotation(rng), np.zeros(3), np.append(radii, 0.0), 0.1)
    return _assembled([part], view=_rotation(rng))


def plain_solid(rng: np.random.Generator) -> Solid:
    """Draw one primitive that is no ellipsoid, or two primitives."""
    parts = [_primitive(rng, int(rng.integers(1, 5)), np.zeros(3), rng.uniform(0.6, 1.0))]
    if rng.random() < 0.5:
        parts.append(_attached(rng, parts, rng.uniform(0.4, 0.9)))
    return _assembled(parts, view=_rotation(rng))


def assembly(rng: np.random.Generator) -> Solid:
    """Draw a body with limbs, sometimes symmetric, carved, flat or wavy."""
    mirrored = bool(rng.random() < 0.45)
    parts = [_primitive(rng, _body_kind(rng), np.zeros(3), rng.uniform(0.7, 1.0))]
    limbs = int(rng.integers(1, 6 if mirrored else 9))
    shrink = rng.uniform(0.35, 0.95)
    for _ in range(limbs):
        parts.append(_attached(rng, parts, rng.uniform(0.6, 1.2) * shrink))
    if rng.random() < 0.4:  # features: eyes, buttons, dents
        parts += _features(rng, parts)
    if rng.random() < 0.2:
        parts = _flattened(parts, rng.uniform(0.25, 0.6))
    view = _frontal_view(rng) if mirrored and rng.random() < 0.6 else _rotation(rng)
    return _assembled(parts, view=view, mirrored=mirrored, waves=_waves(rng) if rng.random() < 0.2 else None)


def turned_on_a_lathe(rng: np.random.Generator) -> Solid:
    """Draw a body of revolution, stacked along its axis; now and then with a handle, a spout or a stalk."""
    parts: list[Part] = []
    height, radius = 0.0, rng.uniform(0.4, 0.8)
    width = _SHARP if rng.random() < 0.5 else rng.uniform(0.03, 0.4)
    for _ in range(int(rng.integers(2, 6))):
        kind = int(rng.choice([ELLIPSOID, CONE, TORUS, CAPSULE], p=[0.55, 0.25, 0.08, 0.12]))
        half = rng.uniform(0.15, 0.6)
        sizes = {
            ELLIPSOID: (radius, radius * rng.uniform(0.8, 1.1) if rng.random() < 0.4 else half, radius, 0.0),
            CONE: (half, radius, radius * rng.uniform(0.1, 1.2), 0.1 * half * rng.random()),
            TORUS: (0.8 * radius, radius * rng.uniform(0.1, 0.3), 0.0, 0.0),
            CAPSULE: (half, 0.7 * radius, 0.7 * radius * rng.uniform(0.5, 1.3), 0.0),
        }[kind]
        parts.append(Part(kind, _UNTURNED, np.array([0.0, height, 0.0]), np.array(sizes), width))
        height += max(half, sizes[1] if kind == ELLIPSOID else 0.0) * rng.uniform(0.5, 1.25)
        radius = float(np.clip(radius * rng.uniform(0.45, 1.5), 0.12, 1.0))
    if rng.random() < 0.3:
        start = np.array([radius * rng.uniform(0.3, 0.9), height * rng.uniform(0.0, 1.0), 0.0])
        thickness = rng.uniform(0.05, 0.15)
        away = np.array([rng.uniform(-0.2, 1.0), rng.uniform(0.0, 1.0), 0.0])
        parts += _tube(rng, start, away, rng.uniform(0.4, 1.2), thickness, thickness * 0.7, 0.04, bend=0.5)
    if rng.random() < 0.4:
        parts += _features(rng, parts)
    return _assembled(_fitted(parts), view=_upright_view(rng) if rng.random() < 0.75 else _rotation(rng))


def creature(rng: np.random.Generator) -> Solid:
    """Draw a body with a head and with a snout, ears, limbs and a tail where the dice say so."""
    width = _SHARP if rng.random() < 0.25 else rng.uniform(0.03, 0.25)
    body = rng.uniform(0.4, 0.7, 3)
    head_size = rng.uniform(0.25, 0.55)
    head = np.array([0.0, body[1] * rng.uniform(0.8, 1.3), body[2] * rng.uniform(-0.2, 0.9)])
    parts = [
        Part(ELLIPSOID, _about(0, rng.normal(0, 0.4)), np.zeros(3), np.append(body, 0.0), width),
        Part(ELLIPSOID, _UNTURNED, head, np.append(head_size * rng.uniform(0.8, 1.2, 3), 0.0), width),
    ]
    if rng.random() < 0.7:
        snout = np.append(head_size * rng.uniform(0.25, 0.6, 3), 0.0)
        place = head + head_size * np.array([0.0, -0.1, 0.85])
        parts.append(Part(ELLIPSOID, _UNTURNED, place, snout, width / 2))
    if rng.random() < 0.75:
        root = head + head_size * np.array([rng.uniform(0.3, 0.8), rng.uniform(0.6, 1.0), 0.0])
        tip = root + np.array([rng.uniform(0, 0.3), rng.uniform(0.1, 0.7), rng.normal(0, 0.1)])
        parts.append(_limb(root, tip, 0.25 * head_size, head_size * rng.uniform(0.1, 0.35), 0.4 * width))
    for _ in range(int(rng.integers(1, 4))):
        root = body * np.array([rng.uniform(0.4, 0.9), rng.uniform(-0.9, 0.6), rng.uniform(-0.6, 0.8)])
        away = np.array([rng.uniform(0, 0.6), rng.uniform(-1.0, 0.2), rng.normal(0, 0.4)])
        tip = root + away * rng.uniform(0.4, 0.9)
        parts.append(_limb(root, tip, rng.uniform(0.1, 0.22), rng.uniform(0.08, 0.2), 0.6 * width))
    if rng.random() < 0.4:
        root = body * np.array([0.0, -0.2, -0.8])
        length = rng.uniform(0.4, 1.0)
        parts += _tube(rng, root, np.array([0.05, 0.3, -1.0]), length, rng.uniform(0.06, 0.15), 0.05, 0.05)
    if rng.random() < 0.15:
        parts = _flattened(parts, rng.uniform(0.3, 0.6))
    return _assembled(_fitted(parts), view=_upright_view(rng), mirrored=True)


def fingered(rng: np.random.Generator) -> Solid:
    """Draw a slab from whose edge nearly parallel fingers grow."""
    palm = np.array([0.45, rng.uniform(0.35, 0.55), rng.uniform(0.12, 0.25), 0.1])
    parts = [Part(int(rng.choice([ELLIPSOID, BOX])), _UNTURNED, np.zeros(3), palm, 0.1)]
    count = int(rng.integers(2, 6))
    spread, thickness = rng.uniform(0, 0.6), rng.uniform(0.07, 0.14)
    for place in (np.arange(count) - (count - 1) / 2) / max(count - 1, 1):
        root = np.array([0.75 * place, 0.35, 0.0])
        away = np.array([spread * place + rng.normal(0, 0.06), 1.0, rng.normal(0, 0.2)])
        length = rng.uniform(0.4, 0.9)
        parts += _tube(rng, root, away, length, thickness, 0.8 * thickness, 0.05, pieces=3, bend=0.15)
    if rng.random() < 0.7:
        root, away = np.array([0.4, -0.1, 0.05]), np.array([1.0, 0.6, 0.3])
        parts += _tube(rng, root, away, 0.5, 1.2 * thickness, 0.9 * thickness, 0.05, pieces=3, bend=0.2)
    return _assembled(_fitted(parts), view=_upright_view(rng) if rng.random() < 0.7 else _rotation(rng))


def tubes(rng: np.random.Generator) -> Solid:
    """Draw one or two winding tubes."""
    parts: list[Part] = []
    for _ in range(int(rng.integers(1, 3))):
        root, away, length = rng.normal(0, 0.3, 3), rng.normal(size=3), rng.uniform(2.0, 4.0)
        ends = rng.uniform(0.12, 0.3), rng.uniform(0.08, 0.3)
        parts += _tube(rng, root, away, length, *ends, 0.1, pieces=int(rng.integers(6, 12)))
    return _assembled(_fitted(parts), view=_rotation(rng))


def sheet(rng: np.random.Generator) -> Solid:
    """Draw a wavy slab seen from the front: its outline is an edge, and no surface turns away there."""
    half = np.array([rng.uniform(0.7, 1.0), rng.uniform(0.5, 1.0), rng.uniform(0.15, 0.4)])
    if rng.random() < 0.7:
        part = Part(BOX, _UNTURNED, np.zeros(3), np.append(half, 0.02), _SHARP)
    else:
        disc = np.array([half[2], half[0], half[0], 0.0])
        part = Part(CONE, _about(0, np.pi / 2), np.zeros(3), disc, _SHARP)
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
    return _assembled([part], view=_frontal_view(rng), waves=waves)


Family = Callable[[np.random.Generator], Solid]

FAMILIES: tuple[tuple[Family, float], ...] = (
    (lone_ellipsoid, 0.06),
    (plain_solid, 0.14),
    (assembly, 0.3),
    (turned_on_a_lathe, 0.2),
    (creature, 0.14),
    (fingered, 0.05),
    (tubes, 0.05),
    (sheet, 0.06),
)
"""What solids are drawn from, and the share of each."""


def _body_kind(rng: np.random.Generator) -> int:
    return int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.5, 0.12, 0.15, 0.05, 0.18]))


def _primitive(rng: np.random.Generator, kind: int, center: FloatArray, scale: float) -> Part:
    if kind == ELLIPSOID:
        sizes = [*(scale * rng.uniform(0.45, 1.0, 3)), 0.0]
    elif kind == BOX:
        half = scale * rng.uniform(0.35, 0.9, 3)
        sizes = [*half, half.min() * (rng.uniform(0.0, 0.9) if rng.random() < 0.6 else 0.02)]
    elif kind == CAPSULE:
        first = scale * rng.uniform(0.2, 0.55)
        sizes = [scale * rng.uniform(0.4, 1.0), first, first * rng.uniform(0.4, 1.3), 0.0]
    elif kind == TORUS:
        ring = scale * rng.uniform(0.5, 0.8)
        sizes = [ring, ring * rng.uniform(0.2, 0.6), 0.0, 0.0]
    else:
        below = scale * rng.uniform(0.35, 0.8)
        above = below * rng.choice([0.0, rng.uniform(0.0, 1.0), 1.0])
        sizes = [
            scale * rng.uniform(0.3, 0.9),
            below,
            above,
            scale * 0.2 * rng.random() * (rng.random() < 0.5),
        ]
    width = _SHARP if rng.random() < 0.4 else scale * rng.uniform(0.02, 0.4)
    return Part(kind, _rotation(rng), center, np.asarray(sizes, dtype=np.float64), float(width))


def _attached(rng: np.random.Generator, parts: list[Part], scale: float, *, front: bool = False) -> Part:
    """Draw a part whose center lies near the surface of one that is there."""
    _, turn, center, sizes, _ = parts[int(rng.integers(len(parts)))]
    direction = rng.normal(size=3)
    if front:
        direction[2] = abs(direction[2]) + 0.5
    direction /= np.linalg.norm(direction)
    local = turn @ direction
    extent = np.maximum(sizes[:3], 0.15)
    place = center + turn.T @ (local * extent) * rng.uniform(0.6, 1.05)
    kind = int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.45, 0.1, 0.3, 0.03, 0.12]))
    return _primitive(rng, kind, place, scale)


def _features(rng: np.random.Generator, parts: list[Part]) -> list[Part]:
    """Draw small parts on the front of others, a quarter of them cut out."""
    features = []
    scale = rng.uniform(0.08, 0.25)
    for _ in range(int(rng.integers(2, 8))):
        feature = _attached(rng, parts, scale * rng.uniform(0.6, 1.5), front=True)
        features.append(feature._replace(width=-feature.width) if rng.random() < 0.25 else feature)
    return features


def _limb(root: FloatArray, tip: FloatArray, thick: float, thin: float, width: float) -> Part:
    """Return a capsule from one place to another."""
    along = tip - root
    length = float(np.linalg.norm(along))
    sizes = np.array([length / 2, thick, thin, 0.0])
    return Part(CAPSULE, _up_along(along / length), (root + tip) / 2, sizes, width)


def _tube(
    rng: np.random.Generator,
    root: FloatArray,
    away: FloatArray,
    length: float,
    thick: float,
    thin: float,
    width: float,
    *,
    pieces: int = 5,
    bend: float = 0.5,
) -> list[Part]:
    """Draw a chain of capsules that bends in one plane, its way of bending changing now and then."""
    parts = []
    away = away / np.linalg.norm(away)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    angle = bend * rng.normal()
    radii = np.linspace(thick, thin, pieces + 1)
    for first, last in pairwise(radii):
        away = (
            np.cos(angle) * away
            + np.sin(angle) * np.cross(axis, away)
            + (1 - np.cos(angle)) * (axis @ away) * axis
        )
        tip = root + away * length / pieces
        parts.append(_limb(root, tip, first, last, width))
        root = tip
        if rng.random() < 0.3:
            angle = bend * rng.normal()
    return parts


def _flattened(parts: list[Part], share: float) -> list[Part]:
    """Press parts flat along z, ellipsoids with them."""
    flat = [part._replace(center=part.center * [1.0, 1.0, share]) for part in parts]
    return [
        part._replace(sizes=part.sizes * [1.0, 1.0, share, 1.0], turn=_UNTURNED)
        if part.kind == ELLIPSOID
        else part
        for part in flat
    ]


def _fitted(parts: list[Part]) -> list[Part]:
    """Center parts and shrink them to the size of the other families."""
    low, high = (
        function([part.center + sign * part.sizes[:3].max() for part in parts], axis=0)
        for function, sign in ((np.min, -1), (np.max, 1))
    )
    middle = (low + high) / 2 * np.array([0.0, 1.0, 1.0])  # x = 0 may be a mirror
    scale = min(1.0, _FULL_SIZE / float(np.max(high - middle)))
    return [
        Part(part.kind, part.turn, (part.center - middle) * scale, part.sizes * scale, part.width * scale)
        for part in parts
    ]


def _waves(rng: np.random.Generator) -> FloatArray:
    count = int(rng.integers(1, 4))
    vectors = rng.normal(size=(count, 3)) * rng.uniform(2.0, 7.0)
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    heights = 2 * rng.uniform(0.02, 0.12, (count, 1)) / np.maximum(lengths, 2.0)
    return np.concatenate([vectors, rng.uniform(0, 2 * np.pi, (count, 1)), heights], axis=1)


def _assembled(
    parts: list[Part], *, view: FloatArray, mirrored: bool = False, waves: FloatArray | None = None
) -> Solid:
    kinds, turns, centers, sizes, widths = zip(*parts, strict=True)
    return Solid(
        kinds=np.asarray(kinds, dtype=np.int64),
        turns=np.asarray(turns, dtype=np.float64),
        centers=np.asarray(centers, dtype=np.float64),
        sizes=np.asarray(sizes, dtype=np.float64),
        widths=np.asarray(widths, dtype=np.float64),
        mirrored=mirrored,
        waves=np.zeros((0, 5)) if waves is None else waves,
        view=view,
    )


def _frontal_view(rng: np.random.Generator) -> FloatArray:
    """Draw a view from somewhere before the solid, as drawings mostly have it."""
    return _about(2, rng.normal(0, 0.25)) @ _about(0, rng.normal(0, 0.3)) @ _about(1, rng.normal(0, 0.6))


def _upright_view(rng: np.random.Generator) -> FloatArray:
    """Draw a view from anywhere around the solid, a little from above or below."""
    turned = rng.normal(0, 0.8) if rng.random() < 0.7 else rng.uniform(-np.pi, np.pi)
    return _about(2, rng.normal(0, 0.2)) @ _about(0, rng.normal(0.1, 0.35)) @ _about(1, turned)


def _up_along(direction: FloatArray) -> FloatArray:
    """Return a rotation whose second row, a part's own y, is a unit vector."""
    beside = np.cross(direction, [0.0, 0.0, 1.0] if abs(direction[2]) < 0.9 else [1.0, 0.0, 0.0])
    beside /= np.linalg.norm(beside)
    return np.stack([beside, direction, np.cross(beside, direction)])


def _rotation(rng: np.random.Generator) -> FloatArray:
    """Draw a rotation: anyhow, or about one axis only, as upright things stand."""
    if rng.random() < 0.3:
        return _about(int(rng.integers(3)), rng.uniform(-np.pi, np.pi))
    turn, upper = np.linalg.qr(rng.normal(size=(3, 3)))
    turn = turn * np.sign(np.diag(upper))
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def _about(axis: int, angle: float) -> FloatArray:
    turn = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[first, second], turn[second, first] = -np.sin(angle), np.sin(angle)
    return turn

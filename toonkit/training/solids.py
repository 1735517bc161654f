"""Random solids: smooth and creased unions of a few primitives, from which the priors learn."""

from __future__ import annotations

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

UNTURNED = np.eye(3)
SHARP = 0.01  # over which parts pass into each other where they meet in a crease
FULL_SIZE = 1.6  # how far from the center the parts of a family that grows at random may reach


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


def draw_body_kind(rng: np.random.Generator) -> int:
    """Draw the kind of primitive that a body is."""
    return int(rng.choice([ELLIPSOID, BOX, CAPSULE, TORUS, CONE], p=[0.5, 0.12, 0.15, 0.05, 0.18]))


def random_primitive(rng: np.random.Generator, kind: int, center: FloatArray, scale: float) -> Part:
    """Draw a primitive of some kind and of about some size."""
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
    width = SHARP if rng.random() < 0.4 else scale * rng.uniform(0.02, 0.4)
    return Part(kind, random_rotation(rng), center, np.asarray(sizes, dtype=np.float64), float(width))


def attach_part(rng: np.random.Generator, parts: list[Part], scale: float, *, front: bool = False) -> Part:
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
    return random_primitive(rng, kind, place, scale)


def draw_front_features(rng: np.random.Generator, parts: list[Part]) -> list[Part]:
    """Draw small parts on the front of others, a quarter of them cut out."""
    features = []
    scale = rng.uniform(0.08, 0.25)
    for _ in range(int(rng.integers(2, 8))):
        feature = attach_part(rng, parts, scale * rng.uniform(0.6, 1.5), front=True)
        features.append(feature._replace(width=-feature.width) if rng.random() < 0.25 else feature)
    return features


def limb(root: FloatArray, tip: FloatArray, thick: float, thin: float, width: float) -> Part:
    """Return a capsule from one place to another."""
    along = tip - root
    length = float(np.linalg.norm(along))
    sizes = np.array([length / 2, thick, thin, 0.0])
    return Part(CAPSULE, up_along(along / length), (root + tip) / 2, sizes, width)


def random_tube(
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
        parts.append(limb(root, tip, first, last, width))
        root = tip
        if rng.random() < 0.3:
            angle = bend * rng.normal()
    return parts


def flatten(parts: list[Part], share: float) -> list[Part]:
    """Press parts flat along z, ellipsoids with them."""
    flat = [part._replace(center=part.center * [1.0, 1.0, share]) for part in parts]
    return [
        part._replace(sizes=part.sizes * [1.0, 1.0, share, 1.0], turn=UNTURNED)
        if part.kind == ELLIPSOID
        else part
        for part in flat
    ]


def fit_size(parts: list[Part]) -> list[Part]:
    """Center parts and shrink them to the size of the other families."""
    low, high = (
        function([part.center + sign * part.sizes[:3].max() for part in parts], axis=0)
        for function, sign in ((np.min, -1), (np.max, 1))
    )
    middle = (low + high) / 2 * np.array([0.0, 1.0, 1.0])  # x = 0 may be a mirror
    scale = min(1.0, FULL_SIZE / float(np.max(high - middle)))
    return [
        Part(part.kind, part.turn, (part.center - middle) * scale, part.sizes * scale, part.width * scale)
        for part in parts
    ]


def random_waves(rng: np.random.Generator) -> FloatArray:
    """Draw a few waves: see `Solid.waves`."""
    count = int(rng.integers(1, 4))
    vectors = rng.normal(size=(count, 3)) * rng.uniform(2.0, 7.0)
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    heights = 2 * rng.uniform(0.02, 0.12, (count, 1)) / np.maximum(lengths, 2.0)
    return np.concatenate([vectors, rng.uniform(0, 2 * np.pi, (count, 1)), heights], axis=1)


def assemble(
    parts: list[Part], *, view: FloatArray, mirrored: bool = False, waves: FloatArray | None = None
) -> Solid:
    """Return the solid of some parts."""
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


def frontal_view(rng: np.random.Generator) -> FloatArray:
    """Draw a view from somewhere before the solid, as drawings mostly have it."""
    return (
        turn_about(2, rng.normal(0, 0.25))
        @ turn_about(0, rng.normal(0, 0.3))
        @ turn_about(1, rng.normal(0, 0.6))
    )


def upright_view(rng: np.random.Generator) -> FloatArray:
    """Draw a view from anywhere around the solid, a little from above or below."""
    turned = rng.normal(0, 0.8) if rng.random() < 0.7 else rng.uniform(-np.pi, np.pi)
    return turn_about(2, rng.normal(0, 0.2)) @ turn_about(0, rng.normal(0.1, 0.35)) @ turn_about(1, turned)


def up_along(direction: FloatArray) -> FloatArray:
    """Return a rotation whose second row, a part's own y, is a unit vector."""
    beside = np.cross(direction, [0.0, 0.0, 1.0] if abs(direction[2]) < 0.9 else [1.0, 0.0, 0.0])
    beside /= np.linalg.norm(beside)
    return np.stack([beside, direction, np.cross(beside, direction)])


def random_rotation(rng: np.random.Generator) -> FloatArray:
    """Draw a rotation: anyhow, or about one axis only, as upright things stand."""
    if rng.random() < 0.3:
        return turn_about(int(rng.integers(3)), rng.uniform(-np.pi, np.pi))
    turn, upper = np.linalg.qr(rng.normal(size=(3, 3)))
    turn = turn * np.sign(np.diag(upper))
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def turn_about(axis: int, angle: float) -> FloatArray:
    """Return a right-handed rotation about an axis, radians."""
    turn = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[first, second], turn[second, first] = -np.sin(angle), np.sin(angle)
    return turn

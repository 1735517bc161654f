"""The result of a recipe: parts in named materials, patterns on them, and the view."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from toonkit._validation import BoolArray, FloatArray
from toonkit.synthetic.primitives import Solid, Vector

INK = "ink"
"""Pattern that is drawn in the ink of the lines, such as a mouth."""

Where = Callable[[FloatArray], BoolArray]
"""Which of the points (n, 3), in the axes of the model, a pattern covers."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """
    A pattern: where a part shows another material.

    Attributes
    ----------
    material : str
        Name of that material, or `INK`.
    where : callable, (n, 3) -> (n,) bool
        Which points it covers.
    """

    material: str
    where: Where


@dataclass(frozen=True, eq=False)
class Part:
    """
    A solid in one material.

    Attributes
    ----------
    solid : Solid
        Its primitives.
    material : str
        Name of its material; several parts may share one.
    patterns : tuple of Pattern
        What is painted on it; later ones cover earlier ones.
    """

    solid: Solid
    material: str
    patterns: tuple[Pattern, ...] = ()


@dataclass(frozen=True, eq=False)
class Model:
    """
    Everything in a drawing except its colors and lines.

    Attributes
    ----------
    parts : tuple of Part
        What is in it.
    paints : mapping of str to str
        Family of colors, of `synthetic.palette.FAMILIES`, for each material.
    view : ndarray, shape (3, 3)
        Rotation from the axes of the model to those of the picture.
    """

    parts: tuple[Part, ...]
    paints: Mapping[str, str]
    view: FloatArray = field(default_factory=lambda: np.eye(3))


def near(centers: Vector | Sequence[Vector], radius: float) -> Where:
    """Return where a point is within a radius of one of some centers: spots, cheeks, pupils."""
    tree = KDTree(np.atleast_2d(np.asarray(centers, dtype=np.float64)))
    return lambda points: np.isfinite(tree.query(points, distance_upper_bound=radius)[0])


def stripes(direction: Vector, period: float, share: float = 0.5, phase: float = 0.0) -> Where:
    """Return where a point lies in stripes across a direction."""
    along = np.asarray(direction, dtype=np.float64)
    return lambda points: np.asarray(np.mod(points @ along / period + phase, 1.0) < share)


def sectors(count: int, share: float = 0.5, phase: float = 0.0) -> Where:
    """Return where a point lies in sectors around the y axis: upright stripes of something round."""
    return lambda points: np.asarray(
        np.mod(np.arctan2(points[:, 0], points[:, 2]) / (2 * np.pi) * count + phase, 1.0) < share
    )


def oval(center: tuple[float, float], radii: tuple[float, float]) -> Where:
    """Return where a point in front lies in an ellipse seen from the front: bellies, labels."""
    return lambda points: np.asarray(
        (((points[:, 0] - center[0]) / radii[0]) ** 2 + ((points[:, 1] - center[1]) / radii[1]) ** 2 < 1)
        & (points[:, 2] > 0)
    )


def below(height: float, wave: float = 0.0, length: float = 0.3) -> Where:
    """Return where a point lies below a height, perhaps along a wavy line."""

    def where(points: FloatArray) -> BoolArray:
        along = np.arctan2(points[:, 0], points[:, 2]) * 0.5
        return np.asarray(points[:, 1] < height + wave * np.sin(2 * np.pi * along / length))

    return where


def stroke(knots: list[tuple[float, float]], width: float) -> Where:
    """Return where a point in front lies on a polyline, seen from the front: mouths, seams."""
    line = np.asarray(knots, dtype=np.float64)

    def where(points: FloatArray) -> BoolArray:
        flat = points[:, :2]
        nearest = np.full(len(flat), np.inf)
        for start, end in pairwise(line):
            axis = end - start
            share = np.clip((flat - start) @ axis / (axis @ axis), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(flat - start - share[:, None] * axis, axis=1))
        return np.asarray((nearest < width / 2) & (points[:, 2] > 0))

    return where


def smile(center: tuple[float, float], width: float, depth: float, thickness: float) -> Where:
    """Return where a point lies on a mouth: an arc that sags by `depth`, or rises if that is negative."""
    x = np.linspace(-1.0, 1.0, 9)
    knots = [(center[0] + width / 2 * t, center[1] + depth * (t * t - 1)) for t in x.tolist()]
    return stroke(knots, thickness)


def scattered(
    rng: np.random.Generator, center: Vector, radii: Vector, count: int, *, apart: float
) -> NDArray[np.float64]:
    """Return up to `count` places (n, 3) on an ellipsoid, no two of them closer than `apart`."""
    chosen: list[FloatArray] = []
    for _ in range(20 * count):
        direction = rng.normal(size=3)
        place = np.asarray(center) + np.asarray(radii) * direction / np.linalg.norm(direction)
        if all(np.linalg.norm(place - other) >= apart for other in chosen):
            chosen.append(place)
        if len(chosen) == count:
            break
    return np.array(chosen)

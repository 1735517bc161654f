"""Shape: a solid with known normals, and the list of all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.study.solids.distance_fields import Distance, rotation, union

ShapeKind = Literal["primitive", "complex"]


@dataclass(frozen=True)
class View:
    """
    From where a solid is seen, in degrees; all zero looks at its front, along -z.

    Attributes
    ----------
    yaw : float
        Turn about the vertical: positive turns the solid's front toward the picture's right.
    pitch : float
        Tilt of its top toward the viewer: positive looks down on it.
    roll : float
        Turn in the picture, counter-clockwise.
    """

    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0

    def matrix(self) -> FloatArray:
        """Return the (3, 3) rotation from the solid's axes to x right, y up, z toward the viewer."""
        return np.asarray(rotation(z=self.roll) @ rotation(x=self.pitch) @ rotation(y=self.yaw))


@dataclass(frozen=True)
class Shape:
    """
    A solid of the study.

    Attributes
    ----------
    name : str
        Its key in `SHAPES`.
    kind : {"primitive", "complex"}
        Which of the study's two groups it belongs to.
    distance : callable, (n, 3) -> (n,)
        Signed distance, negative inside. The solid lies within `BOUND` of the origin.
    part : callable, (n, 3) -> (n,) int, or None
        Index into `materials` of surface points; None if the solid is of one material.
    materials : tuple of str
        What its parts are called.
    view : View
        The view in which it is best recognized.
    """

    name: str
    kind: ShapeKind
    distance: Distance
    part: Callable[[FloatArray], NDArray[np.intp]] | None = None
    materials: tuple[str, ...] = ("body",)
    view: View = View()


BOUND = 1.5
"""Every solid of the study lies within this distance of the origin."""

SHAPES: dict[str, Shape] = {}
"""All shapes by name, in the order of their definition."""

Solid = Distance | Mapping[str, Distance]


def shape(
    name: str, kind: ShapeKind, view: View | None = None
) -> Callable[[Callable[[], Solid]], Callable[[], Solid]]:
    """
    Register the shape that the decorated function returns.

    The function takes nothing and returns a signed distance or, for a solid of several materials, a dict of
    name -> distance; those are united and each surface point belongs to the nearest.
    """

    def register(build: Callable[[], Solid]) -> Callable[[], Solid]:
        solid = build()
        if isinstance(solid, Mapping):
            distances = tuple(solid.values())
            SHAPES[name] = Shape(
                name, kind, union(*distances), _nearest(distances), tuple(solid), view or View()
            )
        else:
            SHAPES[name] = Shape(name, kind, solid, view=view or View())
        return build

    return register


def _nearest(distances: tuple[Distance, ...]) -> Callable[[FloatArray], NDArray[np.intp]]:
    return lambda points: np.argmin([distance(points) for distance in distances], axis=0)

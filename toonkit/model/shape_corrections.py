"""What a person says about the shape of a drawing: parts that bulge, are flat or in front, and normals at points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import (
    BoolArray,
    any_array,
    as_marks,
    describe_value,
    is_count,
    is_number,
    of_type,
    refuse,
)
from toonkit.model.light import direction_of

PARTS = ("bulge", "flat", "in_front")
"""The properties that a part of a drawing may be given."""

WIDEST_HINT = 1e5
"""Largest radius of a hint, in pixels."""

MOST_HINTS = 1000
"""Largest number of hints for one drawing."""


@dataclass(frozen=True)
class NormalHint:
    """
    The normal at a point of a drawing, as a person wants it.

    Attributes
    ----------
    row, column : int
        The pixel, counted from 0.
    normal : (float, float, float)
        Unit vector, x right, y up, z toward the viewer; given with any length, or as azimuth and elevation in degrees.
    radius : float
        Distance in pixels, up to 100,000, within which the normals turn as well, less with distance.

    Raises
    ------
    ToonkitError
        If the row or the column is not a whole number from 0 on, the normal is zero or points away from the viewer, or the
        radius is not above 0 and at most 100,000.

    Examples
    --------
    >>> NormalHint(120, 80, (0, 90), radius=40).normal
    (0.0, 0.0, 1.0)
    """

    row: int
    column: int
    normal: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        for name in ("row", "column"):
            value = getattr(self, name)
            if not is_count(value, 0, 2**31):
                raise refuse(name, "must be a whole number from 0 on", describe_value(value))
            object.__setattr__(self, name, int(value))
        x, y, z = direction_of("normal", self.normal).tolist()
        object.__setattr__(self, "normal", (x, y, z))
        if not is_number(self.radius) or not 0 < self.radius <= WIDEST_HINT:
            rule = f"must be a number of pixels above 0, at most {WIDEST_HINT:,.0f}"
            raise refuse("radius", rule, describe_value(self.radius))
        object.__setattr__(self, "radius", float(self.radius))


@dataclass(frozen=True, eq=False)
class ShapeCorrections:
    """
    What a person says about the shape of a drawing, for `toonkit.analyze`.

    A method starts from a shape that has these properties. `toonkit` and `classical` are also held to them, but the painted
    tones still count. Each connected region of a mask is a part of its own; one of fewer than 9 pixels is ignored.

    Attributes
    ----------
    bulge : ndarray of bool, shape (H, W), or None
        True on parts that bulge toward the viewer from what is around them.
    flat : ndarray of bool, shape (H, W), or None
        True on parts that are flat. Each keeps the mean direction of its normals, unless a hint changes it.
    in_front : ndarray of bool, shape (H, W), or None
        True on parts that end in front of what is around them: their surface turns away along their border, as it does
        along the outline of the object.
    normals : tuple of NormalHint
        Normals at points, at most 1,000. Where the radii of two overlap, the later one counts more.

    Raises
    ------
    ToonkitError
        If a part is not such an array, or `normals` is not a list of at most 1,000 `NormalHint`.

    Examples
    --------
    >>> belly = np.zeros((64, 64), bool)
    >>> belly[20:40, 20:40] = True
    >>> ShapeCorrections(bulge=belly, normals=[NormalHint(10, 12, (0, 1, 1), radius=8)])
    ShapeCorrections(bulge of 400 pixels, 1 normal)
    """

    bulge: BoolArray | None = None
    flat: BoolArray | None = None
    in_front: BoolArray | None = None
    normals: tuple[NormalHint, ...] = ()

    def __post_init__(self) -> None:
        for name in PARTS:
            if getattr(self, name) is not None:
                part = any_array(name, getattr(self, name))
                if part.dtype != np.bool_ or part.ndim != 2:
                    raise refuse(
                        name, "must be an (H, W) array of bools", describe_value(getattr(self, name))
                    )
                object.__setattr__(self, name, part.copy() if part.any() else None)
        if not isinstance(self.normals, Sequence) or isinstance(self.normals, str):
            raise refuse("normals", "must be a list of NormalHint", describe_value(self.normals))
        for hint in self.normals:
            of_type("normals", hint, NormalHint)
        if len(self.normals) > MOST_HINTS:
            raise refuse("normals", f"must be at most {MOST_HINTS:,}", len(self.normals))
        object.__setattr__(self, "normals", tuple(self.normals))

    @property
    def is_empty(self) -> bool:
        """Whether there are no corrections."""
        return not self.normals and not self.parts

    @property
    def parts(self) -> Mapping[str, BoolArray]:
        """The masks that are given, by name: those in `PARTS`."""
        given = {name: getattr(self, name) for name in PARTS}
        return {name: part for name, part in given.items() if part is not None}

    def __repr__(self) -> str:
        count = len(self.normals)
        said = [f"{name} of {np.count_nonzero(part):,} pixels" for name, part in self.parts.items()]
        said += [f"{count} normal{'s'[: count > 1]}"] if count else []
        return f"ShapeCorrections({', '.join(said) or 'none'})"

    def on(self, mask: ArrayLike) -> ShapeCorrections:
        """
        Return the corrections restricted to an object's pixels.

        Parameters
        ----------
        mask : array_like of bool, shape (H, W)
            True on the object.

        Returns
        -------
        ShapeCorrections
            The same corrections, with parts that are False outside the object.

        Raises
        ------
        ToonkitError
            If the size of a part is not that of the mask, or a hint does not lie on the object.
        """
        on_object = np.asarray(mask, np.bool_)
        height, width = on_object.shape
        for hint in self.normals:
            place = hint.row, hint.column
            if not (hint.row < height and hint.column < width and on_object[place]):
                raise refuse(
                    "shape.normals", "must lie on the object", f"row {hint.row}, column {hint.column}"
                )
        parts = {name: as_marks(f"shape.{name}", part, on_object) for name, part in self.parts.items()}
        return ShapeCorrections(**parts, normals=self.normals)

"""The one place where input is coerced or refused.

Public functions pass their arguments through here; private ones trust what they get. Every refusal is a
`ToonkitError` that names the argument, the rule and the value that broke it.
"""

from __future__ import annotations

from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MIN_OBJECT_PIXELS = 9
"""Fewer pixels than a 3 x 3 block have no interior, hence no shape to recover."""


class ToonkitError(ValueError):
    """Input that toonkit cannot work with: the message names the argument, the rule and the value."""


def refuse(argument: str, rule: str, value: object) -> ToonkitError:
    """Return the error for an argument that broke a rule; the caller raises it."""
    return ToonkitError(f"{argument} {rule}; got {value}")


def is_number(value: object) -> TypeGuard[float]:
    """Tell whether a value is one finite real number."""
    return isinstance(value, int | float | np.number) and bool(np.isfinite(value))


def as_array(argument: str, value: ArrayLike, shape: tuple[int | None, ...]) -> FloatArray:
    """Return `value` as float64, refusing anything that is not a real array of `shape` (None = any length)."""
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise refuse(
            argument, "must be a rectangular array of numbers", "rows of different lengths"
        ) from error
    if array.dtype == object or array.dtype.kind not in "biuf":
        raise refuse(argument, "must hold real numbers", f"dtype {array.dtype}")
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
        raise refuse(argument, f"must have shape {wanted}", array.shape)
    return array.astype(np.float64)


def as_mask(argument: str, value: ArrayLike, shape: tuple[int, int] | None = None) -> BoolArray:
    """Return a (H, W) bool mask with at least `MIN_OBJECT_PIXELS` object pixels, of `shape` if one is given."""
    array = np.asarray(value)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise refuse(
            argument, "must be a (H, W) array, True on the object", f"shape {array.shape}, {array.dtype}"
        )
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise refuse(argument, "must be finite", f"{int((~np.isfinite(array)).sum())} NaN or infinite values")
    if shape is not None and array.shape != shape:
        raise refuse(argument, f"must have the picture's size {shape}", array.shape)
    mask = array.astype(np.bool_)
    count = int(mask.sum())
    if count == 0:
        raise refuse(argument, "must contain the object", "an empty mask")
    if count < MIN_OBJECT_PIXELS:
        raise refuse(argument, f"must cover at least {MIN_OBJECT_PIXELS} pixels to have a shape", f"{count}")
    return mask


def as_light(argument: str, value: ArrayLike) -> FloatArray:
    """Return a unit (3,) direction from the surface to a light on the viewer's side of the image plane."""
    light = as_array(argument, value, (3,))
    if not np.isfinite(light).all():
        raise refuse(argument, "must be finite", np.array2string(light))
    length = float(np.linalg.norm(light))
    if length == 0.0:
        raise refuse(argument, "must point somewhere", "the zero vector (0, 0, 0)")
    light = light / length
    if light[2] < 0.0:
        shown = np.array2string(light, precision=3, suppress_small=True)
        raise refuse(
            argument, "must not come from behind the picture (z >= 0, elevation 0 to 90 degrees)", shown
        )
    return light


def same_shape(argument: str, have: tuple[int, ...], want: tuple[int, ...], of: str) -> None:
    """Refuse an argument whose (H, W) differs from another one's."""
    if have != want:
        raise refuse(argument, f"must have the size of {of} {want}", have)

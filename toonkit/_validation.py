"""The one place where input is coerced or refused.

Public functions pass their arguments through here; private ones trust what they get. Every refusal is a
`ToonkitError` that names the argument, the rule and the value that broke it. Input that can be used, but perhaps
not as it was meant, is accepted with a `ToonkitWarning`.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MIN_OBJECT_PIXELS = 9
"""Fewer pixels than a 3 x 3 block have no interior, hence no shape to recover."""

UNIT = 1e-9
"""How far the length of a unit vector may be from one by rounding."""

BEHIND = 1e-9
"""A light this far behind the image plane is a rounding error of one that lies in it."""

SOURCES = {
    "ToonImage": "toonkit.load_image(path) or toonkit.ToonImage(color, mask)",
    "NormalField": "toonkit.NormalField(vectors, mask), or analysis.normals",
    "ColorMap": "toonkit.ColorMap(colors), or one of analysis.materials.color_maps",
    "Materials": "toonkit.fit_color_maps(image, illumination), or analysis.materials",
    "ToonAnalysis": "toonkit.analyze(image), or toonkit.load_analysis(path)",
    "IlluminationInterval": "toonkit.illumination_interval(image, color_map)",
    "RefinementOptions": "toonkit.RefinementOptions(margin=0.1)",
    "HeightField": "toonkit.height_map(normals)",
    "NormalHint": "toonkit.NormalHint(row, column, normal, radius)",
    "ShapeCorrections": "toonkit.ShapeCorrections(bulge=mask)",
}
"""What to pass where an object of a class is wanted and something else came."""

LONGEST_SHOWN = 60
"""Characters of a text that a message repeats."""


class ToonkitError(ValueError):
    """Input that toonkit cannot work with: the message names the argument, the rule and the value."""


class ToonkitWarning(UserWarning):
    """Input that toonkit uses, but perhaps not as it was meant: the message names the argument and what was assumed."""


_collected: ContextVar[list[str] | None] = ContextVar("_collected", default=None)


def warn(argument: str, assumed: str) -> None:
    """Say in one line what is assumed about an argument that says something else, or nothing."""
    text = f"{argument}: {assumed}"
    collected = _collected.get()
    if collected is None:
        warnings.warn(text, ToonkitWarning, stacklevel=3)
    else:
        collected.append(text)


@contextmanager
def collect_warnings() -> Iterator[list[str]]:
    """Collect the texts of this thread's warnings, which nobody else sees; `warnings` itself mixes those of all threads."""
    collected: list[str] = []
    token = _collected.set(collected)
    try:
        yield collected
    finally:
        _collected.reset(token)


def refuse(argument: str, rule: str, value: object) -> ToonkitError:
    """Return the error for an argument that broke a rule; the caller raises it."""
    return ToonkitError(f"{argument} {rule}; got {value}")


def is_number(value: object) -> TypeGuard[float]:
    """Tell whether a value is one real number that is finite as a float."""
    if not isinstance(value, int | float | np.integer | np.floating):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an int beyond the range of floats
        return False


def is_count(value: object, least: int, most: int) -> TypeGuard[int]:
    """Tell whether a value is a whole number from `least` to `most`."""
    return isinstance(value, int | np.integer) and bool(least <= value <= most)


def check_flag(argument: str, value: object) -> None:
    """Raise `ToonkitError` unless the value is a bool."""
    if not isinstance(value, bool | np.bool_):
        raise refuse(argument, "must be True or False", repr(value))


def check_callable(argument: str, value: object) -> None:
    """Raise `ToonkitError` unless the value is callable or None."""
    if value is not None and not callable(value):
        raise refuse(argument, "must be a function, or None", type(value).__name__)


def as_path(argument: str, value: object) -> Path:
    """Return a path as the system takes one, refusing what is none."""
    if not isinstance(value, str | os.PathLike):
        raise refuse(argument, "must be a path", type(value).__name__)
    path = os.fspath(value)
    try:
        if not isinstance(path, str) or b"\0" in os.fsencode(path):
            raise ValueError
    except ValueError:
        raise refuse(argument, "must be a path of text that can name a file", ascii(path)) from None
    return Path(path)


def any_array(argument: str, value: object) -> NDArray[Any]:
    """Return a value as NumPy reads it, refusing what it cannot read as a rectangular array."""
    try:
        return np.asarray(value)
    except (OverflowError, TypeError, ValueError) as error:
        shown = "rows of different lengths" if isinstance(error, ValueError) else f"{error}"
        raise refuse(argument, "must be a rectangular array of numbers", shown) from error


def as_real(argument: str, value: ArrayLike, *, copy: bool = True) -> FloatArray:
    """Return `value` as float64 of its own shape, refusing anything that is not a real array."""
    array = any_array(argument, value)
    if array.dtype.kind not in "biuf":
        raise refuse(argument, "must hold real numbers", describe_value(value))
    with np.errstate(
        over="ignore", invalid="ignore"
    ):  # a long double becomes infinite, a signaling NaN a quiet one
        # One memory order, so that sums are rounded alike whatever the order of the input.
        return array.astype(np.float64, order="C", copy=copy)


def as_array(
    argument: str, value: ArrayLike, shape: tuple[int | None, ...], *, copy: bool = True
) -> FloatArray:
    """Return `value` as float64, refusing anything that is not a real array of `shape` (None = any length)."""
    array = as_real(argument, value, copy=copy)
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
        raise refuse(argument, f"must have shape {wanted}", array.shape)
    return array


def as_coverage(argument: str, value: ArrayLike, shape: tuple[int, int]) -> FloatArray:
    """Return a (H, W) coverage in [0, 1] of the picture's `shape`."""
    coverage = as_array(argument, value, (None, None))
    same_shape(argument, coverage.shape, shape, "the picture")
    if not (np.isfinite(coverage).all() and coverage.min() >= 0 and coverage.max() <= 1):
        raise refuse(argument, "must lie in [0, 1]", "values outside it or NaN")
    return coverage


def of_type(argument: str, value: object, wanted: type) -> None:
    """Refuse a value that is not an instance of a class of ours."""
    if not isinstance(value, wanted):
        name = wanted.__name__
        advice = f" (pass {SOURCES[name]})" if name in SOURCES else ""
        article = "an" if name[0] in "AEIOU" else "a"
        raise refuse(argument, f"must be {article} {name}{advice}", describe_value(value))


def describe_value(value: object) -> str:
    """Describe, for a message, a value of the wrong kind: text as it is, an array by its shape, else its type."""
    if isinstance(value, str | os.PathLike):
        text = repr(value)
        return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}…"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}, {value.dtype}"
    if isinstance(value, tuple | list) and len(repr(value)) > LONGEST_SHOWN:
        return f"a {type(value).__name__} of length {len(value)}"
    if value is None or isinstance(value, int | float | complex | tuple | list):
        return repr(value)
    return type(value).__name__


def one_of(argument: str, value: object, names: Iterable[str]) -> None:
    """Refuse a value that is none of some names, and point to the one that is spelled most like it."""
    known = tuple(names)
    if isinstance(value, str):
        if value in known:
            return
        lowered = {name.lower(): name for name in known}
        hint = "".join(
            f"; did you mean {lowered[name]!r}?" for name in get_close_matches(value.lower(), lowered, 1)
        )
    else:
        hint = ""
    raise refuse(argument, f"must be one of {', '.join(known)}", f"{value!r}{hint}")


def same_mask(argument: str, mask: BoolArray, wanted: BoolArray, of: str) -> None:
    """Refuse an argument that covers other pixels than another one does."""
    same_shape(argument, mask.shape, wanted.shape, of)
    if (mask != wanted).any():
        raise refuse(
            argument, f"must cover the same mask as {of}", f"{int((mask != wanted).sum())} pixels that differ"
        )


def as_mask(argument: str, value: ArrayLike, shape: tuple[int, int] | None = None) -> BoolArray:
    """Return a (H, W) bool mask with at least `MIN_OBJECT_PIXELS` object pixels, of `shape` if one is given."""
    array = any_array(argument, value)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        rule = "must be a (H, W) array, True on the object, such as image.mask"
        raise refuse(argument, rule, describe_value(value))
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise refuse(argument, "must be finite", f"{int((~np.isfinite(array)).sum())} NaN or infinite values")
    if shape is not None and array.shape != shape:
        raise refuse(argument, f"must have the picture's size {shape}", array.shape)
    if array.dtype != np.bool_ and not np.isin(array, (0, 1, 255)).all():
        rule = "must be True or False everywhere (a soft one goes to load_image, or beside the mask as alpha)"
        raise refuse(argument, rule, f"values from {array.min():.4g} to {array.max():.4g}")
    mask = array.astype(np.bool_, order="C")
    count = int(mask.sum())
    if count == 0:
        raise refuse(argument, "must contain the object", "an empty mask")
    if count < MIN_OBJECT_PIXELS:
        raise refuse(argument, f"must cover at least {MIN_OBJECT_PIXELS} pixels to have a shape", f"{count}")
    return mask


def as_labels(argument: str, value: ArrayLike, mask: BoolArray) -> NDArray[np.intp]:
    """Return (H, W) labels that number from 0 on, in the order given, what occurs on a mask; -1 elsewhere."""
    array = any_array(argument, value)
    if array.dtype.kind not in "iu":
        raise refuse(argument, "must be an (H, W) array of integers", describe_value(value))
    same_shape(argument, array.shape, mask.shape, "the picture")
    given = array[mask]
    if given.min() < -1 or given.max() > np.iinfo(np.intp).max:
        shown = f"{given.min()} to {given.max()}"
        raise refuse(argument, "must be numbers from 0 on, or -1 where unknown", shown)
    inside = given.astype(np.intp)
    if inside.max() < 0:
        raise refuse(argument, "must name a material somewhere on the object", "-1 everywhere")
    labels = np.full(mask.shape, -1, np.intp)
    occurring, number = np.unique(inside, return_inverse=True)
    labels[mask] = number - int(occurring[0] == -1)
    return labels


def as_lines(argument: str, value: ArrayLike, mask: BoolArray) -> BoolArray:
    """Return a (H, W) bool array that is True where an object's line art is, which leaves some of the object free."""
    array = any_array(argument, value)
    if array.ndim != 2 or array.dtype.kind not in "biuf" or not np.isin(array, (0, 1, 255)).all():
        raise refuse(argument, "must be an (H, W) array, True where line art is", describe_value(value))
    same_shape(argument, array.shape, mask.shape, "the picture")
    lines = array.astype(np.bool_) & mask
    if (lines == mask).all():
        raise refuse(argument, "must leave paint somewhere on the object", "line art everywhere")
    return lines


def as_marks(argument: str, value: ArrayLike, mask: BoolArray) -> BoolArray:
    """Return which pixels (H, W) of a mask are marked."""
    array = any_array(argument, value)
    if array.dtype != np.bool_ or array.ndim != 2:
        raise refuse(argument, "must be an (H, W) array of bools", describe_value(value))
    same_shape(argument, array.shape, mask.shape, "the picture")
    marked: BoolArray = array & mask
    return marked


def as_light(argument: str, value: ArrayLike, *, behind: bool = False) -> FloatArray:
    """Return a unit (3,) direction from the surface to a light, on the viewer's side of the image plane unless `behind`."""
    try:
        light = as_array(argument, value, (3,))
    except ToonkitError as error:
        rule = (
            "must be a direction (x, y, z), or an azimuth and elevation in degrees: "
            "toonkit.light_direction(azimuth, elevation)"
        )
        hint = " (pass its .light)" if hasattr(value, "light") else ""
        raise refuse(argument, rule, f"{describe_value(value)}{hint}") from error
    if not np.isfinite(light).all():
        raise refuse(argument, "must be finite", np.array2string(light))
    largest = float(np.abs(light).max())
    if largest == 0.0:
        raise refuse(argument, "must point somewhere", "the zero vector (0, 0, 0)")
    if not 1e-100 < largest < 1e100:
        light = light / largest  # so that the squares of its components stay numbers
    light = light / np.linalg.norm(light)
    if behind and light[2] < -BEHIND:
        return light
    if light[2] < -BEHIND:
        shown = np.array2string(light, precision=3, suppress_small=True)
        raise refuse(
            argument, "must not come from behind the picture (z >= 0, elevation 0 to 90 degrees)", shown
        )
    light[2] = max(light[2], 0.0)
    return light


def check_unit_light(argument: str, value: object) -> None:
    """Refuse what is no light as toonkit keeps one: a unit vector (3,), z >= 0."""
    light = any_array(argument, value)
    good = light.shape == (3,) and light.dtype.kind == "f" and bool((np.abs(light) < 2).all())
    if not (good and abs(np.linalg.norm(light) - 1) < UNIT and light[2] >= -BEHIND):
        raise refuse(
            argument, "must be a unit vector of shape (3,), z >= 0", np.array2string(light, threshold=8)
        )


def same_shape(argument: str, have: tuple[int, ...], want: tuple[int, ...], of: str) -> None:
    """Refuse an argument whose (H, W) differs from another one's."""
    if have != want:
        raise refuse(argument, f"must have the size of {of} {want}", have)


def expand_home(path: str | os.PathLike[str]) -> Path:
    """Return a path with a leading `~/` or `~user/` expanded; a mere file name such as `~sketch.png` stays as it is."""
    given = Path(path)
    if len(given.parts) == 1 and given.parts[0] != "~":
        return given
    try:
        return given.expanduser()
    except RuntimeError:  # there is no such user, so it is a folder's name
        return given

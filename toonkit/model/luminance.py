"""Luminance: the one order in which painted colors go from dark to bright."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray

REC709 = np.array([0.2126, 0.7152, 0.0722])


def srgb_to_linear(color: ArrayLike) -> FloatArray:
    """Decode sRGB values in [0, 1] to linear light (IEC 61966-2-1)."""
    value = np.asarray(color, dtype=np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((np.maximum(value, 0.04045) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(light: ArrayLike) -> FloatArray:
    """Encode linear light in [0, 1] as sRGB (IEC 61966-2-1)."""
    value = np.asarray(light, dtype=np.float64)
    return np.where(
        value <= 0.0031308, value * 12.92, 1.055 * np.maximum(value, 0.0031308) ** (1 / 2.4) - 0.055
    )


def luminance(color: ArrayLike) -> FloatArray:
    """Return the relative luminance (...), linear in light (Rec. 709 primaries), of sRGB colors (..., 3) in [0, 1]."""
    weighted: FloatArray = srgb_to_linear(color) @ REC709
    return weighted


def tone(color: ArrayLike) -> FloatArray:
    """
    Return the luminance of sRGB colors (..., 3), encoded with the sRGB curve: in even steps for the eye, in [0, 1].

    Tolerances between painted colors are stated in it, because a painter's steps are.
    """
    return linear_to_srgb(luminance(color))


def hex_color(color: ArrayLike) -> str:
    """
    Write an sRGB color in [0, 1] as web pages do.

    Examples
    --------
    >>> hex_color([1.0, 0.5, 0.0])
    '#ff8000'
    """
    red, green, blue = np.round(np.asarray(color) * 255).astype(int)
    return f"#{red:02x}{green:02x}{blue:02x}"


def color_of_hex(text: str) -> tuple[float, float, float]:
    """
    Read a color, "#rrggbb" or "#rgb", as sRGB in [0, 1].

    Examples
    --------
    >>> color_of_hex("#ff0033"), color_of_hex("#f03")
    ((1.0, 0.0, 0.2), (1.0, 0.0, 0.2))
    """
    digits = text.removeprefix("#")
    if len(digits) == 3:
        digits = "".join(2 * digit for digit in digits)
    red, green, blue = (level / 255 for level in bytes.fromhex(digits))
    return red, green, blue

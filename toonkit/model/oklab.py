"""
OKLab, a color space in which equal steps look about equal: lightness L in [0, 1], and a, b for hue and chroma.

Source: Björn Ottosson, "A perceptual color space for image processing" (2020), https://bottosson.github.io/posts/oklab/.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear

Lab = NDArray[np.float32]
"""OKLab in single precision."""

_LEVELS = 1023
"""Steps of the table that `tabulated_oklab` decodes sRGB with: four of them to a step of an 8-bit picture."""

_LMS_OF_LINEAR = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
"""Cone responses of linear sRGB."""

_OKLAB_OF_ROOTS = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
"""OKLab of the cube roots of cone responses."""

# Inverted here rather than copied: the published inverses are rounded, and a round trip would err by 1e-8.
_ROOTS_OF_OKLAB = np.linalg.inv(_OKLAB_OF_ROOTS)
_LINEAR_OF_LMS = np.linalg.inv(_LMS_OF_LINEAR)


def srgb_to_oklab(color: ArrayLike) -> FloatArray:
    """
    Convert sRGB (..., 3) in [0, 1] to OKLab: L in [0, 1], a and b within about [-0.4, 0.4]; NaN stays NaN.

    Examples
    --------
    >>> srgb_to_oklab([1.0, 0.0, 0.0]).round(3).tolist()
    [0.628, 0.225, 0.126]
    """
    roots = np.cbrt(srgb_to_linear(color) @ _LMS_OF_LINEAR.T)
    lab: FloatArray = roots @ _OKLAB_OF_ROOTS.T
    return lab


def off_hue(lab: FloatArray, reference: FloatArray) -> FloatArray:
    """
    Return how far OKLab colors (..., 3) are from the hue of others, whatever their lightness and chroma.

    It is the distance of (a, b) from the ray from gray through the reference's (a, b).

    Examples
    --------
    >>> off_hue(np.array([[0.2, 0.3, 0.1], [0.2, -0.3, 0.4]]), np.array([0.9, 0.1, 0.0])).tolist()
    [0.1, 0.5]
    """
    hue = reference[..., 1:] / np.maximum(np.linalg.norm(reference[..., 1:], axis=-1), 1e-12)[..., None]
    along = np.maximum(np.sum(lab[..., 1:] * hue, axis=-1), 0.0)
    off: FloatArray = np.linalg.norm(lab[..., 1:] - along[..., None] * hue, axis=-1)
    return off


def oklab_to_srgb(lab: ArrayLike) -> FloatArray:
    """Convert OKLab (..., 3) to sRGB; NaN stays NaN. Colors that sRGB does not have lie outside [0, 1]."""
    roots = np.asarray(lab, dtype=np.float64) @ _ROOTS_OF_OKLAB.T
    return linear_to_srgb(roots**3 @ _LINEAR_OF_LMS.T)


def tabulated_oklab(color: FloatArray) -> Lab:
    """
    Convert sRGB (..., 3) without NaN to OKLab quickly, in single precision and with sRGB in 1024 levels.

    It differs from `srgb_to_oklab` by up to 0.002, or 0.02 in colors darker than a step of 8 bits.
    """
    decoded = srgb_to_linear(np.linspace(0.0, 1.0, _LEVELS + 1)).astype(np.float32)
    level = np.rint(np.asarray(color) * _LEVELS).astype(np.intp)
    roots = np.cbrt(decoded[np.clip(level, 0, _LEVELS)] @ _LMS_OF_LINEAR.T.astype(np.float32))
    lab: Lab = roots @ _OKLAB_OF_ROOTS.T.astype(np.float32)
    return lab

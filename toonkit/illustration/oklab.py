"""OKLab, the color space in which drawings are taken apart: distances in it are about equally visible."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray

Lab = NDArray[np.float32]

_LEVELS = 1023
"""Steps of the table that decodes sRGB: four of them to a step of an 8-bit picture."""

_TO_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def oklab(color: FloatArray) -> Lab:
    """
    Convert colors to OKLab.

    Parameters
    ----------
    color : ndarray, shape (..., 3)
        sRGB in [0, 1], without NaN.

    Returns
    -------
    ndarray of float32, shape (..., 3)
        Lightness in [0, 1], and two coordinates of hue and chroma, zero for grays.

    References
    ----------
    B. Ottosson, "A perceptual color space for image processing", 2020, https://bottosson.github.io/posts/oklab/
    """
    encoded = np.linspace(0.0, 1.0, _LEVELS + 1)
    decoded = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    level = np.rint(np.asarray(color) * _LEVELS).astype(np.intp)
    light = decoded.astype(np.float32)[np.clip(level, 0, _LEVELS)]
    cones = np.cbrt(light @ _TO_CONES.T.astype(np.float32))
    lab: Lab = cones @ _TO_LAB.T.astype(np.float32)
    return lab

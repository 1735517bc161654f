"""The forward model of Section 3: illumination L · N, and the picture M(L · N)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, of_type
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import direction_of
from toonkit.model.normals import NormalField


def illumination(normals: NormalField, light: ArrayLike) -> FloatArray:
    """
    Illumination L · N, neither clamped nor shifted.

    Parameters
    ----------
    normals : NormalField
        Unit normals.
    light : array_like, shape (3,) or (2,)
        Direction from the surface to the light, or its azimuth and elevation in degrees; it may stand behind the picture.

    Returns
    -------
    ndarray, shape (H, W)
        Values in [-1, 1], NaN outside the mask.

    Raises
    ------
    ToonkitError
        If the light is zero or not finite.
    """
    of_type("normals", normals, NormalField)
    return np.clip(normals.vectors @ direction_of("light", light, behind=True), -1.0, 1.0)


def shade(normals: NormalField, light: ArrayLike, color_map: ColorMap) -> ToonImage:
    """
    Paint a normal field: c = M(L · N).

    Parameters
    ----------
    normals : NormalField
        Unit normals.
    light : array_like, shape (3,) or (2,)
        Direction from the surface to the light, or its azimuth and elevation in degrees; it may stand behind the picture.
    color_map : ColorMap
        The ramp M.

    Returns
    -------
    ToonImage
        The picture, with the mask of the normals.

    Raises
    ------
    ToonkitError
        If the light is zero or not finite.
    """
    of_type("color_map", color_map, ColorMap)
    return ToonImage(color_map(illumination(normals, light)), normals.mask)

"""The forward model of Section 3: illumination L · N, and the picture M(L · N)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_light, of_type
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField


def illumination(normals: NormalField, light: ArrayLike) -> FloatArray:
    """
    Illumination L · N, neither clamped nor shifted.

    Parameters
    ----------
    normals : NormalField
        Unit normals.
    light : array_like, shape (3,)
        Direction from the surface to the light, which may stand behind the picture (z < 0).

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
    return np.clip(normals.vectors @ as_light("light", light, behind=True), -1.0, 1.0)


def shade(normals: NormalField, light: ArrayLike, color_map: ColorMap) -> ToonImage:
    """
    Paint a normal field: c = M(L · N).

    Parameters
    ----------
    normals : NormalField
        Unit normals.
    light : array_like, shape (3,)
        Direction from the surface to the light, which may stand behind the picture (z < 0).
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

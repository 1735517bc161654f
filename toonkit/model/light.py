"""Light directions. Degrees exist only here, at the border; inside, a light is a unit vector."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, ToonkitError, any_array, as_light, is_number, refuse

OPENING_LIGHT = (35.0, 40.0)
"""Azimuth and elevation, in degrees, of the new light that pages and views open with."""


def light_direction(azimuth: float, elevation: float) -> FloatArray:
    """
    Return the unit vector from the surface to a light given in degrees.

    Parameters
    ----------
    azimuth : float
        Degrees, counter-clockwise from +x (the picture's right). 90 is above, 180 left.
    elevation : float
        Degrees from the image plane toward the viewer, -90 to 90. 90 is a light at the viewer's eye, and a negative one
        a light behind the picture, which only relighting takes.

    Returns
    -------
    ndarray, shape (3,)
        Unit vector, x right, y up, z toward the viewer.

    Raises
    ------
    ToonkitError
        If an angle is not a finite number or the elevation lies outside -90 to 90 degrees.

    Examples
    --------
    >>> light_direction(90, 0).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    if not is_number(azimuth):
        raise refuse("azimuth", "must be a finite number of degrees", azimuth)
    if not is_number(elevation):
        raise refuse("elevation", "must be a finite number of degrees", elevation)
    if not -90.0 <= elevation <= 90.0:
        raise refuse("elevation", "must lie in -90 to 90 degrees", elevation)
    # As a Python float: small NumPy types would round the angles, or overflow below.
    turn, rise = math.radians(azimuth), math.radians(elevation)
    # cos(90 degrees) is 6e-17 in floating point: rounding it away keeps 0 exactly 0.
    vector = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)]).round(15)
    return as_light("light", vector, behind=True)


def direction_of(argument: str, light: ArrayLike, *, behind: bool = False) -> FloatArray:
    """
    Return the unit vector (3,) of a light: a direction from the surface, or azimuth and elevation as in `light_direction`.

    Raises `ToonkitError` if it is neither, zero, not finite, or from behind the picture where it may not be.
    """
    try:
        given = any_array(argument, light)
    except ToonkitError:
        return as_light(argument, light, behind=behind)
    if given.shape == (2,):
        azimuth, elevation = given.tolist()
        if not behind and is_number(elevation) and -90.0 <= elevation < 0.0:
            raise refuse(
                "elevation", "must lie in 0 to 90 degrees (a light from behind shades no drawing)", elevation
            )
        return light_direction(azimuth, elevation)
    return as_light(argument, light, behind=behind)


def describe_light(light: FloatArray) -> str:
    """
    Say in words where a light (3,) stands, in whole degrees.

    Examples
    --------
    >>> describe_light(light_direction(-30, 50))
    'azimuth 330°, elevation 50°'
    """
    azimuth, elevation = light_angles(light)
    return f"azimuth {round(azimuth) % 360}°, elevation {elevation:.0f}°"


def light_angles(light: ArrayLike) -> tuple[float, float]:
    """
    Azimuth and elevation, in degrees, of a light direction: the inverse of `light_direction`.

    Parameters
    ----------
    light : array_like, shape (3,)
        Direction from the surface to the light; any length but zero.

    Returns
    -------
    azimuth, elevation : float
        Degrees; azimuth in (-180, 180], elevation in [-90, 90], below 0 for a light behind the picture.

    Raises
    ------
    ToonkitError
        If the light is zero or not finite.
    """
    x, y, z = as_light("light", light, behind=True)
    return float(np.rad2deg(np.arctan2(y, x))), float(np.rad2deg(np.arctan2(z, np.hypot(x, y))))

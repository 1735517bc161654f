"""The light, when nobody gives it (Section 3.2): a simple estimate from the inflated shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import FloatArray, as_light, of_type, same_mask
from toonkit.estimation.inflation import inflate
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.model.luminance import luminance
from toonkit.model.normals import NormalField

LOWEST_ELEVATION = 5.0
"""Degrees. Painted light grazing the image plane or from behind it is a fit to noise, not a light."""


@dataclass(frozen=True, eq=False)
class LightEstimate:
    """
    An estimated light.

    Attributes
    ----------
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    confidence : float
        Share of the luminance's variance that this light explains on the inflated shape, 0 to 1.
    """

    light: FloatArray
    confidence: float


def estimate_light(image: ToonImage, *, initial_normals: NormalField | None = None) -> LightEstimate:
    """
    Estimate the light from the picture alone.

    Parameters
    ----------
    image : ToonImage
        The picture.
    initial_normals : NormalField, optional
        Inflated normals, if they are at hand.

    Returns
    -------
    LightEstimate
        The light and how much of the shading it explains. A picture of one single color says nothing: its light stands at
        the viewer with confidence 0.

    Raises
    ------
    ToonkitError
        If the image is not a `ToonImage`, or the normals cover another mask.

    Notes
    -----
    Least squares of luminance = a · N0 + b over the object; the light is the direction of a. N0 is least certain in the
    middle of wide areas, so the azimuth is better known than the elevation.
    """
    of_type("image", image, ToonImage)
    if initial_normals is None:
        normals = inflate(image.mask, alpha=image.alpha)
    else:
        same_mask("initial_normals", initial_normals.mask, image.mask, "the picture")
        normals = initial_normals
    vectors = normals.vectors[image.mask]
    shades = luminance(image.color[image.mask])
    spread = float(np.var(shades))
    if spread < 1e-10:
        return LightEstimate(light_direction(0.0, 90.0), 0.0)
    columns = np.column_stack([vectors, np.ones(len(vectors))])
    solution = np.linalg.lstsq(columns, shades, rcond=None)[0]
    sideways = float(np.hypot(solution[0], solution[1]))
    floor = sideways * np.tan(np.deg2rad(LOWEST_ELEVATION))
    direction = np.array([solution[0], solution[1], max(solution[2], floor)])
    if np.linalg.norm(direction) < 1e-12:
        return LightEstimate(light_direction(0.0, 90.0), 0.0)
    light = as_light("light", direction)
    return LightEstimate(light, _explained_share(vectors @ light, shades))


def _explained_share(illumination: FloatArray, shades: FloatArray) -> float:
    """Share of the variance of the shades that a rising linear function of the illumination explains, 0 to 1."""
    deviation, rise = illumination - illumination.mean(), shades - shades.mean()
    norms = float(np.linalg.norm(deviation) * np.linalg.norm(rise))
    return max(float(deviation @ rise), 0.0) ** 2 / norms**2 if norms > 1e-12 else 0.0

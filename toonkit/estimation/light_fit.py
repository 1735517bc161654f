"""The light, when nobody gives it (Section 3.2, and the first item of the paper's future work)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import FloatArray, of_type, same_mask
from toonkit.estimation.inflation import inflate
from toonkit.estimation.light_prior import believed_light
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.model.luminance import luminance
from toonkit.model.normals import NormalField

LOWEST_ELEVATION = 5.0
"""Degrees. Painted light grazing the image plane or from behind it is a fit to noise, not a light."""

CLOSE = 10.0
"""Degrees within which an estimate counts as good: the illumination is then off by 0.17 at most, of a range of 2."""

PLAUSIBLE = 0.3
"""Share of the luminance's variance that a light explains on the inflated shape, below which confidence falls to zero with
it: such a picture is shaded in a way that the network has never seen, and its belief is worth little."""


@dataclass(frozen=True, eq=False)
class LightEstimate:
    """
    An estimated light.

    Attributes
    ----------
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    confidence : float
        Probability, as the estimator believes, that the true light is within 10 degrees of it; 0 to 1.
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
        The light, at least 5 degrees above the image plane, and how sure it is. A picture of one single color says
        nothing: its light stands at the viewer with confidence 0.

    Raises
    ------
    ToonkitError
        If the image is not a `ToonImage`, or the normals cover another mask.

    Notes
    -----
    A network trained on shapes and color maps of its own sees mask, N0 and tones and answers with a distribution of
    directions; see `toonkit.estimation.light_prior`. Its belief counts in full where the light explains the shading of the
    inflated shape as a light should, and for nothing where the shading runs against it.
    """
    of_type("image", image, ToonImage)
    if initial_normals is not None:
        same_mask("initial_normals", initial_normals.mask, image.mask, "the picture")
    shades = luminance(image.color[image.mask])
    if float(np.var(shades)) < 1e-10:
        return LightEstimate(light_direction(0.0, 90.0), 0.0)
    normals = inflate(image.mask, alpha=image.alpha) if initial_normals is None else initial_normals
    belief = believed_light(image, normals)
    azimuth = np.rad2deg(np.arctan2(belief.light[1], belief.light[0]))
    elevation = np.rad2deg(np.arcsin(np.clip(belief.light[2], -1.0, 1.0)))
    light = light_direction(float(azimuth), float(max(elevation, LOWEST_ELEVATION)))
    share = _explained_share(normals.vectors[image.mask] @ light, shades)
    return LightEstimate(light, belief.probability_within(CLOSE) * min(share / PLAUSIBLE, 1.0))


def _explained_share(illumination: FloatArray, shades: FloatArray) -> float:
    """Share of the variance of the shades that a rising linear function of the illumination explains, 0 to 1."""
    deviation, rise = illumination - illumination.mean(), shades - shades.mean()
    norms = float(np.linalg.norm(deviation) * np.linalg.norm(rise))
    return max(float(deviation @ rise), 0.0) ** 2 / norms**2 if norms > 1e-12 else 0.0

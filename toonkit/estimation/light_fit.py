"""Estimation of the light (Section 3.2, and the first item of the paper's future work)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from toonkit._validation import FloatArray, check_unit_light, is_number, of_type, refuse, same_mask
from toonkit.estimation.light_prior import LightBelief, believed_light
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.shape_prior import misfit
from toonkit.model.image import ToonImage
from toonkit.model.light import describe_light, light_direction
from toonkit.model.normals import NormalField
from toonkit.numerics.parallel import single_threaded_blas

LOWEST_ELEVATION = 5.0
"""Degrees. An estimate below this elevation fits noise."""

CLOSE = 10.0
"""Degrees within which an estimate counts as good: the illumination is then off by 0.17 at most, of a range of 2."""

PLAUSIBLE = 0.3
"""Share of the luminance's variance that a light explains on the inflated shape, below which confidence falls to zero with
it: such a picture is shaded in a way that the network has never seen, and its belief is worth little."""


STRAIGHT = 0.9999
"""z of a light from which on it has no azimuth: a degree from straight ahead."""

RING, TRIED = 1.2, 6
"""How far from the believed light others are tried, in standard deviations of the belief, and how many. Eighteen on two
rings gained a thirtieth more on generated solids, in almost three times the time."""

SPREADS = (0.03, 0.4)
"""Limits of that standard deviation, radians."""

OBSERVATIONS = 6.0
"""Independent observations of illumination that a picture is worth: how much a light's misfit counts. Of 2, 4, 6, 8 and 12
the best on generated solids, by little."""

NEGLIGIBLE = 1e-4
"""Misfit that the true light may have."""

GUESS = 0.1
"""Confidence below which an estimate is a guess, on generated drawings 25 degrees off on average."""

CUSTOMARY_LIGHT = (130.0, 50.0)
"""Azimuth and elevation, in degrees, of the light that most painters have in mind: upper left, in front."""


@dataclass(frozen=True, eq=False)
class LightEstimate:
    """
    An estimated light.

    Attributes
    ----------
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    confidence : float
        Estimated probability, 0 to 1, that the true light is within 10 degrees.

    Raises
    ------
    ToonkitError
        If the light is not a unit vector with z >= 0, or the confidence is not a number from 0 to 1.
    """

    light: FloatArray
    confidence: float

    def __post_init__(self) -> None:
        check_unit_light("light", self.light)
        if not is_number(self.confidence) or not 0 <= self.confidence <= 1:
            raise refuse("confidence", "must be a number from 0 to 1", self.confidence)

    @property
    def is_guess(self) -> bool:
        """Whether an estimate is a guess: its confidence is below `GUESS`."""
        return self.confidence < GUESS

    def __repr__(self) -> str:
        return f"LightEstimate({describe_light(self.light)}, confidence {self.confidence:.2f})"


def estimate_light(
    image: ToonImage | PreparedDrawing, *, initial_normals: NormalField | None = None
) -> LightEstimate:
    """
    Estimate the light from the picture alone.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The picture.
    initial_normals : NormalField, optional
        Inflated normals, if they have been computed.

    Returns
    -------
    LightEstimate
        The light, at least 5 degrees above the image plane, with its confidence. For a picture in a single color the
        light is at the viewer, with confidence 0.

    Raises
    ------
    ToonkitError
        If the image is not a `ToonImage`, or the normals cover another mask.

    Notes
    -----
    A network sees the mask, N0 and the tones, and predicts a distribution of directions; see
    `toonkit.estimation.light_prior`. A few likely directions are then tried. The better the learned shape under a light
    explains the picture (`toonkit.estimation.shape_prior.misfit`), the more likely the light becomes. The confidence is
    lowered where the light does not explain the shading of the inflated shape, down to zero where the shading
    contradicts it.
    """
    drawing = prepare(image)
    if initial_normals is None:
        drawing = drawing.as_painted
    else:
        of_type("initial_normals", initial_normals, NormalField)
        same_mask("initial_normals", initial_normals.mask, drawing.image.mask, "the picture")
    gray = drawing.posed().gray
    shaded = ~gray.hidden
    shades = gray.tone[shaded]
    if shades.size == 0 or float(np.var(shades)) < 1e-10:
        return LightEstimate(light_direction(0.0, 90.0), 0.0)
    normals = drawing.inflated_normals if initial_normals is None else initial_normals
    with single_threaded_blas():
        belief = sharpen(believed_light(drawing, normals), drawing, normals)
        azimuth = np.rad2deg(np.arctan2(belief.light[1], belief.light[0]))
        elevation = np.rad2deg(np.arcsin(np.clip(belief.light[2], -1.0, 1.0)))
        light = light_direction(float(azimuth), float(max(elevation, LOWEST_ELEVATION)))
        share = _explained_share(normals.compact[shaded] @ light, shades)
    return LightEstimate(light, belief.probability_within(CLOSE) * min(share / PLAUSIBLE, 1.0))


def assume_light(image: ToonImage | PreparedDrawing) -> LightEstimate:
    """
    Estimate the light, and fall back to `CUSTOMARY_LIGHT` if the estimate is a guess.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The picture.

    Returns
    -------
    LightEstimate
        The light to use, with the confidence of the estimate.

    Raises
    ------
    ToonkitError
        If the image is not a `ToonImage`.
    """
    estimate = estimate_light(image)
    if estimate.is_guess:
        return replace(estimate, light=light_direction(*CUSTOMARY_LIGHT))
    return estimate


def sharpen(belief: LightBelief, drawing: PreparedDrawing, initial_normals: NormalField) -> LightBelief:
    """
    Update a predicted distribution by how well the learned shape explains the picture under likely lights.

    Parameters
    ----------
    belief : LightBelief
        The predicted distribution.
    drawing : PreparedDrawing
        The drawing.
    initial_normals : NormalField
        N0.

    Returns
    -------
    LightBelief
        The updated distribution. Each light that was tried is weighted by misfit^(-OBSERVATIONS / 2), the likelihood of
        that many Gaussian residuals of unknown variance. The distribution moves and narrows as the weighted mean and
        spread of these lights do. Equal misfits change nothing.
    """
    lights = candidates(belief)
    believed = belief.concentration * (lights @ belief.light)
    misfits = misfit(drawing, lights, initial_normals) + NEGLIGIBLE
    before, after = (_mean(lights, log) for log in (believed, believed - OBSERVATIONS / 2 * np.log(misfits)))
    light = belief.light + after - before
    drawn_together = float(np.linalg.norm(after) - np.linalg.norm(before))
    variance = max(1.0 / belief.concentration - drawn_together, 0.25 / belief.concentration)
    return LightBelief(light / np.linalg.norm(light), 1.0 / variance)


def candidates(belief: LightBelief) -> FloatArray:
    """Return lights to try, shape (n, 3): the likeliest one, then those of a ring around it that are not too low."""
    spread = float(np.clip(belief.concentration**-0.5, *SPREADS))
    light = belief.light
    beside = np.cross(light, [0.0, 0.0, 1.0] if light[2] < STRAIGHT else [1.0, 0.0, 0.0])
    beside /= np.linalg.norm(beside)
    above = np.cross(light, beside)
    angle = np.arange(TRIED)[:, None] * (2 * np.pi / TRIED)
    away = np.cos(angle) * beside + np.sin(angle) * above
    ring = np.cos(RING * spread) * light + np.sin(RING * spread) * away
    lowest = np.sin(np.deg2rad(LOWEST_ELEVATION))
    return np.concatenate([light[None], ring[ring[:, 2] > lowest]])


def _mean(lights: FloatArray, log_weights: FloatArray) -> FloatArray:
    weights = np.exp(log_weights - log_weights.max())
    mean: FloatArray = weights @ lights / weights.sum()
    return mean


def _explained_share(illumination: FloatArray, shades: FloatArray) -> float:
    """Share of the variance of the shades that a rising linear function of the illumination explains, 0 to 1."""
    deviation, rise = illumination - illumination.mean(), shades - shades.mean()
    norms = float(np.linalg.norm(deviation) * np.linalg.norm(rise))
    return max(float(deviation @ rise), 0.0) ** 2 / norms**2 if norms > 1e-12 else 0.0

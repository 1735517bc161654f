"""
A learned distribution of the direction of the light.

A small convolutional network sees the drawing on a square of `SIZE` pixels. `python -m toonkit.training light` trained
it on generated shapes and color maps; `weights/light_prior.json` records how.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array, summary
from toonkit.estimation.overview import Overview
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.tone_ranks import ToneRanks
from toonkit.estimation.turn import TURNS, Turn
from toonkit.estimation.weights import read_weights
from toonkit.estimation.working_square import WorkingSquare
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField

CHANNELS = 7
"""Feature maps of `features`."""

LEAST_CONCENTRATION = 0.05
"""Concentration without any information: nearly uniform over all directions."""

CERTAINTIES = (-4.0, 8.0)
"""Limits of the network's fourth number, the logarithm of a concentration."""


@dataclass(frozen=True, eq=False)
class LightBelief:
    """
    The predicted distribution of the light: von Mises-Fisher, on the sphere.

    Attributes
    ----------
    light : ndarray, shape (3,)
        Unit vector from the surface to the light, its mean.
    concentration : float
        About the inverse of the variance of each of the two angles, in radians.
    """

    light: FloatArray
    concentration: float

    def probability_within(self, degrees: float) -> float:
        """Return the probability that the light is at most so many degrees from the mean."""
        rise = 1.0 - np.cos(np.deg2rad(degrees))
        whole = -np.expm1(-2.0 * self.concentration)
        return float(-np.expm1(-self.concentration * rise) / whole)


def believed_light(drawing: ToonImage | PreparedDrawing, initial_normals: NormalField) -> LightBelief:
    """
    Predict the light with the network.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing.
    initial_normals : NormalField
        N0.

    Returns
    -------
    LightBelief
        Mean and concentration. Several islands share one light: their predictions are averaged by area, so that copies
        of a drawing do not count as further evidence.
    """
    drawing = prepare(drawing)
    pose = drawing.posed()
    islands = [pose.islands[k] for k in drawing.telling_islands]
    beliefs = []
    for k, island in zip(drawing.telling_islands, islands, strict=True):
        belief = _seen_on(pose.overview(k, initial_normals))
        beliefs.append(replace(belief, light=island.turn.vectors_back(belief.light)))
    if len(beliefs) == 1:
        return beliefs[0]
    total = np.average(
        [belief.concentration * belief.light for belief in beliefs],
        axis=0,
        weights=[island.grid.size for island in islands],
    )
    strength = float(np.linalg.norm(total))
    if strength < LEAST_CONCENTRATION:
        return LightBelief(np.array([0.0, 0.0, 1.0]), LEAST_CONCENTRATION)
    return LightBelief(total / strength, strength)


def _seen_on(overview: Overview) -> LightBelief:
    """Predict the light of one island."""
    square = WorkingSquare.around(overview.grid, np.array([1.0, 0.0]))
    drawn = overview.seen_from(square)
    if not drawn.mask.any():  # a line thinner than the square's pixels
        return LightBelief(np.array([0.0, 0.0, 1.0]), LEAST_CONCENTRATION)
    seen = features(drawn.tones, drawn.mask, drawn.ink, drawn.initial)
    weights = read_weights("light_prior")
    # The mean of the answers in all eight turns turns with the drawing.
    answers = [(turn, summary(weights, turned(seen, turn)).astype(np.float64)) for turn in TURNS]
    means = [turn.vectors_back(answer[:3] / np.linalg.norm(answer[:3])) for turn, answer in answers]
    total = np.mean(means, axis=0)
    agreement = float(np.linalg.norm(total))
    own = float(np.mean([concentration(float(answer[3])) for _, answer in answers]))
    # Answers that disagree add their scatter to the variance that each admits.
    return LightBelief(total / agreement, float(1.0 / (1.0 / own + 1.0 - agreement)))


def features(tones: Array, mask: BoolArray, ink: BoolArray, initial_normals: Array) -> Array:
    """
    Return the input of the network.

    Parameters
    ----------
    tones : ndarray, shape (SIZE, SIZE)
        Tones in [0, 1] of the painted colors.
    mask, ink : ndarray of bool, shape (SIZE, SIZE)
        The object, and where ink hides its paint.
    initial_normals : ndarray, shape (SIZE, SIZE, 3)
        N0.

    Returns
    -------
    ndarray of float32, shape (CHANNELS, SIZE, SIZE)
        Mask, N0, tone, rank and ink, zero beside the object.
    """
    ranks = ToneRanks.of(tones[mask])
    seen = np.zeros((CHANNELS, *mask.shape), np.float32)
    seen[0] = mask
    seen[1:4] = np.moveaxis(initial_normals, -1, 0)
    seen[4][mask] = ranks.tone
    seen[5][mask] = ranks.rank
    seen[6] = ink
    return seen * mask


def concentration(raw: float) -> float:
    """Map the network's fourth output, any real number, to a concentration between 0.05 and a few thousand."""
    return float(LEAST_CONCENTRATION + np.exp(np.clip(raw, *CERTAINTIES)))


def turned(seen: Array, turn: Turn) -> Array:
    """Turn features, N0 among them."""
    maps = np.moveaxis(turn.picture(np.moveaxis(seen, 0, -1)), -1, 0).copy()
    maps[1:4] = np.moveaxis(turn.vectors(np.moveaxis(maps[1:4], 0, -1)), -1, 0)
    return maps

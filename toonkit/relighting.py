"""Relighting (Section 3.4, Eq. 7): the same shape and colors under another light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_light
from toonkit.analysis import ToonAnalysis
from toonkit.model.image import ToonImage, nearest_object_pixel

DETAIL_RANGE = 0.15
"""Change of illumination over which the painted detail hands over to the model: about half a tone of a four-tone ramp."""


def relight(analysis: ToonAnalysis, new_light: ArrayLike, *, keep_detail: bool = True) -> ToonImage:
    """
    Put an analyzed picture under a new light.

    Parameters
    ----------
    analysis : ToonAnalysis
        The picture taken apart.
    new_light : array_like, shape (3,)
        Direction from the surface to the new light.
    keep_detail : bool, optional
        True keeps what the model does not explain (band edges, brush texture) where the illumination hardly changes, so
        that at the original light the input returns unchanged. False paints the model alone (Eq. 7).

    Returns
    -------
    ToonImage
        The relit picture, with the input's mask and alpha.

    Raises
    ------
    ToonkitError
        If the new light is zero, not finite or from behind.

    Notes
    -----
    With I = L · N and I' = L' · N the picture is c' = M(I') + w (c - M(I)), where w = exp(-((I' - I) / 0.15)²).
    Pixels that the object touches without filling them move as the nearest object pixel does.
    """
    light = as_light("new_light", new_light)
    before = analysis.illumination
    after = np.clip(analysis.normals.vectors @ light, -1.0, 1.0)
    model = analysis.color_map(after)
    image = analysis.image
    if not keep_detail:
        return ToonImage(model, image.mask, alpha=image.alpha)
    unexplained = image.color - analysis.color_map(before)
    color = np.clip(model + detail_weight(after - before)[..., None] * unexplained, 0.0, 1.0)
    return ToonImage(color, image.mask, alpha=image.alpha, fringe=_moved_fringe(image, color))


def detail_weight(change: FloatArray) -> FloatArray:
    """How much of the painted detail stays, 0 to 1, where the illumination changes by `change`."""
    return np.exp(-((change / DETAIL_RANGE) ** 2))


def _moved_fringe(image: ToonImage, color: FloatArray) -> FloatArray:
    touched = ~np.isnan(image.fringe[..., 0])
    fringe = np.full_like(color, np.nan)
    if touched.any():
        rows, columns = nearest_object_pixel(image.mask)
        there = rows[touched], columns[touched]
        fringe[touched] = np.clip(image.fringe[touched] + color[there] - image.color[there], 0.0, 1.0)
    return fringe

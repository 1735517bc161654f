"""Relighting (Section 3.4, Eq. 7): the same shape and colors under another light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_light, of_type
from toonkit.analysis import ToonAnalysis
from toonkit.model.image import ToonImage
from toonkit.model.shading import illumination

DETAIL_RANGE = 0.15
"""Change of illumination over which the painted detail hands over to the model: about half a tone of a four-tone ramp."""

DETAIL_SIZE = 0.1
"""Color difference, in sRGB, up to which what the model leaves unexplained is texture; a larger one is a misplaced edge."""


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
        If the new light is zero, not finite or from behind, or the analysis is none.

    Notes
    -----
    With I = L · N and I' = L' · N the picture is c' = M(I') + w d, where d = c - M(I) is the detail and

        w = exp(-((I' - I) / r)²),    r = 0.15 / (1 + |d|² / 0.1²).

    Texture, whose d is small, stays until the light has turned by half a tone. A large d is no texture but a band edge that
    the model put a pixel beside the painted one: it goes at the first turn of the light, or it would stay behind as a
    scratch where the edge was. Pixels that the object touches without filling them move as the nearest object pixel does.
    """
    of_type("analysis", analysis, ToonAnalysis)
    light = as_light("new_light", new_light)
    image, mask = analysis.image, analysis.image.mask
    after = illumination(analysis.normals, light)[mask]
    color = np.full_like(image.color, np.nan)
    color[mask] = analysis.color_map(after)
    if not keep_detail:
        return ToonImage(color, mask, alpha=image.alpha)
    before = analysis.illumination[mask]
    detail = image.color[mask] - analysis.color_map(before)
    kept = detail_weight(after - before, detail)[:, None] * detail
    color[mask] = np.clip(color[mask] + kept, 0.0, 1.0)
    return ToonImage(color, mask, alpha=image.alpha, fringe=_moved_fringe(image, color))


def detail_weight(change: FloatArray, detail: FloatArray) -> FloatArray:
    """Return how much of a detail (..., 3) stays, 0 to 1, where the illumination changes by `change` (...)."""
    size = np.sum(detail**2, axis=-1) / DETAIL_SIZE**2
    weight: FloatArray = np.exp(-((change * (1.0 + size) / DETAIL_RANGE) ** 2))
    return weight


def _moved_fringe(image: ToonImage, color: FloatArray) -> FloatArray:
    touched = ~np.isnan(image.fringe[..., 0])
    there = image.fringe_sources
    fringe = np.full_like(color, np.nan)
    fringe[touched] = np.clip(image.fringe[touched] + color[there] - image.color[there], 0.0, 1.0)
    return fringe

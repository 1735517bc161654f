"""
Recoloring: a drawing as its artist would have painted it with other color maps.

What the color map explains of a drawing changes with it. What it does not is either texture, which stays, or an edge that
lies a pixel beside the painted one, which goes, or it would stand out where the new map has no edge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.materials import Materials
from toonkit.model.tone_ramp import ToneRamp

TEXTURE = 0.15
"""Color difference, in sRGB, up to which what the model leaves unexplained is texture, which stays."""


def recolor_materials(drawn: Materials, ramps: Mapping[int, ToneRamp]) -> Materials:
    """Give some materials other tones; a material that stays flat is flat, and its color map has one color."""
    tones, flat, color_maps = list(drawn.tones), drawn.flat.copy(), list(drawn.color_maps)
    for number, ramp in ramps.items():
        tones[number] = ramp.colors[-1:] if flat[number] else ramp.colors
        color_maps[number] = ramp.color_map()
        if ramp.stays_flat:
            flat[number] = True
            color_maps[number] = ColorMap(tones[number].mean(axis=0)[None])
    return replace(drawn, tones=tuple(tones), flat=flat, color_maps=tuple(color_maps))


def recolor(
    paint: FloatArray,
    labels: NDArray[np.integer],
    illumination: FloatArray,
    drawn: Materials,
    materials: Materials,
    which: BoolArray,
) -> FloatArray:
    """
    Paint colors anew.

    Parameters
    ----------
    paint : ndarray, shape (n, 3)
        sRGB as drawn.
    labels : ndarray of int, shape (n,)
        Their materials.
    illumination : ndarray, shape (n,)
        L · N under the light of the drawing.
    drawn, materials : Materials
        The materials as they are drawn, and as they shall be.
    which : ndarray of bool, shape (count,)
        Those that change.

    Returns
    -------
    ndarray, shape (n, 3)
        sRGB.

    Notes
    -----
    With the color maps M and M' and the detail d = c - M(I), a shaded material becomes c' = M'(I) + k d, where k falls
    from 1 to max(1 - |d|² / 0.15², 0) as |M'(I) - M(I)| rises from 0 to 0.15. A flat one of color b becomes c' = c + b' - b.
    """
    changed = paint.copy()
    for number in np.flatnonzero(which):
        own = np.flatnonzero(labels == number)
        if drawn.flat[number]:
            changed[own] += materials.base_tones[number] - drawn.base_tones[number]
        else:
            was = drawn.color_maps[number](illumination[own])
            now = materials.color_maps[number](illumination[own])
            if materials.flat[number]:  # it stays as drawn
                now = was
            detail, moved = paint[own] - was, now - was
            share = np.minimum(np.sqrt(np.einsum("pc,pc->p", moved, moved)) / TEXTURE, 1.0)
            kept = 1.0 - share * (1.0 - texture_share(detail))
            changed[own] = now + kept[:, None] * detail
    return np.clip(changed, 0.0, 1.0, out=changed)


def texture_share(detail: FloatArray) -> FloatArray:
    """How much of details (n, 3) is texture, 1 to 0, shape (n,)."""
    share: FloatArray = np.maximum(1.0 - np.einsum("pc,pc->p", detail, detail) / TEXTURE**2, 0.0)
    return share

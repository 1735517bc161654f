"""Which tones could be shades of one paint, by their colors alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.illustration.tones import Matrix

SPREAD, SPREAD_PER_DROP = 0.028, 0.17
"""OKLab distance from the ray that gives cost 1: base value, plus this much per unit of lightness difference."""

FADE, BOOST = 0.3, 1.35
"""Minimum and maximum chroma of a shade relative to that of the brighter tone."""

COLORED, MIN_HUE_COSINE = 0.04, 0.5
"""Minimum chroma for the hue to be meaningful, and the minimum cosine of the angle between the hues of two shades."""

MIN_LIGHTNESS_RATIO = 0.3
"""Minimum lightness of a shade relative to the brighter tone."""


def shade_cost(lab: FloatArray) -> Matrix:
    """
    Return how poorly each pair of OKLab tones (n, 3) fits as shades of one paint: (n, n), zero on the diagonal.

    At 1 the color is one spread away from the ray. Merging allows up to `LARGEST_COST`, or `LARGEST_SMOOTH_COST` where
    the contact is mostly smooth.
    """
    darker, brighter, drop = _ordered(lab)
    dot, square = (brighter * darker).sum(axis=2), (brighter**2).sum(axis=2)
    scale = np.clip(dot / np.maximum(square, 1e-6), FADE, BOOST)
    off = np.linalg.norm(darker - scale[..., None] * brighter, axis=2)
    cost: Matrix = off / (SPREAD + SPREAD_PER_DROP * drop)
    np.fill_diagonal(cost, 0.0)
    return cost


def _ordered(lab: FloatArray) -> tuple[FloatArray, FloatArray, Matrix]:
    """Chroma vectors (n, n, 2) of the darker and the brighter tone of each pair, and how much darker it is (n, n)."""
    chroma = np.broadcast_to(lab[None, :, 1:], (len(lab), len(lab), 2))
    first_is_darker = (lab[:, None, 0] <= lab[None, :, 0])[..., None]
    other = chroma.transpose(1, 0, 2)
    darker, brighter = np.where(first_is_darker, other, chroma), np.where(first_is_darker, chroma, other)
    return darker, brighter, np.abs(lab[:, None, 0] - lab[None, :, 0])


def out_of_range(lab: FloatArray) -> NDArray[np.bool_]:
    """Mark pairs whose hue or lightness differs too much to be shades of one paint."""
    darker, brighter, drop = _ordered(lab)
    chroma = np.linalg.norm(darker, axis=2), np.linalg.norm(brighter, axis=2)
    colored = (chroma[0] > COLORED) & (chroma[1] > COLORED)
    turned = (darker * brighter).sum(axis=2) < MIN_HUE_COSINE * chroma[0] * chroma[1]
    deep = drop > (1.0 - MIN_LIGHTNESS_RATIO) * np.maximum(lab[:, None, 0], lab[None, :, 0])
    return np.asarray((colored & turned) | deep)

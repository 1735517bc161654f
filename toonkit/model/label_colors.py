"""The color of each label in a picture of materials."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import any_array, refuse
from toonkit.model.oklab import oklab_to_srgb
from toonkit.model.whole_pixels import opaque, put_pixels

MOST_NUMBER = 1 << 24
"""Largest number that is painted: there are no more colors than that."""

CHROMA, DARKEST, BRIGHTEST = 0.13, 0.62, 0.86
"""OKLab chroma of the colors, and their lightness, of which each takes one of three steps."""

_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def label_picture(labels: NDArray[np.integer]) -> NDArray[np.uint8]:
    """
    Paint each label (H, W), numbers from 0 on or -1 for nothing, in an RGBA color (H, W, 4) of its own.

    Successive numbers are far apart in hue, always in the same color; -1 is transparent.

    Examples
    --------
    >>> label_picture(np.array([[-1, 0, 1]]))[0, :, 3].tolist()
    [0, 255, 255]
    """
    array = any_array("labels", labels)
    if array.ndim != 2 or array.dtype.kind not in "iu" or array.size == 0:
        raise refuse("labels", "must be an (H, W) array of integers", f"shape {array.shape}, {array.dtype}")
    if array.max() > MOST_NUMBER:
        raise refuse("labels", f"must be numbers up to {MOST_NUMBER:,}", int(array.max()))
    labels = array.astype(np.intp)
    number = np.arange(int(labels.max()) + 1)
    hue = number * _GOLDEN_ANGLE
    lightness = DARKEST + (BRIGHTEST - DARKEST) * (number % 3) / 2
    colors = oklab_to_srgb(np.column_stack([lightness, CHROMA * np.cos(hue), CHROMA * np.sin(hue)]))
    inside = labels >= 0
    rgba = np.zeros((*labels.shape, 4), np.uint8)
    put_pixels(rgba, inside, opaque(np.round(np.clip(colors, 0, 1) * 255).astype(np.uint8))[labels[inside]])
    return rgba

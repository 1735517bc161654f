"""A color map taken from a drawing by a stroke over one material (Section 4.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import any_array, describe_value, refuse, same_shape
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear, tone

SAMPLES = 1024
"""Most samples of an extracted color map. If there are more pixels, several share a sample."""

MIN_STROKE = 2
"""Fewest object pixels under a stroke. A single pixel has no dark and no bright end."""


def extract_color_map(image: ToonImage | PreparedDrawing, stroke: ArrayLike) -> ColorMap:
    """
    Take a color map from a drawing: the pixels under a stroke over one material, sorted by luminance.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The drawing.
    stroke : array_like of bool, shape (H, W)
        True under the stroke. Pixels outside the object are ignored. Pixels that the object covers in part are ignored
        if at least two others remain. Under line art the paint beneath it counts.

    Returns
    -------
    ColorMap
        One sample per pixel under the stroke, at most 1024, over -1 to 1. A tone takes the same share of the domain as
        of the stroke.

    Raises
    ------
    ToonkitError
        If the stroke is not a mask of the picture's size, or covers fewer than two pixels of the object.

    Examples
    --------
    >>> picture = ToonImage(np.linspace([0.2, 0, 0.2], [1, 0.8, 0.6], 16)[None].repeat(4, 0), np.ones((4, 16)))
    >>> extract_color_map(picture, np.arange(64).reshape(4, 16) < 16).colors[-1].round(6).tolist()
    [1.0, 0.8, 0.6]
    """
    drawing = prepare(image)
    passes = any_array("stroke", stroke)
    if passes.ndim != 2 or passes.dtype != np.bool_:
        raise refuse("stroke", "must be a (H, W) bool array, such as array > 0", describe_value(passes))
    same_shape("stroke", passes.shape, drawing.shape, "the picture")
    touched = passes & drawing.mask
    if not touched.any():
        raise refuse("stroke", "must pass over the object", f"{int(passes.sum())} pixels, none of them on it")
    if touched.sum() < MIN_STROKE:
        raise refuse("stroke", f"must pass over at least {MIN_STROKE} object pixels", int(touched.sum()))
    filled = touched & (drawing.alpha >= 1)
    chosen = filled if filled.sum() >= MIN_STROKE else touched
    colors = drawing.without_ink[chosen[drawing.mask]]
    ordered = srgb_to_linear(colors[np.argsort(tone(colors), kind="stable")])
    # Means of runs of ranks, of light: the mean of brighter colors is never darker.
    runs = np.array_split(ordered, min(len(ordered), SAMPLES))
    return ColorMap(linear_to_srgb(np.array([run.mean(axis=0) for run in runs])))

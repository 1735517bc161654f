"""The study's color maps, and the tool that takes one from a drawing (Section 4.1)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, refuse, same_shape
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear, tone

SAMPLES = 1024
"""Samples of a ramp over -1..1: a hard step is then 1/500 of illumination wide."""

MIN_STROKE = 2
"""Object pixels under a stroke: one has no dark and no bright end."""


@dataclass(frozen=True)
class Ramp:
    """
    A color map as a painter would write it down.

    Attributes
    ----------
    name : str
        Its key.
    tones : tuple of str
        Colors from dark to bright, `#rrggbb` sRGB.
    steps : tuple of (float, float)
        Illumination at which each tone gives way to the next, and how wide the transition is.
    tags : tuple of str
        What is particular about it.
    """

    name: str
    tones: tuple[str, ...]
    steps: tuple[tuple[float, float], ...]
    tags: tuple[str, ...]

    def color_map(self) -> ColorMap:
        """Return the ramp as a `ColorMap` over -1..1, with smooth steps between its tones, mixed as light is."""
        illumination = np.linspace(-1.0, 1.0, SAMPLES)
        colors = srgb_to_linear(np.array([_rgb(value) for value in self.tones]))
        light = np.repeat(colors[:1], SAMPLES, axis=0)
        for (at, softness), darker, brighter in zip(self.steps, colors[:-1], colors[1:], strict=True):
            share = np.clip((illumination - at) / max(softness, 1e-9) + 0.5, 0.0, 1.0)
            light += (share**2 * (3 - 2 * share))[:, None] * (brighter - darker)
        return ColorMap(np.clip(linear_to_srgb(light), 0.0, 1.0))


@cache
def load_ramps() -> dict[str, Ramp]:
    """Read the study's ramps: name -> `Ramp`, in the order of `color_maps.json`."""
    records = json.loads(files("toonkit.study").joinpath("color_maps.json").read_text(encoding="utf-8"))
    return {
        record["name"]: Ramp(
            record["name"],
            tuple(record["tones"]),
            tuple((step["at"], step["softness"]) for step in record["steps"]),
            tuple(record["tags"]),
        )
        for record in records
    }


def load_color_maps() -> dict[str, ColorMap]:
    """Return the study's color maps: name -> `ColorMap` of 1024 samples over -1..1."""
    return {name: ramp.color_map() for name, ramp in load_ramps().items()}


def extract_color_map(image: ToonImage, stroke: ArrayLike) -> ColorMap:
    """
    Take a color map from a drawing: the pixels under a stroke over one material, sorted by luminance.

    Parameters
    ----------
    image : ToonImage
        The drawing.
    stroke : array_like of bool, shape (H, W)
        True under the stroke. What lies outside the object is ignored, and so are pixels that the object only
        covers in part as long as two others remain.

    Returns
    -------
    ColorMap
        One sample per pixel under the stroke, at most 1024, over -1..1: a tone takes the share of the domain
        that it has of the stroke.

    Raises
    ------
    ToonkitError
        If the stroke is no mask of the picture's size, misses the object, or touches fewer than two of its
        pixels.

    Examples
    --------
    >>> picture = ToonImage(np.linspace([0.2, 0, 0.2], [1, 0.8, 0.6], 16)[None].repeat(4, 0), np.ones((4, 16)))
    >>> extract_color_map(picture, np.arange(64).reshape(4, 16) < 16).colors[-1].round(6).tolist()
    [1.0, 0.8, 0.6]
    """
    passes = np.asarray(stroke)
    if passes.ndim != 2 or passes.dtype != np.bool_:
        raise refuse("stroke", "must be a (H, W) bool array", f"shape {passes.shape}, {passes.dtype}")
    same_shape("stroke", passes.shape, image.shape, "the picture")
    touched = passes & image.mask
    if not touched.any():
        raise refuse("stroke", "must pass over the object", f"{int(passes.sum())} pixels, none of them on it")
    if touched.sum() < MIN_STROKE:
        raise refuse("stroke", f"must pass over at least {MIN_STROKE} object pixels", int(touched.sum()))
    filled = touched & (image.alpha >= 1)
    colors = image.color[filled if filled.sum() >= MIN_STROKE else touched]
    ordered = srgb_to_linear(colors[np.argsort(tone(colors), kind="stable")])
    # Means of runs of ranks, of light: the mean of brighter colors is never darker.
    runs = np.array_split(ordered, min(len(ordered), SAMPLES))
    return ColorMap(linear_to_srgb(np.array([run.mean(axis=0) for run in runs])))


def _rgb(value: str) -> FloatArray:
    return np.array([int(value[start : start + 2], 16) / 255 for start in (1, 3, 5)])

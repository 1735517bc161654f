"""The study's color maps (Section 4.1)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear

SAMPLES = 1024
"""Samples of a ramp over -1 to 1. A hard step is 1/500 of illumination wide."""


@dataclass(frozen=True)
class Ramp:
    """
    A color map as a list of tones and the steps between them.

    Attributes
    ----------
    name : str
        Name in `color_maps.json`.
    tones : tuple of str
        Colors from dark to bright, `#rrggbb` sRGB.
    steps : tuple of (float, float)
        Illumination at which each tone gives way to the next, and how wide the transition is.
    tags : tuple of str
        Descriptive labels.
    """

    name: str
    tones: tuple[str, ...]
    steps: tuple[tuple[float, float], ...]
    tags: tuple[str, ...]

    @property
    def softness(self) -> float:
        """Mean width of the steps between its tones, in illumination."""
        return float(np.mean([width for _, width in self.steps])) if self.steps else 0.0

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


def _rgb(value: str) -> FloatArray:
    return np.array([int(value[start : start + 2], 16) / 255 for start in (1, 3, 5)])

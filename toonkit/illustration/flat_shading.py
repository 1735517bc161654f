"""
Flat shading: color maps for materials that are painted in one tone.

Such a material does not show how its color changes with the light. It gets shadows like those of the shaded materials,
or a plain shadow if there are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.luminance import linear_to_srgb
from toonkit.model.oklab import oklab_to_srgb, srgb_to_oklab

SAMPLES = 256
"""Samples of a derived color map, over all illuminations."""

DARKNESS = (0.6, 0.9)
"""Least and greatest OKLab lightness of a derived shadow, relative to the lit tone."""

FADE = (0.7, 1.3)
"""Least and greatest chroma of a derived shadow, relative to that of the lit tone."""

MOST_TINT = 0.03
"""Greatest tint of a derived shadow, in OKLab, on white."""

EDGE = (-0.2, 0.6)
"""Least and greatest illumination at which a derived shadow begins."""

WIDTH = (0.04, 0.8)
"""Least and greatest width, in illumination, of the transition from a derived shadow to the lit tone."""

LEAST_STEP = 0.03
"""Least difference of OKLab lightness between a material's tones for its shadow to serve as an example."""

LEAST_SHARE = 0.02
"""Least share of the object that shaded materials must cover for their shadows to serve as examples."""


@dataclass(frozen=True)
class Shadow:
    """
    How a shadow differs from the lit tone.

    Attributes
    ----------
    darkness : float
        Its OKLab lightness, relative.
    fade : float
        Its chroma, relative.
    tint : (float, float)
        Offset of its OKLab a and b, relative to the lightness of the lit tone.
    edge : float
        Illumination halfway between shadow and light.
    width : float
        Width of the transition, in illumination.
    """

    darkness: float
    fade: float
    tint: tuple[float, float]
    edge: float
    width: float

    def color_map(self, lit: FloatArray) -> ColorMap:
        """Return the map of a material whose lit tone, sRGB (3,), is known."""
        bright = srgb_to_oklab(lit)
        dark = np.array(
            [self.darkness * bright[0], *(self.fade * bright[1:] + bright[0] * np.array(self.tint))]
        )
        where = np.linspace(-1.0, 1.0, SAMPLES)
        rise = np.clip((where - self.edge) / self.width + 0.5, 0.0, 1.0)
        share = (rise * rise * (3.0 - 2.0 * rise))[:, None]
        return ColorMap(np.clip(oklab_to_srgb((1.0 - share) * dark + share * bright), 0.0, 1.0))


def _shadow_on_white(linear: tuple[float, float, float], edge: float, width: float) -> Shadow:
    """Return the shadow that multiplies linear light."""
    lightness, a, b = srgb_to_oklab(linear_to_srgb(np.array(linear)))
    return Shadow(float(lightness), 1.0, (float(a), float(b)), edge, width)


PLAIN = _shadow_on_white((0.55, 0.52, 0.66), edge=0.25, width=0.12)
"""A cool shadow. It covers a little less than half of a ball that is lit from the side."""


def derive_shadow(color_maps: Sequence[ColorMap], areas: FloatArray) -> Shadow:
    """Derive the shadow of flat materials: the median of the shaded ones' by area, or a plain one if these are few."""
    found = [_shadow_of(color_map) for color_map in color_maps]
    kept = [(shadow, area) for shadow, area in zip(found, areas, strict=True) if shadow is not None]
    if sum(area for _, area in kept) < LEAST_SHARE:
        return PLAIN
    rows = np.array([[s.darkness, s.fade, *s.tint, s.edge, s.width] for s, _ in kept])
    weights = np.array([area for _, area in kept])
    darkness, fade, a, b, edge, width = (_weighted_median(column, weights) for column in rows.T)
    tint = np.array([a, b]) * min(1.0, MOST_TINT / max(float(np.hypot(a, b)), 1e-9))
    return Shadow(
        float(np.clip(darkness, *DARKNESS)),
        float(np.clip(fade, *FADE)),
        (float(tint[0]), float(tint[1])),
        float(np.clip(edge, *EDGE)),
        float(np.clip(width, *WIDTH)),
    )


def _shadow_of(color_map: ColorMap) -> Shadow | None:
    """Measure the shadow of a material; None if its tones hardly differ."""
    lab = srgb_to_oklab(color_map.colors)
    lightness = np.maximum.accumulate(lab[:, 0])
    dark, bright = lab[0], lab[-1]
    rise = lightness[-1] - lightness[0]
    if rise < LEAST_STEP:
        return None
    low, middle, high = np.interp(
        lightness[0] + rise * np.array([0.2, 0.5, 0.8]), lightness, color_map.illumination
    )
    chroma = np.hypot(*bright[1:])
    fade = float(dark[1:] @ bright[1:]) / max(float(chroma**2), 1e-6) if chroma > LEAST_STEP else 1.0
    fade = float(np.clip(fade, *FADE))
    tint = (dark[1:] - fade * bright[1:]) / bright[0]
    return Shadow(
        float(dark[0] / bright[0]),
        fade,
        (float(tint[0]), float(tint[1])),
        float(middle),
        float(high - low) / 0.6,
    )


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    order = np.argsort(values)
    reached = np.cumsum(weights[order]) >= 0.5 * weights.sum()
    return float(values[order][np.argmax(reached)])

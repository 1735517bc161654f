"""Paint of a drawing under any light: color maps, highlights and cast shadows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.synthetic.model import Model
from toonkit.synthetic.palette import random_bases, random_shading, smooth_ramp, stepped_ramp
from toonkit.synthetic.surface_samples import Samples
from toonkit.synthetic.tracing import Frame, Tracer

HIGHLIT, SHADOWED = 0.5, 0.25
"""Shares of the drawings with highlights, and with a cast shadow."""

SMALL = 0.03
"""Share of the object below which a material counts as a detail, which most painters leave flat."""

_SHADOW_RAYS = 512  # along each side of the light's view


@dataclass(frozen=True, eq=False)
class Highlights:
    """
    Bright spots on glossy materials.

    Attributes
    ----------
    glossy : ndarray of bool, shape (m,)
        Which materials have them.
    cosine : float
        Least cosine of the angle between the normal and the direction halfway between light and viewer, on a highlight.
    color : ndarray, shape (3,)
        sRGB.
    opacity : float
        Share of that color.
    """

    glossy: BoolArray
    cosine: float
    color: FloatArray
    opacity: float


@dataclass(frozen=True, eq=False)
class Paint:
    """
    Painted samples.

    Attributes
    ----------
    color : ndarray, shape (n, 3)
        sRGB.
    highlight, shadow : ndarray of bool, shape (n,)
        Where a highlight covers, and where a shadow falls on what faces the light.
    """

    color: FloatArray
    highlight: BoolArray
    shadow: BoolArray


@dataclass(frozen=True, eq=False)
class Painter:
    """
    The paint of one drawing under any light.

    Attributes
    ----------
    samples : Samples
        What is painted.
    model : Model
        What casts shadows.
    color_maps : tuple of ColorMap
        One a material.
    highlights : Highlights or None
        None if there are none.
    shadow_tint : ndarray, shape (3,), or None
        What a cast shadow multiplies colors with; None if no shadow is cast.
    """

    samples: Samples
    model: Model
    color_maps: tuple[ColorMap, ...]
    highlights: Highlights | None
    shadow_tint: FloatArray | None

    def paint(self, light: FloatArray) -> Paint:
        """Paint under a light, a unit vector in the axes of the picture."""
        samples = self.samples
        lit = np.clip(samples.normals @ light, -1.0, 1.0)
        color = np.empty((len(lit), 3))
        for number, color_map in enumerate(self.color_maps):
            own = samples.material == number
            color[own] = color_map(lit[own])
        shadow = np.zeros(len(lit), np.bool_)
        if self.shadow_tint is not None:
            shadow = self._shadowed(light, lit)
            color[shadow] *= self.shadow_tint
        highlight = np.zeros(len(lit), np.bool_)
        if self.highlights is not None:
            shiny = self.highlights
            half = light + np.array([0.0, 0.0, 1.0])
            toward = samples.normals @ (half / np.linalg.norm(half))
            highlight = shiny.glossy[samples.material] & (toward >= shiny.cosine) & ~shadow & (lit > 0)
            color[highlight] += shiny.opacity * (shiny.color - color[highlight])
        return Paint(color, highlight, shadow)

    def _shadowed(self, light: FloatArray, lit: FloatArray) -> BoolArray:
        """Tell which samples that face the light do not see it: something is nearer in the light's own view."""
        side = np.cross([0.0, 1.0, 0.0] if abs(light[1]) < 0.9 else [1.0, 0.0, 0.0], light)
        side /= np.linalg.norm(side)
        axes = np.array([side, np.cross(light, side), light])
        tracer = Tracer([part.solid for part in self.model.parts], axes @ self.model.view)
        tight = tracer.enclosing_frame()
        frame = Frame(tight.center, tight.width * 1.02)
        depth = tracer.trace(frame, _SHADOW_RAYS, normals=False).depth
        texel = frame.width / _SHADOW_RAYS
        seen = self.samples.positions @ axes.T
        column = ((seen[:, 0] - frame.center[0]) / texel + _SHADOW_RAYS / 2).astype(np.intp)
        row = ((frame.center[1] - seen[:, 1]) / texel + _SHADOW_RAYS / 2).astype(np.intp)
        last = _SHADOW_RAYS - 1
        nearest = depth[np.clip(row, 0, last), np.clip(column, 0, last)]
        # A texel away along the surface the depth differs by its slope.
        slope = np.sqrt(1 - lit**2) / np.maximum(lit, 0.05)
        return np.asarray((lit > 0.05) & (nearest > seen[:, 2] + 2 * texel * (1 + slope)))


def random_painter(samples: Samples, model: Model, rng: np.random.Generator) -> Painter:
    """Draw the colors of a model's materials, and whether there are highlights and cast shadows."""
    names = samples.names
    areas = np.bincount(samples.material, minlength=len(names)) / len(samples.material)
    bases = random_bases([model.paints[name] for name in names], rng)
    shading = random_shading(rng)
    gradients = rng.choice([0.0, 0.15, 0.6], p=[0.55, 0.3, 0.15])  # how often this painter paints them
    flats = rng.choice([0.05, 0.25], p=[0.6, 0.4])
    color_maps, flat = [], np.zeros(len(names), np.bool_)
    for number, area in enumerate(areas):
        flat[number] = rng.random() < (0.7 if area < SMALL else flats) and area < 0.35
        if flat[number]:
            color_maps.append(stepped_ramp(bases[number], 1, shading, rng))
        elif rng.random() < gradients:
            color_maps.append(smooth_ramp(bases[number], shading, rng))
        else:
            color_maps.append(
                stepped_ramp(bases[number], int(rng.choice([2, 3, 4], p=[0.5, 0.38, 0.12])), shading, rng)
            )
    highlights = None
    if rng.random() < HIGHLIT:
        glossy = ~flat & (rng.random(len(names)) < rng.choice([0.35, 1.0]))
        glossy[areas.argmax()] = True
        color = np.array([1.0, 1.0, rng.uniform(0.9, 1.0)])
        angle = np.deg2rad(rng.uniform(10, 20))
        highlights = Highlights(
            glossy, float(np.cos(angle)), color, float(rng.choice([1.0, rng.uniform(0.5, 0.9)]))
        )
    tint = None
    if rng.random() < SHADOWED:
        tint = rng.uniform(0.55, 0.75) * np.array([1.0, rng.uniform(0.95, 1.0), rng.uniform(1.0, 1.25)])
    return Painter(samples, model, tuple(color_maps), highlights, tint)

"""Drawings to learn from: a shape of the dataset, turned, lit, painted and perhaps inked at random."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array
from toonkit.estimation.shape_prior import material_borders
from toonkit.model.light import light_direction
from toonkit.training.dataset import Dataset
from toonkit.training.inking import random_ink, remove_ink
from toonkit.training.materials import paint_materials, random_labels
from toonkit.training.painting import random_ramp

ELEVATIONS = (12.0, 88.0)
"""Degrees between which the light stands."""

DOUBTFUL = 0.5
"""Share of the drawings, where there may be such, whose light is known only approximately."""

DOUBTS = (1.5, 30.0)
"""Standard deviations of such a light about each of two axes, degrees: small ones as often as large ones."""

INKED = 0.4
"""Share of the drawings to learn from that have line art, where there is room for it."""

OUTLINED = 0.6
"""The same of drawings in several materials."""

BETWEEN = 0.7
"""Share of these that have lines between their materials."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """
    What is painted, and what is true.

    Attributes
    ----------
    tones : ndarray of float32, shape (S, S)
        As painted, relative to the brightest of its material if there are several; under ink and on flat materials those of
        the nearest paint that shows shading, as in `toonkit.estimation.shading_ratio`.
    ink : ndarray of bool, shape (S, S)
        Where no shading shows: under ink and on flat materials.
    borders : ndarray of bool, shape (S, S), or None
        Where one material meets another; None of a drawing that is painted with one.
    mask : ndarray of bool, shape (S, S)
        The object.
    initial_normals, normals : ndarray of float32, shape (S, S, 3)
        N0 and the truth.
    light : ndarray of float32, shape (3,)
        Unit vector toward the light, as far as is known.
    doubt : float
        Standard deviation of the true light from it about each of two axes, radians, before those behind the image plane
        are drawn again.
    """

    tones: Array
    ink: BoolArray
    borders: BoolArray | None
    mask: BoolArray
    initial_normals: Array
    normals: Array
    light: Array
    doubt: float


@dataclass(frozen=True, eq=False)
class Drawings:
    """
    Endless drawings of some shapes.

    Attributes
    ----------
    dataset : Dataset
        All shapes.
    first, last : int
        Which of them: from `first` to before `last`.
    """

    dataset: Dataset
    first: int
    last: int

    def draw(
        self,
        rng: np.random.Generator,
        *,
        turned: bool,
        doubtful: bool = False,
        inked: float = 0.0,
        colored: bool = False,
    ) -> Drawing:
        """
        Draw one.

        Parameters
        ----------
        rng : Generator
            Source of every choice.
        turned : bool
            Whether the light may come from any azimuth; otherwise it comes from the right.
        doubtful : bool, optional
            Whether it is often known only approximately.
        inked : float, optional
            Probability of line art, where there is room for it.
        colored : bool, optional
            Whether it is painted with several materials.
        """
        which, variant = int(rng.integers(self.first, self.last)), int(rng.integers(8))
        shape = self.dataset.view(which, variant)
        azimuth = rng.uniform(0.0, 360.0) if turned else 0.0
        light = light_direction(azimuth, rng.uniform(*ELEVATIONS))
        ramp = random_ramp(rng)
        doubt = _draw_doubt(rng) if doubtful else 0.0
        illumination = shape.normals @ tilt_light(light, doubt, rng).astype(np.float32)
        tones, told, borders = ramp(illumination).astype(np.float32), shape.mask, None
        if colored:
            labels = random_labels(shape.parts, rng)
            borders = material_borders(labels, shape.mask)
            in_materials, shows = paint_materials(labels, illumination, rng)
            if shows.any():
                tones, told = in_materials, shows
        hidden = shape.mask & ~told
        if rng.random() < inked:
            drawn = shape.contours
            if borders is not None and rng.random() < BETWEEN:
                drawn = drawn | borders
            ink = random_ink(shape.mask, drawn, shape.normals, rng)
            if (told & ~ink).any():
                hidden |= ink
        return Drawing(
            tones=remove_ink(tones, hidden, shape.mask),
            ink=hidden,
            borders=borders,
            mask=shape.mask,
            initial_normals=shape.initial_normals,
            normals=shape.normals,
            light=light.astype(np.float32),
            doubt=doubt,
        )


def _draw_doubt(rng: np.random.Generator) -> float:
    """Draw how far off, in radians, the light may be; often 0."""
    return float(np.deg2rad(np.exp(rng.uniform(*np.log(DOUBTS))))) if rng.random() < DOUBTFUL else 0.0


def tilt_light(light: FloatArray, doubt: float, rng: np.random.Generator) -> FloatArray:
    """Draw a direction around a light, in front of the image plane; with no doubt, the light itself."""
    if doubt == 0.0:
        return light
    while True:
        away = light + np.tan(doubt) * rng.normal(size=3)
        if away[2] > 0.0:
            return np.asarray(away / np.linalg.norm(away))

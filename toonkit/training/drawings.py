"""Drawings to learn from: a shape of the dataset, turned, lit, painted and perhaps inked at random."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array
from toonkit.model.light import light_direction
from toonkit.training.dataset import Dataset
from toonkit.training.inking import random_ink, uninked
from toonkit.training.painting import random_ramp

ELEVATIONS = (12.0, 88.0)
"""Degrees between which the light stands."""

DOUBTFUL = 0.5
"""Share of the drawings, where there may be such, whose light is known only approximately."""

DOUBTS = (1.5, 30.0)
"""Standard deviations of such a light about each of two axes, degrees: small ones as often as large ones."""

INKED = 0.4
"""Share of the drawings to learn from that have line art, where there is room for it."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """
    What is painted, and what is true.

    Attributes
    ----------
    tones : ndarray of float32, shape (S, S)
        As painted; under ink those of the nearest paint that shows, as in `toonkit.illustration`.
    ink : ndarray of bool, shape (S, S)
        Where ink hides the paint.
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
        self, rng: np.random.Generator, *, turned: bool, doubtful: bool = False, inked: float = 0.0
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

        Returns
        -------
        Drawing
            The drawing.
        """
        which, variant = int(rng.integers(self.first, self.last)), int(rng.integers(8))
        normals, initial, mask, contours = self.dataset.view(which, variant)
        azimuth = rng.uniform(0.0, 360.0) if turned else 0.0
        light = light_direction(azimuth, rng.uniform(*ELEVATIONS))
        ramp = random_ramp(rng)
        doubt = 0.0
        if doubtful and rng.random() < DOUBTFUL:
            doubt = float(np.deg2rad(np.exp(rng.uniform(*np.log(DOUBTS)))))
        tones = ramp(normals @ tilted(light, doubt, rng).astype(np.float32)).astype(np.float32)
        ink = np.zeros_like(mask)
        if rng.random() < inked:
            ink = random_ink(mask, contours, normals, rng)
        shown = uninked(tones, ink, mask)
        return Drawing(shown, ink, mask, initial, normals, light.astype(np.float32), doubt)


def tilted(light: FloatArray, doubt: float, rng: np.random.Generator) -> FloatArray:
    """Draw a direction around a light, in front of the image plane; with no doubt, the light itself."""
    if doubt == 0.0:
        return light
    while True:
        away = light + np.tan(doubt) * rng.normal(size=3)
        if away[2] > 0.0:
            return np.asarray(away / np.linalg.norm(away))

"""Drawings to learn from: a shape of the dataset, turned, lit and painted at random."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray
from toonkit.estimation.convolution import Array
from toonkit.model.light import light_direction
from toonkit.training.dataset import Dataset
from toonkit.training.painting import random_ramp

ELEVATIONS = (12.0, 88.0)
"""Degrees between which the light stands."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """
    What is painted, and what is true.

    Attributes
    ----------
    tones : ndarray of float32, shape (S, S)
        As painted.
    mask : ndarray of bool, shape (S, S)
        The object.
    initial_normals, normals : ndarray of float32, shape (S, S, 3)
        N0 and the truth.
    light : ndarray of float32, shape (3,)
        Unit vector toward the light.
    """

    tones: Array
    mask: BoolArray
    initial_normals: Array
    normals: Array
    light: Array


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

    def draw(self, rng: np.random.Generator, *, turned: bool) -> Drawing:
        """Draw one, lit from any azimuth if `turned`, and otherwise from the right."""
        which, variant = int(rng.integers(self.first, self.last)), int(rng.integers(8))
        normals, initial, mask = self.dataset.view(which, variant)
        azimuth = rng.uniform(0.0, 360.0) if turned else 0.0
        light = light_direction(azimuth, rng.uniform(*ELEVATIONS)).astype(np.float32)
        tones = random_ramp(rng)(normals @ light).astype(np.float32)
        return Drawing(tones, mask, initial, normals, light)

"""Random color maps: what a shape's illumination may be painted as, as far as tones go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray

HARD = 0.004
"""Width of a hard step, in illumination."""


@dataclass(frozen=True, eq=False)
class RandomRamp:
    """
    Tones of a color map, without its hues.

    Attributes
    ----------
    tones : ndarray, shape (n,)
        In [0, 1], dark to bright.
    edges, widths : ndarray, shape (n - 1,)
        Illumination at which each tone gives way to the next, and over what width.
    """

    tones: FloatArray
    edges: FloatArray
    widths: FloatArray

    def __call__(self, illumination: NDArray[Any]) -> FloatArray:
        """Return the tones of illuminations of any shape, in steps of an 8-bit picture."""
        painted = np.full(illumination.shape, self.tones[0])
        for edge, width, rise in zip(self.edges, self.widths, np.diff(self.tones), strict=True):
            share = np.clip((illumination - edge) / width + 0.5, 0.0, 1.0)
            painted += rise * share**2 * (3 - 2 * share)
        return np.asarray(np.rint(np.clip(painted, 0.0, 1.0) * 255) / 255)


def random_ramp(rng: np.random.Generator) -> RandomRamp:
    """Draw a color map: two to six tones; all steps hard, all soft, or mixed."""
    count = int(rng.choice([2, 3, 4, 5, 6], p=[0.22, 0.36, 0.24, 0.1, 0.08]))
    tones = random_tones(rng, count)
    edges = np.sort(rng.uniform(-0.5, 0.95, count - 1))
    kind = rng.random()
    if kind < 0.4:
        widths = np.full(count - 1, HARD)
    elif kind < 0.75:
        widths = np.exp(rng.uniform(np.log(0.05), np.log(1.4), count - 1))
    else:
        widths = np.where(rng.random(count - 1) < 0.5, HARD, rng.uniform(0.05, 0.9, count - 1))
    return RandomRamp(tones, edges, widths)


def random_tones(rng: np.random.Generator, count: int) -> FloatArray:
    """Draw so many tones in [0, 1], dark to bright, that can be told apart."""
    tones = np.sort(rng.uniform(0.05, 1.0, count))
    tones = tones[0] + np.concatenate([[0.0], np.cumsum(np.maximum(np.diff(tones), 0.06))])
    return np.asarray(tones / max(tones[-1], 1.0))

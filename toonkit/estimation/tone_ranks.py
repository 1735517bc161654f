"""What a network is told of a pixel's color: its tone and how many pixels are darker, both of 0 to 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit.estimation.convolution import Array


@dataclass(frozen=True, eq=False)
class ToneRanks:
    """
    The pixels of an object in the order of their tones; those of one tone share their place.

    Attributes
    ----------
    tone : ndarray, shape (P,)
        0 for the darkest, 1 for the brightest.
    below : ndarray of int, shape (P,)
        How many pixels are darker.
    upto : ndarray of int, shape (P,)
        How many are not brighter, the pixel itself among them.
    """

    tone: Array
    below: NDArray[np.intp]
    upto: NDArray[np.intp]

    @classmethod
    def of(cls, tones: Array) -> ToneRanks:
        """Rank tones (P,) in [0, 1], told apart as an 8-bit picture does."""
        level = np.rint(tones * 255).astype(np.intp)
        upto = np.cumsum(np.bincount(level, minlength=256))
        below = np.concatenate([[0], upto[:-1]])
        darkest, brightest = float(tones.min()), float(tones.max())
        return cls((tones - darkest) / max(brightest - darkest, 1e-3), below[level], upto[level])

    @property
    def rank(self) -> NDArray[np.float64]:
        """The middle place of a pixel's tone, as a share of all pixels, shape (P,)."""
        return np.asarray((self.below + self.upto) / (2.0 * len(self.tone)))

"""What every step needs of a drawing, read once: pixels, outline, ink, tones and the inflated shape (Section 3.1)."""

from __future__ import annotations

from functools import cached_property
from threading import Lock
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.inflation import inflated_normals
from toonkit.estimation.line_art import LineArt, found_line_art
from toonkit.estimation.painted_tones import PaintedTones, decoded
from toonkit.estimation.silhouette import Silhouette, trace_silhouette
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import MaskedGrid

REMEMBERED = 2
"""Readings that are kept, as long as their pictures live: analyzing one again under another light is quick."""


class Reading:
    """
    A drawing's pixels, outline, ink, tones and inflated shape, each made when it is first asked for.

    Parameters
    ----------
    color : ndarray, shape (H, W, 3)
        sRGB in [0, 1] on the object.
    mask : ndarray, shape (H, W)
        bool, True on the object.
    alpha : ndarray, shape (H, W)
        Coverage in [0, 1].
    """

    def __init__(self, color: FloatArray, mask: BoolArray, alpha: FloatArray) -> None:
        self._color, self._mask, self._alpha = color, mask, alpha

    @cached_property
    def grid(self) -> MaskedGrid:
        """The object's pixels."""
        return MaskedGrid(self._mask)

    @cached_property
    def silhouette(self) -> Silhouette:
        """The outline, between the pixels."""
        return trace_silhouette(self.grid, self._alpha)

    @cached_property
    def line_art(self) -> LineArt | None:
        """The ink, if there is any."""
        return found_line_art(self._color, self._decoded[1], self.grid)

    @property
    def inked_places(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Row and column of each pixel that the ink touches."""
        pixels = np.zeros(0, np.intp) if self.line_art is None else self.line_art.pixels
        return self.grid.rows[pixels], self.grid.columns[pixels]

    @property
    def paint(self) -> FloatArray:
        """The colors without the ink, shape (P, 3)."""
        return self._colors if self.line_art is None else self.line_art.removed(self._colors)

    @cached_property
    def tones(self) -> PaintedTones:
        """The tones of the paint, without the ink."""
        if self.line_art is None:
            return PaintedTones.between(*self._decoded, self.grid)
        return PaintedTones.of(self.paint, self.grid)

    @cached_property
    def initial_normals(self) -> NormalField:
        """N0, inflated from the outline."""
        return inflated_normals(self.grid, self.silhouette)

    @property
    def _colors(self) -> FloatArray:
        return self.grid.gather(self._color)

    @cached_property
    def _decoded(self) -> tuple[FloatArray, FloatArray]:
        return decoded(self._colors)


_READINGS: WeakKeyDictionary[ToonImage, Reading] = WeakKeyDictionary()
_ONE_AT_A_TIME = Lock()  # a dashboard relights while it analyzes


def reading(image: ToonImage) -> Reading:
    """Return what is read off a drawing; of the last few drawings it is remembered."""
    with _ONE_AT_A_TIME:
        known = _READINGS.pop(image, None)
        found = Reading(image.color, image.mask, image.alpha) if known is None else known
        _READINGS[image] = found  # the last one in the order of use
        for older in list(_READINGS)[:-REMEMBERED]:
            _READINGS.pop(older, None)
    return found

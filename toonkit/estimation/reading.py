"""What every step needs of a drawing, read once: pixels, outline, tones and the inflated shape (Section 3.1)."""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.inflation import inflated_normals
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.estimation.silhouette import Silhouette, trace_silhouette
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import MaskedGrid

REMEMBERED = 2
"""Readings that are kept, as long as their pictures live: analyzing one again under another light is quick."""


class Reading:
    """
    A drawing's pixels, outline, tones and inflated shape, each made when it is first asked for.

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
    def tones(self) -> PaintedTones:
        """The painted colors' tones."""
        return PaintedTones.of(self._color[self._mask], self.grid)

    @cached_property
    def initial_normals(self) -> NormalField:
        """N0, inflated from the outline."""
        return inflated_normals(self.grid, self.silhouette)


_READINGS: WeakKeyDictionary[ToonImage, Reading] = WeakKeyDictionary()


def reading(image: ToonImage) -> Reading:
    """Return what is read off a drawing; of the last few drawings it is remembered."""
    known = _READINGS.pop(image, None)
    found = Reading(image.color, image.mask, image.alpha) if known is None else known
    _READINGS[image] = found  # the last one in the order of use
    for older in list(_READINGS)[:-REMEMBERED]:
        _READINGS.pop(older, None)
    return found

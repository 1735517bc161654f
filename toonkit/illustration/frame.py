"""The object's bounding box with a margin. All work is done on it, so that padding a picture changes nothing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.model.oklab import Lab, tabulated_oklab
from toonkit.model.whole_pixels import pixels_at, put_pixels
from toonkit.numerics.masked_grid import Box, bounding_box

MARGIN = 1
"""Margin around the bounding box, in pixels, so that every pixel of the object has eight neighbors."""


@dataclass(frozen=True, eq=False)
class Frame:
    """
    An object, cut out.

    Attributes
    ----------
    place : (slice, slice)
        Rows and columns of the bounding box in the picture.
    mask : ndarray of bool, shape (h, w)
        The object within the box and its margin.
    pixels : ndarray, shape (P, 3)
        sRGB of the object's pixels.
    views : int
        How often it shows the object side by side, as the frames of an animation do.
    """

    place: Box
    mask: BoolArray
    pixels: FloatArray
    views: int = 1

    @classmethod
    def around(cls, color: FloatArray, mask: BoolArray, *, views: int = 1) -> Frame:
        """Cut out the object of a picture (H, W, 3); colors outside the mask (H, W) are ignored."""
        return cls.of_pixels(pixels_at(color, mask), mask, views=views)

    @classmethod
    def of_pixels(cls, pixels: FloatArray, mask: BoolArray, *, views: int = 1) -> Frame:
        """Cut out an object whose pixels, those of a mask (H, W), have some colors (P, 3)."""
        place = bounding_box(mask)
        return cls(place, np.pad(mask[place], MARGIN), pixels, views)

    @property
    def color(self) -> FloatArray:
        """The colors, sRGB, shape (h, w, 3); zero outside the mask. Made whenever it is asked for."""
        color = np.zeros((*self.mask.shape, 3))
        put_pixels(color, self.mask, self.pixels)
        return color

    @cached_property
    def lab(self) -> Lab:
        """The same in OKLab, float32. Made when it is first asked for, and kept until `release`."""
        return tabulated_oklab(self.color)

    def release(self) -> None:
        """Free what can be made again."""
        self.__dict__.pop("lab", None)

    def cut(self, values: NDArray[Any]) -> NDArray[Any]:
        """Cut values (H, W, ...) of the picture to this frame, zero in the margin."""
        around = [(MARGIN, MARGIN)] * 2 + [(0, 0)] * (values.ndim - 2)
        return np.pad(values[self.place], around)

    def inner(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values (h, w, ...) of this frame without the margin."""
        return values[MARGIN:-MARGIN, MARGIN:-MARGIN]

    def compact(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values (h, w, ...) of this frame at the object's pixels, (P, ...)."""
        return np.asarray(values[self.mask])

    @property
    def size(self) -> float:
        """Square root of the object's area, in pixels: of one view of it."""
        return float(np.sqrt(np.count_nonzero(self.mask) / self.views))

"""Colored light and ambient light on paint whose shadow and lit tone are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.luminance import srgb_to_linear
from toonkit.numerics.compiled import njit
from toonkit.numerics.parallel import run_on_row_chunks


@dataclass(frozen=True, eq=False)
class LightColor:
    """
    The effect of colored and ambient light on the materials of a drawing.

    Attributes
    ----------
    color : ndarray, shape (3,)
        Color of the light in linear light; 1 in each channel is white.
    ambient : float
        How much light comes from all sides, 0 to 1.
    shadows, lit_tones : ndarray, shape (count, 3)
        The ends of each material's color map, in linear light.
    """

    color: FloatArray
    ambient: float
    shadows: FloatArray
    lit_tones: FloatArray

    @classmethod
    def of(cls, color: FloatArray, ambient: float, color_maps: Sequence[ColorMap]) -> LightColor:
        """Take a light's color, sRGB (3,), and the color maps of the materials it falls on."""
        ends = (
            srgb_to_linear(np.array([color_map.colors[end] for color_map in color_maps])) for end in (0, -1)
        )
        return cls(srgb_to_linear(color), ambient, *ends)

    @property
    def is_white(self) -> bool:
        """Whether colors stay as they are."""
        return bool((self.color == 1.0).all())

    def filled(self, colors: FloatArray, labels: NDArray[np.integer]) -> None:
        """Let ambient light fall on colors (..., 3), sRGB, of some materials (...): a share of the way to the lit tone."""
        if self.ambient > 0.0:
            self._change(colors, labels, np.ones(3), self.ambient)

    def tinted(self, colors: FloatArray, labels: NDArray[np.integer]) -> None:
        """Tint what colors (..., 3), sRGB, of some materials (...) have in addition to the shadow."""
        if not self.is_white:
            self._change(colors, labels, self.color, 0.0)

    def _change(
        self, colors: FloatArray, labels: NDArray[np.integer], color: FloatArray, ambient: float
    ) -> None:
        flat = colors.reshape(-1, 3)
        run_on_row_chunks(_change, labels.ravel(), flat, self.shadows, self.lit_tones, color, ambient)


@njit(cache=True, nogil=True, error_model="numpy")
def _change(labels, colors, shadows, lit_tones, color, ambient, first, last):  # type: ignore[no-untyped-def]
    for pixel in range(first, last):
        which = labels[pixel]
        if which < 0:
            continue
        for k in range(3):
            value = colors[pixel, k]
            linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
            changed = linear + ambient * max(lit_tones[which, k] - linear, 0.0)
            changed -= (1.0 - color[k]) * max(changed - shadows[which, k], 0.0)
            if changed != linear:  # elsewhere encoding what was decoded would round
                changed = changed * 12.92 if changed <= 0.0031308 else 1.055 * changed ** (1.0 / 2.4) - 0.055
                colors[pixel, k] = min(max(changed, 0.0), 1.0)

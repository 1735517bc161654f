"""A drawing in several materials as one gray picture: each color relative to the brightest one of its material."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.islands import Island
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.model.image import nearest_object_pixel
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear
from toonkit.numerics.masked_grid import IndexArray, MaskedGrid

BRIGHTEST = 0.98
"""Share of a material's pixels that are at most as bright as its brightest tone; others are highlights and noise."""

LIT = 0.8
"""Linear light of the brightest tone in the gray picture."""


@dataclass(frozen=True, eq=False)
class PaintedMaterial:
    """
    One material of a drawing.

    Attributes
    ----------
    pixels : ndarray of int, shape (p,), or slice
        Which of the object's pixels are painted with it.
    tones : PaintedTones or None
        Their tones; None if it is flat.
    """

    pixels: IndexArray | slice
    tones: PaintedTones | None


@dataclass(frozen=True, eq=False)
class GrayPaint:
    """
    What an object's pixels show of shading.

    Attributes
    ----------
    light : ndarray, shape (P,)
        Luminance, linear and without the colors of materials.
    tone : ndarray, shape (P,)
        Its tone, plain.
    hidden : ndarray of bool, shape (P,)
        Where no shading shows: under ink and highlights, and on flat materials. There, light and tone are those of the
        nearest pixel of the same island that shows shading.
    """

    light: FloatArray
    tone: FloatArray
    hidden: BoolArray


def gray_paint(
    materials: Sequence[PaintedMaterial], islands: Sequence[Island], covered: BoolArray
) -> GrayPaint:
    """
    Divide the colors of each material by its brightest tone.

    Parameters
    ----------
    materials : sequence of PaintedMaterial
        All of a drawing.
    islands : sequence of Island
        All parts of the object.
    covered : ndarray of bool, shape (P,)
        Where ink or a highlight covers the paint.

    Returns
    -------
    GrayPaint
        A drawing in one material stays as it is.
    """
    if len(materials) == 1 and materials[0].tones is not None:
        tones = materials[0].tones
        return GrayPaint(srgb_to_linear(tones.tone), tones.plain, covered)
    gray, told = np.full(len(covered), LIT), np.zeros(len(covered), np.bool_)
    for material in materials:
        if material.tones is None:
            continue
        gray[material.pixels] = relative_shade(srgb_to_linear(material.tones.tone))
        told[material.pixels] = True
    for island in islands:
        shown = told[island.pixels]
        if shown.any() and not shown.all():
            gray[island.pixels] = _nearest(gray[island.pixels], shown, island.grid)
    return GrayPaint(gray, np.asarray(linear_to_srgb(gray)), covered | ~told)


def relative_shade(shade: FloatArray) -> FloatArray:
    """Scale the linear light (p,) of one material so that its brightest tone becomes `LIT`."""
    return np.asarray(LIT * np.minimum(shade / max(float(np.quantile(shade, BRIGHTEST)), 1e-6), 1.0))


def _nearest(values: FloatArray, known: BoolArray, grid: MaskedGrid) -> FloatArray:
    """Give each pixel of an island, both of shape (p,), the value of the nearest one that is known."""
    picture = np.zeros(grid.mask.shape, np.bool_)
    picture[grid.mask] = known
    return np.asarray(values[grid.index[nearest_object_pixel(picture)][grid.mask]])

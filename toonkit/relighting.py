"""Relighting (Section 3.4, Eq. 7): the same shape and colors under another light."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from toonkit._validation import BoolArray, FloatArray, as_light, of_type
from toonkit.analysis import ToonAnalysis
from toonkit.model.image import ToonImage
from toonkit.numerics.bands import run_in_bands

DETAIL_RANGE = 0.15
"""Change of illumination over which the painted detail hands over to the model: about half a tone of a four-tone ramp."""

DETAIL_SIZE = 0.1
"""Color difference, in sRGB, up to which what the model leaves unexplained is texture; a larger one is a misplaced edge."""


def relight(analysis: ToonAnalysis, new_light: ArrayLike, *, keep_detail: bool = True) -> ToonImage:
    """
    Put an analyzed picture under a new light.

    Parameters
    ----------
    analysis : ToonAnalysis
        The picture taken apart.
    new_light : array_like, shape (3,)
        Direction from the surface to the new light.
    keep_detail : bool, optional
        True keeps what the model does not explain (band edges, brush texture) where the illumination hardly changes, so
        that at the original light the input returns unchanged. False paints the model alone (Eq. 7).

    Returns
    -------
    ToonImage
        The relit picture, with the input's mask and alpha.

    Raises
    ------
    ToonkitError
        If the new light is zero, not finite or from behind, or the analysis is none.

    Notes
    -----
    With I = L · N and I' = L' · N the picture is c' = M(I') + w d, where d = c - M(I) is the detail and

        w = (1 - ((I' - I) / 2r)²)⁴ within 2r, else 0,    r = 0.15 / (1 + |d|² / 0.1²),

    nearly the bell exp(-((I' - I) / r)²), but with an end.
    Texture, whose d is small, stays until the light has turned by half a tone. A large d is no texture but a band edge that
    the model put a pixel beside the painted one: it goes at the first turn of the light, or it would stay behind as a
    scratch where the edge was. Pixels that the object touches without filling them move as the nearest object pixel does.
    Line art stays as it is drawn: what it covers in part changes for the rest.
    """
    of_type("analysis", analysis, ToonAnalysis)
    light = as_light("new_light", new_light)
    image, color_map, vectors = analysis.image, analysis.color_map, analysis.normals.vectors

    def relit(mask: BoolArray, normals: FloatArray, painted: FloatArray) -> FloatArray:
        color = np.empty_like(painted)
        run_in_bands(
            _paint, mask, normals, painted, analysis.light, light,
            np.ascontiguousarray(color_map.colors), *color_map.domain, keep_detail, color,
        )  # fmt: skip
        return color

    color = relit(image.mask, vectors, image.color)
    ink = analysis.drawing.line_art
    if ink is not None:
        inked = analysis.drawing.inked_places
        everywhere = np.ones((len(inked[0]), 1), np.bool_)
        beneath = relit(everywhere, vectors[inked][:, None], ink.beneath[:, None])
        color[inked] = ink.over(beneath[:, 0])
    fringe = color[image.fringe_sources]
    if keep_detail:
        fringe = np.clip(fringe + image.fringe_colors - image.color[image.fringe_sources], 0.0, 1.0)
    return ToonImage.like(image, color, fringe)


@njit(cache=True, nogil=True, error_model="numpy")
def _paint(  # type: ignore[no-untyped-def]
    mask, normals, painted, light, new_light, colors, low, high, keep_detail, color, first, last
):
    """Paint the rows from first to last; NaN where there is no object."""
    lx, ly, lz = light
    x, y, z = new_light
    for row in range(first, last):
        for column in range(mask.shape[1]):
            if not mask[row, column]:
                color[row, column, 0] = color[row, column, 1] = color[row, column, 2] = np.nan
                continue
            n0, n1, n2 = normals[row, column, 0], normals[row, column, 1], normals[row, column, 2]
            was, now = lx * n0 + ly * n1 + lz * n2, x * n0 + y * n1 + z * n2
            red, green, blue = _mapped(colors, low, high, now)
            if keep_detail and abs(now - was) < 2.0 * DETAIL_RANGE:  # farther off nothing is kept
                was_red, was_green, was_blue = _mapped(colors, low, high, was)
                more_red = painted[row, column, 0] - was_red
                more_green = painted[row, column, 1] - was_green
                more_blue = painted[row, column, 2] - was_blue
                kept = detail_weight(now - was, more_red**2 + more_green**2 + more_blue**2)
                if kept > 0.0:
                    red = min(max(red + kept * more_red, 0.0), 1.0)
                    green = min(max(green + kept * more_green, 0.0), 1.0)
                    blue = min(max(blue + kept * more_blue, 0.0), 1.0)
            color[row, column, 0], color[row, column, 1], color[row, column, 2] = red, green, blue


@njit(cache=True, nogil=True, error_model="numpy")
def detail_weight(change: float, squared_size: float) -> float:
    """Return how much of a detail of |d|² stays, 0 to 1, where the illumination changes by `change`."""
    turn = change * (1.0 + squared_size / DETAIL_SIZE**2) / (2.0 * DETAIL_RANGE)
    left = max(1.0 - turn * turn, 0.0)
    return left * left * left * left


@njit(cache=True, nogil=True, error_model="numpy")
def _mapped(colors, low, high, illumination):  # type: ignore[no-untyped-def]
    """Return the color of an illumination, linear between samples; as `ColorMap` does."""
    steps = colors.shape[0] - 1
    if steps == 0:
        return colors[0, 0], colors[0, 1], colors[0, 2]
    position = (min(max(illumination, low), high) - low) * (steps / (high - low))
    start = min(int(position), steps - 1)
    share = position - start
    return (
        (1.0 - share) * colors[start, 0] + share * colors[start + 1, 0],
        (1.0 - share) * colors[start, 1] + share * colors[start + 1, 1],
        (1.0 - share) * colors[start, 2] + share * colors[start + 1, 2],
    )

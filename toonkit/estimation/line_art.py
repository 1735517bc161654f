"""
Line art: ink over the shading, told apart from it.

Hardly a light paints these: a silhouette that is dark all around, and a color darker than all that the silhouette shows. For
a light leaves the part of every silhouette bright that faces it, and the darkest shading of a closed shape lies on it, where
the normals face farthest away. Only under a light from straight ahead a whole silhouette may be evenly dark: such a rim of
shading is taken for an outline.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import (
    distance_transform_cdt,
    distance_transform_edt,
    find_objects,
    label,
    maximum_filter,
)

from toonkit._validation import BoolArray, FloatArray
from toonkit.numerics.masked_grid import DOWN, LEFT, OUTSIDE, RIGHT, UP, MaskedGrid

DARKEST_PAINT = 0.35
"""Tone above which an outline is no ink."""

SAME = 0.08
"""Tones of one ink differ by less than this."""

GAP = 0.15
"""Tone by which ink is darker than the paint beside it."""

ALL_AROUND = 0.92
"""Share of the silhouette that an outline follows."""

FOLLOWED, LEFT_OVER = 0.8, 0.3
"""Shares of the silhouette along which an outline is at least as wide as its least width, and as its width."""

WIDEST = 0.06
"""Width of an outline at most, and half of that of a mark, in square roots of the object's area."""

EVEN = 0.3
"""Least width of an outline, relative to its width: what is more uneven is a shadow's crescent."""

HAIRLINE = 3.0
"""Pixels up to which a line is too thin for its width to be even."""

EXCEPTIONS = 0.01
"""Share of the silhouette that may be as dark as ink: where lines end on it."""

FEWEST, MOST = 0.0005, 0.25
"""Shares of the object: less ink than this is a speck, and more is paint."""

BLUR, DARKER = 2, 0.03
"""Pixels beside a line that may be mixed with it, and the tone by which they then are darker than those after them."""


@dataclass(frozen=True, eq=False)
class LineArt:
    """
    A drawing's ink, and the paint beneath: such a pixel shows coverage * ink + (1 - coverage) * beneath.

    Attributes
    ----------
    pixels : ndarray, shape (n,)
        Compact index of each pixel that ink touches.
    sources : ndarray, shape (n,)
        That of the nearest pixel that none touches.
    coverage : ndarray, shape (n,)
        Share of each that is ink, above 0 and up to 1.
    drawn, beneath : ndarray, shape (n, 3)
        Their colors with the ink and without, sRGB in [0, 1]: beneath is the color of the source.
    """

    pixels: NDArray[np.intp]
    sources: NDArray[np.intp]
    coverage: FloatArray
    drawn: FloatArray
    beneath: FloatArray

    def over(self, paint: FloatArray) -> FloatArray:
        """Return the colors of these pixels, (n, 3), on other paint (n, 3) than what is beneath."""
        return np.clip(self.drawn + (1.0 - self.coverage)[:, None] * (paint - self.beneath), 0.0, 1.0)

    def removed(self, colors: FloatArray) -> FloatArray:
        """Return the drawing's colors (P, 3) without the ink."""
        paint = colors.copy()
        paint[self.pixels] = self.beneath
        return paint


def find_line_art(
    colors: FloatArray,
    tone: FloatArray,
    grid: MaskedGrid,
    *,
    rim: NDArray[np.intp] | None,
    cut: tuple[bool, bool, bool, bool],
    area: int,
) -> LineArt | None:
    """
    Find the ink of a drawing.

    Parameters
    ----------
    colors : ndarray, shape (P, 3)
        sRGB in [0, 1] of the object's pixels.
    tone : ndarray, shape (P,)
        Their tones in [0, 1].
    grid : MaskedGrid
        The pixels.
    rim : ndarray of int, shape (n,), or None
        Those on the silhouette; None if that does not face all four ways, so that the frame could hide the darkest shading.
    cut : tuple of bool
        Whether the frame cut the object off to the RIGHT, UP, LEFT and DOWN.
    area : int
        Pixels of the largest island: lines are narrow relative to its size.

    Returns
    -------
    LineArt or None
        None if there is none.
    """
    if rim is None:
        return None
    widest = WIDEST * np.sqrt(area)
    ink = _outline(tone, grid, rim, cut, widest)
    clean = None if ink is None else _untouched(ink, tone, grid)
    under = tone if clean is None or not clean.any() else tone[_nearest(clean, grid, distance_transform_cdt)]
    limit = np.sort(_darkest_near(under, grid, rim))[int(EXCEPTIONS * rim.size)] - GAP
    marks = under < limit
    if marks.any():
        marks = _narrow(marks, widest, grid)
    if marks.any():
        ink = marks if ink is None else marks | ink
        clean = _untouched(ink, tone, grid)
    if ink is None or clean is None or not clean.any() or not FEWEST <= ink.mean() <= MOST:
        return None
    nearest = _nearest(clean, grid, distance_transform_edt)
    coverage = _coverage(tone, ink, nearest)
    touched = np.flatnonzero(coverage)
    sources = nearest[touched]
    return LineArt(touched, sources, coverage[touched], colors[touched], colors[sources])


def _darkest_near(tone: FloatArray, grid: MaskedGrid, pixels: NDArray[np.intp]) -> FloatArray:
    """Least tone of the object within `BLUR` pixels of some pixels: a rim may be mixed with what was behind it."""
    framed = np.pad(grid.index, BLUR, constant_values=OUTSIDE)
    rows, columns = grid.rows[pixels], grid.columns[pixels]
    tones = np.append(tone, np.inf)  # of OUTSIDE, the last one
    least = np.full(len(pixels), np.inf)
    for down in range(2 * BLUR + 1):
        for along in range(2 * BLUR + 1):
            np.minimum(least, tones[framed[rows + down, columns + along]], out=least)
    return least


def _outline(
    tone: FloatArray,
    grid: MaskedGrid,
    rim: NDArray[np.intp],
    cut: tuple[bool, bool, bool, bool],
    widest: float,
) -> BoolArray | None:
    """Pixels of the ink that follows the silhouette, and of all lines that are as dark and up to about twice as wide."""
    around = _darkest_near(tone, grid, rim)
    ink_tone = float(np.median(around))
    if ink_tone > DARKEST_PAINT or np.mean(around < ink_tone + SAME) < ALL_AROUND:
        return None
    dark = tone < ink_tone + SAME
    framed = np.pad(grid.mask, 1)
    for direction, line in ((RIGHT, np.s_[:, -1]), (UP, np.s_[0]), (LEFT, np.s_[:, 0]), (DOWN, np.s_[-1])):
        framed[line] = cut[direction]  # where the frame cut it off, the object goes on
    inward = _depth(framed, grid)
    shares = (np.bincount(inward, dark) / np.maximum(np.bincount(inward), 1))[1:]
    start = int(np.argmax(shares[: BLUR + 1]))  # a rim may be mixed with what was behind it
    after = np.append(shares[start:], 0.0)
    least_width, width = (start + int(np.argmax(after < share)) for share in (FOLLOWED, LEFT_OVER))
    if width > widest or (width > HAIRLINE and least_width < EVEN * width):
        return None
    beside = tone[(inward > width + BLUR) & (inward <= width + 2 * BLUR)]
    if beside.size == 0 or np.median(beside) < ink_tone + GAP:
        return None
    return _narrow(dark, width + 1, grid)


def _narrow(chosen: BoolArray, half_width: float, grid: MaskedGrid) -> BoolArray:
    """Return the chosen pixels (P,) but for those of parts that are wider than twice the half width."""
    picture = _on_picture(chosen, grid)
    core = distance_transform_edt(picture) > half_width
    if not core.any():
        return chosen
    wide = picture & (distance_transform_edt(~core) <= half_width)
    # What is left of a wide part in its corners is short; a line that ends on one goes on.
    rest, _ = label(picture & ~wide, np.ones((3, 3)))
    beside = np.unique(rest[maximum_filter(wide, 3)])
    extents = find_objects(rest)
    for number in beside[beside > 0]:
        down, along = extents[number - 1]
        if max(down.stop - down.start, along.stop - along.start) <= 2 * half_width:
            wide[extents[number - 1]] |= rest[extents[number - 1]] == number
    return _of_object(picture & ~wide, grid)


def _untouched(ink: BoolArray, tone: FloatArray, grid: MaskedGrid) -> BoolArray:
    """
    Pixels (P,) that no ink touches.

    Those beside a line are mixed with it: one, or two where those too are mostly darker than what comes after them. No more
    are given up than need be, for colors change fastest at the silhouette.
    """
    away = _depth(~_on_picture(ink, grid), grid)
    beyond, second = away > BLUR, away == BLUR
    if not (beyond.any() and second.any()):
        return beyond
    after = tone[_nearest(beyond, grid, distance_transform_cdt)]
    blurred = np.median(after[second] - tone[second]) > DARKER
    return beyond if blurred else beyond | second


def _nearest(chosen: BoolArray, grid: MaskedGrid, transform: Callable[..., Any]) -> NDArray[np.intp]:
    """Compact index of the chosen pixel (P,) nearest to each pixel, as a distance transform of scipy measures it."""
    rows, columns = transform(~_on_picture(chosen, grid), return_distances=False, return_indices=True)
    framed = np.pad(grid.index, 1, constant_values=OUTSIDE)
    return _of_object(framed[rows, columns], grid).astype(np.intp)


def _depth(inside: BoolArray, grid: MaskedGrid) -> NDArray[np.int32]:
    """How many pixels deep each of the object's pixels lies in some part of the framed picture, 1 at its edge; 0 outside."""
    return _of_object(distance_transform_cdt(inside, "chessboard"), grid)


def _on_picture(chosen: BoolArray, grid: MaskedGrid) -> BoolArray:
    """Pixels (P,) as a picture with a frame of one pixel, (H + 2, W + 2), False beside the object."""
    picture = np.zeros(grid.mask.shape, np.bool_)
    picture[grid.mask] = chosen
    return np.pad(picture, 1)


def _of_object(picture: NDArray[Any], grid: MaskedGrid) -> NDArray[Any]:
    """Return what a framed picture (H + 2, W + 2) holds at the object's pixels, (P,)."""
    return np.asarray(picture[1:-1, 1:-1][grid.mask])


def _coverage(tone: FloatArray, ink: BoolArray, nearest: NDArray[np.intp]) -> FloatArray:
    """Share of ink (P,): one on it, and beside it by how far its tone lies between ink and paint, from a fiftieth on."""
    paint = tone[nearest]
    drop = paint - float(np.median(tone[ink]))
    share = np.divide(paint - tone, drop, out=np.zeros(len(tone)), where=drop > SAME)
    coverage = np.where(ink, 1.0, np.minimum(share, 1.0))
    return np.where(coverage < 0.02, 0.0, coverage)

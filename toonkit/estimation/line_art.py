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
from toonkit.numerics.masked_grid import OUTSIDE, STEPS, MaskedGrid

DARKEST_PAINT = 0.35
"""Tone above which an outline is no ink."""

SAME = 0.08
"""Tones of one ink differ by less than this."""

GAP = 0.15
"""Tone by which ink is darker than the paint beside it."""

ALL_AROUND = 0.92
"""Share of the silhouette that an outline follows."""

FOLLOWED, LEFT = 0.8, 0.3
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


def found_line_art(color: FloatArray, tone: FloatArray, grid: MaskedGrid) -> LineArt | None:
    """
    Find the ink of a drawing.

    Parameters
    ----------
    color : ndarray, shape (H, W, 3)
        sRGB in [0, 1] on the object.
    tone : ndarray, shape (P,)
        Tones of the object's pixels in [0, 1].
    grid : MaskedGrid
        The pixels.

    Returns
    -------
    LineArt or None
        None if there is none, or if a silhouette that the frame cuts off could hide the darkest shading.
    """
    rim = _silhouette_pixels(grid)
    if rim is None:
        return None
    ink = _outline(tone, grid, rim)
    clean = None if ink is None else _untouched(ink, tone, grid)
    under = tone if clean is None or not clean.any() else tone[_nearest(clean, grid, distance_transform_cdt)]
    limit = np.sort(_darkest_near(under, grid, rim))[int(EXCEPTIONS * rim.size)] - GAP
    marks = under < limit
    if marks.any():
        marks = _narrow(marks, WIDEST * np.sqrt(grid.size), grid)
    if marks.any():
        ink = marks if ink is None else marks | ink
        clean = _untouched(ink, tone, grid)
    if ink is None or clean is None or not clean.any() or not FEWEST <= ink.mean() <= MOST:
        return None
    nearest = _nearest(clean, grid, distance_transform_edt)
    coverage = _coverage(tone, ink, nearest)
    touched = np.flatnonzero(coverage)
    sources = nearest[touched]
    drawn, beneath = (color[grid.rows[which], grid.columns[which]] for which in (touched, sources))
    return LineArt(touched, sources, coverage[touched], drawn, beneath)


def _silhouette_pixels(grid: MaskedGrid) -> NDArray[np.intp] | None:
    """Pixels on the silhouette, those on the frame apart; None if it does not face all four ways."""
    height, width = grid.mask.shape
    facing = []
    for direction, (down, along) in enumerate(STEPS):
        open_there = np.flatnonzero(grid.neighbors[:, direction] == OUTSIDE)
        row, column = grid.rows[open_there] + down, grid.columns[open_there] + along
        facing.append(open_there[(row >= 0) & (row < height) & (column >= 0) & (column < width)])
    return np.unique(np.concatenate(facing)) if all(side.size for side in facing) else None


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


def _outline(tone: FloatArray, grid: MaskedGrid, rim: NDArray[np.intp]) -> BoolArray | None:
    """Pixels of the ink that follows the silhouette, and of all lines that are as dark and up to about twice as wide."""
    around = _darkest_near(tone, grid, rim)
    ink_tone = float(np.median(around))
    if ink_tone > DARKEST_PAINT or np.mean(around < ink_tone + SAME) < ALL_AROUND:
        return None
    dark = tone < ink_tone + SAME
    inward = _depth(grid.mask, grid)  # beyond the frame the object goes on
    shares = (np.bincount(inward, dark) / np.maximum(np.bincount(inward), 1))[1:]
    start = int(np.argmax(shares[: BLUR + 1]))  # a rim may be mixed with what was behind it
    after = np.append(shares[start:], 0.0)
    least_width, width = (start + int(np.argmax(after < share)) for share in (FOLLOWED, LEFT))
    if width > WIDEST * np.sqrt(grid.size) or (width > HAIRLINE and least_width < EVEN * width):
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
    narrow: BoolArray = (picture & ~wide)[grid.mask]
    return narrow


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
    nearest: NDArray[np.intp] = grid.index[rows, columns][grid.mask].astype(np.intp)
    return nearest


def _depth(inside: BoolArray, grid: MaskedGrid) -> NDArray[np.int32]:
    """How many pixels deep each of the object's pixels lies in some part (H, W) of the picture, 1 at its edge; 0 outside."""
    depth: NDArray[np.int32] = distance_transform_cdt(inside, "chessboard")
    deep: NDArray[np.int32] = depth[grid.mask]
    return deep


def _on_picture(chosen: BoolArray, grid: MaskedGrid) -> BoolArray:
    """Pixels (P,) as a picture (H, W), False beside the object."""
    picture = np.zeros(grid.mask.shape, np.bool_)
    picture[grid.mask] = chosen
    return picture


def _coverage(tone: FloatArray, ink: BoolArray, nearest: NDArray[np.intp]) -> FloatArray:
    """Share of ink (P,): one on it, and beside it by how far its tone lies between ink and paint, from a fiftieth on."""
    paint = tone[nearest]
    drop = paint - float(np.median(tone[ink]))
    share = np.divide(paint - tone, drop, out=np.zeros(len(tone)), where=drop > SAME)
    coverage = np.where(ink, 1.0, np.minimum(share, 1.0))
    return np.where(coverage < 0.02, 0.0, coverage)

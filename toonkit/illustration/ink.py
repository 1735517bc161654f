"""
Ink: thin lines over the paint.

A line is darker than the paint on both of its sides, and much narrower than the object. Shading makes such dark strips,
too: a crescent of shadow along the silhouette, or the gap between two parts. Ink differs from shading in where its
color occurs. The color of an outline follows the silhouette all around, also where it faces the light. The shadow color
of a closed shape never does. The color of inner lines occurs almost nowhere else, whereas the color of shading also
occurs along the silhouette.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.filling import nearest_sources
from toonkit.illustration.frame import Frame
from toonkit.illustration.neighborhoods import grown, shrunk
from toonkit.model.oklab import Lab
from toonkit.model.whole_pixels import pixels_at

WIDEST = 0.035
"""Greatest width of a line, in square roots of the object's area."""

SMALLEST = 50.0
"""Square root of the area, in pixels, up to which lines are at most two pixels wide. In larger objects lines may be
four pixels wide or more."""

TINY = 16.0
"""Square root of the area, in pixels, up to which paint may be as narrow as lines."""

DARKER = 0.07
"""Least difference of OKLab lightness between a line and the paint beside it."""

SAME_INK = 0.06
"""OKLab distance within which colors are one ink."""

MIXING_REACH = 2
"""Pixels beside a line that may be mixed with it."""

OFF_MIXTURE = 0.12
"""Greatest distance of a mixed pixel from the mixtures of ink and paint, in sRGB."""

LEAST_COVERAGE = 0.12
"""Coverage below which a pixel counts as paint."""

PIECE = 0.65
"""Least share of a color that lies in strips, for it to be the ink of a part of the outline."""

BLACK = 0.2
"""OKLab lightness below which a color is seldom a shadow."""

ENCLOSED, ENCLOSED_BY_BLACK = 0.75, 0.62
"""Least share of the silhouette that an outline follows, on opposite sides at once. The shading of one material follows
less of it: its darkest color lies where the silhouette faces away from the light, and along gaps between parts."""

SPECK = 0.0008
"""Least share of the object that the ink of one color covers."""

PAINT = 0.05
"""Coverage below which a pixel shows only paint."""

CELL, CELLS, LOWEST = 0.042, 40, -14
"""Histogram of colors: width of a cell in OKLab, cells along each axis, and number of the first."""

INKS = 6
"""Most colors that are examined."""


@dataclass(frozen=True, eq=False)
class Ink:
    """
    The ink of a drawing. A pixel shows coverage * color + (1 - coverage) * the paint beneath, in sRGB.

    Attributes
    ----------
    coverage : ndarray, shape (h, w)
        In [0, 1]; 0 outside the mask.
    colors : ndarray, shape (n, 3)
        sRGB of the ink in the pixels where coverage is not 0, in row-major order.
    outlined : bool
        Whether ink follows more of the silhouette than shading can.
    only_lines : bool
        Whether the drawing has nothing but lines: no paint, or blank paper beneath.
    """

    coverage: FloatArray
    colors: FloatArray
    outlined: bool
    only_lines: bool

    @classmethod
    def none(cls, mask: BoolArray) -> Ink:
        """Return the ink of a drawing (h, w) that has none."""
        return cls(np.zeros(mask.shape), np.zeros((0, 3)), outlined=False, only_lines=False)


@dataclass(frozen=True, eq=False)
class _Strips:
    """Dark strips: pixels of them, their darkest ones, and the width of the window that found them."""

    pixels: BoolArray
    cores: BoolArray
    width: int


def find_ink(frame: Frame, *, hard_edges: bool = False) -> Ink:
    """
    Find the ink of a drawing.

    Parameters
    ----------
    frame : Frame
        The object.
    hard_edges : bool, optional
        True for pixel art, in which each pixel is either ink or paint. Tones between ink and paint count as paint.

    Returns
    -------
    Ink
        Coverage zero everywhere if there is none.

    Examples
    --------
    >>> y, x = np.mgrid[:64, :64] - 31.5
    >>> mask = np.hypot(x, y) < 28
    >>> color = np.full((64, 64, 3), 0.8)
    >>> color[np.hypot(x, y) > 26] = 0.1
    >>> ink = find_ink(Frame.around(color, mask))
    >>> float(ink.coverage[29, 2]), float(ink.coverage[29, 29])
    (1.0, 0.0)
    """
    strips, around = _dark_strips(frame), _Silhouette.of(frame.mask)
    if np.count_nonzero(strips.cores) < SPECK * frame.size**2:
        return Ink.none(frame.mask)
    lines = _lines(frame, strips, around)
    if not lines.any():
        return Ink.none(frame.mask)
    return _ink_along(frame, lines, strips, around, hard_edges=hard_edges)


def known_ink(frame: Frame, lines: BoolArray, *, hard_edges: bool = False) -> Ink:
    """
    Unmix the ink of a drawing whose lines somebody knows.

    Parameters
    ----------
    frame : Frame
        The object.
    lines : ndarray of bool, shape (h, w)
        True where ink covers most of a pixel; False everywhere if there is none.
    hard_edges : bool, optional
        As for `find_ink`.

    Returns
    -------
    Ink
        At least half of each pixel that is given, and as much of those beside them as their colors say.
    """
    if not lines.any():
        return Ink.none(frame.mask)
    strips = _Strips(lines, lines, _window(frame))
    return _ink_along(frame, lines, strips, _Silhouette.of(frame.mask), hard_edges=hard_edges)


def _ink_along(
    frame: Frame, lines: BoolArray, strips: _Strips, around: _Silhouette, *, hard_edges: bool
) -> Ink:
    """Return the ink of a drawing with lines."""
    coverage, color = lines.astype(np.float64), frame.color
    if not hard_edges:
        coverage, color = _coverage(frame, lines, strips)
    inked = coverage > 0.5
    enclosure = _both_sides(around.share(grown(inked, 1)))
    black = inked.any() and np.median(frame.lab[inked, 0]) < BLACK
    outlined = enclosure > (ENCLOSED_BY_BLACK if black else ENCLOSED)
    colors = pixels_at(color, coverage > 0)
    return Ink(coverage, colors, bool(outlined), _has_only_lines(frame, coverage))


def _dark_strips(frame: Frame) -> _Strips:
    """Close dark strips narrower than a square window; what that makes brighter is a strip. Outside counts as bright."""
    width = _window(frame)
    lightness = np.where(frame.mask, frame.lab[..., 0], np.float32(2.0))
    padded = np.pad(lightness, width, constant_values=2.0)
    closed = ndimage.grey_closing(padded, (width, width))[width:-width, width:-width]
    pixels = frame.mask & (closed - lightness > DARKER)
    cores = pixels & (lightness - ndimage.minimum_filter(lightness, 3) < DARKER / 2)
    return _Strips(pixels, cores, width)


def _window(frame: Frame) -> int:
    """Width of a window, in pixels, that is wider than the lines of a drawing: an odd number."""
    return max(int(WIDEST * frame.size) | 1, 5 if frame.size > SMALLEST else 3)


def _lines(frame: Frame, strips: _Strips, around: _Silhouette) -> BoolArray:
    """Pixels of strips in the colors that are ink."""
    mask, lab = frame.mask, frame.lab
    lines, pieces = np.zeros_like(mask), np.zeros_like(mask)
    for ink in _frequent_colors(lab[strips.cores]):
        near = mask & (_distance(lab, ink) < SAME_INK)
        thin = near & strips.cores
        count = np.count_nonzero(thin)
        if count < SPECK * frame.size**2:
            continue
        share = count / np.count_nonzero(near)
        followed = around.share(grown(thin, 1))
        encloses = _both_sides(followed)
        least = 0.1 if share > 0.85 or ink[0] < BLACK else 0.3
        if encloses > least:
            # Where lines meet, ink is wider than the window.
            lines |= near & grown(thin, strips.width // 2) if share > 0.6 else thin
        elif share > 0.75 and followed.max() < 0.27:
            lines |= _elongated(thin)
        elif share > PIECE:
            pieces |= thin
    # Lines may be a darker shade of the paint they surround: the outline then has a color for each part.
    if pieces.any() and _both_sides(around.share(grown(pieces | lines, 1))) > 0.4:
        lines |= pieces
    if frame.size <= TINY:  # the pixels inside the silhouette are most of it, whatever they are painted
        return lines
    return lines | _outlines(frame, around, strips.width)


def _outlines(frame: Frame, around: _Silhouette, width: int) -> BoolArray:
    """Find lines of any lightness, and a sticker's border: one color along the silhouette on all sides, nowhere wide."""
    mask, lab = frame.mask, frame.lab
    inner = shrunk(mask, 1)
    band = inner & ~shrunk(inner, 1)
    lines = np.zeros_like(mask)
    if not band.any():
        return lines
    for ink in _frequent_colors(lab[band])[:2]:
        near = mask & (_distance(lab, ink) < SAME_INK)
        if _both_sides(around.share(grown(near, 1))) < 0.5:
            continue
        wide = near & grown(shrunk(near, width // 2), width // 2)
        if np.count_nonzero(band & near & ~wide) > 0.8 * np.count_nonzero(band & near):
            lines |= near & ~grown(wide, 1)
    return lines


def _both_sides(followed: FloatArray) -> float:
    """How much of the silhouette is followed on opposite sides at once: the shadow of one light never is."""
    return float(np.minimum(followed[:4], followed[4:]).mean())


@dataclass(frozen=True, eq=False)
class _Silhouette:
    """Pixels of the silhouette (n,), by the eighth of the circle that they face (n,)."""

    pixels: NDArray[np.intp]
    facing: NDArray[np.intp]

    @classmethod
    def of(cls, mask: BoolArray) -> _Silhouette:
        """Find the silhouette of a mask."""
        rim = mask & ~shrunk(mask, 1)
        down, right = np.gradient(ndimage.gaussian_filter(mask.astype(np.float32), 2.5))
        pixels = np.flatnonzero(rim)
        # Eighths centered on the axes and diagonals stay eighths when the picture is turned or mirrored.
        angle = np.arctan2(down.ravel()[pixels], right.ravel()[pixels])
        return cls(pixels, np.rint(angle / (np.pi / 4)).astype(np.intp) % 8)

    def share(self, marked: BoolArray) -> FloatArray:
        """Share of each eighth's pixels that are marked, shape (8,); eighths that hardly occur count as the others."""
        total = np.bincount(self.facing, minlength=8)
        hit = np.bincount(self.facing, weights=marked.ravel()[self.pixels], minlength=8)
        rare = total < 0.02 * total.sum()
        return np.where(rare, hit.sum() / max(total.sum(), 1), hit / np.maximum(total, 1))


def _frequent_colors(colors: Lab) -> list[NDArray[np.float32]]:
    """Peaks of colors (n, 3), most frequent first."""
    found = []
    cells = np.rint(colors / CELL).astype(np.intp) - LOWEST
    keys = (cells[:, 0] * CELLS + cells[:, 1]) * CELLS + cells[:, 2]
    for _ in range(INKS):
        if len(colors) == 0:
            break
        fullest = int(np.bincount(keys).argmax())
        cell = np.array([fullest // CELLS**2, fullest // CELLS % CELLS, fullest % CELLS])
        start = (cell + LOWEST) * CELL
        ink = np.median(colors[_distance(colors, start) < SAME_INK], axis=0)
        found.append(ink)
        left = _distance(colors, ink) >= SAME_INK
        if left.all():
            break
        colors, keys = colors[left], keys[left]
    return found


def _elongated(thin: BoolArray) -> BoolArray:
    """Keep pieces that are far longer than wide: spots, eyes and buttons are paint."""
    labels, count = ndimage.label(thin, np.ones((3, 3)))
    if count == 0:
        return thin
    depth = ndimage.distance_transform_edt(thin)
    area = np.bincount(labels.ravel(), minlength=count + 1)
    deepest = ndimage.maximum(depth, labels, np.arange(count + 1))
    keep = area > 5.0 * (2.0 * np.asarray(deepest) - 1.0) ** 2
    keep[0] = False
    return np.asarray(keep[labels])


def _coverage(frame: Frame, lines: BoolArray, strips: _Strips) -> tuple[FloatArray, FloatArray]:
    """Unmix the pixels in and beside lines into ink and the paint next to them."""
    reach = frame.mask & grown(lines, MIXING_REACH)
    reach |= strips.cores & grown(lines, 3 * strips.width)
    ink_source = nearest_sources(lines, frame.lab, reach, within=3 * strips.width)
    clean = frame.mask & ~reach & ~strips.pixels
    paint_source = nearest_sources(clean, frame.lab, reach | strips.pixels, within=4 * strips.width)
    both = np.flatnonzero((reach & (ink_source >= 0) & (paint_source >= 0)).ravel())
    drawn = frame.color
    colors = drawn.reshape(-1, 3)
    ink, paint = colors[ink_source.ravel()[both]], colors[paint_source.ravel()[both]]
    away, own = ink - paint, colors[both] - paint
    share = np.clip((own * away).sum(axis=1) / np.maximum((away**2).sum(axis=1), 1e-6), 0.0, 1.0)
    off = np.linalg.norm(own - share[:, None] * away, axis=1)
    share[(off > OFF_MIXTURE) | (share < LEAST_COVERAGE)] = 0.0
    coverage = np.zeros(frame.mask.shape)
    coverage.ravel()[both] = share
    drawn.reshape(-1, 3)[both] = ink
    coverage[lines] = np.where(paint_source[lines] >= 0, np.maximum(coverage[lines], 0.5), 1.0)
    return coverage, drawn


def _has_only_lines(frame: Frame, coverage: FloatArray) -> bool:
    """Tell whether the paint is nowhere wider than lines, or blank."""
    if not coverage.any():
        return False
    paint = frame.mask & (coverage < PAINT)
    if not paint.any():
        return True
    width = 2 * max(1, int(WIDEST * frame.size)) + 1
    if frame.size > TINY and not shrunk(paint, width // 2).any():
        return True
    colors = pixels_at(frame.lab, paint)
    middle = np.median(colors, axis=0)
    blank = middle[0] > 0.93 and np.hypot(middle[1], middle[2]) < 0.02
    return bool(blank and np.mean(_distance(colors, middle) < SAME_INK) > 0.95)


def _distance(lab: Lab, to: NDArray[np.floating]) -> NDArray[np.float32]:
    away = lab - np.asarray(to, np.float32)
    distance: NDArray[np.float32] = np.sqrt(np.einsum("...c,...c", away, away))
    return distance

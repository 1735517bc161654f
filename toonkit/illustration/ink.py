"""Ink: thin lines over the paint, and how much of each pixel they cover."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.filling import find_nearest_sources
from toonkit.illustration.frame import Frame
from toonkit.illustration.ink_lines import (
    BLACK,
    SAME_INK,
    SPECK,
    TINY,
    WIDEST,
    Silhouette,
    Strips,
    color_distance,
    find_dark_strips,
    find_lines,
    line_window,
    opposite_share,
)
from toonkit.illustration.neighborhoods import grow_mask, shrink_mask
from toonkit.model.whole_pixels import pixels_at

MIXING_REACH = 2
"""Pixels beside a line that may be mixed with it."""

OFF_MIXTURE = 0.12
"""Greatest distance of a mixed pixel from the mixtures of ink and paint, in sRGB."""

LEAST_COVERAGE = 0.12
"""Coverage below which a pixel counts as paint."""

ENCLOSED, ENCLOSED_BY_BLACK = 0.75, 0.62
"""Least share of the silhouette that an outline follows, on opposite sides at once. The shading of one material follows
less of it: its darkest color lies where the silhouette faces away from the light, and along gaps between parts."""

PAINT = 0.05
"""Coverage below which a pixel shows only paint."""


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
    strips, around = find_dark_strips(frame), Silhouette.of(frame.mask)
    if np.count_nonzero(strips.cores) < SPECK * frame.size**2:
        return Ink.none(frame.mask)
    lines = find_lines(frame, strips, around)
    if not lines.any():
        return Ink.none(frame.mask)
    return _unmix_ink(frame, lines, strips, around, hard_edges=hard_edges)


def unmix_known_ink(frame: Frame, lines: BoolArray, *, hard_edges: bool = False) -> Ink:
    """
    Unmix the ink of a drawing whose lines (h, w), where ink covers most of a pixel, are known.

    It covers at least half of each given pixel, and as much of those beside them as their colors say.
    """
    if not lines.any():
        return Ink.none(frame.mask)
    strips = Strips(lines, lines, line_window(frame))
    return _unmix_ink(frame, lines, strips, Silhouette.of(frame.mask), hard_edges=hard_edges)


def _unmix_ink(
    frame: Frame, lines: BoolArray, strips: Strips, around: Silhouette, *, hard_edges: bool
) -> Ink:
    """Return the ink of a drawing with lines."""
    coverage, color = lines.astype(np.float64), frame.color
    if not hard_edges:
        coverage, color = _unmix_pixels(frame, lines, strips)
    inked = coverage > 0.5
    enclosure = opposite_share(around.share(grow_mask(inked, 1)))
    black = inked.any() and np.median(frame.lab[inked, 0]) < BLACK
    outlined = enclosure > (ENCLOSED_BY_BLACK if black else ENCLOSED)
    colors = pixels_at(color, coverage > 0)
    return Ink(coverage, colors, bool(outlined), _has_only_lines(frame, coverage))


def _unmix_pixels(frame: Frame, lines: BoolArray, strips: Strips) -> tuple[FloatArray, FloatArray]:
    """Unmix the pixels in and beside lines into ink and the paint next to them."""
    reach = frame.mask & grow_mask(lines, MIXING_REACH)
    reach |= strips.cores & grow_mask(lines, 3 * strips.width)
    ink_source = find_nearest_sources(lines, frame.lab, reach, within=3 * strips.width)
    clean = frame.mask & ~reach & ~strips.pixels
    paint_source = find_nearest_sources(clean, frame.lab, reach | strips.pixels, within=4 * strips.width)
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
    if frame.size > TINY and not shrink_mask(paint, width // 2).any():
        return True
    colors = pixels_at(frame.lab, paint)
    middle = np.median(colors, axis=0)
    blank = middle[0] > 0.93 and np.hypot(middle[1], middle[2]) < 0.02
    return bool(blank and np.mean(color_distance(colors, middle) < SAME_INK) > 0.95)

"""
Highlights: small bright spots of light on materials, which no color map explains.

A highlight is a small, bright, pale piece of one color. Larger and darker materials enclose it and show their lit tones
around it, and there are only a few of its kind. The criteria are strict, because eyes, teeth and patterns look similar
but are materials.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from skimage.measure import label

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.filling import Labels
from toonkit.illustration.ramps import Groups
from toonkit.illustration.tones import Tones

BRIGHTER = 0.06
"""Minimum difference of OKLab lightness between a highlight and the paint around it."""

MAX_CHROMA_EXCESS = 0.02
"""Maximum amount by which a highlight's OKLab chroma may exceed that of the surrounding paint."""

BRIGHT = 0.75
"""Minimum OKLab lightness of a highlight."""

PALE = 0.06
"""Maximum OKLab chroma of a highlight on a given material."""

EVEN = 0.06
"""Maximum range of OKLab lightness within a highlight."""

ENCLOSED, LIT = 0.55, 0.5
"""Minimum shares of a highlight's perimeter that border on larger, darker materials, and on their lit tones."""

MAX_OTHER_PAINT = 0.15
"""Maximum share of its perimeter that borders on other paint. The white of an eye exceeds it because of the pupil."""

LIT_RANGE = 0.03
"""Maximum difference of OKLab lightness from the brightest tone of the material for a tone to count as lit."""

LARGEST, LARGEST_TOGETHER, LARGEST_BESIDE = 0.05, 0.12, 0.3
"""Maximum area of a highlight: as a share of the object, of the object for all highlights of one color together, and
of the material around it."""

SEVERAL, ALIKE = 2, 0.25
"""Maximum number of highlights of similar size on one connected region of paint, and the minimum area of such a highlight
relative to the largest one there. More highlights are treated as a pattern."""

TOUCHING = 0.05
"""A spot with at most this share of its perimeter on the color's own material counts as lying on another material."""

SPOTS = 0.8
"""Minimum share of a color's area that spots must cover for the color to be a highlight, if it also occurs in a
material."""

JUMP, LARGEST_NAMED = 0.25, 0.3
"""For a given material: the minimum difference of OKLab lightness between a highlight and every other large tone, and the
maximum share of the material that highlights may cover."""

LARGE = 0.05
"""Minimum share of a material that a large tone covers."""


@dataclass(frozen=True, eq=False)
class _ToneRange:
    """Areas (m,) of groups of tones, and lightness and chroma of their large tones: darkest, brightest, most colorful."""

    area: FloatArray
    darkest: FloatArray
    brightest: FloatArray
    chroma: FloatArray


def find_highlights(tones: Tones, group: Groups) -> BoolArray:
    """
    Find the pixels (h, w) of highlights, given the material (n,) of each tone.

    A highlight color may have been grouped as a separate material, or as the brightest tone of a material whose ramp it
    fits. The latter is only recognized if some spots of that color lie on another material.
    """
    color, home = _bright_colors(tones, group)
    painted = tones.labels >= 0
    owner = np.where(painted, color[tones.labels], -1)
    possible: BoolArray = owner >= 0
    if not possible.any():
        return possible
    pieces = label(owner + 1, background=0, connectivity=2)
    count = int(pieces.max()) + 1
    member = np.zeros(count, np.intp)
    member[pieces[possible]] = owner[possible]
    area = np.bincount(pieces.ravel(), minlength=count)
    beside, perimeter = _contact(pieces, tones.labels, count, len(tones.area))
    spots = _tone_range(tones, color, len(home))
    around = _tone_range(tones, group, len(home))
    among_others = (color >= 0) & (home[color] >= 0)
    shaded = _tone_range(tones, np.where(among_others, -1, group), len(home))
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    piece, tone = beside.row, beside.col
    ground = group[tone]
    own = ground == home[member[piece]]
    surrounds = (
        (lightness[tone] < spots.darkest[member[piece]] - BRIGHTER)
        & (chroma[tone] > spots.chroma[member[piece]] - MAX_CHROMA_EXCESS)
        & (LARGEST_BESIDE * around.area[ground] > area[piece])
    )
    brightest = np.where(own, shaded.brightest[ground], around.brightest[ground])
    lit = surrounds & (lightness[tone] > brightest - LIT_RANGE)
    enclosed = np.bincount(piece, beside.data * surrounds, count) / np.maximum(perimeter, 1)
    at_light = np.bincount(piece, beside.data * lit, count) / np.maximum(perimeter, 1)
    apart = np.bincount(piece, beside.data * ~surrounds, count) / np.maximum(perimeter, 1)
    found = (
        (enclosed > ENCLOSED)
        & (at_light > LIT)
        & (apart < MAX_OTHER_PAINT)
        & (area < LARGEST * tones.area.sum())
    )
    found[0] = False  # piece 0 is the background
    at_home = np.bincount(piece, beside.data * own, count)
    found &= _spots_alone(found, area, member, home, at_home / np.maximum(perimeter, 1))
    return _drop_patterns(found[pieces], np.where(painted, group[tones.labels], -1))


def find_named_highlights(tones: Tones, materials: Labels) -> BoolArray:
    """
    Find the pixels (h, w) of highlights on given materials (h, w), -1 where none is given.

    A highlight is a bright, pale tone much lighter than the material's other large tones.
    """
    named: BoolArray = (materials >= 0) & (tones.labels >= 0)
    if not named.any():
        return named
    area = tones.area_by_material(materials)
    share = area / np.maximum(area.sum(axis=1, keepdims=True), 1)
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    bright = (lightness > BRIGHT) & (chroma < PALE) & (area > 0)
    below = np.where((share >= LARGE) & ~bright, lightness, -np.inf).max(axis=1, keepdims=True)
    bright &= lightness > below + JUMP
    few = np.isfinite(below) & ((bright * share).sum(axis=1, keepdims=True) < LARGEST_NAMED)
    lit: BoolArray = named & (bright & few)[materials, tones.labels]
    return lit


def _spots_alone(
    found: BoolArray,
    area: NDArray[np.intp],
    member: NDArray[np.intp],
    home: NDArray[np.intp],
    at_home: FloatArray,
) -> BoolArray:
    """
    Drop pieces whose color is an ordinary lit tone of some material.

    A color is not an ordinary lit tone if spots cover nearly all of its area and at least one spot lies on another material.
    A lit tone would border on its own material's shade.
    """
    shown = home[member] >= 0
    found = found & ~(shown & (at_home > TOUCHING) & (at_home < 0.5))
    spots = np.bincount(member, area * found, len(home))
    abroad = np.bincount(member, found & (at_home <= TOUCHING), len(home))
    alone: BoolArray = found & (
        ~shown | ((spots > SPOTS * np.bincount(member, area, len(home))) & (abroad > 0))[member]
    )
    return alone


def _bright_colors(tones: Tones, group: Groups) -> tuple[Groups, NDArray[np.intp]]:
    """
    Return the highlight color of each tone (n,), -1 if it cannot be one, and the material of each color (c,).

    The material is the one whose ramp contains the color along with other tones; -1 if the color is a material by
    itself.
    """
    count = int(group.max()) + 1
    extent = _tone_range(tones, group, count)
    even = extent.brightest - extent.darkest < EVEN
    alone = even & (extent.darkest > BRIGHT)
    brightest = np.zeros(count)
    np.maximum.at(brightest, group, tones.lab[:, 0])
    top = tones.lab[:, 0] > np.maximum(brightest[group] - LIT_RANGE, BRIGHT)
    top &= ~alone[group] & (tones.lab[:, 0] > extent.darkest[group] + BRIGHTER)
    color = np.where(top, group + count, np.where(alone[group], group, -1))
    area = np.bincount(color[color >= 0], tones.area[color >= 0], 2 * count)
    color = np.where((color >= 0) & (area[color] < LARGEST_TOGETHER * tones.area.sum()), color, -1)
    home = np.concatenate([np.full(count, -1), np.arange(count)])
    return color, home


def _tone_range(tones: Tones, group: Groups, count: int) -> _ToneRange:
    """Return the area of each group of tones, and the lightness and chroma of its large tones."""
    member = group >= 0
    area = np.bincount(group[member], tones.area[member], count).astype(np.float64)
    large = member & (tones.area >= LARGE * area[group])
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    darkest, brightest, palest = np.ones(count), np.zeros(count), np.zeros(count)
    np.minimum.at(darkest, group[large], lightness[large])
    np.maximum.at(brightest, group[large], lightness[large])
    np.maximum.at(palest, group[large], chroma[large])
    return _ToneRange(area, darkest, brightest, palest)


def _contact(
    pieces: NDArray[np.intp], tones: NDArray[np.integer], count: int, tone_count: int
) -> tuple[sparse.coo_array, NDArray[np.intp]]:
    """Count the boundary pixel pairs of each piece, per adjacent tone and in total."""
    own, other = [], []
    for axis in (0, 1):
        for one, two in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            here = (one, slice(None)) if axis == 0 else (slice(None), one)
            there = (two, slice(None)) if axis == 0 else (slice(None), two)
            border = (pieces[here] > 0) & (pieces[here] != pieces[there])
            own.append(pieces[here][border])
            other.append(tones[there][border])
    piece, tone = np.concatenate(own), np.concatenate(other)
    perimeter = np.bincount(piece, minlength=count)
    paint = tone >= 0
    pairs = sparse.coo_array(
        (np.ones(int(paint.sum())), (piece[paint], tone[paint])), shape=(count, tone_count)
    )
    pairs.sum_duplicates()
    return pairs, perimeter


def _drop_patterns(lit: BoolArray, owner: NDArray[np.intp]) -> BoolArray:
    """Drop highlights on connected regions of paint that carry more than `SEVERAL` of similar size."""
    spots, count = ndimage.label(lit, np.ones((3, 3)))
    if count <= SEVERAL:
        return lit
    pieces, grounds = label(np.where(lit, 0, owner + 1), background=0, return_num=True, connectivity=1)
    beside, _ = _contact(spots, pieces - 1, count + 1, grounds)
    ground = np.asarray(beside.tocsr().argmax(axis=1)).ravel()
    area = np.bincount(spots.ravel())
    area[0] = 0
    largest = np.zeros(grounds, np.intp)
    np.maximum.at(largest, ground, area)
    like = np.bincount(ground, area > ALIKE * largest[ground])
    few: BoolArray = (like[ground] <= SEVERAL)[spots]
    return lit & few

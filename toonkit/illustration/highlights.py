"""
Highlights: small bright spots of light on materials, which no color map explains.

Only what hardly can be anything else counts: a small, bright, pale piece of one color, enclosed by larger and darker
materials that show their lit tones around it, and one of a few there. Eyes, teeth and patterns are materials of their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skimage.measure import label

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.ramps import Groups
from toonkit.illustration.tones import Tones

BRIGHTER = 0.06
"""OKLab lightness by which a highlight is brighter than the paint around it, at least."""

PALEST = 0.02
"""OKLab chroma that a highlight may have beyond that of the paint around it."""

BRIGHT = 0.75
"""OKLab lightness of a highlight, at least."""

EVEN = 0.06
"""Range of OKLab lightness within the color of a highlight, at most."""

ENCLOSED, LIT = 0.55, 0.5
"""Shares of a highlight's perimeter along larger materials that are darker, and along their lit tones, at least."""

APART = 0.15
"""Share of its perimeter along other paint, a pupil say, at most."""

LIT_RANGE = 0.03
"""OKLab lightness down to which a tone is as lit as its material's brightest."""

LARGEST, LARGEST_TOGETHER, LARGEST_BESIDE = 0.05, 0.12, 0.3
"""Area of a highlight at most: shares of the object, of it for all of one color, and of a material around it."""

SEVERAL, ALIKE = 2, 0.25
"""Highlights on one piece of paint, at most, of those that are not far smaller than the largest: more are a pattern."""

LARGE = 0.05
"""Share of a material from which a tone counts as a large one."""


@dataclass(frozen=True, eq=False)
class _Extent:
    """Areas (m,) of groups of tones, and lightness and chroma of their large tones: darkest, brightest, most colorful."""

    area: FloatArray
    darkest: FloatArray
    brightest: FloatArray
    chroma: FloatArray


def find_highlights(tones: Tones, group: Groups) -> BoolArray:
    """
    Find the pixels of highlights.

    Parameters
    ----------
    tones : Tones
        The tones of a drawing.
    group : ndarray of int, shape (n,)
        Material of each tone, 0 to below m; highlights of one color may be one of its own.

    Returns
    -------
    ndarray of bool, shape (h, w)
        True on highlights, whatever lies beneath them.
    """
    extent = _extent(tones, group)
    whole = tones.area.sum()
    even = extent.brightest - extent.darkest < EVEN
    candidate = even & (extent.darkest > BRIGHT) & (extent.area < LARGEST_TOGETHER * whole)
    painted = tones.labels >= 0
    owner = np.where(painted, group[tones.labels], -1)
    possible: BoolArray = painted & candidate[owner]
    if not possible.any():
        return possible
    pieces = label(np.where(possible, owner + 1, 0), background=0, connectivity=2)
    count = int(pieces.max()) + 1
    member = np.zeros(count, np.intp)
    member[pieces[possible]] = owner[possible]
    area = np.bincount(pieces.ravel(), minlength=count)
    beside, perimeter = _contact(pieces, tones.labels, count, len(tones.area))
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    piece, tone = beside.row, beside.col
    surrounds = (
        (lightness[tone] < extent.darkest[member[piece]] - BRIGHTER)
        & (chroma[tone] > extent.chroma[member[piece]] - PALEST)
        & (LARGEST_BESIDE * extent.area[group[tone]] > area[piece])
    )
    lit = surrounds & (lightness[tone] > extent.brightest[group[tone]] - LIT_RANGE)
    enclosed = np.bincount(piece, beside.data * surrounds, count) / np.maximum(perimeter, 1)
    at_light = np.bincount(piece, beside.data * lit, count) / np.maximum(perimeter, 1)
    apart = np.bincount(piece, beside.data * ~surrounds, count) / np.maximum(perimeter, 1)
    found = (enclosed > ENCLOSED) & (at_light > LIT) & (apart < APART) & (area < LARGEST * whole)
    found[0] = False
    return _few(found[pieces], owner)


def _extent(tones: Tones, group: Groups) -> _Extent:
    count = int(group.max()) + 1
    area = np.zeros(count)
    np.add.at(area, group, tones.area)
    large = tones.area >= LARGE * area[group]
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    darkest, brightest, palest = np.ones(count), np.zeros(count), np.zeros(count)
    np.minimum.at(darkest, group[large], lightness[large])
    np.maximum.at(brightest, group[large], lightness[large])
    np.maximum.at(palest, group[large], chroma[large])
    return _Extent(area, darkest, brightest, palest)


def _contact(
    pieces: NDArray[np.intp], tones: NDArray[np.integer], count: int, tone_count: int
) -> tuple[sparse.coo_array, NDArray[np.intp]]:
    """Count each piece's pairs of neighboring pixels: those with every tone, and all of them."""
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


def _few(lit: BoolArray, owner: NDArray[np.intp]) -> BoolArray:
    """Drop what lies on a piece of paint that shows more than `SEVERAL`."""
    spots, count = label(lit, return_num=True, connectivity=2)
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

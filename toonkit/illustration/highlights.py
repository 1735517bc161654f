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
"""Least difference of OKLab lightness between a highlight and the paint around it."""

PALEST = 0.02
"""Greatest OKLab chroma of a highlight beyond that of the paint around it."""

BRIGHT = 0.75
"""Least OKLab lightness of a highlight."""

PALE = 0.06
"""Greatest OKLab chroma of a highlight on a given material."""

EVEN = 0.06
"""Greatest range of OKLab lightness within a highlight."""

ENCLOSED, LIT = 0.55, 0.5
"""Least shares of a highlight's perimeter that border on larger, darker materials, and on their lit tones."""

APART = 0.15
"""Greatest share of its perimeter that borders on other paint, such as a pupil."""

LIT_RANGE = 0.03
"""Greatest difference of OKLab lightness from the brightest tone of the material for a tone to count as lit."""

LARGEST, LARGEST_TOGETHER, LARGEST_BESIDE = 0.05, 0.12, 0.3
"""Greatest area of a highlight: as a share of the object, of the object for all highlights of one color together, and
of the material around it."""

SEVERAL, ALIKE = 2, 0.25
"""Most highlights of similar size on one piece of paint. More of them are a pattern."""

TOUCHING, SPOTS = 0.05, 0.8
"""For a color that also occurs within a material: the greatest share of a spot's perimeter along that material, if the
spot lies on another one, and the least share of the color's area that spots cover."""

JUMP, LARGEST_NAMED = 0.25, 0.3
"""For a given material: the least difference of OKLab lightness between a highlight and every other large tone, and its
greatest share of the material."""

LARGE = 0.05
"""Least share of a material that a large tone covers."""


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
        Material of each tone, 0 to m - 1. Highlights of one color may be a material of their own here. They may also be
        the brightest tones of a material whose ramp they happen to fit, if some of them lie on another material.

    Returns
    -------
    ndarray of bool, shape (h, w)
        True on highlights.
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
    spots = _extent(tones, color, len(home))
    around = _extent(tones, group, len(home))
    among_others = (color >= 0) & (home[color] >= 0)
    shaded = _extent(tones, np.where(among_others, -1, group), len(home))
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    piece, tone = beside.row, beside.col
    ground = group[tone]
    own = ground == home[member[piece]]
    surrounds = (
        (lightness[tone] < spots.darkest[member[piece]] - BRIGHTER)
        & (chroma[tone] > spots.chroma[member[piece]] - PALEST)
        & (LARGEST_BESIDE * around.area[ground] > area[piece])
    )
    brightest = np.where(own, shaded.brightest[ground], around.brightest[ground])
    lit = surrounds & (lightness[tone] > brightest - LIT_RANGE)
    enclosed = np.bincount(piece, beside.data * surrounds, count) / np.maximum(perimeter, 1)
    at_light = np.bincount(piece, beside.data * lit, count) / np.maximum(perimeter, 1)
    apart = np.bincount(piece, beside.data * ~surrounds, count) / np.maximum(perimeter, 1)
    found = (enclosed > ENCLOSED) & (at_light > LIT) & (apart < APART) & (area < LARGEST * tones.area.sum())
    found[0] = False
    at_home = np.bincount(piece, beside.data * own, count)
    found &= _spots_alone(found, area, member, home, at_home / np.maximum(perimeter, 1))
    return _few(found[pieces], np.where(painted, group[tones.labels], -1))


def find_named_highlights(tones: Tones, materials: Labels) -> BoolArray:
    """
    Find the pixels of highlights on given materials.

    Parameters
    ----------
    tones : Tones
        The tones of a drawing.
    materials : ndarray of int, shape (h, w)
        Material of each pixel, -1 where none is given.

    Returns
    -------
    ndarray of bool, shape (h, w)
        True where a material shows a bright and pale tone far above its others.
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
    Tell which pieces are not of a color that is a lit tone where a material shows it among others.

    It is none if nearly all of its pieces are spots, and one is beside its home: a lit tone borders on its material's shade.
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
    Return the colors that highlights may have.

    Returns
    -------
    color : ndarray of int, shape (n,)
        Color of each tone, -1 if highlights have another one.
    home : ndarray of int, shape (c,)
        Material that shows each color among others; -1 if none does.
    """
    count = int(group.max()) + 1
    extent = _extent(tones, group, count)
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


def _extent(tones: Tones, group: Groups, count: int) -> _Extent:
    member = group >= 0
    area = np.bincount(group[member], tones.area[member], count).astype(np.float64)
    large = member & (tones.area >= LARGE * area[group])
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

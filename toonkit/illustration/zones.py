"""
Zones: connected pieces of paint that are flat or change smoothly.

An edge is recognized by its contrast relative to the smooth variation beside it. Soft gradients therefore stay whole,
however steep they are, and small steps between flat tones are found. Pixels on an edge are mixtures and belong to the
adjacent zone with the nearest color.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from toonkit._validation import BoolArray
from toonkit.illustration.filling import Labels, find_nearest_sources
from toonkit.illustration.neighborhoods import shrink_mask
from toonkit.model.oklab import Lab
from toonkit.numerics.compiled import njit

SAME = 0.012
"""OKLab distance up to which neighbors have the same color: three steps of an 8-bit channel."""

CONTRAST = 2.0
"""Contrast of an edge relative to the variation of the paint around it."""

SURROUNDINGS = 9
"""Width of the window in which the variation of the paint is measured, in pixels."""

FEWEST = 4
"""Fewest pixels of a zone."""

GRAIN = 0.004
"""OKLab lightness by which half of the pixels differ from the mean of their neighbors, in grainy paint."""

ALIKE_GRAIN, PASSES = 0.08, 3
"""OKLab distance of colors that belong to one grainy paint, and how often the grain is averaged."""

MIXED = 0.035
"""OKLab distance from the mixtures of two neighboring zones up to which a thin zone is such a mixture."""


@dataclass(frozen=True, eq=False)
class Zones:
    """
    Pieces of paint.

    Attributes
    ----------
    labels : ndarray of int32, shape (h, w)
        Zone of each pixel of paint, -1 elsewhere; not all numbers occur.
    lab : ndarray of float32, shape (h, w, 3)
        Colors of the paint without mixtures: of a mixed pixel that of the zone it belongs to, nearby.
    sources : ndarray of int32, shape (h, w)
        Flat index of the pixel that this color is of: the pixel's own where it is not mixed; -1 beside the paint.
    """

    labels: Labels
    lab: Lab
    sources: Labels


def find_zones(lab: Lab, paint: BoolArray) -> Zones:
    """Find the zones of a picture, which no edge crosses, where paint shows (h, w); paint stays off the array's border."""
    lab = _remove_grain(lab, paint)
    change, flat = np.zeros(paint.shape, np.float32), np.zeros(paint.shape, np.bool_)
    row, width = lab.reshape(-1, 3), paint.shape[1]
    _measure(row, paint.ravel(), width, np.float32(SAME**2), flat.ravel(), change.ravel())
    weight = ndimage.uniform_filter(paint.astype(np.float32), SURROUNDINGS)
    around = ndimage.uniform_filter(change, SURROUNDINGS) / np.maximum(weight, 1e-6)
    smooth = paint & (flat | (change < SAME + CONTRAST * around))
    return _remove_specks(_connected(smooth, flat, lab), lab, paint)


def _remove_grain(lab: Lab, paint: BoolArray) -> Lab:
    """Average each pixel with those neighbors that are much like it, if most paint is grained or dithered."""
    lightness = lab[..., 0]
    cross = ndimage.convolve(lightness, np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], np.float32) / 4)
    inner = shrink_mask(paint, 1)
    if not inner.any() or np.median(np.abs(cross - lightness)[inner]) < GRAIN:
        return lab
    smooth = lab
    for _ in range(PASSES):
        total, count = smooth.copy(), np.ones(paint.shape, np.float32)
        for step in ((0, 1), (1, 0), (1, 1), (1, -1)):
            for sign in (1, -1):
                near = np.roll(smooth, (sign * step[0], sign * step[1]), (0, 1))
                away = near - lab
                counts = np.roll(paint, (sign * step[0], sign * step[1]), (0, 1))
                counts = counts & (np.einsum("hwc,hwc->hw", away, away) < ALIKE_GRAIN**2)
                total += np.where(counts[..., None], near, np.float32(0.0))
                count += counts
        smooth = total / count[..., None]
    return np.where(paint[..., None], smooth, lab)


def _connected(smooth: BoolArray, flat: BoolArray, lab: Lab) -> Labels:
    """Label the connected pieces of what is smooth from 0; -1 elsewhere."""
    labels = np.full(smooth.shape, -1, np.int32)
    own = np.arange(smooth.size, dtype=np.int32)
    row, width = lab.reshape(-1, 3), smooth.shape[1]
    _connect(row, smooth.ravel(), flat.ravel(), width, np.float32(SAME**2), own, labels.ravel())
    return labels


def _remove_specks(labels: Labels, lab: Lab, paint: BoolArray) -> Zones:
    """Dissolve pieces that are too small or nothing but the mixture between two others, and fill all of the paint."""
    sizes = np.bincount(labels[labels >= 0])
    own = labels >= 0
    own[own] = sizes[labels[own]] >= FEWEST
    thin = paint & ~own
    pieces = _connected(thin, thin, lab)
    kept = _unmixed_pieces(pieces, lab, paint)
    labels = np.where(own, labels, np.where(kept, pieces + len(sizes), -1))
    own |= kept
    if not own.any():  # a drawing of a few pixels, all different
        own, labels = paint, np.where(paint, 0, -1)
    source = find_nearest_sources(own, lab, paint)
    filled = source >= 0
    zones, shown = np.full(paint.shape, -1, np.int32), lab.copy()
    zones[filled] = labels.ravel()[source[filled]]
    shown[filled] = lab.reshape(-1, 3)[source[filled]]
    return Zones(zones, shown, source)


def _unmixed_pieces(pieces: Labels, lab: Lab, paint: BoolArray) -> BoolArray:
    """Find thin pieces of a color of their own: most of their pixels lie between no two opposite neighbors in color."""
    place = np.flatnonzero(pieces.ravel() >= 0)
    which = pieces.ravel()[place]
    sizes = np.bincount(which)
    counted = sizes[which] >= FEWEST
    place, which = place[counted], which[counted]
    mixed = np.zeros(len(place), np.bool_)
    colors, shown, width = lab.reshape(-1, 3), paint.ravel(), paint.shape[1]
    own = colors[place]
    for step in (1, width, width + 1, width - 1):
        for reach in (1, 2):
            first, second = place - reach * step, place + reach * step
            inside = (first >= 0) & (second < len(colors))
            first, second = np.where(inside, first, place), np.where(inside, second, place)
            between = colors[second] - colors[first]
            length = np.einsum("pc,pc->p", between, between)
            along = np.einsum("pc,pc->p", own - colors[first], between) / np.maximum(length, 1e-6)
            off = own - colors[first] - along[:, None] * between
            near = np.einsum("pc,pc->p", off, off) < MIXED**2
            mixed |= (
                shown[first] & shown[second] & near & (along > 0.05) & (along < 0.95) & (length > 9 * SAME**2)
            )
    share = np.bincount(which, mixed, minlength=len(sizes)) / np.maximum(sizes, 1)
    keep = (sizes >= FEWEST) & (share < 0.4)
    kept = np.zeros(pieces.shape, np.bool_)
    kept.ravel()[place[keep[which]]] = True
    return kept


@njit(cache=True, nogil=True, error_model="numpy")
def _measure(lab, paint, width, same, flat, change):  # type: ignore[no-untyped-def]
    """Mark pixels with enough neighbors alike, and measure how much each differs from its four neighbors at most."""
    for p in range(width + 1, paint.size - width - 1):
        if not paint[p]:
            continue
        alike, present, most = 0, 0, np.float32(0.0)
        for n in range(9):
            q = p + (n // 3 - 1) * width + n % 3 - 1
            if q != p and paint[q]:
                d0 = lab[q, 0] - lab[p, 0]
                d1 = lab[q, 1] - lab[p, 1]
                d2 = lab[q, 2] - lab[p, 2]
                d = d0 * d0 + d1 * d1 + d2 * d2
                present += 1
                if d < same:
                    alike += 1
                if n % 2 == 1 and d > most:
                    most = d
        flat[p] = alike >= 3 or (present > 0 and alike == present)
        change[p] = np.sqrt(most)


@njit(cache=True, nogil=True, error_model="numpy")
def _connect(lab, smooth, flat, width, same, parent, labels):  # type: ignore[no-untyped-def]
    """
    Label connected pieces: flat pixels that are alike, and pixels of no edge that are not both flat.

    `parent` holds the pixels' own indices. Here and above, pixels are counted in one row: that halves the time to compile.
    """
    for p in range(width + 1, smooth.size - width - 1):
        if not smooth[p]:
            continue
        q = p - width
        for _ in range(2):
            if smooth[q]:
                d0 = lab[q, 0] - lab[p, 0]
                d1 = lab[q, 1] - lab[p, 1]
                d2 = lab[q, 2] - lab[p, 2]
                if d0 * d0 + d1 * d1 + d2 * d2 < same or not (flat[p] or flat[q]):
                    a, b = p, q
                    while parent[a] != a:
                        parent[a] = parent[parent[a]]
                        a = parent[a]
                    while parent[b] != b:
                        parent[b] = parent[parent[b]]
                        b = parent[b]
                    if a < b:
                        parent[b] = a
                    else:
                        parent[a] = b
            q = p - 1
    count = 0
    for p in range(smooth.size):
        if smooth[p]:
            if parent[p] == p:
                labels[p] = count
                count += 1
            else:
                parent[p] = parent[parent[p]]
                labels[p] = labels[parent[p]]

"""The distinct colors of a drawing, and how the pixels of each lie together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray

LEVELS = 65_535
"""Steps of each channel: those of a 16-bit picture. Computed colors differ by rounding."""

BLOCK = 1 << 13
"""Pixels that are listed at a time."""

Numbers = NDArray[np.int32]


def distinct_colors(
    colors: FloatArray, beside: NDArray[np.integer], most: int
) -> tuple[NDArray[np.intp], Numbers]:
    """
    List the distinct colors of some pixels, each together with a number that belongs to it.

    Parameters
    ----------
    colors : ndarray, shape (P, 3)
        sRGB in [0, 1].
    beside : ndarray of int, shape (P,)
        Another number of each pixel, 0 to 65,535, such as its opacity or its material. Pixels of one color with different
        numbers count separately.
    most : int
        Stop as soon as there are more than so many.

    Returns
    -------
    firsts : ndarray of int, shape (n,)
        The first pixel of each.
    which : ndarray of int32, shape (P,)
        For each pixel the place of its color in `firsts`; only for pixels seen before the stop.
    """
    places: dict[int, int] = {}
    firsts: list[int] = []
    which = [np.empty(0, np.int32)]
    for start in range(0, len(colors), BLOCK):
        key = _packed(colors[start : start + BLOCK], beside[start : start + BLOCK])
        # Neighbors mostly have one color, so only the first pixel of each run is looked up.
        runs = np.append(0, 1 + np.flatnonzero(key[1:] != key[:-1]))
        values, first, inverse = np.unique(key[runs], return_index=True, return_inverse=True)
        place = np.empty(len(values), np.int32)
        for k in np.argsort(first):
            place[k] = places.setdefault(int(values[k]), len(firsts))
            if place[k] == len(firsts):
                firsts.append(start + int(runs[first[k]]))
        which.append(np.repeat(place[inverse], np.diff(runs, append=len(key))))
        if len(firsts) > most:
            break
    return np.array(firsts, np.intp), np.concatenate(which)


def _packed(colors: FloatArray, beside: NDArray[np.integer]) -> NDArray[np.uint64]:
    """Write each color (n, 3) and the number beside it (n,) as one number."""
    key = beside.astype(np.uint64)
    for channel in colors.T:
        key = (key << np.uint64(16)) | np.rint(channel * LEVELS).astype(np.uint64)
    return key


def beside_their_own(which: Numbers, mask: BoolArray) -> tuple[BoolArray, BoolArray]:
    """
    Tell how pixels lie among those of other colors.

    Parameters
    ----------
    which : ndarray of int, shape (P,)
        The color of each pixel of the mask, as a number.
    mask : ndarray of bool, shape (H, W)
        Where they are.

    Returns
    -------
    alone : ndarray of bool, shape (P,)
        True where none of the four neighbors has the same color.
    edge : ndarray of bool, shape (P,)
        True where a neighbor has another color.
    """
    image = np.full(np.add(mask.shape, 2), -1, np.int32)
    inner = image[1:-1, 1:-1]
    inner[mask] = which
    alone, edge = np.ones(which.shape, np.bool_), np.zeros(which.shape, np.bool_)
    for around in (image[:-2, 1:-1], image[2:, 1:-1], image[1:-1, :-2], image[1:-1, 2:]):
        neighbor = around[mask]
        alone &= neighbor != which
        edge |= (neighbor != which) & (neighbor >= 0)
    return alone, edge

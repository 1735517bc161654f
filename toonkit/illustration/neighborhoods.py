"""
Dilation, erosion and local range over squares; pixels beyond the edge of the picture do not count.

SciPy's filters give the same values, but take several times as long.
"""

from __future__ import annotations

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.numerics.parallel import run_on_row_chunks


def grow_mask(marked: BoolArray, steps: int) -> BoolArray:
    """Dilate the marked pixels of a picture (H, W) by a square that reaches some steps to each side."""
    return _grow_along_columns(_grow_along_columns(marked, steps).T, steps).T


def shrink_mask(marked: BoolArray, steps: int) -> BoolArray:
    """Erode the marked pixels of a picture (H, W) by a square that reaches some steps to each side."""
    return ~grow_mask(~marked, steps)


def range_around(color: FloatArray) -> FloatArray:
    """Range of each pixel of a picture (H, W, C) and its eight neighbors in the channel where it is largest, (H, W)."""
    widest = np.empty(color.shape[:2])
    run_on_row_chunks(_find_widest, color, widest)
    return widest


def _grow_along_columns(marked: BoolArray, steps: int) -> BoolArray:
    """Dilate along the first axis: each pass reaches three times as far as the one before."""
    grown, reach = marked.copy(order="K"), 0
    while reach < steps:
        step = min(2 * reach + 1, steps - reach)
        before = grown.copy(order="K")
        grown[step:] |= before[:-step]
        grown[:-step] |= before[step:]
        reach += step
    return grown


def _find_widest(color: FloatArray, widest: FloatArray, first: int, last: int) -> None:
    """Write the ranges of some rows."""
    above = min(first, 1)
    widest[first:last] = 0.0
    for channel in np.moveaxis(color[first - above : last + 1], 2, 0):
        greatest, least = (_extreme_around(channel, extreme) for extreme in (np.maximum, np.minimum))
        spread = (greatest - least)[above : above + last - first]
        np.maximum(widest[first:last], spread, out=widest[first:last])


def _extreme_around(channel: FloatArray, extreme: np.ufunc) -> FloatArray:
    """Return the extreme of each pixel and its eight neighbors."""
    for _ in range(2):
        found = channel.copy(order="K")
        extreme(found[1:], channel[:-1], out=found[1:])
        extreme(found[:-1], channel[1:], out=found[:-1])
        channel = found.T
    return channel

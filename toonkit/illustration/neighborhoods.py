"""What lies around each pixel of a picture, within a square; pixels beyond its edge do not count."""

from __future__ import annotations

import numpy as np

from toonkit._validation import BoolArray, FloatArray
from toonkit.numerics.bands import run_in_bands
from toonkit.numerics.compiled import njit


def grown(marked: BoolArray, steps: int) -> BoolArray:
    """Add to the marked pixels of a picture (H, W) what lies within some steps of one, diagonal ones among them."""
    along, around = np.empty_like(marked), np.empty_like(marked)
    run_in_bands(_grow_along_rows, marked, steps, along)
    run_in_bands(_grow_along_columns, along, steps, around)
    return around


def shrunk(marked: BoolArray, steps: int) -> BoolArray:
    """Keep of the marked pixels of a picture (H, W) those that have no other one within some steps."""
    return ~grown(~marked, steps)


def range_around(color: FloatArray) -> FloatArray:
    """Range of each pixel of a picture (H, W, C) and its eight neighbors in the channel where it is largest, (H, W)."""
    widest = np.empty(color.shape[:2])
    run_in_bands(_find_widest, color, widest)
    return widest


@njit(cache=True, nogil=True)
def _grow_along_rows(marked, steps, grown, first, last):  # type: ignore[no-untyped-def]
    width = marked.shape[1]
    for row in range(first, last):
        left = 0  # steps that the last marked pixel still reaches
        for column in range(width):
            left = steps + 1 if marked[row, column] else left - 1
            grown[row, column] = left > 0
        left = 0
        for column in range(width - 1, -1, -1):
            left = steps + 1 if marked[row, column] else left - 1
            grown[row, column] |= left > 0


@njit(cache=True, nogil=True)
def _grow_along_columns(marked, steps, grown, first, last):  # type: ignore[no-untyped-def]
    height, width = marked.shape
    left = np.zeros(width, np.int32)
    for row in range(max(first - steps, 0), last):
        for column in range(width):
            left[column] = steps + 1 if marked[row, column] else left[column] - 1
            if row >= first:
                grown[row, column] = left[column] > 0
    left[:] = 0
    for row in range(min(last + steps, height) - 1, first - 1, -1):
        for column in range(width):
            left[column] = steps + 1 if marked[row, column] else left[column] - 1
            if row < last:
                grown[row, column] |= left[column] > 0


@njit(cache=True, nogil=True)
def _find_widest(color, widest, first, last):  # type: ignore[no-untyped-def]
    height, width, channels = color.shape
    for row in range(first, last):
        for column in range(width):
            most = 0.0
            for channel in range(channels):
                least = greatest = color[row, column, channel]
                for near in range(max(row - 1, 0), min(row + 2, height)):
                    for beside in range(max(column - 1, 0), min(column + 2, width)):
                        value = color[near, beside, channel]
                        least, greatest = min(least, value), max(greatest, value)
                most = max(most, greatest - least)
            widest[row, column] = most

"""Codes of pixels: the number of a material, plus what the pixel is marked as beside that. Knows no panel."""

from __future__ import annotations

import zlib

import numpy as np
from numpy.typing import NDArray

MOST_MATERIALS = 4096
"""Materials at most, for their numbers to fit in 16 bits with room to spare."""

MARKS = {
    name: MOST_MATERIALS * (place + 1) for place, name in enumerate(("ink", "highlight", "shadow", "plain"))
}
"""What a pixel may be marked as beside its material: ink, a highlight, a cast shadow, or neither of these. Each number is
added to that of the material."""

INK, HIGHLIGHT, SHADOW, PLAIN = (mark // MOST_MATERIALS for mark in MARKS.values())

Numbers = NDArray[np.int16]
LabelVersion = bytes
"""One state of the label map, compressed: a drawing of 512 by 512 pixels takes a few kilobytes."""


def numbers_in(labels: NDArray[np.integer]) -> list[int]:
    """Return the numbers of the materials that occur, in rising order: much faster than sorting them all."""
    numbers: list[int] = np.flatnonzero(np.bincount(labels.ravel() + 1)[1:]).tolist()
    return numbers


def materials_of(codes: NDArray[np.integer]) -> Numbers:
    """
    Return the numbers of the materials of pixels with marks.

    A material most of which is marked as ink, highlight or shadow was only taken for one: where it is marked, it is -1, for
    an analysis to find what is beneath.
    """
    numbers = np.where(codes >= 0, codes % MOST_MATERIALS, -1).astype(np.int16)
    hidden = (codes >= MARKS["ink"]) & (codes < MARKS["plain"])
    if hidden.any():
        area = np.bincount(numbers[numbers >= 0])
        mostly = 2 * np.bincount(numbers[hidden], minlength=len(area)) > area
        numbers[hidden & mostly[numbers]] = -1
    return numbers


def materials_in(codes: Numbers) -> list[int]:
    """Return the numbers of the materials that occur beneath marks, in rising order."""
    return numbers_in(np.where(codes >= 0, codes % MOST_MATERIALS, -1))


def packed_codes(labels: NDArray[np.integer]) -> LabelVersion:
    """Compress a label map, which `unpacked_codes` returns."""
    return zlib.compress(labels.astype(np.int16).tobytes(), 1)


def unpacked_codes(version: LabelVersion, shape: tuple[int, ...]) -> Numbers:
    """Return the label map, of a known shape, that was compressed."""
    return np.frombuffer(zlib.decompress(version), np.int16).reshape(shape).copy()

"""A montage: frames side by side in one picture, so that they can be analyzed together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import refuse
from toonkit.model.decoding import MAX_PIXELS, Pixels
from toonkit.numerics.masked_grid import bounding_box

GAP = 4
"""Pixels between frames: nothing that looks at neighbors looks across."""


@dataclass(frozen=True)
class Place:
    """
    Where the visible part of a frame is.

    Attributes
    ----------
    top, left : int
        Its upper left pixel in the frame.
    row, column : int
        The same in the montage.
    height, width : int
        Its size, 0 if nothing of the frame is visible.
    shape : (int, int)
        Height and width of the whole frame.
    """

    top: int
    left: int
    row: int
    column: int
    height: int
    width: int
    shape: tuple[int, int]

    @property
    def in_frame(self) -> tuple[slice, slice]:
        """Rows and columns in the frame."""
        return slice(self.top, self.top + self.height), slice(self.left, self.left + self.width)

    @property
    def in_montage(self) -> tuple[slice, slice]:
        """Rows and columns in the montage."""
        return slice(self.row, self.row + self.height), slice(self.column, self.column + self.width)


def lay_out(frames: Sequence[NDArray[np.uint8]]) -> tuple[tuple[int, int], tuple[Place, ...]]:
    """Arrange the visible parts of frames (h, w, 4) in rows; return the shape of the montage, and the places."""
    boxes = [_visible(frame[..., 3] > 0) for frame in frames]
    area = sum((height + GAP) * (width + GAP) for _, _, height, width in boxes)
    widest = max(int(np.sqrt(area)), *(width + 2 * GAP for _, _, _, width in boxes))
    places, row, column, lowest, broadest = [], GAP, GAP, 0, 0
    for frame, (top, left, height, width) in zip(frames, boxes, strict=True):
        if column > GAP and column + width + GAP > widest:
            row, column, lowest = row + lowest + GAP, GAP, 0
        places.append(Place(top, left, row, column, height, width, (frame.shape[0], frame.shape[1])))
        column += width + GAP
        lowest, broadest = max(lowest, height), max(broadest, column)
    return (row + lowest + GAP, broadest), tuple(places)


def montage(frames: Sequence[NDArray[np.uint8]]) -> tuple[Pixels, tuple[Place, ...]]:
    """Put frames (h, w, 4) side by side; return the picture, and where they are in it."""
    shape, places = lay_out(frames)
    if shape[0] * shape[1] > MAX_PIXELS:
        rule = f"must have at most {MAX_PIXELS // 10**6} million pixels together"
        raise refuse("frames", rule, f"{shape[0] * shape[1] // 10**6} million")
    color, alpha = np.zeros((*shape, 3)), np.zeros(shape)
    for frame, place in zip(frames, places, strict=True):
        seen = frame[place.in_frame]
        color[place.in_montage], alpha[place.in_montage] = seen[..., :3] / 255, seen[..., 3] / 255
    return Pixels(color, alpha), places


def cut(picture: NDArray[Any], places: Sequence[Place], fill: float = 0) -> list[NDArray[Any]]:
    """Return the frames (h, w, ...) of a montage (H, W, ...), filled where nothing of them is visible."""
    frames = []
    for place in places:
        frame = np.full((*place.shape, *picture.shape[2:]), fill, picture.dtype)
        frame[place.in_frame] = picture[place.in_montage]
        frames.append(frame)
    return frames


def _visible(painted: NDArray[np.bool_]) -> tuple[int, int, int, int]:
    """Return the first row and column, and height and width, of what is painted."""
    if not painted.any():
        return 0, 0, 0, 0
    rows, columns = bounding_box(painted)
    return rows.start, columns.start, rows.stop - rows.start, columns.stop - columns.start

"""Where the frames of a sprite sheet are: in a grid, where an atlas says, or wherever something is painted."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, as_path, is_count, refuse
from toonkit.model.file_bytes import read_bytes

MOST_FRAMES = 1024

MOST_ATLAS_BYTES = 1 << 24

SPECK = 16
"""Pixels below which a part of a sheet is no frame of its own, but belongs to the nearest one."""


@dataclass(frozen=True)
class FrameBox:
    """
    The part of a sheet that shows a frame.

    Attributes
    ----------
    name : str
        The frame's name.
    row, column : int
        The upper left pixel of the part.
    height, width : int
        Its size on the sheet.
    rotated : bool
        Whether the frame lies on the sheet turned clockwise by a quarter turn.
    """

    name: str
    row: int
    column: int
    height: int
    width: int
    rotated: bool = False

    @property
    def place(self) -> tuple[slice, slice]:
        """Rows and columns on the sheet."""
        return slice(self.row, self.row + self.height), slice(self.column, self.column + self.width)


@dataclass(frozen=True)
class SheetLayout:
    """
    The frames of a sheet.

    Attributes
    ----------
    shape : (int, int)
        Height and width of the sheet.
    boxes : tuple of FrameBox
        Its frames, each part of the sheet once.
    """

    shape: tuple[int, int]
    boxes: tuple[FrameBox, ...]

    def cut(self, sheet: NDArray[Any]) -> Iterator[NDArray[Any]]:
        """Yield the frames (h, w, ...) of a sheet (H, W, ...), upright."""
        for box in self.boxes:
            part = sheet[box.place]
            yield np.rot90(part) if box.rotated else part

    def put_together(self, frames: Sequence[NDArray[Any]], fill: float = 0) -> NDArray[Any]:
        """Put frames, as `cut` yields them, on a sheet that is filled elsewhere."""
        sheet = np.full((*self.shape, *frames[0].shape[2:]), fill, frames[0].dtype)
        for box, frame in zip(self.boxes, frames, strict=True):
            sheet[box.place] = np.rot90(frame, -1) if box.rotated else frame
        return sheet


def grid_layout(shape: tuple[int, int], columns: int, rows: int) -> SheetLayout:
    """Divide a sheet (height, width) into equal cells of whole pixels, row by row from the upper left; refuse too many."""
    if not (is_count(columns, 1, shape[1]) and is_count(rows, 1, shape[0])) or columns * rows > MOST_FRAMES:
        rule = f"must be columns and rows of at most {MOST_FRAMES} frames"
        raise refuse("grid", rule, f"{columns!r} x {rows!r} for {shape[1]} x {shape[0]} pixels")
    if shape[0] % rows or shape[1] % columns:
        rule = f"must divide the sheet of {shape[1]} x {shape[0]} pixels into equal cells"
        raise refuse("grid", rule, f"{columns} x {rows}")
    height, width = shape[0] // rows, shape[1] // columns
    return SheetLayout(
        shape,
        tuple(
            FrameBox(str(number), number // columns * height, number % columns * width, height, width)
            for number in range(columns * rows)
        ),
    )


def island_layout(painted: BoolArray) -> SheetLayout:
    """
    Find the separate parts of a sheet, where anything is painted (H, W), row by row as their upper edges lie.

    Parts whose boxes overlap are one frame, and specks belong to the nearest one. Raises `ToonkitError` if there are
    more than `MOST_FRAMES`, or none.
    """
    labels, count = ndimage.label(painted, np.ones((3, 3)))
    area = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    spans = ndimage.find_objects(labels)
    boxes = [_edges(span) for span, pixels in zip(spans, area, strict=True) if pixels >= SPECK]
    specks = [_edges(span) for span, pixels in zip(spans, area, strict=True) if pixels < SPECK]
    if not 0 < len(boxes) <= MOST_FRAMES or len(specks) > 16 * MOST_FRAMES:
        rule = f"must show 1 to {MOST_FRAMES} separate frames, or come with a grid or an atlas"
        raise refuse("source", rule, f"{len(boxes):,} parts and {len(specks):,} specks")
    edges = np.array(boxes)
    for speck in specks:
        gaps = np.maximum(np.maximum(edges[:, :2] - speck[2:], speck[:2] - edges[:, 2:]), 0)
        nearest = int((gaps**2).sum(axis=1).argmin())
        edges[nearest] = [
            *np.minimum(edges[nearest, :2], speck[:2]),
            *np.maximum(edges[nearest, 2:], speck[2:]),
        ]
    edges = _merged(edges)
    edges = edges[np.lexsort((edges[:, 1], edges[:, 0]))]
    return SheetLayout(
        (painted.shape[0], painted.shape[1]),
        tuple(
            FrameBox(str(number), int(top), int(left), int(bottom - top), int(right - left))
            for number, (top, left, bottom, right) in enumerate(edges)
        ),
    )


def _edges(span: tuple[slice, slice]) -> NDArray[np.intp]:
    return np.array([span[0].start, span[1].start, span[0].stop, span[1].stop], np.intp)


def _merged(edges: NDArray[np.intp]) -> NDArray[np.intp]:
    """Join boxes (n, 4) of first rows and columns, and those after the last ones, until none overlap."""
    kept: list[NDArray[np.intp]] = []
    waiting = list(edges)
    while waiting:
        box = waiting.pop()
        overlapping = [
            number
            for number, other in enumerate(kept)
            if (box[:2] < other[2:]).all() and (other[:2] < box[2:]).all()
        ]
        if overlapping:
            other = kept.pop(overlapping[0])
            waiting.append(np.concatenate([np.minimum(box[:2], other[:2]), np.maximum(box[2:], other[2:])]))
        else:
            kept.append(box)
    return np.array(kept)


def read_atlas(path: str | os.PathLike[str], shape: tuple[int, int]) -> tuple[SheetLayout, dict[str, Any]]:
    """
    Read a JSON atlas as TexturePacker and Aseprite write them; return its frames and the whole content of the file.

    It has "frames", as a hash or an array: each has a "frame" of x, y, w and h, and may be "rotated". Frames that show
    a part of the sheet again are left out. Raises `ToonkitError` if the file is no such atlas, or a frame leaves the
    sheet.
    """
    content, name = read_bytes("atlas", as_path("atlas", path), limit=MOST_ATLAS_BYTES, kind="an atlas")
    rule = "must be a JSON atlas as TexturePacker or Aseprite write it"
    try:
        atlas = json.loads(content)
        listed = atlas["frames"]
        named = (
            list(listed.items())
            if isinstance(listed, dict)
            else [(entry.get("filename", str(number)), entry) for number, entry in enumerate(listed)]
        )
        boxes = [_box(str(key), entry) for key, entry in named]
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError) as error:
        raise refuse("atlas", rule, f"{name} ({type(error).__name__}: {error})") from error
    first: dict[FrameBox, FrameBox] = {}
    for box in boxes:
        first.setdefault(replace(box, name=""), box)
    boxes = list(first.values())
    if not 0 < len(boxes) <= MOST_FRAMES:
        raise refuse("atlas", f"must have 1 to {MOST_FRAMES} frames", f"{name} with {len(boxes):,}")
    for box in boxes:
        inside = (
            min(box.row, box.column) >= 0
            and box.row + box.height <= shape[0]
            and box.column + box.width <= shape[1]
        )
        if not inside or min(box.height, box.width) < 1:
            rule = f"must have frames that lie in the sheet of {shape[1]} x {shape[0]} pixels"
            raise refuse("atlas", rule, f"{name}: {box.name}")
    return SheetLayout(shape, tuple(boxes)), atlas


def _box(name: str, entry: dict[str, Any]) -> FrameBox:
    frame, rotated = entry["frame"], bool(entry.get("rotated", False))
    column, row, width, height = (int(frame[key]) for key in ("x", "y", "w", "h"))
    if rotated:  # width and height are those of the upright frame
        width, height = height, width
    return FrameBox(name, row, column, height, width, rotated)

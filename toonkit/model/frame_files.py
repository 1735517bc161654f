"""read_frames: the frames of a sprite sheet or an animation, and how they lie in their file."""

from __future__ import annotations

import io
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from toonkit._validation import as_path, check_flag, expand_home, refuse
from toonkit.model.decoding import MAX_BYTES, MAX_PIXELS, Pixels, check_size, read_pixels
from toonkit.model.file_bytes import read_bytes
from toonkit.model.loading import image_of
from toonkit.model.sheet_layout import MOST_FRAMES, SheetLayout, grid_layout, island_layout, read_atlas

MOVING = ("GIF", "PNG", "WEBP")
"""Formats that hold animations."""

MILLISECONDS = 100
"""How long a frame is shown whose file does not say."""

FramePixels = NDArray[np.uint8]
"""sRGB and straight alpha of a frame, shape (h, w, 4)."""


@dataclass(frozen=True)
class Timing:
    """
    How an animation runs.

    Attributes
    ----------
    milliseconds : tuple of int
        How long each frame is shown.
    loops : int
        How often it is shown, 0 without end.
    """

    milliseconds: tuple[int, ...]
    loops: int = 0


@dataclass(frozen=True, eq=False)
class Frames:
    """
    The frames of a file.

    Attributes
    ----------
    pictures : tuple of ndarray of uint8, shape (h, w, 4)
        Each frame, upright: sRGB and straight alpha. The background of an opaque file is cut out.
    layout : SheetLayout
        Where they lie; those of an animation one below the other.
    timing : Timing or None
        How they follow one another, if the file is an animation.
    atlas : dict or None
        The atlas that the layout was read from.
    """

    pictures: tuple[FramePixels, ...]
    layout: SheetLayout
    timing: Timing | None = None
    atlas: dict[str, Any] | None = None


def read_frames(
    source: str | os.PathLike[str],
    *,
    atlas: str | os.PathLike[str] | None = None,
    grid: tuple[int, int] | None = None,
    islands: bool = False,
) -> Frames:
    """
    Read a sprite sheet or an animation.

    Parameters
    ----------
    source : path
        A picture that shows several frames, or an animated GIF, PNG (APNG) or WebP.
    atlas : path, optional
        JSON atlas of a sheet, as TexturePacker and Aseprite write it. By default a file beside the sheet that has its name
        but for the suffix, if there is one.
    grid : (int, int), optional
        Columns and rows of a sheet of equal cells.
    islands : bool, optional
        True takes each part of a sheet that touches no other for a frame, whatever atlas there is. This is also done where
        nothing else is known.

    Returns
    -------
    Frames
        The frames with 8 bits a channel.

    Raises
    ------
    ToonkitError
        If the file cannot be read, has too many frames, or more than one layout is given.
    """
    check_flag("islands", islands)
    path = expand_home(as_path("source", source))
    if (atlas is not None) + (grid is not None) + islands > 1:
        raise refuse("atlas", "must stand alone: one of atlas, grid and islands", "more than one")
    moving = _read_animation(path)
    if moving is not None:
        if atlas is not None or grid is not None:
            raise refuse("source", "must be a sheet to have an atlas or a grid", f"{path}, an animation")
        whole, timing = moving
        count = len(timing.milliseconds)
        rgba = _cut_out(Pixels(whole[..., :3] / 255, whole[..., 3] / 255))
        return _frames(rgba, grid_layout(rgba.shape[:2], 1, count), timing)
    rgba = _cut_out(read_pixels("source", path))
    shape = rgba.shape[:2]
    if grid is not None:
        return _frames(rgba, grid_layout(shape, *_pair(grid)))
    beside = path.with_suffix(".json")
    if atlas is None and not islands and beside.is_file():
        atlas = beside
    if atlas is not None:
        layout, content = read_atlas(atlas, shape)
        return _frames(rgba, layout, atlas=content)
    return _frames(rgba, island_layout(rgba[..., 3] > 0))


def _frames(
    rgba: FramePixels,
    layout: SheetLayout,
    timing: Timing | None = None,
    atlas: dict[str, Any] | None = None,
) -> Frames:
    return Frames(tuple(np.ascontiguousarray(frame) for frame in layout.cut(rgba)), layout, timing, atlas)


def _cut_out(pixels: Pixels) -> FramePixels:
    return image_of(pixels, None).to_rgba()


def _pair(grid: Any) -> tuple[int, int]:
    try:
        columns, rows = grid
    except (TypeError, ValueError):
        raise refuse("grid", "must be two numbers, columns and rows", repr(grid)) from None
    return columns, rows


def _read_animation(path: Path) -> tuple[FramePixels, Timing] | None:
    """Return the frames of an animation one below the other, and how it runs; None if the file is no animation."""
    data, name = read_bytes("source", path, limit=MAX_BYTES, kind="a picture file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large pictures; sizes are checked here
            picture = Image.open(io.BytesIO(data), formats=MOVING)
    except Exception:  # read_pixels says what is wrong with it
        return None
    with picture:
        count = int(getattr(picture, "n_frames", 1))
        if count == 1:
            return None
        check_size("source", *picture.size)
        if count > MOST_FRAMES or count * picture.width * picture.height > MAX_PIXELS:
            rule = f"must have at most {MOST_FRAMES} frames of together {MAX_PIXELS // 10**6} million pixels"
            raise refuse("source", rule, f"{name}: {count} of {picture.width} x {picture.height}")
        frames, shown = [], []
        loops = int(picture.info.get("loop", 0))
        try:
            for frame in ImageSequence.Iterator(picture):
                frames.append(np.asarray(frame.convert("RGBA")))
                shown.append(round(frame.info.get("duration") or MILLISECONDS))
        except Exception as error:  # decoders raise nearly every type there is for a damaged file
            raise refuse("source", "must be an undamaged animation", f"{name} ({error})") from error
    return np.concatenate(frames), Timing(tuple(shown), loops)

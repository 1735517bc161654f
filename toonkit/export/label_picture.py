"""Materials as pictures: a color for each, to look at, to correct in any paint program, and to read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from toonkit._validation import any_array, refuse
from toonkit.export.atomic import PathLike, suffix_of
from toonkit.model.decoding import read_pixels
from toonkit.model.loading import HALF_COVERED
from toonkit.model.oklab import oklab_to_srgb

MOST_LABELS = 256
"""Materials that a picture may name; one of more colors is a drawing, or the borders of its colors are soft."""

MOST_NUMBER = 1 << 24
"""Largest number that is painted: there are no more colors than that."""

CHROMA, DARKEST, BRIGHTEST = 0.13, 0.62, 0.86
"""OKLab chroma of the colors, and their lightness, of which each takes one of three steps."""

_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def label_picture(labels: NDArray[np.integer]) -> NDArray[np.uint8]:
    """
    Paint each label in a color of its own.

    Parameters
    ----------
    labels : ndarray of int, shape (H, W)
        Numbers from 0 on, -1 where there is nothing.

    Returns
    -------
    ndarray of uint8, shape (H, W, 4)
        RGBA: successive numbers far apart in hue, always in the same color; transparent at -1.

    Raises
    ------
    ToonkitError
        If the labels are no such numbers.

    Examples
    --------
    >>> label_picture(np.array([[-1, 0, 1]]))[0, :, 3].tolist()
    [0, 255, 255]
    """
    array = any_array("labels", labels)
    if array.ndim != 2 or array.dtype.kind not in "iu" or array.size == 0:
        raise refuse("labels", "must be an (H, W) array of integers", f"shape {array.shape}, {array.dtype}")
    if array.max() > MOST_NUMBER:
        raise refuse("labels", f"must be numbers up to {MOST_NUMBER:,}", int(array.max()))
    labels = array.astype(np.intp)
    number = np.arange(int(labels.max()) + 1)
    hue = number * _GOLDEN_ANGLE
    lightness = DARKEST + (BRIGHTEST - DARKEST) * (number % 3) / 2
    colors = oklab_to_srgb(np.column_stack([lightness, CHROMA * np.cos(hue), CHROMA * np.sin(hue)]))
    inside = labels >= 0
    rgba = np.zeros((*labels.shape, 4), np.uint8)
    rgba[inside, :3] = np.round(np.clip(colors, 0, 1) * 255)[labels[inside]]
    rgba[inside, 3] = 255
    return rgba


def read_labels(path: PathLike) -> NDArray[np.intp]:
    """
    Read which pixels of a picture have the same color.

    Parameters
    ----------
    path : path
        A .png or .webp file with hard borders between its colors. Entries of a palette are told apart even if they have
        the same color.

    Returns
    -------
    ndarray of int, shape (H, W)
        Numbers from 0 on, in the order of their areas, the largest first; -1 where the picture is transparent.

    Raises
    ------
    ToonkitError
        If the suffix is another, the file is no such picture, transparent everywhere, or of more than `MOST_LABELS` colors.
    """
    suffix_of(path, (".png", ".webp"), "materials")
    pixels = read_pixels("materials", path)
    with Image.open(Path(path).expanduser()) as picture:
        index = np.asarray(ImageOps.exif_transpose(picture)) if picture.mode == "P" else None
    if index is None:
        red, green, blue = np.moveaxis(np.round(pixels.color * 65535).astype(np.int64), -1, 0)
        index = (red << 32) | (green << 16) | blue
    known = np.full(index.shape, True) if pixels.alpha is None else pixels.alpha >= HALF_COVERED
    if not known.any():
        raise refuse(
            "materials", "must be opaque where a material is known", f"{path}, transparent everywhere"
        )
    _, number, area = np.unique(index[known], return_inverse=True, return_counts=True)
    if len(area) > MOST_LABELS:
        rule = f"must have at most {MOST_LABELS} colors, one a material, with hard borders between them"
        raise refuse("materials", rule, f"{path} with {len(area):,} colors")
    rank = np.argsort(np.argsort(-area, kind="stable"))
    labels = np.full(index.shape, -1, np.intp)
    labels[known] = rank[number]
    return labels

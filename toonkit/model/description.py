"""What the objects of the model say about themselves: words for their `repr`, and small pictures for notebooks."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from toonkit._validation import BoolArray

LONGEST_SIDE = 512
"""Pixels of a preview at most; a larger picture is reduced."""


def describe_object(mask: BoolArray) -> str:
    """
    Say how large a picture is, and how much of it the object covers.

    Parameters
    ----------
    mask : ndarray of bool, shape (H, W)
        True on the object.

    Returns
    -------
    str
        Width, height and share.

    Examples
    --------
    >>> describe_object(np.arange(12).reshape(3, 4) < 3)
    '4 x 3 pixels, object covers 25 %'
    """
    rows, columns = mask.shape
    return f"{columns} x {rows} pixels, object covers {100 * mask.mean():.0f} %"


def preview_png(pixels: NDArray[np.uint8], *, smooth: bool = True) -> bytes:
    """
    Return pixels (H, W, 3 or 4) of uint8 sRGB as a PNG file of at most `LONGEST_SIDE` pixels on each side.

    When reduced, smooth ones are means of those that they stand for, and others the color of one of them.
    """
    image = Image.fromarray(np.ascontiguousarray(pixels))
    image.thumbnail(
        (LONGEST_SIDE, LONGEST_SIDE), Image.Resampling.BOX if smooth else Image.Resampling.NEAREST
    )
    encoded = io.BytesIO()
    image.save(encoded, "PNG")
    return encoded.getvalue()

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
    Return a small picture as the bytes of a PNG file.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3) or (H, W, 4)
        sRGB, with straight alpha if there are four channels.
    smooth : bool, optional
        Whether reduced pixels take the mean of those that they stand for; if not, the color of one of them.

    Returns
    -------
    bytes
        The picture, at most `LONGEST_SIDE` pixels wide and high.
    """
    image = Image.fromarray(np.ascontiguousarray(pixels))
    image.thumbnail(
        (LONGEST_SIDE, LONGEST_SIDE), Image.Resampling.BOX if smooth else Image.Resampling.NEAREST
    )
    encoded = io.BytesIO()
    image.save(encoded, "PNG")
    return encoded.getvalue()

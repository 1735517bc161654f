"""Pixels of an image copied as wholes: NumPy masks items of one piece several times as fast as rows of numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray

PIECE = 16_384
"""Numbers in a piece."""

Number = TypeVar("Number", bound=np.generic)


def pixels_at(image: NDArray[Number], mask: BoolArray) -> NDArray[Number]:
    """Return `image[mask]`, shape (P, C), of an image (H, W, C) whose channels lie side by side."""
    return _whole(image)[mask].view(image.dtype).reshape(-1, image.shape[-1])


def put_pixels(image: NDArray[Any], mask: BoolArray, pixels: NDArray[Any]) -> None:
    """Set `image[mask]` of an image (H, W, C) whose channels lie side by side to pixels (P, C), or (C,) for all of them."""
    _whole(image)[mask] = _whole(np.ascontiguousarray(pixels, image.dtype))


def pieces(count: int) -> Iterator[slice]:
    """Cut a number of pixels into slices: what is computed on the way is then small, and stays in a core's cache."""
    return (slice(first, first + PIECE) for first in range(0, count, PIECE))


def opaque(colors: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return 8-bit colors (n, 3) with an alpha of 255, (n, 4)."""
    pixels = np.full((len(colors), 4), 255, np.uint8)
    pixels[:, :3] = colors
    return pixels


def _whole(image: NDArray[Any]) -> NDArray[np.void]:
    return image.view(np.dtype((np.void, image.itemsize * image.shape[-1])))[..., 0]

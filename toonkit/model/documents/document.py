"""A layered document, whatever its format: a merged picture, and layers from the bottom to the top."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from toonkit.model.decoding import Pixels

LayerPixels = NDArray[np.uint8]
"""sRGB and straight alpha on the whole canvas, shape (H, W, 4)."""

Blend = Literal["normal", "multiply", "other"]
"""How a layer is composed with what is below it, as far as it matters here."""


@dataclass(frozen=True, eq=False)
class Layer:
    """
    A layer of pixels.

    Attributes
    ----------
    name : str
        Its name.
    groups : tuple of str
        Names of the groups around it, the innermost first.
    area : int
        Pixels that have to be decoded to read it.
    read : callable
        Returns its pixels on the canvas, its own masks applied, its opacity not.
    blend : {"normal", "multiply", "other"}
        How it is composed with what is below it.
    visible : bool
        Whether it and its groups are shown.
    opacity : float
        Its own, times that of its groups, 0 to 1.
    clipped : bool
        Whether it shows only where the layer below it does.
    """

    name: str
    groups: tuple[str, ...]
    area: int
    read: Callable[[], LayerPixels] = field(repr=False)
    blend: Blend = "normal"
    visible: bool = True
    opacity: float = 1.0
    clipped: bool = False


@dataclass(frozen=True, eq=False)
class Document:
    """
    A document that is open.

    Attributes
    ----------
    name : str
        Of the file, for messages.
    layers : tuple of Layer
        From the bottom to the top.
    read_merged : callable
        Returns the merged picture.
    """

    name: str
    layers: tuple[Layer, ...]
    read_merged: Callable[[], Pixels] = field(repr=False)


def on_canvas(pixels: NDArray[np.uint8], top: int, left: int, shape: tuple[int, int]) -> LayerPixels:
    """Put the pixels (h, w, 4) of a layer at their place on a canvas (H, W); what lies outside is cut off."""
    height, width = pixels.shape[:2]
    if (top, left, height, width) == (0, 0, *shape):
        return pixels
    canvas = np.zeros((*shape, 4), np.uint8)
    rows = slice(max(top, 0), min(top + height, shape[0]))
    columns = slice(max(left, 0), min(left + width, shape[1]))
    if rows.start < rows.stop and columns.start < columns.stop:
        canvas[rows, columns] = pixels[
            rows.start - top : rows.stop - top, columns.start - left : columns.stop - left
        ]
    return canvas

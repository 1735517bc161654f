"""Contact sheets of relit drawings: the input, its regions, its base colors, and what it becomes under each light."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import toonkit
from toonkit.model.label_colors import label_picture

TILE = 320
"""Pixels along each side of a picture on a sheet."""

_GAP = 8
_COLUMNS = 3
_GROUND = (238, 236, 231)


def sheet(
    image: toonkit.ToonImage,
    labels: NDArray[np.int64],
    base: toonkit.ToonImage,
    relit: Sequence[toonkit.ToonImage],
) -> NDArray[np.uint8]:
    """Return a sheet (H, W, 3): input, regions and base colors in the first row, then the relit pictures."""
    pictures = [
        image.to_rgba(),
        label_picture(labels),
        base.to_rgba(),
        *(picture.to_rgba() for picture in relit),
    ]
    rows = -(-len(pictures) // _COLUMNS)
    step = TILE + _GAP
    whole = Image.new("RGB", (_COLUMNS * step + _GAP, rows * step + _GAP), _GROUND)
    for index, pixels in enumerate(pictures):
        row, column = divmod(index, _COLUMNS)
        picture = Image.fromarray(pixels)
        scale = TILE / max(picture.size)
        picture = picture.resize(
            (max(1, round(picture.width * scale)), max(1, round(picture.height * scale)))
        )
        left = _GAP + column * step + (TILE - picture.width) // 2
        top = _GAP + row * step + (TILE - picture.height) // 2
        whole.paste(picture, (left, top), picture)
    return np.asarray(whole).copy()

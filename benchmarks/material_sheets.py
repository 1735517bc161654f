"""Contact sheets of relit drawings: the input, its regions, its base colors, and what it becomes under each light."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import toonkit
from toonkit.model.oklab import oklab_to_srgb

TILE = 320
"""Pixels along each side of a picture on a sheet."""

_GAP = 8
_COLUMNS = 3
_GROUND = (238, 236, 231)
_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def sheet(
    image: toonkit.ToonImage,
    labels: NDArray[np.int64],
    base: toonkit.ToonImage,
    relit: Sequence[toonkit.ToonImage],
) -> NDArray[np.uint8]:
    """Return a sheet (H, W, 3): input, regions and base colors in the first row, then the relit pictures."""
    pictures = [
        image.to_rgba(),
        region_colors(labels),
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


def region_colors(labels: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Return regions (H, W) as RGBA: a color each, that of neighboring numbers far apart; transparent at -1."""
    count = int(labels.max()) + 1
    turn = np.arange(count) * _GOLDEN_ANGLE
    lightness = 0.55 + 0.3 * (np.arange(count) % 3) / 2
    colors = np.clip(
        oklab_to_srgb(np.column_stack([lightness, 0.13 * np.cos(turn), 0.13 * np.sin(turn)])), 0, 1
    )
    inside = labels >= 0
    rgba = np.zeros((*labels.shape, 4), np.uint8)
    rgba[inside, :3] = np.round(colors[labels[inside]] * 255)
    rgba[inside, 3] = 255
    return rgba

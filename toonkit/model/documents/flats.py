"""Layers of flat colors as a label map: a color for each material."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray
from toonkit.model.documents.document import Layer
from toonkit.model.documents.roles import check_area

MOST_LABELS = 256
"""Colors of flat layers at most."""

HARD_EDGED = 32
"""Colors up to which all of them are materials; among more, some are mixtures along soft borders."""

BLOCK = 3
"""Rows and columns of one color that an area has somewhere; colors that are nowhere so wide are mixtures."""

ALIKE = 4
"""Steps of each channel by which colors of one material may differ."""

FLAT_SHARE = 0.8
"""Share of a flat layer's pixels that must have the colors of its areas."""

_COLORS, _MOST_COLORS = 1 << 24, 1 << 12


def labels_of_flats(layers: Sequence[Layer], mask: BoolArray) -> NDArray[np.intp] | None:
    """
    Give each color of flat layers, the bottom first, a number (H, W): that of the most frequent color is 0.

    Pixels have -1 where no layer is at least half opaque. A pixel whose color occurs nowhere in a block of 3 x 3 is
    mixed along a border, and belongs to the nearest area. Returns None if the layers are not flat: they have too many
    colors, or too few pixels in them.
    """
    check_area(layers)
    color = np.full(mask.shape, -1, np.int32)
    for layer in layers:
        pixels = layer.read()
        red, green, blue = np.moveaxis(pixels[..., :3].astype(np.int32), -1, 0)
        color = np.where(pixels[..., 3] >= 128, (red << 16) | (green << 8) | blue, color)
    painted = mask & (color >= 0)
    occurring = np.zeros(_COLORS, np.bool_)
    occurring[color[painted]] = True
    if np.count_nonzero(occurring) > HARD_EDGED:
        occurring[:] = False
        occurring[_solid(np.where(painted, color, -1))] = True
    colors = np.flatnonzero(occurring)
    if not 0 < len(colors) <= _MOST_COLORS:
        return None
    number = np.full(_COLORS, -1, np.intp)
    number[colors] = np.arange(len(colors))
    labels = np.where(painted, number[color], -1)
    area = np.bincount(labels[labels >= 0], minlength=len(colors))
    materials = _without_shades(colors, area)
    if area.sum() < FLAT_SHARE * np.count_nonzero(painted) or materials.max() >= MOST_LABELS:
        return None
    return _completed(np.where(labels >= 0, materials[labels], -1), painted)


def _without_shades(colors: NDArray[np.intp], area: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the number of each color's material, the largest first; those that hardly differ share one."""
    channels = np.column_stack([colors >> 16, colors >> 8 & 255, colors & 255])
    material = np.full(len(colors), -1, np.intp)
    count = 0
    for largest in np.argsort(-area, kind="stable"):
        if material[largest] < 0:
            alike = (np.abs(channels - channels[largest]) <= ALIKE).all(axis=1)
            material[alike & (material < 0)] = count
            count += 1
    return material


def _solid(color: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the colors of all blocks of 3 x 3 that have one."""
    if min(color.shape) < BLOCK:
        return color[:0, 0]
    blocks = sliding_window_view(color, (BLOCK, BLOCK))
    middle = blocks[..., 1, 1]
    same = middle >= 0
    for row, column in np.ndindex(BLOCK, BLOCK):
        same &= blocks[..., row, column] == middle
    return np.asarray(middle[same])


def _completed(labels: NDArray[np.intp], painted: BoolArray) -> NDArray[np.intp]:
    """Give painted pixels without a label that of the nearest one that has one."""
    left = painted & (labels < 0)
    if left.any():
        rows, columns = np.flatnonzero(painted.any(axis=1)), np.flatnonzero(painted.any(axis=0))
        box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        rows, columns = ndimage.distance_transform_edt(
            labels[box] < 0, return_distances=False, return_indices=True
        )
        labels[box] = np.where(left[box], labels[box][rows, columns], labels[box])
    return labels

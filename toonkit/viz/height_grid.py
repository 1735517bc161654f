"""A normal field reduced to the grid that a 3-D view shows, with its height and where its arrows stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import BoolArray, refuse
from toonkit.heightfield import HeightField, height_map
from toonkit.model.normals import NormalField

DEFAULT_SIZE = 128
"""Longest side, in samples, of the surface: what a browser gets in about a second."""

ARROWS_ACROSS = 16
"""Arrows along the longest side."""


@dataclass(frozen=True, eq=False)
class HeightGrid:
    """
    A reduced normal field.

    Attributes
    ----------
    normals : NormalField
        Normals, (H, W).
    field : HeightField
        Their height, in pixels of the grid.
    step : int
        Pixels of the picture from one sample to the next.
    arrow_spacing : int
        Pixels of the grid between two arrows.
    arrow_feet : ndarray, shape (H, W), bool
        True on the object pixels that carry an arrow.
    """

    normals: NormalField
    field: HeightField
    step: int
    arrow_spacing: int
    arrow_feet: BoolArray


def reduce_to_grid(normals: NormalField, *, size: int = DEFAULT_SIZE) -> HeightGrid:
    """
    Reduce a normal field by whole steps, and integrate it.

    Parameters
    ----------
    normals : NormalField
        Normals, (H, W).
    size : int, optional
        Longest side of the grid, in samples.

    Returns
    -------
    HeightGrid
        Of at most `size` samples on either side.

    Raises
    ------
    ToonkitError
        If the size is below 8, or the reduced object is too small to have a shape.
    """
    if size < 8:
        raise refuse("size", "must be at least 8 samples", size)
    step = -(-max(normals.shape) // size)
    reduced = NormalField(normals.vectors[::step, ::step], normals.mask[::step, ::step])
    spacing = max(1, round(max(reduced.shape) / ARROWS_ACROSS))
    feet = np.zeros(reduced.shape, dtype=bool)
    feet[spacing // 2 :: spacing, spacing // 2 :: spacing] = True
    return HeightGrid(
        normals=reduced,
        field=height_map(reduced),
        step=step,
        arrow_spacing=spacing,
        arrow_feet=feet & reduced.mask,
    )

"""Corrections of a shape as the arrays of an archive."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray
from toonkit.export.npz import Arrays
from toonkit.model.shape_corrections import MOST_HINTS, PARTS, NormalHint, ShapeCorrections

PREFIX = "shape_"
"""Prefix of the names of these arrays."""

HINTS = f"{PREFIX}normals"


def pack_shape(shape: ShapeCorrections | None, mask: BoolArray) -> dict[str, NDArray[Any]]:
    """Return the corrections as arrays by name: for each part one bool per pixel of the mask, for each hint six numbers."""
    if shape is None:
        return {}
    fields: dict[str, NDArray[Any]] = {PREFIX + name: part[mask] for name, part in shape.parts.items()}
    if shape.normals:
        fields[HINTS] = np.array(
            [(hint.row, hint.column, *hint.normal, hint.radius) for hint in shape.normals], np.float64
        )
    return fields


def read_shape(arrays: Arrays, mask: BoolArray) -> ShapeCorrections | None:
    """Read what `pack_shape` has returned; None if there are no corrections."""
    parts = {}
    for name in PARTS:
        if PREFIX + name in arrays.names:
            parts[name] = np.zeros(mask.shape, np.bool_)
            parts[name][mask] = arrays.read(PREFIX + name, "b", int(mask.sum()))
    hints = arrays.read(HINTS, "f", None, 6, most=6 * MOST_HINTS).tolist() if HINTS in arrays.names else []
    normals = [NormalHint(int(row), int(column), (x, y, z), radius) for row, column, x, y, z, radius in hints]
    shape = ShapeCorrections(**parts, normals=tuple(normals))
    return None if shape.is_empty else shape

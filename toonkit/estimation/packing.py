"""Pixels in few bytes, as archives hold them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.numerics.parallel import run_on_chunks

_NORMAL_STEPS = 32767


def pack_levels(values: FloatArray) -> NDArray[Any]:
    """Return values in [0, 1] as 8- or 16-bit integers if they are exactly levels of these, or else unchanged."""
    for dtype in (np.uint8, np.uint16):
        levels = np.empty(values.shape, dtype)
        if all(run_on_chunks(_write_levels, len(values), values, levels)):
            return levels
    return values


def unpack_levels(packed: NDArray[Any]) -> FloatArray:
    """Return what `pack_levels` was given, to the last bit; unsigned integers of any other size are read as levels, too."""
    if packed.dtype.kind == "u":
        levels: FloatArray = packed / np.float64(np.iinfo(packed.dtype).max)
        return levels
    return packed


def pack_normals(normals: FloatArray) -> NDArray[np.uint16]:
    """
    Return unit vectors (P, 3), z >= 0, as two 16-bit integers each, (P, 2). This turns them by less than 0.005 degrees.

    The hemisphere is projected onto an octahedron, whose upper half is a square in the plane. Unlike x and y alone, this
    encoding is as exact at the rim, where z is small, as elsewhere.
    """
    packed = np.empty((len(normals), 2), np.uint16)
    run_on_chunks(_project, len(normals), normals, packed)
    return packed


def unpack_normals(packed: NDArray[np.uint16]) -> FloatArray:
    """Return the unit vectors (P, 3), z >= 0, of `pack_normals`; any numbers (P, 2) give such vectors."""
    along, across = (packed / _NORMAL_STEPS - 1.0).T
    normals = np.empty((len(packed), 3))
    normals[:, 0], normals[:, 1] = (along + across) / 2, (along - across) / 2
    normals[:, 2] = np.maximum(1.0 - np.abs(normals[:, 0]) - np.abs(normals[:, 1]), 0.0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals


def round_normals(normals: FloatArray) -> FloatArray:
    """Return unit vectors (P, 3), z >= 0, as an archive brings them back: packing them again changes no bit."""
    rounded = np.empty(normals.shape)
    run_on_chunks(_round, len(normals), normals, rounded)
    return rounded


def _round(normals: FloatArray, rounded: FloatArray, piece: slice) -> None:
    """Round some normals."""
    rounded[piece] = unpack_normals(pack_normals(normals[piece]))


def _write_levels(values: FloatArray, levels: NDArray[Any], piece: slice) -> bool:
    """Write the levels of some values; return whether the values equal these levels to the last bit."""
    top = np.iinfo(levels.dtype).max
    nearest = np.rint(values[piece] * top)
    levels[piece] = nearest
    return np.array_equal(nearest / top, values[piece])


def _project(normals: FloatArray, packed: NDArray[np.uint16], piece: slice) -> None:
    """Project some normals onto the octahedron."""
    x, y, z = normals[piece].T
    size = np.abs(x) + np.abs(y) + z
    packed[piece, 0] = np.rint(((x + y) / size + 1) * _NORMAL_STEPS)
    packed[piece, 1] = np.rint(((x - y) / size + 1) * _NORMAL_STEPS)

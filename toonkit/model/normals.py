"""NormalField: unit normals per pixel, and their encoding as the colors of a normal map."""

from __future__ import annotations

from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import (
    BoolArray,
    FloatArray,
    any_array,
    as_array,
    as_mask,
    of_type,
    refuse,
    same_shape,
    warn,
)
from toonkit.model.description import describe_object, preview_png
from toonkit.model.normal_map_check import OFF_UNIT, NormalMapCheck, check_normal_map
from toonkit.model.whole_pixels import pieces, pixels_at, put_pixels

UNIT_TOLERANCE = 1e-3
"""A vector this close to unit length is a rounded unit vector and is renormalized; others are refused."""

GreenAxis = Literal["opengl", "directx"]
"""Which way green points in a normal map: up (OpenGL, Unity, Blender) or down (DirectX, Unreal)."""


class NormalField:
    """
    Unit normals of the visible surface.

    Parameters
    ----------
    vectors : array_like, shape (H, W, 3)
        Unit vectors, x right, y up, z >= 0 toward the viewer. Values outside the mask are ignored.
    mask : array_like, shape (H, W)
        True on the object.

    Raises
    ------
    ToonkitError
        If the shapes differ, or a vector on the object is not finite, not of unit length or faces away.
    """

    def __init__(self, vectors: ArrayLike, mask: ArrayLike) -> None:
        given = as_array("vectors", vectors, (None, None, 3))
        self._mask = as_mask("mask", mask)
        same_shape("mask", self._mask.shape, given.shape[:2], "vectors")
        inside = pixels_at(given, self._mask)
        if not np.isfinite(inside).all():
            raise refuse("vectors", "must be finite on the object", "NaN or infinite components")
        largest = float(np.abs(inside).max())
        if largest > 1 + UNIT_TOLERANCE:  # before it is squared
            raise refuse("vectors", "must have unit length on the object", f"a component of {largest:.6g}")
        length = np.linalg.norm(inside, axis=1)
        worst = float(length[np.argmax(np.abs(length - 1))])
        if abs(worst - 1) > UNIT_TOLERANCE:
            raise refuse("vectors", "must have unit length on the object", f"a vector of length {worst:.6g}")
        lowest = float(inside[:, 2].min())
        if lowest < -UNIT_TOLERANCE:
            raise refuse("vectors", "must face the viewer (z >= 0) on the object", f"z = {lowest:.6g}")
        inside[:, 2] = np.maximum(inside[:, 2], 0.0)
        length = np.linalg.norm(inside, axis=1, keepdims=True)
        # Unit vectors up to rounding stay as they are, so that a field made of a field's vectors is equal to it.
        rounded = np.abs(length - 1) <= 4 * np.finfo(np.float64).eps
        self._compact = inside / np.where(rounded, 1.0, length)
        self._vectors: FloatArray | None = None

    @classmethod
    def of_pixels(cls, vectors: FloatArray, mask: BoolArray) -> NormalField:
        """Make a field of the unit vectors (P, 3), z >= 0, of a mask's pixels in row-major order; nothing is checked."""
        field = object.__new__(cls)
        field._mask, field._compact, field._vectors = mask, vectors, None
        return field

    def __repr__(self) -> str:
        return f"NormalField({describe_object(self.mask)})"

    def _repr_png_(self) -> bytes:
        opacity = np.where(self.mask, 255, 0).astype(np.uint8)
        return preview_png(np.dstack([encode_normal_map(self).astype(np.uint8), opacity]))

    @property
    def mask(self) -> BoolArray:
        """True on the object: bool, shape (H, W)."""
        return self._mask

    @property
    def compact(self) -> FloatArray:
        """The vectors of the object's pixels in row-major order: float64, shape (P, 3)."""
        return self._compact

    @property
    def vectors(self) -> FloatArray:
        """The vectors as an image: float64, shape (H, W, 3), NaN outside the mask. Made when it is first asked for."""
        if self._vectors is None:
            vectors = np.full((*self._mask.shape, 3), np.nan)
            put_pixels(vectors, self._mask, self._compact)
            self._vectors = vectors
        return self._vectors

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        height, width = self.mask.shape
        return height, width

    def save(
        self, path: str | PathLike[str], *, bits: Literal[8, 16] = 8, green: GreenAxis = "opengl"
    ) -> None:
        """
        Write the normals as an opaque normal map.

        `read_normal_map(path, mask=normals.mask)` reads it. One with alpha, named and made for an engine, is what
        `toonkit.export.engines.write_engine_normal_map` writes.

        Parameters
        ----------
        path : path
            Ends in .png. An older file is replaced once the new one is complete.
        bits : {8, 16}, optional
            Bits a channel.
        green : {"opengl", "directx"}, optional
            Green up (OpenGL, Unity, Blender, Godot) or down (DirectX, Unreal).

        Raises
        ------
        ToonkitError
            If `bits`, `green` or the suffix is none of these, or the file cannot be written.
        """
        from toonkit.export.normal_map import write_normal_map  # noqa: PLC0415 - export stands above the model

        write_normal_map(self, path, bits=bits, green=green)


def encode_normal_map(
    normals: NormalField, *, bits: Literal[8, 16] = 8, green: GreenAxis = "opengl"
) -> NDArray[np.unsignedinteger]:
    """
    Encode normals as normal-map colors.

    Each component -1..1 goes to 0..2^bits - 1, z included (so a visible surface has blue >= one half).
    Outside the mask the map holds the flat normal (0, 0, 1), which is what engines expect of padding.

    Parameters
    ----------
    normals : NormalField
        The normals.
    bits : {8, 16}, optional
        Bits a channel.
    green : {"opengl", "directx"}, optional
        Green up (OpenGL) or down (DirectX).

    Returns
    -------
    ndarray, shape (H, W, 3)
        uint8 or uint16.

    Raises
    ------
    ToonkitError
        If the normals are no `NormalField`, or `bits` or `green` is none of the above.
    """
    of_type("normals", normals, NormalField)
    _check_encoding(bits, green)
    steps = (2**bits - 1) / 2
    signs = (1.0, -1.0 if green == "directx" else 1.0, 1.0)
    encoded = np.empty((*normals.shape, 3), f"uint{bits}")
    encoded[:] = np.rint((np.array([0.0, 0.0, 1.0]) + 1) * steps)
    colors = np.empty(normals.compact.shape, encoded.dtype)
    for piece in pieces(len(colors)):
        colors[piece] = np.rint((normals.compact[piece] * signs + 1) * steps)
    put_pixels(encoded, normals.mask, colors)
    return encoded


def decode_normal_map(colors: ArrayLike, mask: ArrayLike, *, green: GreenAxis = "opengl") -> NormalField:
    """
    Decode normal-map colors: the inverse of `encode_normal_map` up to rounding.

    Parameters
    ----------
    colors : array_like, shape (H, W, 3)
        uint8 or uint16, z from -1..1 in blue.
    mask : array_like, shape (H, W)
        True on the object.
    green : {"opengl", "directx"}, optional
        Green up (OpenGL) or down (DirectX).

    Returns
    -------
    NormalField
        Renormalized normals. `toonkit.model.normal_map_check.check_normal_map` says how far they were off.

    Raises
    ------
    ToonkitError
        If the colors are not 8 or 16 bit integers or cannot be a normal map, because most vectors are far from unit length.

    Warns
    -----
    ToonkitWarning
        If some vectors are far from unit length, as blending and resizing leave them, or if the normals at the rim point
        into the object, which tells a wrong `green`.
    """
    array = any_array("colors", colors)
    if array.dtype not in (np.uint8, np.uint16):
        raise refuse("colors", "must be uint8 or uint16", f"dtype {array.dtype}")
    bits = 8 if array.dtype == np.uint8 else 16
    _check_encoding(bits, green)
    vectors = as_array("colors", array, (None, None, 3)) * (2 / (2**bits - 1)) - 1
    if green == "directx":
        vectors[..., 1] *= -1
    on_object = as_mask("mask", mask)
    same_shape("mask", on_object.shape, vectors.shape[:2], "colors")
    check = check_normal_map(vectors, on_object)
    if check.problem:
        raise refuse("colors", "must encode unit vectors with z from -1..1", check.problem)
    _warn_of(check, green)
    vectors[..., 2] = np.maximum(vectors[..., 2], 0.0)
    return NormalField(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True), on_object)


def _warn_of(check: NormalMapCheck, green: GreenAxis) -> None:
    if check.off_unit:
        share = check.off_unit / check.pixels
        warn(
            "colors",
            f"{check.off_unit} of {check.pixels} vectors ({share:.2%}) are more than {OFF_UNIT:.0%} off unit length, "
            f"the worst {check.worst:.2f} long; they are renormalized",
        )
    across, up = check.mirrored
    if up:
        other = "directx" if green == "opengl" else "opengl"
        warn(
            "green",
            f'read as "{green}", normals at the silhouette point into the object; try green="{other}"',
        )
    if across:
        warn("colors", "the normals at the silhouette point inward from left and right: red is mirrored")


def _check_encoding(bits: int, green: str) -> None:
    if not isinstance(bits, int) or bits not in (8, 16):
        raise refuse("bits", "must be 8 or 16", bits)
    if not isinstance(green, str) or green not in ("opengl", "directx"):
        raise refuse("green", 'must be "opengl" (up) or "directx" (down)', repr(green))

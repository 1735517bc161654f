"""Normal maps as PNG files of 8 or 16 bits a channel."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_edt

from toonkit._validation import FloatArray, as_coverage, is_number, refuse
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.export.picture import encode_png
from toonkit.model.normals import GreenAxis, NormalField, encode_normal_map


def write_normal_map(
    normals: NormalField,
    path: PathLike,
    *,
    bits: Literal[8, 16] = 8,
    green: GreenAxis = "opengl",
    alpha: ArrayLike | None = None,
    bleed: float = 0,
) -> None:
    """
    Write normals as a normal map.

    Parameters
    ----------
    normals : NormalField
        The normals; outside their mask the map is flat, (0, 0, 1), but for what `bleed` says.
    path : path
        Ends in .png. An older file is replaced once the new one is complete.
    bits : {8, 16}, optional
        Bits a channel. Eight turn a normal by up to half a degree, sixteen by less than 0.002 degrees.
    green : {"opengl", "directx"}, optional
        Green up (OpenGL, Unity, Blender, Godot) or down (DirectX, Unreal).
    alpha : array_like, shape (H, W), optional
        Coverage, 0 to 1, such as `analysis.image.alpha`: written as alpha. Every pixel that it covers in part has a normal.
    bleed : float, optional
        Pixels by which the normals of the rim go on outward, so that neither filtering nor mipmaps mix flat normals into
        the object.

    Raises
    ------
    ToonkitError
        If an argument breaks these rules, or the file cannot be written.

    Notes
    -----
    The file has no gAMA, iCCP, sRGB or cHRM chunk: normals are no colors, and a program that converted them would turn
    them.
    """
    suffix_of(path, (".png",))
    if not is_number(bleed) or bleed < 0:
        raise refuse("bleed", "must be a number of pixels >= 0", bleed)
    colors: NDArray[Any] = encode_normal_map(normals, bits=bits, green=green)
    coverage = None if alpha is None else as_coverage("alpha", alpha, normals.shape)
    colors = _bled(colors, normals, coverage, bleed)
    if coverage is not None:
        opacity = np.round(coverage * (2**bits - 1)).astype(colors.dtype)
        colors = np.concatenate([colors, opacity[..., None]], axis=-1)
    encoded = encode_png(np.ascontiguousarray(colors), smooth=True)
    with atomic_write(path) as file:
        file.write(encoded)


def _bled(
    colors: NDArray[Any], normals: NormalField, coverage: FloatArray | None, bleed: float
) -> NDArray[Any]:
    """Give pixels outside the object, near it or covered in part, the color of the object pixel nearest to them."""
    if bleed == 0 and coverage is None:
        return colors
    distance, (rows, columns) = distance_transform_edt(~normals.mask, return_indices=True)
    near = distance <= bleed
    if coverage is not None:
        near |= coverage > 0
    bled = colors.copy()
    bled[near] = colors[rows[near], columns[near]]
    return bled

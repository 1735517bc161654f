"""read_normal_map: a normal map of any program as a NormalField, its samples taken as numbers and not as colors."""

from __future__ import annotations

import numpy as np

from toonkit._validation import refuse
from toonkit.model.decoding import PictureSource, read_pixels
from toonkit.model.loading import HALF_COVERED, NEARLY_OPAQUE, read_coverage
from toonkit.model.normals import GreenAxis, NormalField, decode_normal_map


def read_normal_map(
    source: PictureSource, *, mask: PictureSource | None = None, green: GreenAxis = "opengl"
) -> NormalField:
    """
    Read a normal map.

    Parameters
    ----------
    source : path, binary file object or array_like
        A picture as `toonkit.load_image` reads it, z from -1..1 in blue. Gamma, profile and other color spaces that it
        declares are left alone: they do not apply to normals.
    mask : path, binary file object or array_like, optional
        Where the object is, as for `toonkit.load_image`. By default it is where the map is opaque.
    green : {"opengl", "directx"}, optional
        Green up (OpenGL) or down (DirectX).

    Returns
    -------
    NormalField
        Renormalized normals.

    Raises
    ------
    ToonkitError
        If the file is no picture, is opaque without a mask, the mask is of another size, or the colors cannot be a normal
        map.

    Warns
    -----
    ToonkitWarning
        As `decode_normal_map`.

    Examples
    --------
    >>> flat = np.full((8, 8, 3), (128, 128, 255), np.uint8)
    >>> read_normal_map(flat, mask=np.ones((8, 8))).shape
    (8, 8)
    """
    pixels = read_pixels("source", source, colors=False)
    if mask is not None:
        coverage = read_coverage(mask)
    elif pixels.alpha is None or (pixels.alpha >= NEARLY_OPAQUE).all():
        raise refuse(
            "source", "must be transparent around the object, or come with a mask", "an opaque picture"
        )
    else:
        coverage = pixels.alpha
    samples = np.round(np.clip(pixels.color, 0.0, 1.0) * 65535).astype(np.uint16)
    return decode_normal_map(samples, coverage >= HALF_COVERED, green=green)

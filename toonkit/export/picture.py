"""Pictures as PNG or WebP files, alpha kept."""

from __future__ import annotations

import io

import imagecodecs
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from toonkit._validation import any_array, refuse
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.model.image import ToonImage

# In flat paint and smooth normals a row is like the one above. This takes a third of the time of zlib's usual level with a
# filter chosen row by row, for files a twentieth larger if the picture is large, and a third if it is small.
_PNG_LEVEL, _PNG_FILTER = 1, imagecodecs.PNG.FILTER.UP

_WEBP_LONGEST_SIDE = 16383


def write_picture(picture: ToonImage | NDArray[np.uint8], path: PathLike) -> None:
    """
    Write a picture without loss.

    Parameters
    ----------
    picture : ToonImage or ndarray, shape (H, W, 3) or (H, W, 4)
        The picture; an array is uint8 sRGB, with straight alpha if it has four channels.
    path : path
        Ends in .png or .webp. An older file is replaced once the new one is complete.

    Raises
    ------
    ToonkitError
        If the suffix is another, the array is not a uint8 picture, or the file cannot be written.
    """
    suffix = suffix_of(path, (".png", ".webp"))
    pixels = picture.to_rgba() if isinstance(picture, ToonImage) else any_array("picture", picture)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[-1] not in (3, 4):
        shown = f"shape {pixels.shape}, dtype {pixels.dtype}"
        raise refuse("picture", "must be a ToonImage or a uint8 array of shape (H, W, 3 or 4)", shown)
    if 0 in pixels.shape:
        raise refuse("picture", "must have pixels", f"shape {pixels.shape}")
    if suffix == ".webp" and max(pixels.shape) > _WEBP_LONGEST_SIDE:
        raise refuse("path", f"must end in .png for sides over {_WEBP_LONGEST_SIDE} pixels", f"{path}")
    with atomic_write(path) as file:
        file.write(encode_picture(pixels, suffix))


def encode_picture(pixels: NDArray[np.uint8], suffix: str) -> bytes:
    """Return the bytes of a lossless .png or .webp file; both keep the colors under transparent pixels."""
    pixels = np.ascontiguousarray(pixels)
    if suffix == ".png":
        return encode_png(pixels)
    encoded = io.BytesIO()
    Image.fromarray(pixels).save(encoded, "WEBP", lossless=True, exact=True, quality=75)
    return encoded.getvalue()


def encode_png(pixels: NDArray[np.unsignedinteger], *, smooth: bool = False) -> bytes:
    """
    Return the bytes of a .png file of 8 or 16 bits a channel; other threads go on meanwhile.

    In a smooth picture, such as a normal map, nothing is repeated but runs of one value. To look for these alone is faster,
    and the file a little smaller.
    """
    strategy = imagecodecs.PNG.STRATEGY.RLE if smooth else None
    return bytes(imagecodecs.png_encode(pixels, level=_PNG_LEVEL, filter=_PNG_FILTER, strategy=strategy))

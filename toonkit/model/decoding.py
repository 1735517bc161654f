"""Picture files and arrays as sRGB in [0, 1] and opacity: formats, depths, profiles and rotation end here."""

from __future__ import annotations

import io
import logging
import os
import struct
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageCms, UnidentifiedImageError

from toonkit._validation import FloatArray, ToonkitError, any_array, refuse

MAX_PIXELS = 8192 * 8192
"""Largest picture accepted: its normals, color and solver fields still fit into a few GiB."""

PictureSource = str | os.PathLike[str] | BinaryIO | ArrayLike
"""A path, a file opened in binary mode, or an array."""

_FORMATS = ("PNG", "WEBP", "JPEG", "TIFF", "GIF", "BMP")
_FORMAT_NAMES = "PNG, WebP, JPEG, TIFF, GIF or BMP"
_TIFF_STARTS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_ORIENTATION = 274  # EXIF and TIFF tag
_TIFF_WHITE_IS_ZERO, _TIFF_BLACK_IS_ZERO, _TIFF_RGB = 0, 1, 2
_TIFF_PREMULTIPLIED = 1

logging.getLogger("tifffile").addHandler(logging.NullHandler())  # or it prints what is odd about a file


@dataclass(frozen=True, eq=False)
class Pixels:
    """
    A decoded picture.

    Attributes
    ----------
    color : ndarray, shape (H, W, 3)
        float64 sRGB; in [0, 1] if it came from a file or from integers, as given if it came from floats.
    alpha : ndarray, shape (H, W), or None
        float64 opacity, None if the picture has none. Color is not premultiplied by it.
    """

    color: FloatArray
    alpha: FloatArray | None


def read_pixels(argument: str, source: PictureSource) -> Pixels:
    """
    Decode a picture.

    Parameters
    ----------
    argument : str
        Name of the argument, for messages.
    source : path, binary file object or array_like
        PNG, WebP, JPEG, TIFF, GIF or BMP (the first frame), turned upright by its EXIF orientation and
        brought to sRGB by its ICC profile; or an array of shape (H, W), (H, W, 1) gray, (H, W, 2) gray and
        alpha, (H, W, 3) or (H, W, 4): bool, uint8, uint16 or float in [0, 1].

    Returns
    -------
    Pixels
        Color and opacity at the precision of the source.

    Raises
    ------
    ToonkitError
        If there is no such file, or it is no picture, not complete or larger than `MAX_PIXELS`.
    """
    if isinstance(source, str | os.PathLike):
        path = Path(source).expanduser()
        return _from_bytes(argument, _read_path(argument, path), str(path))
    if hasattr(source, "read"):
        try:
            data = source.read()
        except (OSError, ValueError) as error:  # ValueError: a closed file
            raise refuse(argument, "must be a readable file", f"{source!r} ({error})") from error
        if not isinstance(data, bytes):
            raise refuse(argument, 'must be opened in binary mode ("rb")', f"a file of {type(data).__name__}")
        return _from_bytes(argument, data, str(getattr(source, "name", "a file object")))
    return _from_array(argument, source)


def unit_range(argument: str, array: NDArray[Any]) -> FloatArray:
    """Return bool, uint8, uint16 or float samples as float64, full scale at 1; floats pass as they are."""
    if array.dtype == np.bool_ or array.dtype.kind == "f":
        with np.errstate(invalid="ignore"):  # a signaling NaN, which callers refuse as any other
            return array.astype(np.float64)
    if array.dtype in (np.uint8, np.uint16):
        return array / np.float64(np.iinfo(array.dtype).max)
    raise refuse(argument, "must be bool, uint8, uint16 or float in [0, 1]", f"dtype {array.dtype}")


def _read_path(argument: str, path: Path) -> bytes:
    try:
        return path.read_bytes()
    except IsADirectoryError:
        raise refuse(argument, "must be a picture file", f"the folder {path}") from None
    except FileNotFoundError:
        raise refuse(argument, "must be an existing file", f"{path}, which does not exist") from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        raise refuse(argument, "must be a readable file", f"{path} ({error})") from error


def _from_array(argument: str, source: ArrayLike) -> Pixels:
    array = any_array(argument, source)
    if array.ndim == 2:
        array = array[..., None]
    if array.dtype.kind not in "biuf" or array.ndim != 3 or array.shape[-1] not in (1, 2, 3, 4):
        rule = "must be a path, a binary file or an array of shape (H, W), (H, W, 3) or (H, W, 4)"
        raise refuse(
            argument, rule, f"{type(source).__name__} of shape {np.shape(array)}, dtype {array.dtype}"
        )
    _check_size(argument, array.shape[1], array.shape[0])
    return _split(unit_range(argument, array))


def _split(samples: FloatArray) -> Pixels:
    """Separate (H, W, 1..4) samples into color and alpha; gray becomes three equal channels."""
    has_alpha = samples.shape[-1] in (2, 4)
    color = samples[..., :-1] if has_alpha else samples
    if color.shape[-1] == 1:
        color = np.repeat(color, 3, axis=-1)
    return Pixels(np.ascontiguousarray(color), samples[..., -1].copy() if has_alpha else None)


def _check_size(argument: str, width: int, height: int) -> None:
    if width * height > MAX_PIXELS:
        _refuse_large(argument, f"{width} x {height} pixels")
    if min(width, height) < 3:
        raise refuse(argument, "must be at least 3 x 3 pixels", f"{width} x {height}")


def _refuse_large(argument: str, shown: str) -> NoReturn:
    side = round(MAX_PIXELS**0.5)
    rule = (
        f"must have at most {side} x {side} = {MAX_PIXELS // 10**6} million pixels (scale the picture down)"
    )
    raise refuse(argument, rule, shown)


def _from_bytes(argument: str, data: bytes, name: str) -> Pixels:
    if not data:
        raise refuse(argument, "must be a picture file", f"{name}, which is empty")
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # Pillow warns of odd metadata and of large pictures; sizes are checked here
        try:
            samples, profile, orientation = _decode(argument, data)
        except ToonkitError:
            raise
        except UnidentifiedImageError:
            raise refuse(argument, f"must be a {_FORMAT_NAMES} picture", _describe(name, data)) from None
        except Image.DecompressionBombError:
            _refuse_large(argument, f"{name}, far larger")
        except MemoryError:
            raise
        except Exception as error:  # decoders raise nearly every type there is for a damaged file
            raise refuse(argument, "must be a complete, undamaged picture", f"{name} ({error})") from error
    samples = _upright(_to_srgb(samples, profile), orientation)
    return _split(unit_range(argument, samples))


def _describe(name: str, data: bytes) -> str:
    if b"<svg" in data[:1000]:
        return f"{name}, an SVG drawing (export it as PNG)"
    return f"{name}, which is none of these"


def _decode(argument: str, data: bytes) -> tuple[NDArray[Any], bytes | None, int]:
    """Decode to samples (H, W, 1..4), the ICC profile they are in (None: sRGB) and the EXIF orientation."""
    if data.startswith(_TIFF_STARTS):
        deep = _decode_deep_tiff(argument, data)
        if deep is not None:
            return deep
    png_bits = 0
    if data.startswith(b"\x89PNG\r\n\x1a\n") and len(data) >= 25:
        # Read here because Pillow checks the size with an exception that does not tell it.
        width, height, png_bits = struct.unpack(">IIB", data[16:25])
        _check_size(argument, width, height)
    with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
        _check_size(argument, *picture.size)
        picture.load()
        profile = picture.info.get("icc_profile")
        orientation = picture.getexif().get(_ORIENTATION, 1)
        if png_bits == 16:
            return _decode_deep_png(data), profile, orientation
        if picture.mode == "CMYK":
            return np.asarray(_cmyk_to_srgb(picture, profile)), None, orientation
        return _samples(picture), profile, orientation


def _decode_deep_png(data: bytes) -> NDArray[Any]:
    """Sixteen bits a channel, which Pillow would cut to eight."""
    import imagecodecs  # noqa: PLC0415  # its compiled codecs load slowly, and few pictures need them

    samples: NDArray[Any] = imagecodecs.png_decode(data)
    return samples[..., None] if samples.ndim == 2 else samples


def _decode_deep_tiff(argument: str, data: bytes) -> tuple[NDArray[Any], bytes | None, int] | None:
    """Decode a TIFF of more than eight bits a channel; None for any other, which Pillow reads."""
    import tifffile  # noqa: PLC0415  # slow to load, seldom needed

    with tifffile.TiffFile(io.BytesIO(data)) as file:
        page: Any = file.pages[0]
        _check_size(argument, page.imagewidth, page.imagelength)
        if page.bitspersample <= 8:
            return None
        kind = int(page.photometric)
        if kind not in (_TIFF_WHITE_IS_ZERO, _TIFF_BLACK_IS_ZERO, _TIFF_RGB):
            raise refuse(
                argument, "must be gray or RGB if it is a TIFF of 16 bits or more", page.photometric.name
            )
        samples = page.asarray()
        if page.axes.startswith("S"):  # one plane a channel
            samples = np.moveaxis(samples, 0, -1)
        samples = samples.reshape(page.imagelength, page.imagewidth, -1)
        if samples.dtype.kind == "f":
            samples = np.clip(samples, 0.0, 1.0)  # highlights brighter than white have no sRGB color
        else:
            samples = samples / (2.0**page.bitspersample - 1)
        colors = 3 if kind == _TIFF_RGB else 1
        if samples.shape[-1] < colors:
            raise ValueError("channels are missing")
        color, alpha = samples[..., :colors], samples[..., colors : colors + 1]
        if kind == _TIFF_WHITE_IS_ZERO:
            color = 1 - color
        if alpha.size and page.extrasamples and int(page.extrasamples[0]) == _TIFF_PREMULTIPLIED:
            color = np.clip(np.divide(color, alpha, out=np.zeros_like(color), where=alpha > 0), 0.0, 1.0)
        samples = np.concatenate([color, alpha], axis=-1)
        orientation = page.tags.get(_ORIENTATION)
        return samples, page.iccprofile, int(orientation.value) if orientation is not None else 1


def _samples(picture: Image.Image) -> NDArray[Any]:
    """Return the samples of an 8-bit picture, with palettes looked up."""
    if picture.mode == "LA":
        mode = "LA"
    elif picture.has_transparency_data:
        mode = "RGBA"
    else:
        mode = "L" if picture.mode in ("1", "L") else "RGB"
    samples = np.asarray(picture.convert(mode))
    return samples[..., None] if samples.ndim == 2 else samples


def _cmyk_to_srgb(picture: Image.Image, profile: bytes | None) -> Image.Image:
    if profile:
        try:
            srgb = ImageCms.createProfile("sRGB")
            converted = ImageCms.profileToProfile(picture, io.BytesIO(profile), srgb, outputMode="RGB")
        except (ImageCms.PyCMSError, OSError):  # a damaged profile
            converted = None
        if converted is not None:
            return converted
    return picture.convert("RGB")


def _to_srgb(samples: NDArray[Any], profile: bytes | None) -> NDArray[Any]:
    """Convert colors from an embedded ICC profile to sRGB; one that cannot be used is taken for sRGB."""
    if not profile or _is_srgb(profile):
        return samples
    colors = 1 if samples.shape[-1] < 3 else 3
    return np.concatenate([_transform(samples[..., :colors], profile), samples[..., colors:]], axis=-1)


def _is_srgb(profile: bytes) -> bool:
    try:
        described = ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(profile)))
    except (ImageCms.PyCMSError, OSError):
        return True
    return described.startswith("sRGB")


def _transform(color: NDArray[Any], profile: bytes) -> NDArray[Any]:
    """Convert (H, W, 1 or 3) samples to sRGB (H, W, 3) without leaving their precision."""
    import imagecodecs  # noqa: PLC0415  # as above; it converts 16 bits, Pillow does not

    floats = color.dtype.kind == "f"
    given = np.round(color * 65535).astype(np.uint16) if floats else np.ascontiguousarray(color)
    try:
        converted: NDArray[Any] = imagecodecs.cms_transform(
            given[..., 0] if color.shape[-1] == 1 else given,
            profile,
            ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes(),
            colorspace="gray" if color.shape[-1] == 1 else "rgb",
            outcolorspace="rgb",
            outdtype=given.dtype,
        )
    except (RuntimeError, ValueError):  # a profile for another color space than the picture's
        return color
    return converted / np.float64(65535) if floats else converted


def _upright(samples: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Turn a picture the way its EXIF orientation (1 to 8) says it is to be seen."""
    if orientation in (5, 6, 7, 8):
        samples = samples.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        samples = samples[::-1]
    if orientation in (2, 3, 6, 7):
        samples = samples[:, ::-1]
    return samples

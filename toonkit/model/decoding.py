"""Picture files and arrays as sRGB in [0, 1] and opacity: formats, depths, profiles and rotation end here."""

from __future__ import annotations

import io
import os
import warnings
from dataclasses import dataclass
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageCms, UnidentifiedImageError

from toonkit._validation import FloatArray, ToonkitError, any_array, refuse
from toonkit.model import png, tiff
from toonkit.model.color_space import ColorSpace, to_srgb
from toonkit.model.file_bytes import read_bytes
from toonkit.model.foreign_formats import name_format

MAX_PIXELS = 8192 * 8192
"""Largest picture accepted: its normals, color and solver fields still fit into a few GiB."""

PictureSource = str | os.PathLike[str] | BinaryIO | ArrayLike
"""A path, a file opened in binary mode, or an array."""

MAX_BYTES = 16 * MAX_PIXELS + 2**26
"""Largest picture file accepted: four floats for each pixel, and 64 MiB of other content."""

MIN_SIDE = 3
"""Shortest side of a drawing: anything smaller has no interior."""

_FORMATS = ("PNG", "WEBP", "JPEG", "GIF", "BMP")  # besides TIFF
_FORMAT_NAMES = "PNG, WebP, JPEG, TIFF, GIF or BMP"
_ORIENTATION = 274  # EXIF tag


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


@dataclass(frozen=True, eq=False)
class _Decoded:
    """Samples (H, W, 1..4), alpha last in two and four; what they mean, and the EXIF orientation."""

    samples: NDArray[Any]
    space: ColorSpace
    orientation: object


def read_pixels(
    argument: str, source: PictureSource, *, colors: bool = True, min_side: int = MIN_SIDE
) -> Pixels:
    """
    Decode a picture.

    Parameters
    ----------
    argument : str
        Name of the argument, for messages.
    source : path, binary file object or array_like
        PNG, WebP, JPEG, TIFF, GIF or BMP (the first frame), turned upright by its EXIF orientation and brought to sRGB
        from the color space it declares; or an array of shape (H, W), (H, W, 1) gray, (H, W, 2) gray and alpha,
        (H, W, 3) or (H, W, 4): bool, uint8, uint16 or float in [0, 1].
    colors : bool, optional
        False for a picture whose samples are numbers, such as a mask, labels or normals: whatever color space the file
        declares is left alone.
    min_side : int, optional
        Pixels that its shorter side must have.

    Returns
    -------
    Pixels
        Color and opacity at the precision of the source.

    Raises
    ------
    ToonkitError
        If there is no such file, or it is no picture, not complete or larger than `MAX_PIXELS`.

    Warns
    -----
    ToonkitWarning
        If the file declares a color space that cannot be applied, or leaves open what its floats mean.
    """
    if not (isinstance(source, str | os.PathLike) or hasattr(source, "read")):
        return _from_array(argument, source, min_side)
    data, name = read_bytes(argument, source, limit=MAX_BYTES, kind="a picture file")
    decoded = _from_bytes(argument, data, name, min_side)
    samples = to_srgb(argument, decoded.samples, decoded.space) if colors else decoded.samples
    return _split(unit_range(argument, _upright(samples, decoded.orientation)))


def read_palette_indices(argument: str, path: str | os.PathLike[str]) -> NDArray[np.uint8] | None:
    """Return the entry of the palette that each pixel of a file has, upright, shape (H, W); None if it has no palette.

    The file is one that `read_pixels` reads.
    """
    data, _ = read_bytes(argument, path, limit=MAX_BYTES, kind="a picture file")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
            if picture.mode != "P":
                return None
            return _upright(np.asarray(picture), _orientation(picture))


def unit_range(argument: str, array: NDArray[Any]) -> FloatArray:
    """Return bool, uint8, uint16 or float samples as float64, full scale at 1; floats pass as they are."""
    if array.dtype == np.bool_ or array.dtype.kind == "f":
        with np.errstate(invalid="ignore"):  # a signaling NaN, which callers refuse as any other
            return array.astype(np.float64)
    if array.dtype in (np.uint8, np.uint16):
        return array / np.float64(np.iinfo(array.dtype).max)
    raise refuse(argument, "must be bool, uint8, uint16 or float in [0, 1]", f"dtype {array.dtype}")


def _from_array(argument: str, source: ArrayLike, min_side: int) -> Pixels:
    array = any_array(argument, source)
    if array.ndim == 2:
        array = array[..., None]
    if array.dtype.kind not in "biuf" or array.ndim != 3 or array.shape[-1] not in (1, 2, 3, 4):
        rule = "must be a path, a binary file or an array of shape (H, W), (H, W, 3) or (H, W, 4)"
        raise refuse(
            argument, rule, f"{type(source).__name__} of shape {np.shape(array)}, dtype {array.dtype}"
        )
    check_size(argument, array.shape[1], array.shape[0], min_side)
    return _split(unit_range(argument, array))


def _split(samples: FloatArray) -> Pixels:
    """Separate (H, W, 1..4) samples into color and alpha; gray becomes three equal channels."""
    has_alpha = samples.shape[-1] in (2, 4)
    color = samples[..., :-1] if has_alpha else samples
    if color.shape[-1] == 1:
        color = np.repeat(color, 3, axis=-1)
    return Pixels(np.ascontiguousarray(color), samples[..., -1].copy() if has_alpha else None)


def check_size(argument: str, width: int, height: int, min_side: int = MIN_SIDE) -> None:
    """Refuse a picture that is too large or too small."""
    if width * height > MAX_PIXELS:
        _refuse_large(argument, f"{width} x {height} pixels")
    if min(width, height) < min_side:
        raise refuse(argument, f"must be at least {min_side} x {min_side} pixels", f"{width} x {height}")


def _refuse_large(argument: str, shown: str) -> NoReturn:
    side = round(MAX_PIXELS**0.5)
    rule = (
        f"must have at most {side} x {side} = {MAX_PIXELS // 10**6} million pixels (scale the picture down)"
    )
    raise refuse(argument, rule, shown)


def _from_bytes(argument: str, data: bytes, name: str, min_side: int) -> _Decoded:
    with warnings.catch_warnings():
        # Pillow warns of odd metadata and of large pictures; sizes are checked here.
        warnings.simplefilter("ignore")
        try:
            if data.startswith(tiff.STARTS):
                return _decode_tiff(argument, data, min_side)
            return _decode(argument, data, min_side)
        except ToonkitError:
            raise
        except UnidentifiedImageError:
            shown = f"{name}, {name_format(data) or 'which is none of these'}"
            raise refuse(argument, f"must be a {_FORMAT_NAMES} picture", shown) from None
        except Image.DecompressionBombError:
            _refuse_large(argument, f"{name}, far larger")
        except MemoryError:
            raise
        except Exception as error:  # decoders raise nearly every type there is for a damaged file
            raise refuse(argument, "must be a complete, undamaged picture", f"{name} ({error})") from error


def _decode(argument: str, data: bytes, min_side: int) -> _Decoded:
    """Decode all but TIFF."""
    header = png.read_header(data) if data.startswith(png.SIGNATURE) else None
    if header is not None:
        # Before Pillow, which checks the size with an exception that does not tell it.
        check_size(argument, header.width, header.height, min_side)
    with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
        check_size(argument, *picture.size, min_side)
        picture.load()
        profile = picture.info.get("icc_profile")
        space = ColorSpace(profile) if header is None else png.declared_space(data, profile)
        orientation = _orientation(picture)
        if header is not None and header.bits == 16:
            return _Decoded(png.decode_deep_png(data, header), space, orientation)
        if picture.mode == "CMYK":
            return _Decoded(*_cmyk_to_srgb(picture, profile), orientation)
        return _Decoded(_samples(picture), space, orientation)


def _decode_tiff(argument: str, data: bytes, min_side: int) -> _Decoded:
    def check_page(width: int, height: int) -> None:
        check_size(argument, width, height, min_side)

    found = tiff.decode_tiff(argument, data, check_page)
    if not found.inks:
        return _Decoded(found.samples, found.space, found.orientation)
    inks = Image.fromarray(np.ascontiguousarray(found.samples[..., :4]), "CMYK")
    color, space = _cmyk_to_srgb(inks, found.space.profile)
    return _Decoded(np.concatenate([color, found.samples[..., 4:]], axis=-1), space, found.orientation)


def _orientation(picture: Image.Image) -> object:
    try:
        return picture.getexif().get(_ORIENTATION)
    except Exception:  # damaged metadata raises nearly every type there is, and harms no pixel
        return None


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


def _cmyk_to_srgb(picture: Image.Image, profile: bytes | None) -> tuple[NDArray[np.uint8], ColorSpace]:
    """Return inks as sRGB samples, and what is left to say about their profile."""
    if not profile:
        return np.asarray(picture.convert("RGB")), ColorSpace()
    try:
        srgb = ImageCms.createProfile("sRGB")
        converted = ImageCms.profileToProfile(picture, io.BytesIO(profile), srgb, outputMode="RGB")
    except (ImageCms.PyCMSError, OSError):
        converted = None
    if converted is None:
        remark = "its CMYK profile is damaged and is ignored"
        return np.asarray(picture.convert("RGB")), ColorSpace(remark=remark)
    return np.asarray(converted), ColorSpace()


def _upright(samples: NDArray[Any], orientation: object) -> NDArray[Any]:
    """Turn a picture the way its EXIF orientation (1 to 8) says it is to be seen; any other value says nothing."""
    if orientation in (5, 6, 7, 8):
        samples = samples.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        samples = samples[::-1]
    if orientation in (2, 3, 6, 7):
        samples = samples[:, ::-1]
    return samples

"""TIFF files: which of their pictures is the drawing, its samples, and what they mean."""

from __future__ import annotations

import io
import logging
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray, refuse
from toonkit.model.color_space import ColorSpace

if TYPE_CHECKING:
    from tifffile import TiffFile

STARTS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""First bytes of a TIFF file."""

MOST_SAMPLES = 5
"""Samples a pixel at most: four inks and alpha, or RGB, alpha and a saved selection."""

OVERSHOOT = 1.25
"""Largest sample of a float picture in [0, 1]: enlarging one overshoots by at most a fifth or so."""

_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _SEPARATED, _YCBCR = 0, 1, 2, 3, 5, 6
_COLORS = {_WHITE_IS_ZERO: 1, _BLACK_IS_ZERO: 1, _RGB: 3, _PALETTE: 1, _SEPARATED: 4, _YCBCR: 3}
_UNCOMPRESSED, _JPEG = 1, 7
_NO_ALPHA, _PREMULTIPLIED = 0, 1  # meanings of an extra sample
_REDUCED, _MASK = 1, 4  # bits of the type of a page
_ORIENTATION = 274
_MOST_PAGES = 64
_THUMBNAIL = 256  # pixels: no unmarked thumbnail is larger
_BYTE, _WORD = 255.0, 65535.0

logging.getLogger("tifffile").addHandler(logging.NullHandler())  # or it prints what is odd about a file


@dataclass(frozen=True, eq=False)
class TiffPicture:
    """
    The drawing in a TIFF file.

    Attributes
    ----------
    samples : ndarray, shape (H, W, 1..5)
        bool, uint8, uint16 or float in [0, 1]: gray, RGB or, if `inks`, the four inks; alpha last if there is any.
    inks : bool
        True if the samples are cyan, magenta, yellow and black, 255 being full ink.
    space : ColorSpace
        What they mean.
    orientation : object
        The orientation tag, whatever its type; None if there is none.
    """

    samples: NDArray[Any]
    inks: bool
    space: ColorSpace
    orientation: object


def decode_tiff(argument: str, data: bytes, check_size: Callable[[int, int], None]) -> TiffPicture:
    """
    Decode the first picture of a TIFF file that is no thumbnail or mask, nor looks like a thumbnail of a later one.

    `check_size` refuses a width and height before anything of that size is made. Raises `ToonkitError` if the size,
    kind or number of samples is none that toonkit reads, or floats are not in [0, 1].
    """
    import tifffile  # noqa: PLC0415  # slow to load, seldom needed

    with tifffile.TiffFile(io.BytesIO(data)) as file:
        page = _drawing(file)
        check_size(page.imagewidth, page.imagelength)
        kind, colors = _check_kind(argument, page, len(data))
        samples = _read_samples(page)
        if samples.shape[-1] < colors:
            raise ValueError("channels are missing")
        color, alpha = samples[..., :colors], _alpha(page, samples, colors)
        remark = ""
        if kind == _PALETTE:
            color = _looked_up(page, color[..., 0])
        elif samples.dtype.kind == "f":
            scale = _float_scale(argument, color)
            color = _clipped(color, scale)
            alpha = _clipped(alpha, scale if np.nanmax(alpha, initial=0.0) > OVERSHOOT else 1.0)
            remark = "" if scale == 1 else f"a float TIFF of whole numbers, divided by {scale:.0f}"
            if not page.iccprofile:
                remark = f"{remark or 'a float TIFF'}; it has no color profile and is read as sRGB"
        elif samples.dtype != np.bool_:
            color, alpha = _full_scale(color, page.bitspersample), _full_scale(alpha, page.bitspersample)
        if kind == _WHITE_IS_ZERO:
            color = ~color if color.dtype == np.bool_ else _top(color.dtype) - color
        if alpha.size and page.extrasamples and int(page.extrasamples[0]) == _PREMULTIPLIED:
            color, alpha = _straight(color, alpha)
        orientation = page.tags.get(_ORIENTATION)
        return TiffPicture(
            np.concatenate([color, alpha], axis=-1) if alpha.size else color,
            kind == _SEPARATED,
            ColorSpace(page.iccprofile, remark=remark),
            None if orientation is None else orientation.value,
        )


def _drawing(file: TiffFile) -> Any:
    """Return the page of the drawing."""
    pages = list(_pages(file))
    whole = [page for page in pages if not int(page.subfiletype) & (_REDUCED | _MASK)] or pages
    first = whole[0]
    return next((page for page in whole[1:] if _shows(first, page)), first)


def _pages(file: TiffFile) -> Iterator[Any]:
    """Yield the first pages of a file, each followed by those within it; what follows a damaged one is left out."""
    found = 0
    for index in range(_MOST_PAGES):
        try:
            page: Any = file.pages[index]
            within = list(page.pages[:_MOST_PAGES]) if page.subifds else []
        except Exception:  # a damaged page raises nearly every type there is
            if found == 0:
                raise
            return
        for one in (page, *within):
            found += 1
            yield one


def _shows(small: Any, page: Any) -> bool:
    """Tell whether a page shows in full what a smaller one is the thumbnail of."""
    width, height = page.imagewidth, page.imagelength
    if max(small.imagewidth, small.imagelength) > _THUMBNAIL or min(small.imagewidth, small.imagelength) < 1:
        return False
    across, down = width / small.imagewidth, height / small.imagelength
    # Thumbnails are rounded to whole pixels, and some fill a fixed frame.
    return bool(min(across, down) >= 2 and max(across, down) <= 2 * min(across, down))


def _check_kind(argument: str, page: Any, size: int) -> tuple[int, int]:
    """Return the photometric interpretation and its number of colors, refusing what cannot be decoded in bounds."""
    kind, bits = int(page.photometric), page.bitspersample
    if kind not in _COLORS or (kind == _YCBCR and int(page.compression) != _JPEG):
        name = getattr(page.photometric, "name", kind)
        raise refuse(argument, "must be gray, RGB, CMYK or of a palette if it is a TIFF", name)
    if kind in (_SEPARATED, _YCBCR, _PALETTE) and bits != 8 and not (kind == _PALETTE and bits in (1, 2, 4)):
        shown = f"{getattr(page.photometric, 'name', kind)} of {bits} bits"
        raise refuse(argument, "must be gray or RGB if it is a TIFF of 16 bits or more", shown)
    if not 1 <= page.samplesperpixel <= MOST_SAMPLES:
        rule = (
            f"must have at most {MOST_SAMPLES} samples a pixel (merge its layers, drop its further channels)"
        )
        raise refuse(argument, rule, f"a TIFF of {page.samplesperpixel}")
    if page.imagedepth != 1:
        raise refuse(argument, "must be flat", f"a TIFF of {page.imagedepth} slices")
    if page.dtype is None or np.dtype(page.dtype).kind not in "buf":
        raise refuse(argument, "must have unsigned or float samples if it is a TIFF", f"{page.dtype}")
    pixels = page.imagewidth * page.imagelength
    stored = sum(
        max(min(count, size - at), 0) for at, count in zip(page.dataoffsets, page.databytecounts, strict=True)
    )
    if int(page.compression) == _UNCOMPRESSED and 8 * stored < pixels * page.samplesperpixel * bits:
        raise refuse(
            argument, "must be a complete, undamaged picture", f"a TIFF with {stored} bytes of its pixels"
        )
    # A tile is made in its whole size before it is cut to the picture's.
    if math.prod(page.chunks) > 4 * pixels * page.samplesperpixel + 2**24:
        raise refuse(argument, "must be a complete, undamaged picture", f"a TIFF in tiles of {page.chunks}")
    return kind, _COLORS[kind]


def _read_samples(page: Any) -> NDArray[Any]:
    """Decode the samples, shape (H, W, samples); tifffile alone would fill in what a strip or tile lacks."""
    planes, _, height, width, within = page.shaped
    if page.is_contiguous:
        samples = page.asarray().reshape(planes, height, width, within)
    else:
        samples = np.empty((planes, height, width, within), page.dtype)
        found = 0
        for segment, (plane, _, row, column, _), shape in page.segments():
            rows, columns = min(shape[1], height - row), min(shape[2], width - column)
            if segment is None or segment.shape[1] < rows or segment.shape[2] < columns:
                raise ValueError("a strip or tile is incomplete")
            samples[plane, row : row + rows, column : column + columns] = segment[0, :rows, :columns]
            found += rows * columns
        if found < planes * height * width:
            raise ValueError("a strip or tile is missing")
    planes_last: NDArray[Any] = np.moveaxis(samples, 0, -2)
    return planes_last.reshape(height, width, planes * within)


def _alpha(page: Any, samples: NDArray[Any], colors: int) -> NDArray[Any]:
    """Return the samples of the opacity, shape (H, W, 0 or 1); extra samples that do not say what they are are opacity."""
    known = page.extrasamples and int(page.extrasamples[0]) == _NO_ALPHA
    return samples[..., colors:colors] if known else samples[..., colors : colors + 1]


def _looked_up(page: Any, index: NDArray[Any]) -> NDArray[np.uint8]:
    table = np.asarray(page.colormap)
    # Writers scale 8-bit entries to 16 by 256 or by 257; some do not scale them.
    table = (table if table.max() <= _BYTE else table >> 8).astype(np.uint8)
    colors: NDArray[np.uint8] = table.T[index]
    return colors


def _full_scale(samples: NDArray[Any], bits: int) -> NDArray[Any]:
    """Return integers as uint8 or uint16 that use their whole range, or as float."""
    if bits in (8, 16):
        return samples
    return np.asarray(samples / (2.0**bits - 1))


def _float_scale(argument: str, color: NDArray[Any]) -> float:
    """Return the float of white: 1, or 255 or 65535 if the samples are whole numbers up to that."""
    largest = float(np.nanmax(color, initial=0.0))
    if largest <= OVERSHOOT:
        return 1.0
    known = color[~np.isnan(color)]
    scale = _BYTE if largest <= _BYTE else _WORD
    if largest > scale or known.min() < 0 or (known != np.round(known)).any():
        advice = "divide them by 255" if 100 < largest <= 256 else "tone map them"
        rule = f"must have colors in [0, 1] if it is a float TIFF ({advice}, or export it as 16-bit PNG)"
        raise refuse(argument, rule, f"values up to {largest:.6g}")
    return scale


def _clipped(samples: NDArray[Any], scale: float) -> FloatArray:
    return np.clip(samples / np.float64(scale), 0.0, 1.0)


def _straight(color: NDArray[Any], alpha: NDArray[Any]) -> tuple[FloatArray, FloatArray]:
    """Divide colors by the opacity that they were multiplied with."""
    color, alpha = color / _top(color.dtype), alpha / _top(alpha.dtype)
    divided = np.divide(color, alpha, out=np.zeros_like(color), where=alpha > 0)
    return np.clip(divided, 0.0, 1.0), alpha


def _top(kind: np.dtype[Any]) -> Any:
    """Return the sample of white, or of full opacity."""
    return np.float64(1.0) if kind.kind in "fb" else kind.type(np.iinfo(kind).max)

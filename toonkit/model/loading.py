"""load_image: any picture of one drawing as a ToonImage, its mask taken from where the drawing says it is."""

from __future__ import annotations

import os

import numpy as np

from toonkit._validation import MIN_OBJECT_PIXELS, BoolArray, FloatArray, any_array, refuse, same_shape
from toonkit.model.background import cut_out
from toonkit.model.decoding import PictureSource, Pixels, read_pixels, unit_range
from toonkit.model.documents.opening import open_document
from toonkit.model.image import ToonImage

HALF_COVERED = 0.5
"""Opacity at which a pixel belongs to the object: the outline runs where it crosses one half."""


NEARLY_OPAQUE = 250 / 255
"""A picture of which no pixel is less opaque than this is opaque: no object ends in it."""

_ROUNDING = 1e-9


def load_image(source: PictureSource, *, mask: PictureSource | None = None) -> ToonImage:
    """
    Read a drawing and find its object.

    The object is where the picture is opaque. If it is opaque everywhere, `mask` says where the object is;
    without one, a plain background is found and cut away, anti-aliased outline included. A picture that is nearly
    opaque everywhere (alpha of at least 250 of 255) counts as opaque.

    Parameters
    ----------
    source : path, binary file object or array_like
        PNG, WebP, JPEG, TIFF, GIF or BMP of 8 or 16 bits a channel, brought to sRGB from the color space that it
        declares; the merged picture of a layered document, see `load_layers`; or an array of shape (H, W), (H, W, 2),
        (H, W, 3) or (H, W, 4), bool, uint8, uint16, or float in [0, 1]. Two and four channels end in alpha.
    mask : path, binary file object or array_like, optional
        Where the object is, shape (H, W): bool, uint8, uint16, or float in [0, 1]. A soft mask becomes the
        alpha of the picture; integers that are all 0 or 1 are read as such. Of a picture file, the alpha
        counts if it has any, else the brightness. It is multiplied with the picture's own alpha.

    Returns
    -------
    ToonImage
        Mask where alpha is at least one half; alpha and the colors of the outline are kept.

    Raises
    ------
    ToonkitError
        If a file is missing, damaged, too large or no picture; if the mask is of another size or leaves no
        object; if colors are NaN or outside [0, 1]; or if there is neither transparency, nor a mask, nor a
        plain background.

    Warns
    -----
    ToonkitWarning
        If the file declares a color space that cannot be applied, or leaves open what its floats mean.

    Examples
    --------
    >>> picture = np.ones((8, 8, 4))
    >>> picture[:, :4, 3] = 0
    >>> int(load_image(picture).mask.sum())
    32
    """
    document = open_document("source", source)
    return image_of(read_pixels("source", source) if document is None else document.read_merged(), mask)


def image_of(pixels: Pixels, mask: PictureSource | None) -> ToonImage:
    """Find the object in a decoded picture, as `load_image` says; its colors may be changed."""
    _remove_rounding(pixels.color)
    alpha = _opacity(pixels, mask)
    if alpha is None:
        _check_colors(pixels.color, np.ones(pixels.color.shape[:2], dtype=np.bool_))
        return cut_out(pixels.color)
    on_object = alpha >= HALF_COVERED
    _check_object(alpha, int(on_object.sum()), "source" if mask is None else "mask")
    _check_colors(pixels.color, alpha > 0)
    return ToonImage(pixels.color, on_object, alpha=alpha, fringe=pixels.color)


def _opacity(pixels: Pixels, mask: PictureSource | None) -> FloatArray | None:
    """Combine alpha and mask; None if neither says where the object is."""
    alpha = pixels.alpha
    if alpha is not None:
        _check_unit("source", "alpha", alpha)
        if (alpha >= NEARLY_OPAQUE).all():
            alpha = None
    if mask is None:
        return alpha
    coverage = read_coverage(mask)
    same_shape("mask", coverage.shape, pixels.color.shape[:2], "the picture")
    return coverage if alpha is None else coverage * alpha


def read_coverage(mask: PictureSource) -> FloatArray:
    """How much of each pixel a mask covers, shape (H, W)."""
    if isinstance(mask, str | os.PathLike) or hasattr(mask, "read"):
        pixels = read_pixels("mask", mask, colors=False)
        if pixels.alpha is not None and (pixels.alpha < NEARLY_OPAQUE).any():
            return pixels.alpha
        gray: FloatArray = pixels.color.mean(axis=-1)
        return gray
    array = any_array("mask", mask)
    if array.ndim == 3 and array.shape[-1] == 1:
        array = array[..., 0]
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise refuse("mask", "must be an array of shape (H, W)", f"shape {array.shape}, dtype {array.dtype}")
    only_zero_and_one = array.dtype.kind in "iu" and array.size > 0 and array.min() >= 0 and array.max() <= 1
    coverage = array.astype(np.float64) if only_zero_and_one else unit_range("mask", array)
    _check_unit("mask", "values", coverage)
    return coverage


def _remove_rounding(color: FloatArray) -> None:
    """Clip what leaves [0, 1] by no more than arithmetic rounds."""
    near = (color >= -_ROUNDING) & (color <= 1 + _ROUNDING)
    np.clip(color, 0.0, 1.0, out=color, where=near)


def _check_unit(argument: str, what: str, values: FloatArray) -> None:
    if np.isnan(values).any():
        raise refuse(argument, f"must have {what} without NaN", f"{int(np.isnan(values).sum())} NaN")
    if values.min(initial=0) < 0 or values.max(initial=0) > 1:
        shown = f"{values.min():.4g} to {values.max():.4g}"
        raise refuse(argument, f"must have {what} in [0, 1] (divide 8-bit values by 255)", shown)


def _check_colors(color: FloatArray, painted: BoolArray) -> None:
    """Refuse NaN and values off the scale where something is painted; elsewhere they mean nothing."""
    inside = color[painted]
    unknown = ~np.isfinite(inside).all(axis=-1)
    if unknown.any():
        raise refuse(
            "source", "must have finite colors wherever it is painted", f"{int(unknown.sum())} NaN pixels"
        )
    if inside.min() < 0 or inside.max() > 1:
        shown = f"{inside.min():.4g} to {inside.max():.4g}"
        raise refuse("source", "must be sRGB in [0, 1] (divide 8-bit values by 255)", shown)


def _check_object(alpha: FloatArray, count: int, argument: str) -> None:
    if alpha.max() == 0:
        raise refuse(
            argument,
            "must contain the object",
            "an empty mask" if argument == "mask" else "a transparent picture",
        )
    if count == 0:
        shown = f"an opacity of at most {alpha.max():.2g}"
        raise refuse(argument, "must contain an object that is at least half opaque", shown)
    if count < MIN_OBJECT_PIXELS:
        rule = f"must contain an object of at least {MIN_OBJECT_PIXELS} pixels to have a shape"
        raise refuse(argument, rule, f"{count} pixel{'s' if count > 1 else ''}")

"""How far an estimate is from the truth: always over the mask, so that padding a picture changes nothing (Section 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import (
    BoolArray,
    FloatArray,
    as_array,
    as_mask,
    of_type,
    refuse,
    same_mask,
    same_shape,
)
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.model.oklab import off_hue, srgb_to_oklab
from toonkit.numerics.masked_grid import rim_mask

UNCHANGED = 1e-9
"""Color RMSE up to which two pictures are the same but for rounding."""

ROUNDING = 1e-9
"""How far an illumination may leave [-1, 1] by rounding."""

LEAK_CHROMA = (0.05, 0.25)
"""How far shading may move a color off the ray of its chroma, in OKLab: so much, and so much of its chroma."""

LEAK_LIGHTER, LEAK_DARKER = 0.35, 0.4
"""How far shading may raise OKLab lightness, and the share of it that it leaves at least."""


@dataclass(frozen=True, eq=False)
class ErrorSummary:
    """
    A per-pixel error and its summary over the mask.

    Attributes
    ----------
    map : ndarray, shape (H, W)
        Error per pixel, NaN outside the mask.
    mean, median, percentile_95 : float
        Over the mask.
    mean_without_rim : float
        Over the mask without the one-pixel rim, where a pixel is half background; NaN if nothing else is left.
    """

    map: FloatArray
    mean: float
    median: float
    percentile_95: float
    mean_without_rim: float

    def __repr__(self) -> str:
        return (
            f"ErrorSummary(mean {self.mean:.3g}, median {self.median:.3g}, 95th percentile {self.percentile_95:.3g}, "
            f"mean without rim {self.mean_without_rim:.3g})"
        )


@dataclass(frozen=True)
class PictureError:
    """
    How far a picture is from another.

    Attributes
    ----------
    rmse, rmse_without_rim : float
        Root mean square difference over the mask, and over the mask without the one-pixel rim (NaN if nothing is left).
    """

    rmse: float
    rmse_without_rim: float


def angular_error(normals: NormalField, reference: NormalField) -> ErrorSummary:
    """
    Angle between two normal fields.

    Parameters
    ----------
    normals, reference : NormalField
        Fields over the same mask.

    Returns
    -------
    ErrorSummary
        Degrees.

    Raises
    ------
    ToonkitError
        If the masks differ.
    """
    for name, field in (("normals", normals), ("reference", reference)):
        of_type(name, field, NormalField)
    same_mask("reference", reference.mask, normals.mask, "the estimate")
    a, b = normals.vectors, reference.vectors
    # arctan2 of both products: exact near 0, where arccos is not.
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))
    return _summary(np.rad2deg(angle), reference.mask)


def illumination_error(illumination: ArrayLike, reference: ArrayLike, mask: ArrayLike) -> ErrorSummary:
    """
    Absolute difference of two illuminations.

    Parameters
    ----------
    illumination, reference : array_like, shape (H, W)
        L · N in [-1, 1] on the mask.
    mask : array_like, shape (H, W)
        True on the object.

    Returns
    -------
    ErrorSummary
        In units of illumination, 0 to 2.

    Raises
    ------
    ToonkitError
        If shapes differ, the mask is empty, or a value on it is NaN or outside [-1, 1].
    """
    on_object = as_mask("mask", mask)
    both = {"illumination": illumination, "reference": reference}
    ours, theirs = (as_array(name, value, (None, None)) for name, value in both.items())
    for name, value in (("illumination", ours), ("reference", theirs)):
        same_shape(name, value.shape, on_object.shape, "the mask")
        inside = value[on_object]
        if not np.isfinite(inside).all():
            raise refuse(name, "must be known on the object", "NaN or infinite values")
        if np.abs(inside).max() > 1 + ROUNDING:
            raise refuse(
                name, "must lie in [-1, 1] on the object", f"{inside.min():.4g} to {inside.max():.4g}"
            )
    difference = np.full(on_object.shape, np.nan)
    difference[on_object] = np.abs(ours[on_object] - theirs[on_object])
    return _summary(difference, on_object)


def picture_error(image: ToonImage, reference: ToonImage) -> PictureError:
    """
    Root mean square difference of two pictures, over the mask and the three channels.

    Parameters
    ----------
    image, reference : ToonImage
        Pictures over the same mask.

    Returns
    -------
    PictureError
        In sRGB, 0 to 1.

    Raises
    ------
    ToonkitError
        If the masks differ.
    """
    _same_object(image, reference)
    mask = image.mask
    squares = ((image.pixels - reference.pixels) ** 2).sum(axis=1) / 3
    core = squares[~rim_mask(mask)[mask]]
    return PictureError(
        rmse=float(np.sqrt(squares.mean())),
        rmse_without_rim=float(np.sqrt(core.mean())) if core.size else float("nan"),
    )


def color_rmse(image: ToonImage, reference: ToonImage) -> float:
    """
    Root mean square difference of two pictures: `picture_error` in one number.

    Parameters
    ----------
    image, reference : ToonImage
        Pictures over the same mask.

    Returns
    -------
    float
        In sRGB, 0 to 1.

    Raises
    ------
    ToonkitError
        If the masks differ.
    """
    return picture_error(image, reference).rmse


def color_difference(image: ToonImage, reference: ToonImage) -> ErrorSummary:
    """
    Difference of two pictures as seen: CIEDE2000.

    Parameters
    ----------
    image, reference : ToonImage
        Pictures over the same mask.

    Returns
    -------
    ErrorSummary
        In units of just noticeable differences (about 1), D65.

    Raises
    ------
    ToonkitError
        If the masks differ.
    """
    from skimage.color import deltaE_ciede2000, rgb2lab  # noqa: PLC0415 - a tenth of a second, which nothing else need wait

    _same_object(image, reference)
    mask = image.mask
    ours, theirs = (rgb2lab(picture.pixels[None])[0] for picture in (image, reference))
    difference = np.full(mask.shape, np.nan)
    difference[mask] = deltaE_ciede2000(ours, theirs)
    return _summary(difference, mask)


def relight_response(
    before: ToonImage, after: ToonImage, true_before: ToonImage, true_after: ToonImage
) -> float:
    """
    How much a picture changes under a new light, against how much the truth changes.

    Parameters
    ----------
    before, after : ToonImage
        Our picture under the original and the new light.
    true_before, true_after : ToonImage
        The true ones.

    Returns
    -------
    float
        Ratio of root mean square changes: 1 is right, 0 a picture that ignores the light (the paper's "dynamic
        illumination change", Section 4.3). NaN if the truth does not change.

    Raises
    ------
    ToonkitError
        If the masks differ.
    """
    pictures = {"before": before, "after": after, "true_before": true_before, "true_after": true_after}
    for name, picture in pictures.items():
        of_type(name, picture, ToonImage)
        same_mask(name, picture.mask, before.mask, "the estimate")
    truth = color_rmse(true_after, true_before)
    return color_rmse(after, before) / truth if truth > UNCHANGED else float("nan")


def leak(before: ToonImage, after: ToonImage) -> float:
    """
    Share of pixels whose color moves further than shading can move it: another material's color came in.

    Parameters
    ----------
    before, after : ToonImage
        The drawing, and the same relit.

    Returns
    -------
    float
        0 to 1, over the mask.

    Raises
    ------
    ToonkitError
        If the masks differ.

    Notes
    -----
    In OKLab, let a pixel go from lightness L, chroma vector (a, b) and chroma C to L', (a', b'). It leaks if (a', b') is
    farther than 0.05 + 0.25 C from the ray from gray through (a, b), or if L' > L + 0.35 or L' < 0.4 L.
    """
    old, new = _lab_on_object(before, after)
    chroma = np.linalg.norm(old[:, 1:], axis=1)
    base, share = LEAK_CHROMA
    leaks = off_hue(new, old) > base + share * chroma
    leaks |= (new[:, 0] > old[:, 0] + LEAK_LIGHTER) | (new[:, 0] < LEAK_DARKER * old[:, 0])
    return float(leaks.mean())


def response(before: ToonImage, after: ToonImage) -> float:
    """
    Mean absolute change of OKLab lightness: how much a new light does, when no truth is known.

    Parameters
    ----------
    before, after : ToonImage
        The drawing, and the same relit.

    Returns
    -------
    float
        0 to 1, over the mask.

    Raises
    ------
    ToonkitError
        If the masks differ.
    """
    old, new = _lab_on_object(before, after)
    return float(np.abs(new[:, 0] - old[:, 0]).mean())


def _lab_on_object(before: ToonImage, after: ToonImage) -> tuple[FloatArray, FloatArray]:
    for name, picture in (("before", before), ("after", after)):
        of_type(name, picture, ToonImage)
    same_mask("after", after.mask, before.mask, "the drawing")
    old, new = (srgb_to_oklab(picture.pixels) for picture in (before, after))
    return old, new


def _same_object(image: ToonImage, reference: ToonImage) -> None:
    for name, picture in (("image", image), ("reference", reference)):
        of_type(name, picture, ToonImage)
    same_mask("reference", reference.mask, image.mask, "the estimate")


def _summary(error: FloatArray, mask: BoolArray) -> ErrorSummary:
    inside = error[mask]
    core = inside[~rim_mask(mask)[mask]]
    return ErrorSummary(
        map=error,
        mean=float(inside.mean()),
        median=float(np.median(inside)),
        percentile_95=float(np.percentile(inside, 95)),
        mean_without_rim=float(core.mean()) if core.size else float("nan"),
    )

"""The linked pictures of an analysis as arrays, reduced to the size of the screen, and readings of single pixels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from skimage.measure import find_contours

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.model.image import ToonImage
from toonkit.model.label_colors import label_picture
from toonkit.model.luminance import hex_color
from toonkit.model.normals import NormalField, encode_normal_map
from toonkit.model.shading import illumination

GROUND = (123, 124, 129)
"""Color (sRGB, 8-bit) around the object, on which both dark and bright paint can be seen."""

SHADED = np.array([(16, 20, 40), (86, 96, 140), (255, 244, 205)])
"""Colors of illumination -1, 0 and 1: none of them is that of the ground."""

LEVELS = np.arange(-3, 4) / 4
"""Illuminations at which isophotes are drawn."""

Pixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Picture:
    """
    One of the linked pictures.

    Attributes
    ----------
    title : str
        What it shows.
    pixels : ndarray of uint8, shape (H, W, 3)
        The picture, opaque.
    illumination : ndarray of float32, shape (H, W), optional
        L · N, -1 to 1, from which isophotes are drawn; NaN outside the object. None if the picture has none.
    """

    title: str
    pixels: Pixels
    illumination: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class Window:
    """
    A part of a picture as it is sent.

    Attributes
    ----------
    top, bottom, left, right : int
        Its rows are `top` to `bottom - 1`, its columns `left` to `right - 1`.
    step : float
        Pixels of the picture for each pixel that is sent, at least 1.
    """

    top: int
    bottom: int
    left: int
    right: int
    step: float

    @classmethod
    def around(
        cls, columns: tuple[float, float], rows: tuple[float, float], shape: tuple[int, ...], sent: float
    ) -> Window:
        """
        Return the visible part of a picture; it is never empty.

        Parameters
        ----------
        columns, rows : tuple of float
            First and last position of the view, in pixels; it may extend beyond the picture.
        shape : tuple of int
            Height and width of the picture.
        sent : float
            Pixels to send for the whole width of the view.
        """
        top, left = (
            int(np.clip(pair[0], 0, size - 1)) for pair, size in ((rows, shape[0]), (columns, shape[1]))
        )
        bottom, right = (
            int(np.clip(np.ceil(pair[1]), first + 1, size))
            for pair, first, size in ((rows, top, shape[0]), (columns, left, shape[1]))
        )
        return cls(top, bottom, left, right, max((columns[1] - columns[0]) / sent, 1.0))


def pictures_of_drawing(analysis: ToonAnalysis) -> dict[str, Picture]:
    """Return the pictures that all methods share: the drawing, its regions, and the illumination of the initial normals."""
    return {
        "drawing": Picture("Drawing", _opaque(analysis.image.to_rgba())),
        "regions": Picture("Regions", _opaque(label_picture(analysis.materials.labels))),
        "initial": _isophotes("Illumination before refinement", analysis.initial_normals, analysis.light),
    }


def pictures_of_method(analysis: ToonAnalysis, name: str = "") -> dict[str, Picture]:
    """Return the pictures of what a method has found; if a name is given, their titles contain it."""
    words = f" · {name}" if name else ""
    normals = analysis.normals
    coverage = np.where(normals.mask, 255, 0).astype(np.uint8)
    return {
        "base": Picture(f"Base color{words}", _opaque(analysis.base_color.to_rgba())),
        "normals": Picture(f"Normal map{words}", _opaque(np.dstack([encode_normal_map(normals), coverage]))),
        "refined": _isophotes(f"Illumination after refinement{words}", normals, analysis.light),
    }


def relit_picture(relit: ToonImage, name: str = "") -> Picture:
    """Return a relit picture; if the name of its method is given, the title contains it."""
    return Picture(f"Relit · {name}" if name else "Relit", _opaque(relit.to_rgba()))


def reduced(pixels: Pixels, window: Window) -> Pixels:
    """Return a part of a picture (H, W, 3), averaged over the pixels that share one pixel of the screen."""
    part = pixels[window.top : window.bottom, window.left : window.right]
    if window.step == 1:
        return part
    size = [max(round(side / window.step), 1) for side in (part.shape[1], part.shape[0])]
    return np.asarray(Image.fromarray(part).resize((size[0], size[1]), Image.Resampling.BOX))


def isophotes(illumination: NDArray[np.floating], window: Window) -> FloatArray:
    """
    Return the curves of equal illumination in a part of a picture, at each of the `LEVELS`.

    Parameters
    ----------
    illumination : ndarray, shape (H, W)
        L · N, NaN outside the object.
    window : Window
        The part.

    Returns
    -------
    ndarray, shape (n, 2)
        Columns and rows in pixels, 0.5 in the middle of the first one; a row of NaN after each curve.
    """
    skipped = round(window.step)
    field = illumination[window.top : window.bottom : skipped, window.left : window.right : skipped]
    curves = [np.empty((0, 2))]
    if min(field.shape) > 1:  # a row alone has no curves
        for level in LEVELS:
            for curve in find_contours(field, level):
                places = curve[:, ::-1] * skipped + (window.left + 0.5 * skipped, window.top + 0.5 * skipped)
                curves += [places, np.full((1, 2), np.nan)]
    return np.concatenate(curves)


@dataclass(frozen=True)
class PixelReading:
    """
    What is known of a pixel of the object.

    Attributes
    ----------
    paint : str
        Its color as drawn, as "#rrggbb".
    material : str
        Its material, such as "2 of 5".
    normals : mapping of str to (float, float, float)
        Its unit normal by the name of each method.
    illuminations : mapping of str to (float, float)
        L · N by the name of each method, under the light of the analysis and under the new light.
    """

    paint: str
    material: str
    normals: Mapping[str, tuple[float, float, float]]
    illuminations: Mapping[str, tuple[float, float]]


def read_pixel(
    analyses: Mapping[str, ToonAnalysis], row: int, column: int, new_light: ArrayLike
) -> PixelReading | None:
    """
    Read a pixel of a drawing.

    Parameters
    ----------
    analyses : mapping of str to ToonAnalysis
        Analyses of the drawing by the name of their method; the paint and the materials are those of the first one.
    row, column : int
        The pixel, which must lie within the picture.
    new_light : array_like, shape (3,)
        Unit vector to the new light.

    Returns
    -------
    PixelReading or None
        None outside the object.
    """
    analysis = next(iter(analyses.values()))
    label = int(analysis.materials.labels[row, column])
    if label < 0:
        return None
    normals = {name: found.normals.vectors[row, column] for name, found in analyses.items()}
    return PixelReading(
        paint=hex_color(analysis.image.color[row, column]),
        material=f"{label + 1} of {analysis.materials.count}",
        normals={name: (float(x), float(y), float(z)) for name, (x, y, z) in normals.items()},
        illuminations={
            name: (float(normal @ analyses[name].light), float(normal @ np.asarray(new_light)))
            for name, normal in normals.items()
        },
    )


def _isophotes(title: str, normals: NormalField, light: FloatArray) -> Picture:
    """Return a picture of L · N in `SHADED` colors, with the illumination from which its isophotes are drawn."""
    value = illumination(normals, light)
    seen = np.zeros((*value.shape, 4), np.uint8)
    seen[normals.mask, 3] = 255
    for channel in range(3):
        shade = np.interp(value[normals.mask], (-1, 0, 1), SHADED[:, channel])
        seen[normals.mask, channel] = shade.round().astype(np.uint8)
    return Picture(title, _opaque(seen), value.astype(np.float32))


def _opaque(rgba: Pixels) -> Pixels:
    """Return a picture (H, W, 4) composited on `GROUND`: a sharp picture must cover the coarser one below it."""
    alpha = rgba[..., 3:].astype(np.uint16)
    mixed = rgba[..., :3] * alpha + np.array(GROUND, np.uint16) * (255 - alpha)
    return ((mixed + 127) // 255).astype(np.uint8)

"""What a graphics card needs of an analysis: color, line art, normals and color map as texture bytes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.preparation import PreparedDrawing
from toonkit.model.color_map import ColorMap
from toonkit.model.image import nearest_object_pixel
from toonkit.model.light import light_angles
from toonkit.model.normals import NormalField

LONGEST_MAP = 1024
"""Samples of the largest color map sent: longer ones are resampled, since a texture's width is limited."""

FARTHEST = 2048
"""Pixels up to which a half float counts exactly: no fringe is that wide."""


@dataclass(frozen=True, eq=False)
class RelightTextures:
    """
    One analysis as the bytes of four textures, row 0 at the top.

    Attributes
    ----------
    width, height : int
        Size in pixels.
    color : bytes
        RGBA8, straight alpha: the picture as painted.
    paint : bytes
        RGBA8: what lies beneath its line art, and in alpha how much of that shows; empty for a picture without.
    normals : bytes
        RG16F: the equal-area projection (nx, ny) / sqrt(2 (1 + nz)). Unlike (nx, ny) itself it loses no
        precision at the rim, where nz = sqrt(1 - nx² - ny²) amplifies rounding. Outside the mask it holds
        the way (columns, rows), in pixels, to the nearest object pixel, which is longer than any projection.
    color_map : bytes
        RGBA32F, one row: the samples of M.
    domain : (float, float)
        Illumination of the first and last sample.
    analyzed_light : (float, float)
        Azimuth and elevation, in degrees, of the light the picture was analyzed under.
    """

    width: int
    height: int
    color: bytes
    paint: bytes
    normals: bytes
    color_map: bytes
    domain: tuple[float, float]
    analyzed_light: tuple[float, float]


def encode_textures(analysis: ToonAnalysis) -> RelightTextures:
    """
    Encode an analysis for the relight view's shader.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.

    Returns
    -------
    RelightTextures
        Its picture, refined normals and color map.
    """
    height, width = analysis.image.shape
    color = analysis.image.to_rgba()
    return RelightTextures(
        width=width,
        height=height,
        color=color.tobytes(),
        paint=_paint_beneath(analysis.drawing, color),
        normals=_project(analysis.normals).astype("<f2").tobytes(),
        color_map=_map_samples(analysis.materials.color_maps[0]).astype("<f4").tobytes(),
        domain=analysis.materials.color_maps[0].domain,
        analyzed_light=light_angles(analysis.light),
    )


def _paint_beneath(drawing: PreparedDrawing, color: NDArray[np.uint8]) -> bytes:
    """Encode a picture's colors (H, W, 4) without its line art."""
    mixed = drawing.mixed
    if mixed.pixels.size == 0:
        return b""
    paint = color.copy()
    paint[..., 3] = 255
    beneath = np.column_stack([drawing.paint[mixed.sources[:, 0]], mixed.shares.sum(axis=1)])
    paint[drawing.places(mixed.pixels)] = np.round(beneath * 255)
    return paint.tobytes()


def _project(normals: NormalField) -> FloatArray:
    """Equal-area projection on the object, the way to the nearest object pixel elsewhere, shape (H, W, 2)."""
    rows, columns = nearest_object_pixel(normals.mask)
    here = np.indices(normals.shape)
    way = np.stack([columns - here[1], rows - here[0]], axis=-1)
    vectors = np.where(normals.mask[..., None], normals.vectors, 0.0)
    projected = vectors[..., :2] / np.sqrt(2 * (1 + vectors[..., 2:]))
    encoded: FloatArray = np.where(normals.mask[..., None], projected, np.clip(way, -FARTHEST, FARTHEST))
    return encoded


def _map_samples(color_map: ColorMap) -> FloatArray:
    """Return RGBA samples, shape (K, 4); the shader is linear between them, as ColorMap is."""
    if len(color_map.colors) > LONGEST_MAP:
        color_map = color_map.resampled(LONGEST_MAP)
    return np.concatenate([color_map.colors, np.ones((len(color_map.colors), 1))], axis=1)

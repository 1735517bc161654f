"""What a graphics card needs of an analysis: color, normals, materials and their color maps as texture bytes."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.illustration.light_color import LightColor
from toonkit.illustration.mixed_pixels import MixedPixels
from toonkit.model.color_map import ColorMap
from toonkit.model.image import eight_bit, nearest_object_pixel
from toonkit.model.light import light_angles
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.model.tone_ramp import SAMPLES
from toonkit.relighting import DETAIL_RANGE, DETAIL_SIZE, FULL_TURN, HIGHLIGHT_RANGE, Paint

LONGEST_MAP = 1024
"""Samples of the largest color map sent: longer ones are resampled, since a texture's width is limited."""

FARTHEST = 2048
"""Pixels up to which a half float counts exactly: no fringe is that wide."""

HIGHLIT = 0xFFFF
"""Second material of a mixture that is a highlight over the first."""

MIXED = 1 << 31
"""Bit of a pixel's part that tells a mixed pixel from one of a single material."""

MIXTURES_WIDE = 1024
"""Mixed pixels in each row of their texture."""

Words = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class RelightTextures:
    """
    One analysis as the bytes of seven textures, row 0 at the top.

    Attributes
    ----------
    width, height : int
        Size in pixels.
    color : bytes
        RGBA8, straight alpha: the picture as painted.
    normals : bytes
        RG16F: the equal-area projection (nx, ny) / sqrt(2 (1 + nz)). Unlike (nx, ny) itself it loses no
        precision at the rim, where nz = sqrt(1 - nx² - ny²) amplifies rounding. Outside the mask it holds
        the way (columns, rows), in pixels, to the nearest object pixel, which is longer than any projection.
        RG32F for pixel art, where a normal that is rounded may give its pixel another color.
    parts : bytes
        R32UI: the number of each pixel's material, or `MIXED` plus the number of its mixture. Empty where all pixels are
        material 0 and none is mixed.
    mixtures : bytes
        RGBA32UI, `MIXTURES_WIDE` to a row: the two pixels that a mixed one shows, as column + 2¹⁶ row each, then their
        materials and their shares in units of 1 / 65535, both as first + 2¹⁶ second; `HIGHLIT` for the second material
        marks a highlight. Empty where there are none.
    color_maps : bytes
        RGBA32F, one row for each material: the samples of its M, followed by zeros.
    materials : bytes
        RGBA32F, one row for each material: the illumination of the first and last sample of M, the number of the last
        sample, and 1 if it is flat, else 0; then its color as a whole, and the number of colors in its ramp.
    ramps : bytes
        RGBA32F, one row for each material: its shadow and its lit tone in linear light, and the colors of its ramp, if
        there is a palette, followed by zeros.
    analyzed_light : (float, float)
        Azimuth and elevation, in degrees, of the light the picture was analyzed under.
    """

    width: int
    height: int
    color: bytes
    normals: bytes
    parts: bytes
    mixtures: bytes
    color_maps: bytes
    materials: bytes
    ramps: bytes
    analyzed_light: tuple[float, float]


def encode_textures(analysis: ToonAnalysis, *, keep_detail: bool = True) -> RelightTextures:
    """
    Encode an analysis for the relight view's shader.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    keep_detail : bool, optional
        As in `relight`. It matters for pixel art alone, which has no palette without it.

    Returns
    -------
    RelightTextures
        Its picture, refined normals, materials and the color maps that it is drawn with.
    """
    analysis = as_drawn(analysis)
    height, width = analysis.image.shape
    paint = Paint.of(analysis, None, keep_detail=keep_detail)
    maps = [_sent(color_map) for color_map in paint.materials.color_maps]
    parts, mixtures = _parts(analysis, paint.mixed)
    ramps = _ramps(paint)
    glow = LightColor.of(np.ones(3), 0.0, analysis.materials.color_maps)
    return RelightTextures(
        width=width,
        height=height,
        color=analysis.image.to_rgba().tobytes(),
        normals=_project(analysis.normals)
        .astype("<f4" if analysis.drawing.is_pixel_art else "<f2")
        .tobytes(),
        parts=parts.astype("<u4").tobytes(),
        mixtures=mixtures.astype("<u4").tobytes(),
        color_maps=_stack([color_map.colors for color_map in maps]).astype("<f4").tobytes(),
        materials=_describe(paint.materials, maps, ramps).astype("<f4").tobytes(),
        ramps=_stack(
            [
                np.concatenate([*ends, ramp])
                for *ends, ramp in zip(glow.shadows[:, None], glow.lit_tones[:, None], ramps, strict=True)
            ]
        )
        .astype("<f4")
        .tobytes(),
        analyzed_light=light_angles(analysis.light),
    )


def encode_recolored(analysis: ToonAnalysis) -> bytes:
    """
    Encode the color maps of materials that have others than they are drawn with.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.

    Returns
    -------
    bytes
        RGBA32F, one row for each material: whether it is recolored and, if so, whether it stays as drawn; its color as a
        whole; then samples of its map over all illuminations. Empty if no material is recolored.
    """
    drawn, materials = analysis.drawn_materials, analysis.materials
    if drawn is None:
        return b""
    rows = np.zeros((materials.count, SAMPLES + 2, 4))
    for row, color_map in zip(rows, materials.color_maps, strict=True):
        row[2:, :3] = color_map(np.linspace(-1.0, 1.0, SAMPLES))
    rows[:, 0, 0] = analysis.is_recolored
    rows[:, 0, 1] = [
        flat and len(color_map.colors) == 1
        for flat, color_map in zip(materials.flat, materials.color_maps, strict=True)
    ]
    rows[:, 1, :3] = materials.base_tones
    return rows.astype("<f4").tobytes()


def as_drawn(analysis: ToonAnalysis) -> ToonAnalysis:
    """Return an analysis with the color maps that the picture is drawn with."""
    return analysis if analysis.drawn_materials is None else analysis.recolored({})


def _parts(analysis: ToonAnalysis, mixed: MixedPixels) -> tuple[Words, Words]:
    """Return the part (H, W) that each pixel has, and the mixtures (rows, MIXTURES_WIDE, 4)."""
    labels, drawing = analysis.materials.labels, analysis.drawing
    count = mixed.pixels.size
    if analysis.materials.count == 1 and count == 0:
        return np.zeros(0, np.uint32), np.zeros(0, np.uint32)
    parts = np.maximum(labels, 0).astype(np.uint32)
    parts[drawing.places(mixed.pixels)] = MIXED + np.arange(count, dtype=np.uint32)
    mixtures = np.zeros((-(-count // MIXTURES_WIDE) * MIXTURES_WIDE, 4), np.uint32)
    rows, columns = drawing.places(mixed.sources)
    mixtures[:count, :2] = columns + (rows << 16)
    materials = labels[rows, columns].astype(np.intp)
    materials[mixed.highlit, 1] = HIGHLIT
    mixtures[:count, 2] = _pairs(materials)
    mixtures[:count, 3] = _pairs(np.round(np.clip(mixed.shares, 0.0, 1.0) * 65535).astype(np.intp))
    return parts, mixtures


def _pairs(numbers: NDArray[np.intp]) -> NDArray[np.intp]:
    """Put two numbers of 16 bits (n, 2) into one."""
    return numbers[:, 0] + (numbers[:, 1] << 16)


def _sent(color_map: ColorMap) -> ColorMap:
    return color_map.resampled(LONGEST_MAP) if len(color_map.colors) > LONGEST_MAP else color_map


def _ramps(paint: Paint) -> list[FloatArray]:
    """Return the palette's ramps in 8 bits, as the colors are that the shader compares with them."""
    if paint.palette is None:
        return [np.zeros((0, 3))] * paint.materials.count
    return [eight_bit(ramp) / 255 for ramp in paint.palette.ramps]


def _stack(rows: list[FloatArray]) -> FloatArray:
    """Return colors (k, 3) of each material as RGBA, shape (count, K, 4)."""
    samples = np.zeros((len(rows), max(len(colors) for colors in rows), 4))
    for row, colors in zip(samples, rows, strict=True):
        row[: len(colors), :3] = colors
    return samples


def _describe(materials: Materials, maps: list[ColorMap], ramps: list[FloatArray]) -> FloatArray:
    """Return what the shader needs to know of each material, shape (count, 2, 4)."""
    about = np.zeros((materials.count, 2, 4))
    about[:, 0, :2] = [color_map.domain for color_map in maps]
    about[:, 0, 2] = [len(color_map.colors) - 1 for color_map in maps]
    about[:, 0, 3] = materials.flat
    about[:, 1, :3] = materials.base_tones
    about[:, 1, 3] = [len(ramp) for ramp in ramps]
    return about


def _project(normals: NormalField) -> FloatArray:
    """Equal-area projection on the object, the way to the nearest object pixel elsewhere, shape (H, W, 2)."""
    rows, columns = nearest_object_pixel(normals.mask)
    here = np.indices(normals.shape)
    way = np.stack([columns - here[1], rows - here[0]], axis=-1)
    vectors = np.where(normals.mask[..., None], normals.vectors, 0.0)
    projected = vectors[..., :2] / np.sqrt(2 * (1 + vectors[..., 2:]))
    encoded: FloatArray = np.where(normals.mask[..., None], projected, np.clip(way, -FARTHEST, FARTHEST))
    return encoded


def describe_picture(analysis: ToonAnalysis, *, keep_detail: bool = True) -> dict[str, Any]:
    """
    Describe an analysis as the relight views take it.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    keep_detail : bool, optional
        As in `encode_textures`.

    Returns
    -------
    dict
        Values by the names that both views have for them.
    """
    described = asdict(encode_textures(analysis, keep_detail=keep_detail))
    size = [described.pop("width"), described.pop("height")]
    return {
        **described,
        "analyzed_light": list(described["analyzed_light"]),
        "picture_size": size,
        "detail_range": DETAIL_RANGE,
        "detail_size": DETAIL_SIZE,
        "highlight_range": HIGHLIGHT_RANGE,
        "full_turn": FULL_TURN,
    }

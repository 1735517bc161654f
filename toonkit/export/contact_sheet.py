"""contact_sheet: one picture that shows an analysis at a glance: a drawing, the parts of its model, and relit pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont

from toonkit._validation import FloatArray, as_light, of_type, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.export.thumbnail import Thumbnail
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage, eight_bit
from toonkit.model.label_colors import label_picture
from toonkit.model.light import light_angles, light_direction
from toonkit.model.whole_pixels import opaque, put_pixels
from toonkit.relighting import relight_pixels

STANDARD_LIGHTS: tuple[tuple[float, float], ...] = (
    (180, 15),
    (135, 40),
    (45, 40),
    (0, 15),
    (225, 25),
    (270, 25),
    (315, 25),
    (0, 90),
)
"""Azimuth and elevation, in degrees, of the lights shown by default: over the top, then below, then frontal."""

MATTE = ColorMap(np.linspace(0.25, 0.95, 64)[:, None].repeat(3, axis=1), (-0.3, 1.0))
"""Color map of the balls that show a light where many materials have one each."""

_TILE = 264  # pixels, as all below
_PADDING = 14
_GAP = 18
_MARGIN = 28
_CAPTION = 34
_BALL_RADIUS = 21
_LARGE_BALL_RADIUS = 96
_CORNER = 10
_CHECK = 11
_FINER = 4  # supersampling of balls and rounded corners
_COLUMNS = 4

_SHEET = (232, 230, 225)
_CARD = (252, 252, 250)
_CHECKED = (244, 243, 240)
_BORDER = (208, 205, 198)
_INK = (58, 56, 52)
_FAINT_INK = (128, 124, 116)


@dataclass(frozen=True, eq=False)
class _Tile:
    """A picture (RGBA), its caption in two weights, and the light to show beside it."""

    picture: Image.Image
    title: str
    detail: str
    light: FloatArray | None


def contact_sheet(
    analysis: ToonAnalysis,
    lights: Sequence[ArrayLike] | None = None,
    *,
    keep_detail: bool = True,
    base_color: ToonImage | None = None,
) -> NDArray[np.uint8]:
    """
    Lay out a drawing, what it was taken apart into, and relit pictures on one sheet.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    lights : sequence of array_like, shape (3,), optional
        Lights to relight with; `STANDARD_LIGHTS` by default.
    keep_detail : bool, optional
        As in `relight`.
    base_color : ToonImage, optional
        `analysis.base_color`, if it is at hand.

    Returns
    -------
    ndarray, shape (H, W, 3)
        uint8 sRGB. The first row has the input, its materials or, where there is one, its color map on a ball, its base
        color and its normals. Each relit picture carries a ball under its light, painted with the only color map, or gray.

    Raises
    ------
    ToonkitError
        If the analysis is none, there is no light, or one is zero, not finite or from behind.
    """
    of_type("analysis", analysis, ToonAnalysis)
    if lights is not None and not isinstance(lights, Iterable):
        raise refuse("lights", "must be a sequence of lights", type(lights).__name__)
    directions = [light_direction(*angles) for angles in STANDARD_LIGHTS] if lights is None else list(lights)
    if not directions:
        raise refuse("lights", "must hold at least one light", "none")
    checked = [as_light("lights", light) for light in directions]
    several = analysis.materials.count > 1
    small = Thumbnail.of(analysis, _TILE - 2 * _PADDING)
    base_colors = analysis.base_colors() if base_color is None else base_color.pixels
    base = small.picture(base_colors[small.pixels], keep_detail=False)
    tiles = [
        _input_tile(analysis, small),
        _materials_tile(analysis, small) if several else _color_map_tile(analysis),
        _Tile(base, "base color", "without shading", None),
        _normal_tile(analysis, small),
    ]
    relit_colors = relight_pixels(analysis, checked, small.pixels, keep_detail=keep_detail)
    for light, relit in zip(checked, relit_colors, strict=True):
        picture = small.picture(relit, keep_detail=keep_detail)
        tiles.append(_Tile(picture, "relit", _angles(light), light))
    return _sheet(tiles, MATTE if several else analysis.color_map)


def _input_tile(analysis: ToonAnalysis, small: Thumbnail) -> _Tile:
    picture = small.picture(analysis.image.pixels[small.pixels])
    return _Tile(picture, "input", _angles(analysis.light), np.asarray(analysis.light))


def _materials_tile(analysis: ToonAnalysis, small: Thumbnail) -> _Tile:
    count, flat = analysis.materials.count, int(analysis.materials.flat.sum())
    labels = analysis.materials.labels[analysis.drawing.places(small.object_pixels)]
    colors = label_picture(labels[None])[0, :, :3]
    return _Tile(small.of_object(colors), "materials", f"{count}, {flat or 'none'} flat", None)


def _color_map_tile(analysis: ToonAnalysis) -> _Tile:
    ball = _ball(tuple(analysis.light), analysis.color_map, _LARGE_BALL_RADIUS)
    return _Tile(ball, "color map", "on a ball", None)


def _normal_tile(analysis: ToonAnalysis, small: Thumbnail) -> _Tile:
    colors = eight_bit((analysis.normals.compact[small.object_pixels] + 1) / 2)
    return _Tile(small.of_object(colors), "normals", f"method {analysis.method}", None)


def _angles(light: FloatArray) -> str:
    azimuth, elevation = light_angles(light)
    if round(elevation) == 90:
        return "from the front"
    return f"azimuth {round(azimuth) % 360}°, elevation {round(elevation)}°"


def _sheet(tiles: list[_Tile], color_map: ColorMap) -> NDArray[np.uint8]:
    rows = -(-len(tiles) // _COLUMNS)
    width = 2 * _MARGIN + _COLUMNS * _TILE + (_COLUMNS - 1) * _GAP
    height = 2 * _MARGIN - _GAP + rows * (_TILE + _CAPTION + _GAP) - _CAPTION // 4  # captions end above that
    sheet = Image.new("RGB", (width, height), _SHEET)
    card, corners, outline = _card(), _rounded(outline=False), _rounded(outline=True)
    for index, tile in enumerate(tiles):
        row, column = divmod(index, _COLUMNS)
        left, top = _MARGIN + column * (_TILE + _GAP), _MARGIN + row * (_TILE + _CAPTION + _GAP)
        sheet.paste(card, (left, top), corners)
        x, y = left + (_TILE - tile.picture.width) // 2, top + (_TILE - tile.picture.height) // 2
        sheet.paste(tile.picture, (x, y), tile.picture)
        if tile.light is not None:
            ball = _ball(tuple(tile.light), color_map, _BALL_RADIUS)
            sheet.paste(ball, (left + _TILE - ball.width - 6, top + 6), ball)
        sheet.paste(_BORDER, (left, top, left + _TILE, top + _TILE), outline)
        _caption(sheet, tile, left, top + _TILE + 7)
    return np.asarray(sheet).copy()


def _caption(sheet: Image.Image, tile: _Tile, left: int, top: int) -> None:
    draw = ImageDraw.Draw(sheet)
    strong, small = _font(15), _font(13)
    draw.text((left + 3, top), tile.title, fill=_INK, font=strong)
    across = draw.textlength(tile.detail, font=small)
    draw.text((left + _TILE - 3 - across, top + 1), tile.detail, fill=_FAINT_INK, font=small)


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size=size)


@cache
def _card() -> Image.Image:
    """Draw the checkered ground that says: transparent."""
    row, column = np.indices((_TILE, _TILE)) // _CHECK
    dark = (row + column) % 2 == 1
    return Image.fromarray(np.where(dark[..., None], _CHECKED, _CARD).astype(np.uint8))


@cache
def _rounded(*, outline: bool) -> Image.Image:
    """Draw the coverage of a card with rounded corners, or of its border."""
    side = _TILE * _FINER
    fine = Image.new("L", (side, side), 0)
    box, radius = (0, 0, side - 1, side - 1), _CORNER * _FINER
    draw = ImageDraw.Draw(fine)
    if outline:
        draw.rounded_rectangle(box, radius, outline=255, width=_FINER)
    else:
        draw.rounded_rectangle(box, radius, fill=255)
    return fine.resize((_TILE, _TILE), Image.Resampling.BOX)


@lru_cache(maxsize=64)  # sheets of one batch have most of them in common
def _ball(light: tuple[float, ...], color_map: ColorMap, radius: int) -> Image.Image:
    """Draw a ball painted with a color map, and a dot where the light stands above it."""
    side = (2 * radius + 8) * _FINER
    center, radius = (side - 1) / 2, radius * _FINER
    along = (np.arange(side) - center) / radius
    squared = along**2 + along[:, None] ** 2
    beyond = (np.sqrt(squared) - 1) * radius / _FINER  # pixels outside the ball
    inside = beyond <= -1.2
    row, column = np.nonzero(inside)
    x, y, z = along[column], -along[row], np.sqrt(1 - squared[inside])  # row 0 is the top, y points up
    rgba = np.full((side, side, 4), (*_CARD, 0), np.uint8)
    rgba[beyond < 3.2, 3] = 255  # a halo sets it off from the picture below
    put_pixels(rgba, np.abs(beyond) < 1.2, np.array((*_INK, 255)))
    lit = color_map(np.clip(x * light[0] + y * light[1] + z * light[2], -1, 1))
    put_pixels(rgba, inside, opaque(eight_bit(lit)))
    fine = Image.fromarray(rgba)
    draw = ImageDraw.Draw(fine)
    spot = (center + light[0] * radius, center - light[1] * radius)
    draw.circle(spot, 3.6 * _FINER, fill=(255, 214, 64, 255), outline=(*_INK, 255), width=_FINER)
    return fine.resize((side // _FINER, side // _FINER), Image.Resampling.BOX)

"""A relit picture as layers: base color, shadow, light, highlight and ink, as painting programs compose them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.model.light import direction_of
from toonkit.relighting import RelightOptions, highlights_left, relight

Blend = Literal["normal", "multiply", "add"]
"""How a layer is composed with what is below it."""

STEP = 1 / 255
"""A step of an 8-bit picture."""

OPAQUE = 255

Pixels = NDArray[np.uint8]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class LayerKind:
    """
    What is the same for one layer of every picture.

    Attributes
    ----------
    name : str
        Its name in a painting program.
    group : str
        The group that it belongs to there.
    blend : {"normal", "multiply", "add"}
        How it is composed with what is below it, on sRGB values.
    """

    name: str
    group: str
    blend: Blend


KINDS = {
    "base_color": LayerKind("Base color", "Color", "normal"),
    "shadow": LayerKind("Shadow", "Light", "multiply"),
    "light": LayerKind("Light", "Light", "add"),
    "highlight": LayerKind("Highlight", "Light", "add"),
    "ink": LayerKind("Ink", "Ink", "normal"),
}
"""The layers from the bottom to the top, by the attributes of `Layers`."""


@dataclass(frozen=True, eq=False)
class Layers:
    """
    A relit picture taken apart: each layer is 8-bit sRGB with straight alpha, shape (H, W, 4).

    Where a layer does nothing its alpha is 0 and its color neutral, for engines that ignore alpha in some blend modes: white
    in the shadow, black in light and highlight.

    Attributes
    ----------
    base_color : ndarray of uint8
        The paint without shading and ink, with the alpha of the picture, but for soft outlines in ink.
    shadow : ndarray of uint8
        What the paint is multiplied by where the light leaves it darker; opaque there.
    light : ndarray of uint8
        What is added where the light makes the paint brighter; opaque there.
    highlight : ndarray of uint8
        What is added where the drawing has highlights; opaque there.
    ink : ndarray of uint8
        The line art; its alpha says how much of a pixel it covers.
    picture : ndarray of uint8
        The relit picture itself.
    """

    base_color: Pixels
    shadow: Pixels
    light: Pixels
    highlight: Pixels
    ink: Pixels
    picture: Pixels

    def __iter__(self) -> Iterator[tuple[str, LayerKind, Pixels]]:
        """Yield of each layer, from the bottom to the top, its key, its kind and its pixels."""
        for key, kind in KINDS.items():
            yield key, kind, getattr(self, key)

    def compose(self) -> Pixels:
        """
        Compose the layers.

        Returns
        -------
        ndarray of uint8, shape (H, W, 4)
            Within one step, 1/255, of `picture`.

        Notes
        -----
        A layer of color c and alpha a over what is there, of color b and alpha β, gives

            α = a + β - aβ,    α c' = a (1 - β) c + a β B(b, c) + (1 - a) β b,

        with B(b, c) = c for "normal", bc for "multiply" and min(1, b + c) for "add" (W3C Compositing and Blending, section
        5.8.1). Shadow, light and highlight are empty where the base color is not opaque, so that programs with other rules
        for coverage give the same picture.
        """
        height, width = self.picture.shape[:2]
        below, under = np.zeros((height, width, 3)), np.zeros((height, width, 1))
        for _, kind, pixels in self:
            color, alpha = pixels[..., :3] * STEP, pixels[..., 3:] * STEP
            blended = _BLENDS[kind.blend](below, color)
            covered = alpha + under - alpha * under
            total = alpha * (1 - under) * color + alpha * under * blended + (1 - alpha) * under * below
            below = np.divide(total, covered, out=np.zeros_like(total), where=covered > 0)
            under = covered
        composed: Pixels = np.round(np.concatenate([below, under], axis=-1) * 255).astype(np.uint8)
        return composed


_BLENDS = {
    "normal": lambda below, color: color,  # noqa: ARG005  # one signature for all
    "multiply": lambda below, color: below * color,
    "add": lambda below, color: np.minimum(below + color, 1.0),
}


def split_layers(analysis: ToonAnalysis, light: ArrayLike, **options: Unpack[RelightOptions]) -> Layers:
    """
    Relight a drawing and take the picture apart into layers.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    light : array_like, shape (3,) or (2,)
        The new light, as in `relight`.
    **options
        Those of `relight`.

    Returns
    -------
    Layers
        Layers that compose to `relight(analysis, light, **options)` within 1/255.

    Raises
    ------
    ToonkitError
        As `relight` does.

    Notes
    -----
    Of each color channel of the paint, relit to u over a base color b, either the shadow u / b acts, where u < b, or the
    light u - b. Shadow and light are computed from the base color as rounded to 8 bits, and the ink from all of them, so
    that no rounding adds up. Ink is that of the drawing; where a pixel is not quite a mixture of ink and paint, the ink
    takes the difference.

    Pixels that the drawing covers only in part, such as its soft outline, stand in one layer as they are relit: in the ink
    where they continue a line, else in the base color. A shadow or light over such a pixel would make it more opaque in
    most programs.
    """
    relit = relight(analysis, light, **options)
    picture = relit.to_rgba()
    source, coverage = _paint_sources(analysis)
    seen = picture[..., 3].ravel()
    opaque = np.flatnonzero((seen == OPAQUE) & analysis.image.mask.ravel())
    # Under ink lies the paint of the pixel that it was unmixed with.
    paint = relit.color.reshape(-1, 3)[source[opaque]]
    base = _steps(analysis.base_color.color.reshape(-1, 3)[source])
    shine = np.clip(_highlight(analysis, direction_of("light", light, behind=True))[opaque], 0.0, paint)
    shadow, bright, shine = _shading(paint, base[opaque], shine)
    line, share = _ink(
        relit.color.reshape(-1, 3)[opaque], base[opaque] * shadow + bright + shine, coverage[opaque]
    )
    layers = Layers(
        base_color=picture.copy(),
        shadow=_layer(picture.shape, opaque, shadow, (shadow < 1).any(axis=1)),
        light=_layer(picture.shape, opaque, bright, (bright > 0).any(axis=1)),
        highlight=_layer(picture.shape, opaque, shine, (shine > 0).any(axis=1)),
        ink=_layer(picture.shape, opaque, line, share),
        picture=picture,
    )
    layers.shadow[layers.shadow[..., 3] == 0, :3] = 255
    below, above = layers.base_color.reshape(-1, 4), layers.ink.reshape(-1, 4)
    below[opaque, :3] = np.round(255 * base[opaque])
    soft_lines = (seen > 0) & (coverage > 0.5)
    soft_lines[opaque] = False
    above[soft_lines] = below[soft_lines]
    below[soft_lines] = np.column_stack([np.round(255 * base[soft_lines]), np.zeros(soft_lines.sum())])
    return layers


def _layer(shape: tuple[int, ...], places: Indices, colors: FloatArray, alpha: ArrayLike) -> Pixels:
    """Return a layer with colors (n, 3) and alphas (n,) at some pixels (n,), empty elsewhere."""
    pixels, alpha = np.zeros(shape, np.uint8), np.asarray(alpha, dtype=np.float64)
    shown = alpha > 0
    pixels.reshape(-1, 4)[places[shown]] = np.round(255 * np.column_stack([colors[shown], alpha[shown]]))
    return pixels


def _shading(
    paint: FloatArray, base: FloatArray, shine: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return shadow, light and highlight that make paint (n, 3) of base colors, in steps of 8 bits."""
    dimmed = paint - shine
    shadow = np.where(dimmed < base - STEP / 2, _steps(dimmed / np.maximum(base, STEP)), 1.0)
    bright = np.where(dimmed > base + STEP / 2, _steps(np.maximum(dimmed - base, 0.0)), 0.0)
    rest = np.clip(paint - base * shadow - bright, 0.0, 1.0)
    return shadow, bright, np.where(shine > 0, _steps(rest), 0.0)


def _steps(values: FloatArray) -> FloatArray:
    """Round to 8 bits."""
    rounded: FloatArray = np.round(255 * values) / 255
    return rounded


def _paint_sources(analysis: ToonAnalysis) -> tuple[Indices, FloatArray]:
    """
    Return for each pixel (H·W,) the index of the one that shows its paint without ink, and how much of it is ink.

    Pixels of the fringe are as the object pixel nearest to them.
    """
    drawing, image = analysis.drawing, analysis.image
    source, coverage = np.arange(image.mask.size), np.zeros(image.mask.size)
    places, mixed = np.flatnonzero(image.mask.ravel()), drawing.mixed
    covered = drawing.frame.compact(drawing.ink.coverage)[mixed.pixels]
    inked = covered > 0
    source[places[mixed.pixels[inked]]] = places[mixed.sources[inked, 0]]
    coverage[places[mixed.pixels]] = covered
    fringe, nearest = (
        np.ravel_multi_index(where, image.shape) for where in (image.fringe_places, image.fringe_sources)
    )
    source[fringe], coverage[fringe] = source[nearest], coverage[nearest]
    return source, coverage


def _highlight(analysis: ToonAnalysis, light: FloatArray) -> FloatArray:
    """Return what highlights add to the paint under a light, shape (H·W, 3), of either sign."""
    drawing, mixed = analysis.drawing, analysis.drawing.mixed
    lit = mixed.highlit
    change = analysis.normals.compact[mixed.pixels[lit]] @ (light - analysis.light)
    added = np.zeros((analysis.image.mask.size, 3))
    place = np.flatnonzero(analysis.image.mask.ravel())[mixed.pixels[lit]]
    before = drawing.paint[mixed.sources[lit, 0]]
    added[place] = highlights_left(change)[:, None] * (mixed.drawn[lit] - before)
    return added


def _ink(target: FloatArray, under: FloatArray, coverage: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Find the ink (n, 3), and how much of it (n,), that makes one color of another.

    The coverage given is the least: where it takes ink beyond black or white, more is needed.
    """
    inked = coverage > 0
    missing = target - under
    room = np.where(missing > 0, 1.0 - under, under)
    needed = np.divide(np.abs(missing), room, out=np.zeros_like(missing), where=room > 0).max(axis=1)
    share = np.ceil(255 * np.clip(np.maximum(coverage, needed), 0.0, 1.0)) / 255
    share = np.where(inked, share, 0.0)
    color = np.zeros_like(target)
    weight = share[inked, None]
    color[inked] = np.clip((target[inked] - (1.0 - weight) * under[inked]) / weight, 0.0, 1.0)
    return _steps(color), share

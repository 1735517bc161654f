"""Relighting (Section 3.4, Eq. 7): the same shape and colors under another light."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import BoolArray, FloatArray, as_array, check_flag, is_number, of_type, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.illustration.light_color import LightColor
from toonkit.illustration.mixed_pixels import MixedPixels
from toonkit.illustration.palette import MOST_COLORS, Palette, nearest_in_ramps
from toonkit.model.image import ToonImage
from toonkit.model.light import direction_of
from toonkit.model.materials import Materials
from toonkit.numerics.compiled import njit
from toonkit.numerics.parallel import run_on_row_chunks

DETAIL_RANGE = 0.15
"""Change of illumination over which the painted detail hands over to the model: about half a tone of a four-tone ramp."""

DETAIL_SIZE = 0.1
"""Residuals below this sRGB difference are treated as texture, larger ones as misplaced band edges."""

HIGHLIGHT_RANGE = 0.2
"""Change of illumination over which a highlight fades."""

LEAST_BASE = 0.05
"""Least sRGB channel by which a shade is divided: a darker base color counts as this."""

FULL_TURN = np.deg2rad(12.0)
"""Light rotation, in radians, beyond which flat materials show their full derived shading."""


class RelightOptions(TypedDict, total=False):
    """Keyword arguments that other functions forward to `relight`; see there."""

    keep_detail: bool
    flat_shading: float
    palette: bool | None
    light_color: ArrayLike
    ambient: float


def relight(
    analysis: ToonAnalysis,
    new_light: ArrayLike,
    *,
    keep_detail: bool = True,
    flat_shading: float = 1.0,
    palette: bool | None = None,
    light_color: ArrayLike = (1.0, 1.0, 1.0),
    ambient: float = 0.0,
) -> ToonImage:
    """
    Put an analyzed picture under a new light.

    Parameters
    ----------
    analysis : ToonAnalysis
        Analysis of the picture.
    new_light : array_like, shape (3,) or (2,)
        Direction from the surface to the new light, or its azimuth and elevation in degrees. It may lie behind the
        picture: z < 0, or an elevation between -90 and 0 degrees.
    keep_detail : bool, optional
        True keeps what the model does not explain (band edges, brush texture) where the illumination barely changes, so
        that relighting with the original light reproduces the input. False paints the model alone (Eq. 7).
    flat_shading : float, optional
        Strength of shading on flat materials, from 0 (unshaded) to 1.
    palette : bool, optional
        True paints with the drawing's own colors only, each pixel with those of its material. False allows any color. The
        default is True for pixel art (see `toonkit.illustration.palette.is_pixel_art`), except if none of its
        materials has more than one color or `keep_detail` is False.
    light_color : array_like, shape (3,), optional
        Color of the new light, sRGB in [0, 1]; white by default. It tints lit areas even when `new_light` is the
        drawing's own light. Shadows and line art keep their colors.
    ambient : float, optional
        How much light comes from all sides, 0 to 1: at 0 shadows are as the drawing paints them, at 1 there are none.

    Returns
    -------
    ToonImage
        The relit picture, with the input's mask and alpha.

    Raises
    ------
    ToonkitError
        If the new light is zero or not finite, the analysis is not a `ToonAnalysis`, `keep_detail` or `palette` is not
        a bool, the flat shading, the light's color or the ambient light lies outside [0, 1], or `palette` is True and a
        material has more than 256 colors.

    Notes
    -----
    With I = L · N and I' = L' · N the color of a shaded material becomes c' = M(I') + w d. The detail d = c - M(I) is
    what the drawing shows beyond the model. Its weight is::

        w = (1 - ((I' - I) / 2r)²)⁴ within 2r, else 0,    r = 0.15 / (1 + ‖d‖² / 0.1²)

    This approximates the Gaussian exp(-((I' - I) / r)²) but has compact support. A small detail is texture and stays until
    the light has turned by about half a tone. A large detail is a band edge that the model places beside the painted one. It
    disappears as soon as the light moves, because it would remain as a scratch where the edge was.

    A flat material of color b becomes c' = c (1 + g (M(I') - b) / max(b, 0.05)), channel by channel, so that its pattern is
    shaded with it. The factor g grows from 0 to `flat_shading` as the light turns by `FULL_TURN`, so that shadows come in
    gradually. Recolored materials (`ToonAnalysis.recolored`) are first painted with their new color maps under the
    drawing's light. Pixels that the object covers in part change as the nearest object pixel does. Line art stays as drawn.
    Where it covers a pixel in part, the rest of the pixel changes, and so do pixels that two materials share. A highlight
    moves with the paint beneath it and fades as w does for a small d, with r = `HIGHLIGHT_RANGE`.

    With a palette each pixel takes the color of its material's ramp that is nearest to c', in sRGB. Edges are hard: a
    pixel is ink, a highlight or paint, never a mixture. Ink stays as drawn, and so do pixels in a color that the ramp
    does not have. A flat material changes only if the drawing has a color that could be its shadow.

    Ambient light a and a light of color λ are applied per channel in linear RGB; λ is the linear color of the
    light. With the first color of M as shadow s and the last as lit tone t::

        c'' = e - (1 - λ) max(e - s, 0),    e = c' + a max(t - c', 0)

    What the light adds to the shadow thus takes the color of the light, highlights and texture included. White light
    without ambient light leaves c' unchanged. With a palette e is rounded to the palette before it is tinted.

    A light behind the picture follows the same rule. Visible normals have N_z >= 0, so with L_z < 0 a surface that
    faces the viewer has a negative illumination and is in shadow. Only a rim that turns away toward the light, L · N >
    0, is lit. It gets narrower the farther behind the light stands. From straight behind, L · N = -N_z and nothing is
    lit.
    """
    of_type("analysis", analysis, ToonAnalysis)
    light = direction_of("new_light", new_light, behind=True)
    if not is_number(flat_shading) or not 0 <= flat_shading <= 1:
        raise refuse("flat_shading", "must be a number from 0 to 1", flat_shading)
    check_flag("keep_detail", keep_detail)
    shine = as_array("light_color", light_color, (3,))
    if not ((shine >= 0) & (shine <= 1)).all():
        raise refuse("light_color", "must be sRGB in [0, 1]", shine.tolist())
    if not is_number(ambient) or not 0 <= ambient <= 1:
        raise refuse("ambient", "must be a number from 0 to 1", ambient)
    image, normals = analysis.image, analysis.normals.compact
    labels = analysis.materials.labels[image.mask]
    paint = Paint.of(analysis, palette, keep_detail=keep_detail)
    mixed = paint.mixed
    strength = flat_shading * (turn_share(analysis.light, light) if keep_detail else 1.0)
    color = np.empty_like(image.pixels)
    painted = analysis.recolor(image.pixels, slice(None)) if analysis.is_recolored.any() else image.pixels
    run_on_row_chunks(
        _paint, labels, normals, painted, analysis.light, light,
        *_stacked(paint.materials), float(strength), bool(keep_detail), color,
    )  # fmt: skip
    glow = LightColor.of(shine, float(ambient), analysis.materials.color_maps)
    glow.filled(color, labels)
    left = highlights_left(normals[mixed.pixels] @ (light - analysis.light))
    shown, beneath = image.pixels[mixed.sources], color[mixed.sources]
    color[mixed.pixels] = mixed.over(shown, beneath, left)
    color = paint.rounded(color, image.pixels, labels, mixed.pixels[mixed.highlit])
    followed = image.fringe_pixels
    fringe = color[followed]
    if keep_detail:
        fringe = np.clip(fringe + image.fringe_colors - image.pixels[followed], 0.0, 1.0)
        fringe = paint.rounded(fringe, image.fringe_colors, labels[followed])
    if not glow.is_white:
        untinted = color[followed]
        glow.tinted(color, labels)
        glow.tinted(beneath, labels[mixed.sources])
        mixture = mixed.over(shown, beneath, left)
        color[mixed.pixels] = np.where(mixed.highlit[:, None], color[mixed.pixels], mixture)
        fringe = np.clip(fringe + color[followed] - untinted, 0.0, 1.0)
    return ToonImage.like(image, color, fringe)


@dataclass(frozen=True, eq=False)
class Paint:
    """
    Materials, mixed pixels and palette used to relight a drawing.

    Attributes
    ----------
    materials : Materials
        Its materials.
    mixed : MixedPixels
        The pixels that show more than the paint of their own material.
    palette : Palette or None
        Colors that the result is limited to, or None.
    """

    materials: Materials
    mixed: MixedPixels
    palette: Palette | None

    @classmethod
    def of(cls, analysis: ToonAnalysis, palette: bool | None, *, keep_detail: bool) -> Paint:
        """Build it from an analysis; the options are those of `relight`."""
        drawing, found = analysis.drawing, None
        if palette is not None:
            check_flag("palette", palette)
        if palette or (palette is None and keep_detail and drawing.is_pixel_art):
            found = analysis.palette
        if found is None and palette:
            rule = f"must be False for a drawing with more than {MOST_COLORS} colors in a material"
            raise refuse("palette", rule, palette)
        if found is None or not (palette or found.shades):
            return cls(analysis.materials, drawing.mixed, None)
        paint = analysis.image.pixels[drawing.mixed.sources[:, 0]]
        return cls(found.materials, drawing.mixed.unmixed(paint), found)

    def rounded(
        self,
        color: FloatArray,
        drawn: FloatArray,
        labels: NDArray[np.integer],
        free: NDArray[np.intp] | None = None,
    ) -> FloatArray:
        """
        Map colors to the nearest palette color of their material.

        Parameters
        ----------
        color, drawn : ndarray, shape (n, 3)
            Relit and drawn colors of some pixels, sRGB.
        labels : ndarray of int, shape (n,)
            Their materials.
        free : ndarray of int, optional
            Indices of pixels whose drawn color is also a candidate, even if the palette lacks it; all by default. Other
            pixels keep a drawn color that is not in the palette.

        Returns
        -------
        ndarray, shape (n, 3)
            The mapped colors; `color` itself if there is no palette.
        """
        if self.palette is None:
            return color
        if free is None:
            return nearest_in_ramps(color, drawn, labels, self.palette, own=True)
        rounded = nearest_in_ramps(color, drawn, labels, self.palette, own=False)
        rounded[free] = nearest_in_ramps(color[free], drawn[free], labels[free], self.palette, own=True)
        return rounded


def relight_pixels(
    analysis: ToonAnalysis,
    new_lights: Sequence[FloatArray],
    pixels: NDArray[np.intp],
    *,
    keep_detail: bool = True,
    palette: bool | None = None,
) -> Iterator[FloatArray]:
    """
    Yield the colors of selected pixels under new lights, for pictures that show a drawing at reduced size.

    Parameters
    ----------
    analysis : ToonAnalysis
        Analysis of the picture.
    new_lights : sequence of ndarray, shape (3,)
        Unit vectors from the surface to the new lights.
    pixels : ndarray of int, shape (n,)
        Indices of object pixels, counted in row-major order.
    keep_detail : bool, optional
        As in `relight`.
    palette : bool, optional
        As in `relight`.

    Yields
    ------
    ndarray, shape (n, 3)
        sRGB under each light, bit-identical to the colors of `relight`.
    """
    drawing, light = analysis.drawing, analysis.light
    paint = Paint.of(analysis, palette, keep_detail=keep_detail)
    place, mixed = paint.mixed.among(pixels)
    every = np.concatenate([pixels, mixed.sources.ravel()])  # mixed pixels need their source pixels too
    labels, drawn = analysis.materials.labels[drawing.places(every)], analysis.image.pixels[every]
    painted, normals = analysis.recolor(drawn, every), analysis.normals.compact[every]
    for new_light in new_lights:
        color = np.empty_like(painted)
        strength = turn_share(light, new_light) if keep_detail else 1.0
        run_on_row_chunks(
            _paint, labels, normals, painted, light, new_light,
            *_stacked(paint.materials), float(strength), bool(keep_detail), color,
        )  # fmt: skip
        left = highlights_left(normals[place] @ (new_light - light))
        before, after = (colors[len(pixels) :].reshape(-1, 2, 3) for colors in (drawn, color))
        color[place] = mixed.over(before, after, left)
        own = slice(len(pixels))
        yield paint.rounded(color[own], drawn[own], labels[own], place[mixed.highlit])


def highlights_left(change: FloatArray) -> FloatArray:
    """Return the remaining strength of highlights, 0 to 1, for a change of illumination (n,)."""
    turn = change / (2.0 * HIGHLIGHT_RANGE)
    left: FloatArray = np.maximum(1.0 - turn * turn, 0.0) ** 4
    return left


def turn_share(light: FloatArray, new_light: FloatArray) -> float:
    """Return the smoothstep of the angle between two lights, 0 to 1, saturating at `FULL_TURN`."""
    angle = float(np.arctan2(np.linalg.norm(np.cross(light, new_light)), light @ new_light))
    share = min(angle / FULL_TURN, 1.0)
    return float(share * share * (3.0 - 2.0 * share))


def _stacked(materials: Materials) -> tuple[FloatArray, NDArray[np.intp], FloatArray, BoolArray, FloatArray]:
    """Concatenate all color maps (K, 3); return them with start offsets, domains, flat flags and base tones."""
    maps = materials.color_maps
    first = np.cumsum([0, *(len(color_map.colors) for color_map in maps)])
    colors = np.ascontiguousarray(np.concatenate([color_map.colors for color_map in maps]))
    domains = np.array([color_map.domain for color_map in maps])
    return colors, first, domains, materials.flat, materials.base_tones


@njit(cache=True, nogil=True, error_model="numpy")
def _paint(  # type: ignore[no-untyped-def]
    labels, normals, painted, light, new_light, colors, starts, domains, flat, base, strength, keep_detail, color,
    first, last,
):  # fmt: skip
    """Paint the pixels from first to last."""
    lx, ly, lz = light
    x, y, z = new_light
    for pixel in range(first, last):
        which = labels[pixel]
        ramp = colors[starts[which] : starts[which + 1]]
        low, high = domains[which, 0], domains[which, 1]
        n0, n1, n2 = normals[pixel, 0], normals[pixel, 1], normals[pixel, 2]
        was, now = lx * n0 + ly * n1 + lz * n2, x * n0 + y * n1 + z * n2
        red, green, blue = _mapped(ramp, low, high, now)
        if flat[which]:
            start = painted[pixel] if keep_detail else base[which]
            red = _shaded(start[0], base[which, 0], red, strength)
            green = _shaded(start[1], base[which, 1], green, strength)
            blue = _shaded(start[2], base[which, 2], blue, strength)
        elif keep_detail and abs(now - was) < 2.0 * DETAIL_RANGE:  # beyond this change the weight is zero
            was_red, was_green, was_blue = _mapped(ramp, low, high, was)
            more_red = painted[pixel, 0] - was_red
            more_green = painted[pixel, 1] - was_green
            more_blue = painted[pixel, 2] - was_blue
            kept = detail_weight(now - was, more_red**2 + more_green**2 + more_blue**2)
            if kept > 0.0:
                red = min(max(red + kept * more_red, 0.0), 1.0)
                green = min(max(green + kept * more_green, 0.0), 1.0)
                blue = min(max(blue + kept * more_blue, 0.0), 1.0)
        color[pixel, 0], color[pixel, 1], color[pixel, 2] = red, green, blue


@njit(cache=True, nogil=True, error_model="numpy")
def _shaded(painted, base, shade, strength):  # type: ignore[no-untyped-def]
    """Return a channel of a flat material's paint, which changes in proportion as its base color changes to a shade."""
    return min(max(painted * (1.0 + strength * (shade - base) / max(base, LEAST_BASE)), 0.0), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def detail_weight(change: float, squared_size: float) -> float:
    """Return the weight, 0 to 1, of a detail with squared color difference `squared_size` for a change of illumination."""
    turn = change * (1.0 + squared_size / DETAIL_SIZE**2) / (2.0 * DETAIL_RANGE)
    left = max(1.0 - turn * turn, 0.0)
    return left * left * left * left


@njit(cache=True, nogil=True, error_model="numpy")
def _mapped(colors, low, high, illumination):  # type: ignore[no-untyped-def]
    """Return the color of an illumination, linear between samples; as `ColorMap` does."""
    steps = colors.shape[0] - 1
    if steps == 0:
        return colors[0, 0], colors[0, 1], colors[0, 2]
    position = (min(max(illumination, low), high) - low) * (steps / (high - low))
    start = min(int(position), steps - 1)
    share = min(position - start, 1.0)  # rounding may exceed 1
    return (
        (1.0 - share) * colors[start, 0] + share * colors[start + 1, 0],
        (1.0 - share) * colors[start, 1] + share * colors[start + 1, 1],
        (1.0 - share) * colors[start, 2] + share * colors[start + 1, 2],
    )

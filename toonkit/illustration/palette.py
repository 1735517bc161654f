"""
The palette of pixel art: the few colors of a drawing with hard edges, and the ramp that each material has of them.

Relit pictures of such a drawing use the same colors, as its artist would.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.distinct_colors import LEVELS, beside_their_own, distinct_colors
from toonkit.illustration.flat_shading import LEAST_STEP
from toonkit.illustration.shades import out_of_range, shade_cost
from toonkit.illustration.tones import RADIUS
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.luminance import luminance, tone
from toonkit.model.materials import Materials
from toonkit.model.oklab import off_hue, srgb_to_oklab
from toonkit.numerics.compiled import njit
from toonkit.numerics.masked_grid import bounding_box

FEW_COLORS = 64
"""Most colors of pixel art, counting a color at each opacity separately."""

FEWEST_PIXELS, MOST_SCATTERED = 4.0, 0.5
"""Fewest pixels per color, on average, and the greatest share of scattered colors. A color is scattered if most of its
pixels have no neighbor of the same color. A small anti-aliased picture has few colors, too, but most of them are
mixtures, which are scattered along its edges."""

SMALL, DETAILED = 100, 0.1
"""Size of an object, in pixels, up to which its pixels are visible, and the share of pixels beside another color from
which this holds for a larger one. Large areas in few colors are clip art. Its flat parts get derived shadows instead."""

SAME = 1e-6
"""Difference in each channel below which colors are equal. Computed colors differ by rounding."""

MOST_COLORS = 256
"""Most colors of a palette that is requested, as in an indexed picture."""

SHADOW_COST = 2.1
"""Cost up to which a color may be a shade of another. It is higher than for tones of one material, because shadows in
pixel art change their hue."""

SHADOW_TURN = 0.05, 0.25
"""Greatest OKLab distance of a shadow from the line from gray through the lit color, and how much it grows with the
chroma. Beyond, the shadow looks like another material."""

SHADOW_APART = 0.12
"""OKLab distance up to which a color of the palette stands for the shadow that a flat material should have."""


@dataclass(frozen=True, eq=False)
class Palette:
    """
    The colors in which a drawing is relit, material by material.

    Attributes
    ----------
    ramps : tuple of ndarray, shape (k, 3)
        For each material the colors it is painted with, sRGB as in the drawing, darkest first; none for one that takes any.
        That of a flat material also has the color of the drawing that could best be its shadow, if there is one.
    materials : Materials
        The materials; the color map of a flat one ends in that shadow, or has no shadow.
    """

    ramps: tuple[FloatArray, ...]
    materials: Materials

    @property
    def shades(self) -> bool:
        """Whether any material has more than one color, so that the drawing can answer to a light."""
        return any(len(ramp) > 1 for ramp in self.ramps)

    def stacked(self) -> tuple[FloatArray, NDArray[np.intp]]:
        """Return all ramps as one array (K, 3), and the place of the first color of each and of the end, (count + 1,)."""
        return np.concatenate(self.ramps), np.cumsum([0, *(len(ramp) for ramp in self.ramps)])

    def without(self, which: BoolArray, materials: Materials) -> Palette:
        """Return the palette without the ramps of some materials (count,), which are as in others instead."""
        kept = self.materials
        recolored = Materials(
            kept.labels,
            tuple(materials.tones[k] if out else kept.tones[k] for k, out in enumerate(which)),
            np.where(which, materials.flat, kept.flat),
            tuple(materials.color_maps[k] if out else kept.color_maps[k] for k, out in enumerate(which)),
        )
        ramps = (ramp[:0] if out else ramp for ramp, out in zip(self.ramps, which, strict=True))
        return Palette(tuple(ramps), recolored)


def is_pixel_art(image: ToonImage, *, views: int = 1) -> bool:
    """
    Tell whether a drawing is pixel art: of few colors, without anti-aliasing, and small or full of details.

    Where it shows several views of an object side by side, each of its parts has to be small.
    """
    opacity, faint = (
        np.rint(image.alpha[where] * LEVELS).astype(np.int32) for where in (image.mask, image.fringe_places)
    )
    inside, which = distinct_colors(image.pixels, opacity, FEW_COLORS)
    fringe, _ = distinct_colors(image.fringe_colors, faint, FEW_COLORS)
    pixels = len(image.pixels) + len(image.fringe_colors)
    if len(inside) + len(fringe) > min(FEW_COLORS, pixels / FEWEST_PIXELS):
        return False
    alone, edge = beside_their_own(which, image.mask)
    areas, scattered = np.bincount(which), np.bincount(which, alone)
    if (2 * scattered > areas).mean() > MOST_SCATTERED:
        return False
    parts = [bounding_box(image.mask)] if views == 1 else ndimage.find_objects(ndimage.label(image.mask)[0])
    across = max(span.stop - span.start for part in parts for span in part)
    return across <= SMALL or bool(edge.mean() >= DETAILED)


def find_palette(image: ToonImage, materials: Materials) -> Palette | None:
    """Find the ramp of each material in the colors of a drawing; None if a material has more than `MOST_COLORS` colors."""
    most = MOST_COLORS * materials.count
    labels = materials.labels[image.mask]
    firsts, _ = distinct_colors(image.pixels, labels, most)
    if len(firsts) > most:
        return None
    colors, of = image.pixels[firsts], labels[firsts]
    ramps = [_ramp(colors[of == number], materials, number) for number in range(materials.count)]
    shades = np.unique(np.concatenate(ramps), axis=0)
    tones, color_maps = list(materials.tones), list(materials.color_maps)
    for number in np.flatnonzero(materials.flat):
        shadow = None
        if len(ramps[number]) == 1:
            tones[number] = ramps[number]
            shadow = _shadow(ramps[number][0], color_maps[number].colors[0], shades)
        color_maps[number] = _ending_in(shadow, color_maps[number], tones[number].mean(axis=0))
        if shadow is not None:
            ramps[number] = np.stack([shadow, ramps[number][0]])
    kept = replace(materials, tones=tuple(tones), color_maps=tuple(color_maps))
    return Palette(tuple(ramps), kept)


def _ramp(colors: FloatArray, materials: Materials, number: int) -> FloatArray:
    """Choose from the colors (n, 3) that occur in a material those that its tones or its color map explain."""
    lab = srgb_to_oklab(colors)
    away = np.linalg.norm(lab[:, None] - srgb_to_oklab(materials.tones[number]), axis=-1).min(axis=1)
    if not materials.flat[number]:
        away = np.minimum(away, _distance_to_curve(lab, srgb_to_oklab(materials.color_maps[number].colors)))
    ramp = colors[away < max(RADIUS, float(away.min()) + 1e-9)]
    sorted_ramp: FloatArray = ramp[np.argsort(luminance(ramp), kind="stable")]
    return sorted_ramp


def _distance_to_curve(points: FloatArray, curve: FloatArray) -> FloatArray:
    """Return the distance of points (n, 3) to the nearest of the segments between those of a curve (k, 3)."""
    starts, ways = curve[:-1], np.diff(curve, axis=0)
    bent = np.flatnonzero(
        (ways != 0).any(axis=1)
    )  # most samples of a ramp of few tones repeat the one before
    starts, ways = starts[bent], ways[bent]
    from_start = points[:, None] - starts
    share = np.einsum("nkc,kc->nk", from_start, ways) / np.einsum("kc,kc->k", ways, ways)
    off = from_start - np.clip(share, 0.0, 1.0)[..., None] * ways
    nearest: FloatArray = np.linalg.norm(off, axis=-1).min(axis=1, initial=np.inf)
    return nearest


def _shadow(lit: FloatArray, wanted: FloatArray, shades: FloatArray) -> FloatArray | None:
    """Find the color (3,) of some (n, 3) that is a shade of a lit tone and nearest to the shadow that is wanted."""
    lab = srgb_to_oklab(np.concatenate([lit[None], shades]))
    could_be = (shade_cost(lab)[0] <= SHADOW_COST) & ~out_of_range(lab)[0]
    could_be &= lab[:, 0] < lab[0, 0] - LEAST_STEP
    could_be &= off_hue(lab, lab[0]) <= SHADOW_TURN[0] + SHADOW_TURN[1] * np.linalg.norm(lab[0, 1:])
    away = np.where(could_be, np.linalg.norm(lab - srgb_to_oklab(wanted), axis=-1), np.inf)
    nearest = int(away.argmin())
    return shades[nearest - 1] if away[nearest] < SHADOW_APART else None


def _ending_in(shadow: FloatArray | None, color_map: ColorMap, lit: FloatArray) -> ColorMap:
    """Return the derived color map of a flat material with another shadow; without any, it is one color."""
    if shadow is None:
        return ColorMap(lit[None], color_map.domain)
    tones = np.maximum.accumulate(tone(color_map.colors))
    share = (tones - tones[0]) / max(float(tones[-1] - tones[0]), 1e-9)
    return ColorMap(shadow + share[:, None] * (lit - shadow), color_map.domain)


def nearest_in_ramps(
    wanted: FloatArray, drawn: FloatArray, which: NDArray[np.integer], palette: Palette, *, own: bool
) -> FloatArray:
    """
    Round colors to the ramps of their materials.

    Parameters
    ----------
    wanted, drawn : ndarray, shape (n, 3)
        The relit colors of some pixels and the ones they are drawn in, sRGB.
    which : ndarray of int, shape (n,)
        Their materials.
    palette : Palette
        The ramps.
    own : bool
        True counts the color that a pixel is drawn in as one of its ramp. False leaves what is drawn in another color than
        those of its ramp as it is: a line, a glint, a button of one pixel.

    Returns
    -------
    ndarray, shape (n, 3)
        The nearest colors, sRGB; of equally near ones the darkest. Without a ramp, those that are wanted.
    """
    rounded = np.empty_like(wanted)
    _round(wanted, drawn, which, *palette.stacked(), own, rounded)
    return rounded


@njit(cache=True, nogil=True, error_model="numpy")
def _round(wanted, drawn, which, ramps, starts, own, rounded):  # type: ignore[no-untyped-def]
    for pixel in range(len(which)):
        best = np.inf
        listed = False
        if starts[which[pixel]] == starts[which[pixel] + 1]:
            rounded[pixel] = wanted[pixel]
            continue
        for k in range(starts[which[pixel]], starts[which[pixel] + 1]):
            listed |= (
                abs(ramps[k, 0] - drawn[pixel, 0]) < SAME
                and abs(ramps[k, 1] - drawn[pixel, 1]) < SAME
                and abs(ramps[k, 2] - drawn[pixel, 2]) < SAME
            )
            off = (
                (wanted[pixel, 0] - ramps[k, 0]) ** 2
                + (wanted[pixel, 1] - ramps[k, 1]) ** 2
                + (wanted[pixel, 2] - ramps[k, 2]) ** 2
            )
            if off < best:
                best = off
                rounded[pixel] = ramps[k]
        off = (
            (wanted[pixel, 0] - drawn[pixel, 0]) ** 2
            + (wanted[pixel, 1] - drawn[pixel, 1]) ** 2
            + (wanted[pixel, 2] - drawn[pixel, 2]) ** 2
        )
        if (own and off < best) or not (own or listed):
            rounded[pixel] = drawn[pixel]

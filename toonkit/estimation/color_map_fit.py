"""The color map by rank matching, and the intervals of illumination it allows (Section 3.2, Figures 4 and 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from toonkit._validation import FloatArray, as_array, of_type, refuse, same_shape
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.illustration.flat_shading import derive_shadow
from toonkit.model.color_map import HALF_STEP, ColorMap, IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.luminance import linear_to_srgb
from toonkit.model.materials import Materials
from toonkit.model.oklab import oklab_to_srgb, srgb_to_oklab
from toonkit.numerics.parallel import run_on_chunks

SAMPLES = 1024
"""Samples of a fitted map. A hard step between two bands is blurred over at most 1/500 of illumination."""

PULSE = 25
"""A color that comes and goes within fewer samples is a pulse: 2.4 % of the map."""

TYPICAL = (0.03, 0.97)
"""Shares of a material's pixels, from dark to bright, at which its color map ends. The colors beyond may belong to
remains of a line, a highlight or a mixture of materials, and would spread over the relit picture."""


def fit_color_map(image: ToonImage | PreparedDrawing, illumination: ArrayLike) -> ColorMap:
    """
    Estimate the color map from a picture and the illumination of a normal field.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The picture.
    illumination : array_like, shape (H, W)
        L · N in [-1, 1] on the object.

    Returns
    -------
    ColorMap
        Map over the range of the given illumination, dark to bright.

    Raises
    ------
    ToonkitError
        If the illumination has another size or is NaN or outside [-1, 1] on the object.

    Notes
    -----
    The k-th darkest pixel gets the k-th smallest illumination (Figure 4), so that each painted color owns the interval
    of illumination that its pixels' ranks cover. Mixed pixels of anti-aliased band edges have no color of their own: each
    counts for the nearer of the two bands it mixes.

    Examples
    --------
    >>> illumination = np.linspace(-1, 1, 400).reshape(20, 20)
    >>> color = np.where(illumination[..., None] < 0.25, [0.3, 0.2, 0.4], [0.9, 0.8, 0.7])
    >>> fit_color_map(ToonImage(color, np.ones((20, 20), bool)), illumination)([0.2, 0.3]).round(6).tolist()
    [[0.3, 0.2, 0.4], [0.9, 0.8, 0.7]]
    """
    drawing = prepare(image)
    return rank_matched(drawing.tones, _on_object(illumination, drawing))


def fit_color_maps(image: ToonImage | PreparedDrawing, illumination: ArrayLike) -> Materials:
    """
    Estimate the color map of each material of a picture. Every method ends with this step.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The picture.
    illumination : array_like, shape (H, W)
        L · N in [-1, 1] on the object.

    Returns
    -------
    Materials
        The picture's materials with their color maps. Shaded materials get theirs as in `fit_color_map`, each from its
        own pixels. The maps of flat materials are derived from those.

    Raises
    ------
    ToonkitError
        If the illumination has another size or is NaN or outside [-1, 1] on the object.

    Examples
    --------
    >>> illumination = np.tile(np.linspace(-1, 1, 32), (32, 1))
    >>> color = np.full((32, 32, 3), (0.8, 0.2, 0.2))
    >>> color[16:] = (0.2, 0.3, 0.8)
    >>> len(fit_color_maps(ToonImage(color, np.ones((32, 32), bool)), illumination).color_maps)
    2
    """
    drawing = prepare(image)
    color_maps = fit_materials(drawing, _on_object(illumination, drawing))
    return replace(drawing.materials, color_maps=color_maps)


def illumination_interval(image: ToonImage | PreparedDrawing, color_map: ColorMap) -> IlluminationInterval:
    """
    Range of illumination that each pixel's painted color allows (Eq. 4, Figure 5).

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The picture.
    color_map : ColorMap
        Its color map.

    Returns
    -------
    IlluminationInterval
        Bounds of shape (H, W), NaN outside the mask. A mixed pixel of an anti-aliased band edge lies somewhere between
        the bands it mixes: its interval spans from the darker to the brighter one.

    Raises
    ------
    ToonkitError
        If an argument has the wrong type.
    """
    drawing = prepare(image)
    of_type("color_map", color_map, ColorMap)
    return drawing.interval(allowed_interval(drawing.tones, color_map))


def fit_materials(drawing: PreparedDrawing, illumination: FloatArray) -> tuple[ColorMap, ...]:
    """
    Fit the color map of every material to the illumination (P,) of its own pixels; derive those of the flat ones.

    See `fit_color_map` for the former, and `toonkit.illustration.flat_shading` for the latter.
    """
    materials = drawing.painted_materials
    trim = len(materials) > 1
    fitted = [
        None if material.tones is None else _fitted(material.tones, illumination[material.pixels], trim=trim)
        for material in materials
    ]
    shaded = [color_map for color_map in fitted if color_map is not None]
    shadow = derive_shadow(shaded, drawing.materials.shares[~drawing.materials.flat])
    return tuple(
        shadow.color_map(base) if color_map is None else color_map
        for color_map, base in zip(fitted, drawing.materials.base_tones, strict=True)
    )


def _fitted(tones: PaintedTones, illumination: FloatArray, *, trim: bool) -> ColorMap:
    """Fit one material. Optionally replace both ends of its map by the colors at `TYPICAL` shares of its pixels."""
    color_map = rank_matched(tones, illumination)
    if not trim:
        return color_map
    ends = np.quantile(illumination, TYPICAL)
    return ColorMap(color_map(np.clip(color_map.illumination, *ends)), color_map.domain)


def allowed_intervals(drawing: PreparedDrawing, color_maps: Sequence[ColorMap]) -> IlluminationInterval:
    """
    Range of illumination (P,) that each pixel allows, given its material's color map.

    It is all of [-1, 1] where the material is flat, and under ink and highlights, which hide how the paint is lit.
    """
    lower, upper = np.full(drawing.grid.size, -1.0), np.full(drawing.grid.size, 1.0)
    for material, color_map in zip(drawing.painted_materials, color_maps, strict=True):
        if material.tones is not None:
            allowed = allowed_interval(material.tones, color_map)
            lower[material.pixels], upper[material.pixels] = allowed.lower, allowed.upper
    lower[drawing.hidden], upper[drawing.hidden] = -1.0, 1.0
    return IlluminationInterval(lower, upper)


def painted_intervals(
    drawing: PreparedDrawing, color_maps: Sequence[ColorMap], allowed: IlluminationInterval
) -> IlluminationInterval:
    """Narrow what `allowed_intervals` returned to what the nearer one of the bands that each pixel mixes allows."""
    lower, upper = allowed.lower.copy(), allowed.upper.copy()
    for material, color_map in zip(drawing.painted_materials, color_maps, strict=True):
        if material.tones is not None:
            own = IlluminationInterval(lower[material.pixels], upper[material.pixels])
            narrow = painted_interval(material.tones, color_map, own)
            lower[material.pixels], upper[material.pixels] = narrow.lower, narrow.upper
    hidden = drawing.hidden
    lower[hidden], upper[hidden] = allowed.lower[hidden], allowed.upper[hidden]
    return IlluminationInterval(lower, upper)


def rank_matched(tones: PaintedTones, illumination: FloatArray) -> ColorMap:
    """
    Fit the map to the illumination (P,) of a drawing's pixels, in any order; see `fit_color_map`.

    Each sample takes the mean color of its ranks, computed in linear light. Means of sRGB values could be darker for
    brighter colors. Pulses are removed, see `_without_pulses`.
    """
    ordered = np.sort(illumination)
    low, high = float(ordered[0]), float(ordered[-1])
    light = tones.ordered.of_darkest
    if high - low < 1e-6:
        mean = light(np.array([len(ordered)])) / len(ordered)
        return ColorMap(linear_to_srgb(mean), (max(low - 1e-6, -1.0), min(high + 1e-6, 1.0)))
    where = np.linspace(low, high, SAMPLES)
    # Rank of each cell's ends: pixels with equal illumination have no order, so they share their colors' mean.
    edges = np.concatenate([[low], (where[1:] + where[:-1]) / 2, [high]])
    first = np.searchsorted(ordered, edges[:-1], side="left")
    last = np.searchsorted(ordered, edges[1:], side="right")
    filled = last > first
    mean = (light(last[filled]) - light(first[filled])) / (last - first)[filled, None]
    samples = np.stack([np.interp(where, where[filled], channel) for channel in mean.T], axis=1)
    return ColorMap(_without_pulses(linear_to_srgb(np.clip(samples, 0.0, 1.0))), (low, high))


def _without_pulses(colors: FloatArray) -> FloatArray:
    """
    Remove the pulses of a map (SAMPLES, 3), sRGB: steps to another color and back within fewer than `PULSE` samples.

    Where two gradients of different hue have the same luminance, their colors take turns in the order of ranks, and the map
    would paint thin stripes. The median of each component, in OKLab, removes pulses. It leaves monotonic steps, such
    as those between most tones, exactly as they are.
    """
    lab = srgb_to_oklab(colors)
    smooth = np.column_stack(
        [ndimage.median_filter(component, 2 * PULSE - 1, mode="nearest") for component in lab.T]
    )
    changed = (smooth != lab).any(axis=1)
    if not changed.any():
        return colors
    colors = colors.copy()
    colors[changed] = np.clip(oklab_to_srgb(smooth[changed]), 0.0, 1.0)
    return colors


def allowed_interval(tones: PaintedTones, color_map: ColorMap) -> IlluminationInterval:
    """Range of illumination (P,) that each of a drawing's pixels allows; see `illumination_interval`."""
    tolerance, lower, upper = _tolerance(tones), tones.darkest, tones.brightest
    lower -= tolerance
    upper += tolerance
    run_on_chunks(_allow, len(lower), color_map, lower, upper)
    return IlluminationInterval(lower, upper)


def painted_interval(
    tones: PaintedTones, color_map: ColorMap, allowed: IlluminationInterval
) -> IlluminationInterval:
    """Narrow what `allowed_interval` returned to what the nearer one of the bands that each pixel mixes allows."""
    mixed = tones.mixtures.pixels
    if mixed.size == 0:
        return allowed
    tolerance = _tolerance(tones)
    plain = tones.mixtures.nearer
    narrow = color_map.allowed(plain - tolerance, plain + tolerance)
    lower, upper = allowed.lower.copy(), allowed.upper.copy()
    lower[mixed], upper[mixed] = narrow.lower, narrow.upper
    return IlluminationInterval(lower, upper)


def _on_object(illumination: ArrayLike, drawing: PreparedDrawing) -> FloatArray:
    """Check an illumination (H, W), and return that of the object's pixels (P,)."""
    if getattr(illumination, "dtype", None) == np.bool_:
        raise refuse("illumination", "must be numbers; `extract_color_map` takes a stroke", "bool")
    values = as_array("illumination", illumination, (None, None))
    same_shape("illumination", values.shape, drawing.mask.shape, "the picture")
    inside = values[drawing.mask]
    if not (np.isfinite(inside).all() and np.abs(inside).max() <= 1 + 1e-9):
        raise refuse("illumination", "must lie in [-1, 1] on the object", "values outside it or NaN")
    return np.clip(inside, -1.0, 1.0)


def _tolerance(tones: PaintedTones) -> float:
    """Return how far the tone of a color may lie from the intended one."""
    return max(HALF_STEP, tones.noise)


def _allow(color_map: ColorMap, lower: FloatArray, upper: FloatArray, piece: slice) -> None:
    """Replace the least and greatest tones of some pixels by the bounds that they allow."""
    allowed = color_map.allowed(lower[piece], upper[piece])
    lower[piece], upper[piece] = allowed.lower, allowed.upper

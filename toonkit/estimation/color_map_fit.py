"""The color map by rank matching, and the intervals of illumination it allows (Section 3.2, Figures 4 and 5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import maximum_filter, minimum_filter

from toonkit._validation import BoolArray, FloatArray, as_array, of_type, refuse, same_shape
from toonkit.model.color_map import HALF_STEP, ColorMap, IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear, tone

SAMPLES = 1024
"""Samples of a fitted map: a hard step between two bands is blurred over 1/500 of illumination at most."""

FLAT = 2.5 / 255
"""Colors of one band differ by less than this: rounding, and a compressor's noise."""

FLAT_NEIGHBORS = 4
"""Neighbors of its own tone that a pixel of a band has at least; of a band two pixels wide, five."""

MIXING_REACH = 2
"""An anti-aliased band edge is at most this many pixels away from the bands it mixes."""


def fit_color_map(image: ToonImage, illumination: ArrayLike) -> ColorMap:
    """
    Estimate the color map from a picture and the illumination of a normal field.

    Parameters
    ----------
    image : ToonImage
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
    >>> fit_color_map(ToonImage(color, np.ones((20, 20), bool)), illumination)([0.2, 0.3]).tolist()
    [[0.3, 0.2, 0.4], [0.9, 0.8, 0.7]]
    """
    of_type("image", image, ToonImage)
    light = as_array("illumination", illumination, (None, None))
    same_shape("illumination", light.shape, image.mask.shape, "the picture")
    pairs = light[image.mask]
    if not (np.isfinite(pairs).all() and np.abs(pairs).max() <= 1 + 1e-9):
        raise refuse("illumination", "must lie in [-1, 1] on the object", "values outside it or NaN")
    colors = _band_colors(
        image.color[image.mask], tone(image.color)[image.mask], plain_tones(image)[image.mask]
    )
    return _rank_matched(colors, np.sort(np.clip(pairs, -1.0, 1.0)))


def illumination_interval(image: ToonImage, color_map: ColorMap) -> IlluminationInterval:
    """
    Range of illumination that each pixel's painted color allows (Eq. 4, Figure 5).

    Parameters
    ----------
    image : ToonImage
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
        If an argument is of another type.
    """
    of_type("image", image, ToonImage)
    of_type("color_map", color_map, ColorMap)
    tolerance = max(HALF_STEP, noise_level(image))
    interval = color_map.invert(image.color, tolerance=tolerance)
    mixed = mixed_pixels(image)
    if not mixed.any():
        return interval
    size = 2 * MIXING_REACH + 1
    plain = image.mask & ~mixed
    lowest = minimum_filter(np.where(plain, interval.lower, np.inf), size)
    highest = maximum_filter(np.where(plain, interval.upper, -np.inf), size)
    return IlluminationInterval(
        np.where(mixed, lowest, interval.lower), np.where(mixed, highest, interval.upper)
    )


def mixed_pixels(image: ToonImage) -> BoolArray:
    """
    Find the anti-aliased pixels of band edges: colors that are a mixture of two flat bands beside them.

    Parameters
    ----------
    image : ToonImage
        The picture.

    Returns
    -------
    ndarray, shape (H, W)
        True where a pixel is not flat itself, has a flat pixel that is darker and one that is brighter within
        `MIXING_REACH` pixels, and a tone strictly between theirs. Soft transitions wider than that are left alone.
        Flat is a pixel with the tone of four of its neighbors, or of all where it has fewer.
    """
    mixed: BoolArray = image.mask & (plain_tones(image) != tone(image.color))
    return mixed


def plain_tones(image: ToonImage) -> FloatArray:
    """
    Tones of a picture, without mixtures: a mixed pixel takes the nearer tone of the two bands it mixes.

    Parameters
    ----------
    image : ToonImage
        The picture.

    Returns
    -------
    ndarray, shape (H, W)
        Tone in [0, 1], NaN outside the mask.
    """
    tones = tone(image.color)
    flat = image.mask & _is_flat(tones)
    size = 2 * MIXING_REACH + 1
    darker = minimum_filter(np.where(flat, tones, np.inf), size)
    brighter = maximum_filter(np.where(flat, tones, -np.inf), size)
    mixed = image.mask & ~flat & (tones > darker + FLAT) & (tones < brighter - FLAT)
    nearer = np.where(tones - darker < brighter - tones, darker, brighter)
    return np.where(mixed, nearer, tones)


def _is_flat(tones: FloatArray) -> BoolArray:
    """Tell which pixels belong to a band: at a band's edge a mixed pixel resembles two neighbors along it at most."""
    framed = np.pad(tones, 1, constant_values=np.nan)
    height, width = tones.shape
    alike = np.zeros(tones.shape, dtype=np.int8)
    present = np.zeros(tones.shape, dtype=np.int8)
    for down in (0, 1, 2):
        for along in (0, 1, 2):
            if (down, along) == (1, 1):
                continue
            neighbor = framed[down : down + height, along : along + width]
            alike += np.abs(neighbor - tones) < FLAT
            present += ~np.isnan(neighbor)
    flat: BoolArray = alike >= np.minimum(present, FLAT_NEIGHBORS)
    return flat


def noise_level(image: ToonImage) -> float:
    """
    Estimate how much the tones of one painted color scatter.

    Parameters
    ----------
    image : ToonImage
        The picture.

    Returns
    -------
    float
        Standard deviation in tone (0..1), from the median second difference along rows: zero for flat colors and for
        gradients, whatever the number of band edges.
    """
    tones = tone(image.color)
    second = np.abs(tones[:, 2:] - 2 * tones[:, 1:-1] + tones[:, :-2])
    inside = second[np.isfinite(second)]
    if inside.size == 0:
        return 0.0
    # A second difference of independent noise has sqrt(6) times its deviation; the median of |x| is 0.6745 deviations.
    return float(np.median(inside) / (0.6745 * np.sqrt(6)))


def _band_colors(colors: FloatArray, tones: FloatArray, plain: FloatArray) -> FloatArray:
    """Colors (P, 3) from dark to bright, each mixed one replaced by a color of the band whose tone it was given."""
    pure = np.flatnonzero(plain == tones)
    pure = pure[np.argsort(plain[pure], kind="stable")]
    mixed = np.flatnonzero(plain != tones)
    stand_in = np.arange(len(colors))
    stand_in[mixed] = pure[np.searchsorted(plain[pure], plain[mixed])]
    return colors[stand_in[np.argsort(plain, kind="stable")]]


def _rank_matched(colors: FloatArray, illumination: FloatArray) -> ColorMap:
    """Map from colors and illuminations that are both sorted: each sample takes the mean color of its ranks.

    The mean is one of light, not of sRGB values: only so does the mean of brighter colors never come out darker.
    """
    low, high = float(illumination[0]), float(illumination[-1])
    if high - low < 1e-6:
        return ColorMap(
            linear_to_srgb(srgb_to_linear(colors).mean(axis=0))[None],
            (max(low - 1e-6, -1.0), min(high + 1e-6, 1.0)),
        )
    where = np.linspace(low, high, SAMPLES)
    # Rank of each cell's ends: pixels with equal illumination have no order, so they share their colors' mean.
    edges = np.concatenate([[low], (where[1:] + where[:-1]) / 2, [high]])
    first = np.searchsorted(illumination, edges[:-1], side="left")
    last = np.searchsorted(illumination, edges[1:], side="right")
    total = np.concatenate([np.zeros((1, 3)), np.cumsum(srgb_to_linear(colors), axis=0)])
    filled = last > first
    mean = (total[last[filled]] - total[first[filled]]) / (last - first)[filled, None]
    samples = np.stack([np.interp(where, where[filled], channel) for channel in mean.T], axis=1)
    return ColorMap(linear_to_srgb(np.clip(samples, 0.0, 1.0)), (low, high))

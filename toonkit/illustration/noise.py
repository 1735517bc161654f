"""Compression noise, as in JPEG files: colors of flat paint vary by a few steps, and hues run across borders."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.filling import Labels
from toonkit.illustration.frame import Frame
from toonkit.illustration.neighborhoods import grow_mask, range_around, shrink_mask
from toonkit.illustration.zones import find_zones
from toonkit.model.oklab import Lab, tabulated_oklab
from toonkit.model.whole_pixels import pixels_at
from toonkit.numerics.compiled import njit

WAVERS = 16
"""Difference, in steps of an 8-bit channel, up to which neighbors are the same paint with noise and not an edge."""

NOISY, ROUGH = 0.2, 1.05
"""Least share of noisy pixels, and least ratio of their second to their first differences. Clean gradients stay below
0.8, and clean flat colors have hardly any noisy pixels."""

ALIKE, PASSES = 20, 3
"""Steps of a channel within which neighbors are averaged, and how often."""

STEADY = 12
"""Steps of a channel within which a pixel and its eight neighbors are the same paint, away from borders."""

REACH = 6
"""Distance from a border, in pixels, within which the hue may be that of another paint."""

LUMA = np.array([0.299, 0.587, 0.114])
"""JPEG's luma of a color in sRGB (ITU-R BT.601)."""

SAME_LUMA = 12 / 255
"""Greatest difference of luma between pixels near a border and their own paint. Compression keeps luma better than hue."""

FEWEST = 12
"""Fewest pixels of a flat zone."""

FLAT, NEAR, AROUND = 0.9, 5, 16
"""Least share of a flat zone's middle whose colors are near its median; and, in steps of a channel, how near they must
be, and how far from the median colors are replaced by it."""

ONE_COLOR = 6
"""Steps of a channel within which two flat zones are of one color."""


def remove_noise(frame: Frame) -> Frame:
    """
    Give flat paint one color each, and pixels beside borders that of their own paint, if colors waver all over a drawing.

    A drawing without noise is returned unchanged.
    """
    if not _wavers(frame):
        return frame
    original = color = frame.color
    averaged = np.empty_like(color)
    for _ in range(PASSES):
        _average(
            color.reshape(-1, 3),
            original.reshape(-1, 3),
            frame.mask.ravel(),
            frame.mask.shape[1],
            ALIKE / 255,
            averaged.reshape(-1, 3),
        )
        color, averaged = averaged, np.empty_like(averaged)
    lab = tabulated_oklab(color)
    source = _own_paint(color, lab, frame.mask)
    color, lab = color.reshape(-1, 3)[source], lab.reshape(-1, 3)[source]
    color = _flatten(color, lab, frame.mask)
    return replace(frame, pixels=pixels_at(color, frame.mask))


def _wavers(frame: Frame) -> bool:
    """Tell whether colors waver without any direction in much of a drawing."""
    inner, color = shrink_mask(frame.mask, 1), frame.color
    steps = 255 * range_around(color)
    wavering = inner & (steps > 0.5) & (steps < WAVERS + 0.5)
    if np.count_nonzero(wavering) <= NOISY * np.count_nonzero(inner):
        return False
    value, second, first = color.sum(axis=2), 0.0, 0.0
    for axis in (0, 1):
        before, after = np.roll(value, 1, axis), np.roll(value, -1, axis)
        second += float(np.abs(before - 2 * value + after)[wavering].sum())
        first += float(np.abs(before - after)[wavering].sum())
    return second > ROUGH * first


@njit(cache=True, nogil=True, error_model="numpy")
def _average(color, original, mask, width, alike, out):  # type: ignore[no-untyped-def]
    """Average each pixel with those neighbors that are like what it was at first."""
    for p in range(mask.size):
        for c in range(3):
            out[p, c] = color[p, c]
        if not mask[p]:
            continue
        count = 1
        for n in range(9):
            q = p + (n // 3 - 1) * width + n % 3 - 1
            if (
                mask[q]
                and q != p
                and abs(color[q, 0] - original[p, 0]) < alike
                and abs(color[q, 1] - original[p, 1]) < alike
                and abs(color[q, 2] - original[p, 2]) < alike
            ):
                count += 1
                for c in range(3):
                    out[p, c] += color[q, c]
        for c in range(3):
            out[p, c] /= count


def _own_paint(color: FloatArray, lab: Lab, mask: BoolArray) -> NDArray[np.intp]:
    """
    Find steady pixels of the same luma near those that are not: a compressor smears hues further than luma.

    Returns the flat index (h, w) of the pixel whose color each gets: its own where it is steady, or nothing is found.
    """
    own = np.arange(mask.size).reshape(mask.shape)
    steady = mask & (255 * range_around(color) < STEADY + 0.5)
    source = np.where(steady, own, -1).ravel()
    luma, lab, width = (color @ LUMA).ravel(), lab.reshape(-1, 3), mask.shape[1]
    left = np.flatnonzero(mask & ~steady & grow_mask(steady, REACH))
    for _ in range(REACH):
        least, found = np.full(len(left), np.inf, np.float32), np.full(len(left), -1)
        for step in (1, width, width + 1, width - 1):
            for side in (left - step, left + step):
                candidate = source[side]
                away = ((lab[candidate] - lab[left]) ** 2).sum(axis=1)
                nearer = (
                    (candidate >= 0) & (np.abs(luma[candidate] - luma[left]) < SAME_LUMA) & (away < least)
                )
                least, found = np.where(nearer, away, least), np.where(nearer, candidate, found)
        source[left] = found
        left = left[found < 0]
    return np.where(source.reshape(mask.shape) >= 0, source.reshape(mask.shape), own)


def _flatten(color: FloatArray, lab: Lab, mask: BoolArray) -> FloatArray:
    """Give the flat zones of a picture (h, w, 3) their median colors, and one color to those that differ by noise alone."""
    zones = find_zones(lab, mask)
    unmixed = mask & (zones.sources == np.arange(mask.size).reshape(mask.shape))
    zone, shown = zones.labels[unmixed], 255 * color[unmixed]
    area = np.bincount(zone)
    every = np.arange(len(area))
    usual = np.column_stack([ndimage.median(channel, zone, every) for channel in shown.T])
    away = np.abs(shown - usual[zone]).max(axis=1)
    inner = _far_from_borders(zones.labels)[unmixed]
    counted = inner | (np.bincount(zone, inner, len(area)) < FEWEST)[zone]
    near = np.bincount(zone, counted & (away <= NEAR), len(area))
    flat = (area >= FEWEST) & (near >= FLAT * np.bincount(zone, counted, len(area)))
    clean = unmixed.copy()
    clean[unmixed] = flat[zone] & (away <= AROUND)
    cleaned = color.copy()
    cleaned[clean] = _few_colors(usual, np.where(flat, area, 0))[zones.labels[clean]] / 255
    return cleaned


def _far_from_borders(labels: Labels) -> BoolArray:
    """Mark the pixels that have nothing but their own zone within half of `REACH`: a compressor leaves these as they are."""
    width = REACH | 1
    far: BoolArray = ndimage.minimum_filter(labels, width) == ndimage.maximum_filter(labels, width)
    return far


def _few_colors(usual: FloatArray, area: NDArray[np.intp]) -> FloatArray:
    """Give each of the colors (n, 3) that one of a larger area (n,), which is nearly the same, if there is one."""
    colors = usual.copy()
    palette = np.empty((0, 3))
    for zone in np.argsort(-area, kind="stable")[: np.count_nonzero(area)]:
        away = np.abs(palette - usual[zone]).max(axis=1)
        if away.size and away.min() <= ONE_COLOR:
            colors[zone] = palette[away.argmin()]
        else:
            palette = np.vstack([palette, usual[zone]])
    return colors

"""Noise of a compressor: flat paint whose colors waver by some steps, as JPEG files have it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray
from toonkit.illustration.filling import nearest_sources
from toonkit.illustration.frame import Frame
from toonkit.model.oklab import tabulated_oklab

NEAR, AROUND, BESIDE = 3, 8, 10
"""Steps of an 8-bit channel: how far most pixels of a flat color waver, how far it is taken for that color, and the distance
within which there is hardly another one, as there would be in a gradient."""

CONCENTRATED = 0.75
"""Share of the pixels within `BESIDE` of a flat color that are within `NEAR`, at least."""

FREQUENT, COLORS = 0.002, 96
"""Share of the pixels that a flat color has at least, and how many colors are looked at, at most."""

MOSTLY_FLAT, NOISY = 0.4, 0.03
"""Shares of the pixels: in flat colors, at least, and of those that have not quite their color."""

ROUGH = 1.1
"""Second differences relative to first ones where colors waver, from which that is noise: gradients stay below 0.7."""

SAMPLED = 40_000
"""Pixels in which flat colors are looked for, at most."""

REACH = 4
"""Pixels beside flat paint that may be smeared with it."""


def without_noise(frame: Frame) -> Frame:
    """
    Give pixels of flat paint one color each, if the drawing is painted in flat colors that waver.

    Parameters
    ----------
    frame : Frame
        The object.

    Returns
    -------
    Frame
        The same with clean colors: pixels beside flat paint, which a compressor smears, take the nearest of its colors. A
        drawing without noise, or in gradients, returns as it is.
    """
    levels = np.rint(frame.color[frame.mask] * 255).astype(np.int32)
    palette = _flat_colors(levels[:: -(-len(levels) // SAMPLED)])
    if not palette:
        return frame
    color, flat, wavering = frame.color.copy(), np.zeros_like(frame.mask), np.zeros_like(frame.mask)
    place = np.flatnonzero(frame.mask)
    for peak in palette:
        red, green, blue = (np.abs(levels[:, k] - peak[k]) for k in range(3))
        near = (red <= AROUND) & (green <= AROUND) & (blue <= AROUND)
        color.reshape(-1, 3)[place[near]] = peak / 255
        flat.ravel()[place[near]] = True
        wavering.ravel()[place[near]] = (red + green + blue)[near] > 0
        place, levels = place[~near], levels[~near]
    if _roughness(frame, flat, wavering) < ROUGH:
        return frame
    source = nearest_sources(flat, frame.lab, frame.mask, within=REACH)
    smeared = source >= 0
    color[smeared] = color.reshape(-1, 3)[source[smeared]]
    return replace(frame, color=color, lab=tabulated_oklab(color))


def _roughness(frame: Frame, flat: BoolArray, wavering: BoolArray) -> float:
    """Second differences of the pixels that waver relative to their first ones: large for noise, small in a gradient."""
    value, second, first = frame.color.sum(axis=2), 0.0, 0.0
    for axis in (0, 1):
        before, after = np.roll(value, 1, axis), np.roll(value, -1, axis)
        counted = wavering & np.roll(flat, 1, axis) & np.roll(flat, -1, axis)
        second += float(np.abs(before - 2 * value + after)[counted].sum())
        first += float(np.abs(before - after)[counted].sum())
    return second / max(first, 1e-9)


def _flat_colors(levels: NDArray[np.int32]) -> list[NDArray[np.int32]]:
    """Find the flat colors among pixels (n, 3) of 8 bits; none if they do not waver, or are few."""
    keys, pixels = np.unique(levels @ np.array([65_536, 256, 1], np.int32), return_counts=True)
    if pixels.max() < FREQUENT * len(levels):
        return []
    palette = np.column_stack([keys >> 16, keys >> 8 & 255, keys & 255])
    found, flat, exact = [], 0, 0
    for _ in range(COLORS):
        peak = int(pixels.argmax())
        away = np.abs(palette - palette[peak]).max(axis=1)
        near, beside = pixels[away <= NEAR].sum(), pixels[away <= BESIDE].sum()
        if beside < FREQUENT * len(levels):
            break
        if near >= CONCENTRATED * beside:
            found.append(palette[peak])
            flat += pixels[away <= AROUND].sum()
            exact += pixels[peak]
        pixels = np.where(away <= BESIDE, 0, pixels)
    wavers = flat >= MOSTLY_FLAT * len(levels) and flat - exact >= NOISY * flat
    return found if wavers else []

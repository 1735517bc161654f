"""
Lines of ink: dark strips in colors that occur where shading does not.

A line is darker than the paint on both of its sides, and much narrower than the object. Shading makes such dark strips,
too: a crescent of shadow along the silhouette, or the gap between two parts. Ink differs from shading in where its
color occurs. The color of an outline follows the silhouette all around, also where it faces the light. The shadow color
of a closed shape never does. The color of inner lines occurs almost nowhere else, whereas the color of shading also
occurs along the silhouette.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.frame import Frame
from toonkit.illustration.neighborhoods import grow_mask, shrink_mask
from toonkit.model.oklab import Lab

WIDEST = 0.035
"""Greatest width of a line, in square roots of the object's area."""

TINY = 16.0
"""Square root of the area, in pixels, up to which paint may be as narrow as lines."""

SAME_INK = 0.06
"""OKLab distance within which colors are one ink."""

BLACK = 0.2
"""OKLab lightness below which a color is seldom a shadow."""

SPECK = 0.0008
"""Least share of the object that the ink of one color covers."""

SMALLEST = 50.0
"""Square root of the area, in pixels, up to which lines are at most two pixels wide. In larger objects lines may be
four pixels wide or more."""

DARKER = 0.07
"""Least difference of OKLab lightness between a line and the paint beside it."""

PIECE = 0.65
"""Least share of a color that lies in strips, for it to be the ink of a part of the outline."""

CELL, CELLS, LOWEST = 0.042, 40, -14
"""Histogram of colors: width of a cell in OKLab, cells along each axis, and number of the first."""

INKS = 6
"""Most colors that are examined."""


@dataclass(frozen=True, eq=False)
class Strips:
    """Dark strips: pixels of them, their darkest ones, and the width of the window that found them."""

    pixels: BoolArray
    cores: BoolArray
    width: int


def find_dark_strips(frame: Frame) -> Strips:
    """Close dark strips narrower than a square window; what that makes brighter is a strip. Outside counts as bright."""
    width = line_window(frame)
    lightness = np.where(frame.mask, frame.lab[..., 0], np.float32(2.0))
    padded = np.pad(lightness, width, constant_values=2.0)
    closed = ndimage.grey_closing(padded, (width, width))[width:-width, width:-width]
    pixels = frame.mask & (closed - lightness > DARKER)
    cores = pixels & (lightness - ndimage.minimum_filter(lightness, 3) < DARKER / 2)
    return Strips(pixels, cores, width)


def line_window(frame: Frame) -> int:
    """Width of a window, in pixels, that is wider than the lines of a drawing: an odd number."""
    return max(int(WIDEST * frame.size) | 1, 5 if frame.size > SMALLEST else 3)


def find_lines(frame: Frame, strips: Strips, around: Silhouette) -> BoolArray:
    """Pixels of strips in the colors that are ink."""
    mask, lab = frame.mask, frame.lab
    lines, pieces = np.zeros_like(mask), np.zeros_like(mask)
    for ink in _find_frequent_colors(lab[strips.cores]):
        near = mask & (color_distance(lab, ink) < SAME_INK)
        thin = near & strips.cores
        count = np.count_nonzero(thin)
        if count < SPECK * frame.size**2:
            continue
        share = count / np.count_nonzero(near)
        followed = around.share(grow_mask(thin, 1))
        encloses = opposite_share(followed)
        least = 0.1 if share > 0.85 or ink[0] < BLACK else 0.3
        if encloses > least:
            # Where lines meet, ink is wider than the window.
            lines |= near & grow_mask(thin, strips.width // 2) if share > 0.6 else thin
        elif share > 0.75 and followed.max() < 0.27:
            lines |= _keep_elongated(thin)
        elif share > PIECE:
            pieces |= thin
    # Lines may be a darker shade of the paint they surround: the outline then has a color for each part.
    if pieces.any() and opposite_share(around.share(grow_mask(pieces | lines, 1))) > 0.4:
        lines |= pieces
    if frame.size <= TINY:  # the pixels inside the silhouette are most of it, whatever they are painted
        return lines
    return lines | _find_outlines(frame, around, strips.width)


def _find_outlines(frame: Frame, around: Silhouette, width: int) -> BoolArray:
    """Find lines of any lightness, and a sticker's border: one color along the silhouette on all sides, nowhere wide."""
    mask, lab = frame.mask, frame.lab
    inner = shrink_mask(mask, 1)
    band = inner & ~shrink_mask(inner, 1)
    lines = np.zeros_like(mask)
    if not band.any():
        return lines
    for ink in _find_frequent_colors(lab[band])[:2]:
        near = mask & (color_distance(lab, ink) < SAME_INK)
        if opposite_share(around.share(grow_mask(near, 1))) < 0.5:
            continue
        wide = near & grow_mask(shrink_mask(near, width // 2), width // 2)
        if np.count_nonzero(band & near & ~wide) > 0.8 * np.count_nonzero(band & near):
            lines |= near & ~grow_mask(wide, 1)
    return lines


def opposite_share(followed: FloatArray) -> float:
    """How much of the silhouette is followed on opposite sides at once: the shadow of one light never is."""
    return float(np.minimum(followed[:4], followed[4:]).mean())


@dataclass(frozen=True, eq=False)
class Silhouette:
    """Pixels of the silhouette (n,), by the eighth of the circle that they face (n,)."""

    pixels: NDArray[np.intp]
    facing: NDArray[np.intp]

    @classmethod
    def of(cls, mask: BoolArray) -> Silhouette:
        """Find the silhouette of a mask."""
        rim = mask & ~shrink_mask(mask, 1)
        down, right = np.gradient(ndimage.gaussian_filter(mask.astype(np.float32), 2.5))
        pixels = np.flatnonzero(rim)
        # Eighths centered on the axes and diagonals stay eighths when the picture is turned or mirrored.
        angle = np.arctan2(down.ravel()[pixels], right.ravel()[pixels])
        return cls(pixels, np.rint(angle / (np.pi / 4)).astype(np.intp) % 8)

    def share(self, marked: BoolArray) -> FloatArray:
        """Share of each eighth's pixels that are marked, shape (8,); eighths that hardly occur count as the others."""
        total = np.bincount(self.facing, minlength=8)
        hit = np.bincount(self.facing, weights=marked.ravel()[self.pixels], minlength=8)
        rare = total < 0.02 * total.sum()
        return np.where(rare, hit.sum() / max(total.sum(), 1), hit / np.maximum(total, 1))


def _find_frequent_colors(colors: Lab) -> list[NDArray[np.float32]]:
    """Peaks of colors (n, 3), most frequent first."""
    found = []
    cells = np.rint(colors / CELL).astype(np.intp) - LOWEST
    keys = (cells[:, 0] * CELLS + cells[:, 1]) * CELLS + cells[:, 2]
    for _ in range(INKS):
        if len(colors) == 0:
            break
        fullest = int(np.bincount(keys).argmax())
        cell = np.array([fullest // CELLS**2, fullest // CELLS % CELLS, fullest % CELLS])
        start = (cell + LOWEST) * CELL
        ink = np.median(colors[color_distance(colors, start) < SAME_INK], axis=0)
        found.append(ink)
        left = color_distance(colors, ink) >= SAME_INK
        if left.all():
            break
        colors, keys = colors[left], keys[left]
    return found


def _keep_elongated(thin: BoolArray) -> BoolArray:
    """Keep pieces that are far longer than wide: spots, eyes and buttons are paint."""
    labels, count = ndimage.label(thin, np.ones((3, 3)))
    if count == 0:
        return thin
    depth = ndimage.distance_transform_edt(thin)
    area = np.bincount(labels.ravel(), minlength=count + 1)
    deepest = ndimage.maximum(depth, labels, np.arange(count + 1))
    keep = area > 5.0 * (2.0 * np.asarray(deepest) - 1.0) ** 2
    keep[0] = False
    return np.asarray(keep[labels])


def color_distance(lab: Lab, to: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return the OKLab distance of colors (..., 3) from one color."""
    away = lab - np.asarray(to, np.float32)
    distance: NDArray[np.float32] = np.sqrt(np.einsum("...c,...c", away, away))
    return distance

"""Random ink: which pixels of a shape its outline, the lines on it and marks hide."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt, label

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array

WIDTHS = (0.6, 3.2)
"""Pixels of the square that an outline hides, with what is mixed with it: thin ones as often as wide ones."""

KEPT = 0.8
"""Share of the parts of contours and edges that are drawn, in a drawing that has such lines."""

SHARPEST = 0.6
"""Cosine of the turn between neighbors from which on an edge may be drawn as a line."""

LINES = (0.85, 0.3, 0.5)
"""Shares of the drawings that have lines along contours, lines along sharp edges, and marks that follow nothing."""

MOST = 0.3
"""Share of the object that ink hides at most: what is hardly wider than its lines stays without."""


def random_ink(mask: BoolArray, contours: BoolArray, normals: Array, rng: np.random.Generator) -> BoolArray:
    """
    Draw a shape in ink.

    Parameters
    ----------
    mask, contours : ndarray of bool, shape (S, S)
        The object, and where it ends in front of another part of itself.
    normals : ndarray, shape (S, S, 3)
        The truth, for its sharp edges.
    rng : Generator
        Source of every choice.

    Returns
    -------
    ndarray of bool, shape (S, S)
        Pixels whose paint the ink hides; none of an object that is hardly wider than its lines.
    """
    outline = np.exp(rng.uniform(*np.log(WIDTHS)))
    line = outline * rng.uniform(0.4, 1.1)
    ink = _away_from(~mask) <= outline
    lines = np.zeros_like(mask)
    along_contours, along_edges, marked = rng.random(3) < LINES
    if along_contours:
        lines |= _some_parts(contours, rng)
    if along_edges:
        lines |= _some_parts(_sharp_edges(mask, normals), rng)
    if marked:
        lines |= _marks(mask, rng)
    if lines.any():
        ink |= distance_transform_edt(~lines) <= line / 2
    ink &= mask
    return ink if ink.sum() <= MOST * mask.sum() else np.zeros_like(mask)


def remove_ink(values: Array, ink: BoolArray, mask: BoolArray) -> Array:
    """Return values (S, S) with those under the ink replaced by the nearest that show."""
    if not ink.any():
        return values
    nearest = distance_transform_edt(ink | ~mask, return_distances=False, return_indices=True)
    return np.where(ink, values[tuple(nearest)], values)


def _away_from(outside: BoolArray) -> FloatArray:
    """Distance of each pixel's center from the edge of what is outside, as beyond the square all is."""
    distance: FloatArray = distance_transform_edt(np.pad(~outside, 1))[1:-1, 1:-1] - 0.5
    return distance


def _some_parts(places: BoolArray, rng: np.random.Generator) -> BoolArray:
    """Most connected parts of some pixels, but for specks."""
    parts, count = label(places, np.ones((3, 3)))
    sizes = np.bincount(parts.ravel(), minlength=count + 1)
    kept = (rng.random(count + 1) < KEPT) & (sizes > 3)
    kept[0] = False
    return np.asarray(kept[parts])


def _sharp_edges(mask: BoolArray, normals: Array) -> BoolArray:
    edges = np.zeros_like(mask)
    for here, there in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        turned = np.sum(normals[here] * normals[there], axis=-1) < SHARPEST
        edges[here] |= turned & mask[here] & mask[there]
    return edges


def _marks(mask: BoolArray, rng: np.random.Generator) -> BoolArray:
    """Draw a few spots and strokes anywhere on the object."""
    rows, columns = np.nonzero(mask)
    down, right = np.indices(mask.shape)
    marks = np.zeros_like(mask)
    for _ in range(rng.integers(1, 6)):
        which = rng.integers(len(rows))
        row, column = float(rows[which]), float(columns[which])
        if rng.random() < 0.5:
            size = rng.uniform(0.5, 3.0)
            marks |= (down - row) ** 2 + ((right - column) * rng.uniform(0.6, 1.6)) ** 2 <= size**2
            continue
        heading, bend = rng.uniform(0.0, 2 * np.pi), rng.normal(scale=0.06)
        for _ in range(rng.integers(4, 40)):
            place = round(row), round(column)
            if not (0 <= place[0] < len(mask) and 0 <= place[1] < len(mask) and mask[place]):
                break
            marks[place] = True
            row, column, heading = row + np.sin(heading), column + np.cos(heading), heading + bend
    return marks

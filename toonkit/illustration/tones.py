"""
Tones: the colors of a drawing's paint, and which of them touch.

A flat color is one tone. A gradient is a chain of tones that are just distinguishable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.illustration.filling import Labels
from toonkit.illustration.zones import Zones
from toonkit.model.oklab import Lab
from toonkit.model.whole_pixels import pixels_at

CELL = 0.015
"""Width of the histogram's cells, OKLab."""

RADIUS = 0.03
"""OKLab distance within which colors are one tone."""

FEWEST = 4
"""Fewest pixels of a tone."""

Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tones:
    """
    The colors of paint, darkest first.

    Attributes
    ----------
    labels : ndarray of int32, shape (h, w)
        Tone of each pixel of paint, -1 elsewhere.
    lab : ndarray, shape (n, 3)
        Their mean colors in OKLab.
    area : ndarray of int, shape (n,)
        Their areas, in pixels.
    contact : ndarray, shape (n, n)
        Number of pairs of neighboring pixels in the two tones; symmetric, zero on the diagonal.
    smooth : ndarray, shape (n, n)
        How many of these pairs lie within one zone, where paint changes smoothly.
    way : ndarray, shape (n, n, 2)
        Sum over these pairs of the unit steps, right and up, from the first tone to the second; antisymmetric. It is
        zero for a tone that another one encloses, and long if a straight terminator separates the two.
    perimeter : ndarray, shape (n,)
        Number of pairs of neighboring pixels of which one shows the tone and the other does not.
    """

    labels: Labels
    lab: FloatArray
    area: NDArray[np.intp]
    contact: Matrix
    smooth: Matrix
    way: FloatArray
    perimeter: FloatArray

    def area_by_material(self, materials: Labels) -> NDArray[np.intp]:
        """Return how many pixels of each material (h, w), -1 where there is none, show each tone, shape (m, n)."""
        shown = (materials >= 0) & (self.labels >= 0)
        number, count = len(self.area), int(materials.max()) + 1
        key = materials[shown].astype(np.intp) * number + self.labels[shown]
        return np.bincount(key, minlength=count * number).reshape(count, number)

    def only(self, which: NDArray[np.intp]) -> Tones:
        """Return some tones as if there were no others."""
        place = np.full(len(self.area) + 1, -1, np.int32)  # of -1, the last one, too
        place[which] = np.arange(len(which))
        both = np.ix_(which, which)
        return Tones(
            place[self.labels], self.lab[which], self.area[which], self.contact[both], self.smooth[both],
            self.way[both], self.perimeter[which],
        )  # fmt: skip


def find_tones(zones: Zones) -> Tones:
    """Find the tones of the paint that zones cover."""
    paint = zones.labels >= 0
    colors = pixels_at(zones.lab, paint)
    tone = _cluster(colors)
    count = int(tone.max()) + 1
    area = np.bincount(tone, minlength=count)
    means = (
        np.column_stack([np.bincount(tone, c.astype(np.float64), count) for c in colors.T]) / area[:, None]
    )
    order = np.lexsort((means[:, 2], means[:, 1], means[:, 0]))
    rank = np.argsort(order)
    labels = np.full(paint.shape, -1, np.int32)
    labels[paint] = rank[tone]
    return Tones(labels, means[order], area[order], *_contacts(labels, zones.labels, count))


def _cluster(colors: Lab) -> NDArray[np.intp]:
    """Assign each color (P, 3) to the nearest peak of the histogram of all."""
    cell = np.rint(colors / CELL).astype(np.int64)
    cell -= cell.min(axis=0)
    spans = cell.max(axis=0) + 1
    key = (cell[:, 0] * spans[1] + cell[:, 1]) * spans[2] + cell[:, 2]
    counts = np.bincount(key, minlength=int(np.prod(spans)))
    used = np.flatnonzero(counts)
    weight = counts[used].astype(np.float64)
    where = np.cumsum(counts > 0)[key] - 1
    sums = [np.bincount(where, c.astype(np.float64), len(used)) for c in colors.T]
    means = np.column_stack(sums) / weight[:, None]
    peaks = _peaks(means, weight)
    away = ((means[:, None] - peaks) ** 2).sum(axis=2)
    nearest: NDArray[np.intp] = np.unique(away.argmin(axis=1), return_inverse=True)[1][where]
    return nearest


def _peaks(colors: FloatArray, weight: FloatArray) -> FloatArray:
    """Take the heaviest color that is left, again and again, each with all within reach."""
    left = np.ones(len(colors), np.bool_)
    peaks: list[FloatArray] = []
    while left.any():
        heaviest = int(np.where(left, weight, -1.0).argmax())
        if peaks and weight[heaviest] < FEWEST and len(peaks) > 1:
            break
        near = left & (((colors - colors[heaviest]) ** 2).sum(axis=1) < RADIUS**2)
        if np.sum(weight[near]) >= FEWEST or not peaks:
            peaks.append(np.average(colors[near], axis=0, weights=weight[near]))
        left &= ~near
    return np.array(peaks)


def _contacts(labels: Labels, zones: Labels, count: int) -> tuple[Matrix, Matrix, FloatArray, FloatArray]:
    """Measure the contacts of tones: those of `Tones`, in its order."""
    both, same = np.zeros((2, count, count))
    way, perimeter = np.zeros((count, count, 2)), np.zeros(count)
    steps_of = ((labels[:, :-1], labels[:, 1:]), (labels[1:], labels[:-1]))
    same_zone = (zones[:, :-1] == zones[:, 1:], zones[1:] == zones[:-1])
    for axis, ((first, second), same_here) in enumerate(zip(steps_of, same_zone, strict=True)):
        edge = first != second
        for side in (first[edge], second[edge]):
            perimeter += np.bincount(side[side >= 0], minlength=count)
        differ = edge & (first >= 0) & (second >= 0)
        key = first[differ].astype(np.intp) * count + second[differ]
        steps = np.bincount(key, minlength=count * count).reshape(count, count)
        smooth = np.bincount(key[same_here[differ]], minlength=count * count).reshape(count, count)
        both += steps + steps.T
        same += smooth + smooth.T
        way[..., axis] = steps - steps.T
    return both, same, way, perimeter

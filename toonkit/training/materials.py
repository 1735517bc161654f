"""Random materials: which parts of a shape are painted with what, and what of its shading that leaves to be seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from toonkit._validation import BoolArray
from toonkit.estimation.convolution import Array
from toonkit.estimation.shading_ratio import LIT, relative_shade
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear
from toonkit.training.painting import RandomRamp, random_ramp, random_tones

MOST = 7
"""Materials of a drawing at most."""

FLAT = 0.3
"""Share of the materials that are painted in one tone."""

ALIKE, SCATTER = 0.7, 0.06
"""Share of the drawings whose materials change tone at the same illumination, and how far from it, standard deviation."""

PATTERNED = 0.2
"""Share of the drawings in which stripes or spots of another material cover one."""

SPLIT = 0.25
"""Share of the drawings in which the separate regions of a material are taken for materials of their own."""

LEAST_STEP = 0.02
"""Difference between the tones of a material from which on it shows shading."""


def random_labels(parts: NDArray[np.int8], rng: np.random.Generator) -> NDArray[np.intp]:
    """
    Paint each part of a shape with a material.

    Parameters
    ----------
    parts : ndarray of int8, shape (S, S)
        Number of the part that is seen, -1 beside the object.
    rng : Generator
        Source of every choice.

    Returns
    -------
    ndarray of int, shape (S, S)
        Number of the material, -1 beside the object.
    """
    mask = parts >= 0
    materials = rng.integers(rng.integers(2, MOST + 1), size=int(parts.max()) + 1)
    labels = np.where(mask, materials[parts], -1)
    if rng.random() < PATTERNED:
        covered = labels == rng.choice(labels[mask])
        labels[covered & _pattern(mask.shape, rng)] = MOST
    if rng.random() < SPLIT:
        labels = _split(labels)
    return labels


def paint_materials(
    labels: NDArray[np.intp], illumination: Array, rng: np.random.Generator
) -> tuple[Array, BoolArray]:
    """
    Paint materials, each by a ramp of its own, and see them as `toonkit.estimation.shading_ratio` does.

    Parameters
    ----------
    labels : ndarray of int, shape (S, S)
        Number of the material, -1 beside the object.
    illumination : ndarray, shape (S, S)
        L · N.
    rng : Generator
        Source of every choice.

    Returns
    -------
    tones : ndarray of float32, shape (S, S)
        Each color's tone relative to the brightest one of its material.
    told : ndarray of bool, shape (S, S)
        Where the paint shows shading: not on a material of which a single tone is seen.
    """
    common = random_ramp(rng) if rng.random() < ALIKE else None
    gray, told = np.full(labels.shape, LIT), np.zeros(labels.shape, np.bool_)
    for number in np.unique(labels[labels >= 0]):
        flat = rng.random() < FLAT
        ramp = random_ramp(rng) if common is None else _akin(common, rng)
        here = labels == number
        tones = ramp(illumination[here])
        if not flat and np.ptp(tones) >= LEAST_STEP:
            gray[here], told[here] = relative_shade(srgb_to_linear(tones)), True
    return np.asarray(linear_to_srgb(gray), np.float32), told


def _akin(ramp: RandomRamp, rng: np.random.Generator) -> RandomRamp:
    """Draw other tones that change where those of a ramp do, now and then fewer."""
    first = int(rng.integers(len(ramp.edges))) if rng.random() < 0.3 else 0
    edges = np.sort(ramp.edges[first:] + rng.normal(0.0, SCATTER, len(ramp.edges) - first))
    return RandomRamp(random_tones(rng, len(edges) + 1), edges, ramp.widths[first:])


def _pattern(shape: tuple[int, ...], rng: np.random.Generator) -> BoolArray:
    """Draw stripes or spots over a whole picture."""
    down, right = np.indices(shape)
    angle, period = rng.uniform(0.0, np.pi), rng.uniform(6.0, 30.0)
    along = (right * np.cos(angle) + down * np.sin(angle)) / period + rng.random()
    across = (down * np.cos(angle) - right * np.sin(angle)) / period + rng.random()
    if rng.random() < 0.5:
        return np.asarray(along % 1.0 < rng.uniform(0.3, 0.7))
    return np.asarray(np.hypot(along % 1.0 - 0.5, across % 1.0 - 0.5) < rng.uniform(0.2, 0.4))


def _split(labels: NDArray[np.intp]) -> NDArray[np.intp]:
    """Give each connected region of a material a number of its own."""
    regions, count = np.full(labels.shape, -1), 0
    for number in np.unique(labels[labels >= 0]):
        found, of_it = label(labels == number)
        regions = np.where(found > 0, found - 1 + count, regions)
        count += of_it
    return regions

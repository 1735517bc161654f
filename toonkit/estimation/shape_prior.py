"""
A learned correction of the normals, before the energy does its work.

A small convolutional network sees the drawing on squares of `SIZE` pixels, turned so that the light comes from the
right and scaled so that the object fills them: it works alike at any resolution and for any azimuth of the light. It was
trained by `python -m toonkit.training` on shapes and color maps of its own; `weights/shape_prior.json` says how. Another,
`weights/colored_shape_prior.json`, sees drawings in several materials: it learned what borders between them and flat paint
say of the shape, at the price of a few percent on drawings in one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.convolution import Array, Weights, field
from toonkit.estimation.islands import join_vectors
from toonkit.estimation.overview import Overview
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.tone_ranks import ToneRanks
from toonkit.estimation.weights import read_weights
from toonkit.estimation.working_square import SIZE, WorkingSquare
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.numerics.parallel import run_each
from toonkit.numerics.unit_vectors import unit_vectors

SQUARES = ((1.0, True), (1.045, False))
"""Squares on which the network is asked: how much wider than the object needs, the first one not at all, and whether
mirrored across the light. The mean of two hangs less on where the pixels of a square happen to lie; on two cores they take
as long as one."""

FINER = 2
"""How much finer than those squares the one is on which the answers meet."""

CHANNELS = 12
"""Feature maps of `features` of a drawing in one material; there is one more if there are several."""

DAMPING = 0.25
"""Doubt about the light, radians, at which the network is told exp(-1) of its sine and cosine."""

KEPT_ISLANDS = 16
"""Answers are kept for a drawing of at most this many islands: each takes a megabyte."""

NEGLIGIBLE = 0.005
"""Illumination by which normals may miss what the colors allow, root mean square, and still be taken for right."""


def correct_shape(
    drawing: ToonImage | PreparedDrawing, light: FloatArray, initial_normals: NormalField
) -> NormalField:
    """
    Correct initial normals by what the network has learned of shapes.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    initial_normals : NormalField
        N0.

    Returns
    -------
    NormalField
        Corrected normals on the same mask. Each island is seen by itself.
    """
    drawing = prepare(drawing)
    pose, asked = drawing.posed(light), light.tobytes()
    is_known = initial_normals is drawing.inflated_normals
    changes = pose.learned.get(asked) if is_known else None
    if changes is None:
        colored = len(drawing.painted_materials) > 1
        changes = tuple(
            _change(pose.overview(number, initial_normals), island.turn.vectors(light), colored=colored)
            for number, island in enumerate(pose.islands)
        )
        if is_known and len(changes) <= KEPT_ISLANDS:
            pose.learned.clear()
            pose.learned[asked] = changes
    corrected = []
    for number, (island, change) in enumerate(zip(pose.islands, changes, strict=True)):
        reduced = pose.reduced_paint[number]
        square = WorkingSquare.around(reduced.grid, island.turn.vectors(light)[:2])
        spread = square.enlarged(reduced.factor).spread(square.turned_back(change), island.grid)
        corrected.append(_add_and_normalize(island.own_vectors(initial_normals.compact), spread))
    return NormalField.of_pixels(join_vectors(pose.islands, corrected), initial_normals.mask)


def _change(overview: Overview, light: FloatArray, *, colored: bool) -> FloatArray:
    """Return the change of N0 that the network asks for under a light, on the island's square, `FINER` times as fine."""
    square = WorkingSquare.around(overview.grid, light[:2])
    views = [
        _View.of(overview, light, square, colored=colored, wider=wider, mirrored=mirrored)
        for wider, mirrored in SQUARES
    ]
    answers = run_each([view.answer_on_the_finer_square for view in views])
    return np.asarray(np.mean(answers, axis=0) * views[0].need())


def misfit(
    drawing: ToonImage | PreparedDrawing, lights: FloatArray, initial_normals: NormalField
) -> FloatArray:
    """
    Tell how badly the shape that the network sees under each light explains the picture: the lower, the likelier the light.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing.
    lights : ndarray, shape (n, 3)
        Unit vectors from the surface to lights that may be the drawing's.
    initial_normals : NormalField
        N0.

    Returns
    -------
    ndarray, shape (n,)
        On normals corrected as the network answers, the mean square by which the illumination misses the intervals that
        rank matching gives the colors, relative to the illumination's variance; 1 if there is nothing to be seen. Of
        several islands the mean by area.
    """
    drawing = prepare(drawing)
    colored = len(drawing.painted_materials) > 1
    pose = drawing.posed()
    islands = [pose.islands[k] for k in drawing.telling_islands]
    overviews = [pose.overview(k, initial_normals) for k in drawing.telling_islands]

    def missed(overview: Overview, light: FloatArray) -> float:
        view = _View.of(overview, light, WorkingSquare.around(overview.grid, light[:2]), colored=colored)
        if not view.seen_mask.any():
            return 1.0
        seen = view.features(completed(view.initial + view.answer()))
        return _missed(seen) / max(float(np.var(seen[4][view.seen_mask])), 1e-12)

    each = run_each(
        [
            partial(missed, overview, light)
            for island, overview in zip(islands, overviews, strict=True)
            for light in island.turn.vectors(lights)
        ]
    )
    areas = [island.grid.size for island in islands]
    return np.average(np.reshape(each, (len(overviews), len(lights))), axis=0, weights=areas)


@dataclass(frozen=True, eq=False)
class _View:
    """
    A picture on a square, as the network sees it.

    Attributes
    ----------
    seen_mask, ink, tones, initial : ndarray, shape (SIZE, SIZE) or (SIZE, SIZE, 3)
        What is there; N0 in the square's axes.
    borders : ndarray of bool, shape (SIZE, SIZE), or None
        Where materials meet; None of a drawing in one material.
    elevation : float
        Of the light, radians.
    wider : float
        How much wider than the object needs the square is.
    mirrored : bool
        Whether the network sees the picture mirrored across the light.
    """

    seen_mask: BoolArray
    ink: BoolArray
    tones: Array
    initial: Array
    borders: BoolArray | None
    elevation: float
    wider: float
    mirrored: bool

    @classmethod
    def of(
        cls,
        overview: Overview,
        light: FloatArray,
        square: WorkingSquare,
        *,
        colored: bool,
        wider: float = 1.0,
        mirrored: bool = False,
    ) -> _View:
        """Sample a drawing's tones and N0 on the object's square, or on a wider one."""
        seen = overview.seen_from(square.widened(wider))
        elevation = float(np.arctan2(light[2], np.hypot(*light[:2])))
        borders = material_borders(seen.labels, seen.mask) if colored else None
        initial = square.turned(seen.initial)
        return cls(seen.mask, seen.ink, seen.tones, initial, borders, elevation, wider, mirrored)

    def features(self, normals: NDArray[Any]) -> Array:
        """Return the features, given normals."""
        return features(self.tones, self.seen_mask, self.ink, self.borders, normals, self.elevation)

    @cached_property
    def seen(self) -> Array:
        """The features of N0."""
        return self.features(self.initial)

    def need(self) -> float:
        """Return how much of a change is called for, 0 to 1: none if N0 explains the picture, or nothing is to be seen."""
        if not self.seen_mask.any():  # a line thinner than the square's pixels
            return 0.0
        missed = _missed(self.seen)
        return missed / (missed + NEGLIGIBLE**2)

    def answer(self) -> Array:
        """Return the change of N0, (SIZE, SIZE, 3), that the network asks for; beside the object as at its nearest pixel."""
        if not self.seen_mask.any():
            return np.zeros_like(self.initial)
        weights = read_weights("shape_prior" if self.borders is None else "colored_shape_prior")
        change = _answer(weights, self.seen, mirrored=self.mirrored)
        change = completed(self.initial + change) - self.initial
        nearest = distance_transform_edt(~self.seen_mask, return_distances=False, return_indices=True)
        return np.asarray(change[tuple(nearest)])

    def answer_on_the_finer_square(self) -> FloatArray:
        """Return the answer on the object's square, `FINER` times as fine."""
        return _resampled(self.answer(), self.wider, FINER * SIZE)


def _add_and_normalize(field: FloatArray, step: FloatArray) -> FloatArray:
    """Return the unit vectors (P, 3) of a field plus a step, z >= 0; one that vanishes becomes (0, 0, 1)."""
    changed: FloatArray = field + step
    np.maximum(changed[:, 2], 0.0, out=changed[:, 2])
    changed[~changed.any(axis=1), 2] = 1.0
    return unit_vectors(changed)


def _resampled(field: NDArray[Any], wider: float, size: int) -> FloatArray:
    """Interpolate a field (n, n, C) linearly at the pixels of another square with `size` a side, so many times less wide."""
    count = len(field)
    places = (np.arange(size) - (size - 1) / 2) * (count / (wider * size)) + (count - 1) / 2
    weights = np.maximum(1.0 - np.abs(np.clip(places, 0, count - 1)[:, None] - np.arange(count)), 0.0)
    return np.stack([weights @ part @ weights.T for part in np.moveaxis(field, -1, 0)], axis=-1)


def features(
    tones: Array,
    mask: BoolArray,
    ink: BoolArray,
    borders: BoolArray | None,
    normals: NDArray[Any],
    elevation: float,
    doubt: float = 0.0,
) -> Array:
    """
    Describe a drawing to the network.

    Parameters
    ----------
    tones : ndarray, shape (SIZE, SIZE)
        Tones in [0, 1] of the painted colors.
    mask, ink : ndarray of bool, shape (SIZE, SIZE)
        The object, and where its paint shows no shading.
    borders : ndarray of bool, shape (SIZE, SIZE), or None
        Where one material meets another; None of a drawing in one material.
    normals : ndarray, shape (SIZE, SIZE, 3)
        N0 when the network is asked, or what it made of it; the light's azimuth is zero.
    elevation : float
        Of the light, radians.
    doubt : float, optional
        How far the true light may be from this one: standard deviation about each of two axes, radians. It is given only in
        training, so that the network does not trust a light blindly. Giving it the uncertainty of an estimate did not help.

    Returns
    -------
    ndarray of float32, shape (CHANNELS, SIZE, SIZE), or one map more
        Mask, normals, illumination, the interval of illumination that rank matching on these normals gives each color
        (Figure 4), tone, rank, the light's sine and cosine, damped by exp(-doubt / DAMPING), ink and, if there are
        any, borders; zero beside the object.
    """
    sine, cosine = np.sin(elevation), np.cos(elevation)
    shining = cosine * normals[..., 0] + sine * normals[..., 2]
    ranks = ToneRanks.of(tones[mask])
    ordered = np.sort(shining[mask])
    seen = np.zeros((CHANNELS + (borders is not None), *mask.shape), np.float32)
    seen[0] = mask
    seen[1:4] = np.moveaxis(normals, -1, 0)
    seen[4] = shining
    seen[5][mask] = ordered[ranks.below]
    seen[6][mask] = ordered[ranks.upto - 1]
    seen[7][mask] = ranks.tone
    seen[8][mask] = ranks.rank
    told = np.exp(-doubt / DAMPING)
    seen[9], seen[10] = told * sine, told * cosine
    seen[11] = ink
    if borders is not None:
        seen[12] = borders
    seen *= mask
    return seen


def material_borders(labels: NDArray[Any], mask: BoolArray) -> BoolArray:
    """Tell which pixels of an object have a neighbor to the right or below that is painted with another material."""
    borders = np.zeros(mask.shape, np.bool_)
    borders[:-1] |= (labels[:-1] != labels[1:]) & mask[1:]
    borders[:, :-1] |= (labels[:, :-1] != labels[:, 1:]) & mask[:, 1:]
    return borders & mask


def _answer(weights: Weights, seen: Array, *, mirrored: bool) -> Array:
    """Return the change of the normals, shape (SIZE, SIZE, 3), asked of the drawing or of its mirror image."""
    if not mirrored:
        return np.moveaxis(field(weights, seen), 0, -1)
    reflected = seen[:, ::-1].copy()
    reflected[2] *= -1  # y of the normals
    change = field(weights, reflected)[:, ::-1].copy()
    change[1] *= -1
    return np.moveaxis(change, 0, -1)


def _missed(seen: Array) -> float:
    """Return the mean square by which the normals in the features miss what rank matching allows the colors."""
    on_object = seen[0] > 0
    shining, lower, upper = (seen[k][on_object] for k in (4, 5, 6))
    return float(np.mean((shining - np.clip(shining, lower, upper)) ** 2))


def completed(vectors: NDArray[Any]) -> NDArray[Any]:
    """Turn vectors (..., 3) into unit normals that do not look away from the viewer."""
    facing = vectors.copy()
    facing[..., 2] = np.maximum(facing[..., 2], 0.0)
    length = np.linalg.norm(facing, axis=-1, keepdims=True)
    return np.asarray(facing / np.maximum(length, 1e-9))

"""
A learned correction of the normals, before the energy does its work.

A small convolutional network sees the drawing on squares of `SIZE` pixels, turned so that the light comes from the
right and scaled so that the object fills them: it works alike at any resolution and for any azimuth of the light. It was
trained by `python -m toonkit.training` on shapes and color maps of its own; `weights/shape_prior.json` says how.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.color_map_fit import plain_tones
from toonkit.estimation.convolution import Array, Weights, field
from toonkit.estimation.tone_ranks import ToneRanks
from toonkit.estimation.weights import read_weights
from toonkit.estimation.working_square import WorkingSquare
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField

LOOKS = 2
"""Times the network is asked: the second time it sees what its first answer makes of the colors."""

VIEWS = ((1.0, False), (1.03, True), (1.06, False), (1.09, True))
"""Squares on which it is asked: how much wider than the object needs, and whether mirrored across the light. The mean of the
answers hangs less on where a square's pixels happen to lie."""

CHANNELS = 14
"""Feature maps of `features`."""

NEGLIGIBLE = 0.005
"""Illumination by which normals may miss what the colors allow, root mean square, and still be taken for right."""


def correct_shape(
    image: ToonImage, light: FloatArray, initial_normals: NormalField, *, looks: int = LOOKS
) -> NormalField:
    """
    Correct initial normals by what the network has learned of shapes.

    Parameters
    ----------
    image : ToonImage
        The picture.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    initial_normals : NormalField
        N0.
    looks : int, optional
        Times the network is asked.

    Returns
    -------
    NormalField
        Corrected normals on the same mask.
    """
    tones = np.nan_to_num(plain_tones(image))
    changes = [
        _seen_change(image.mask, tones, light, initial_normals, widened, mirrored=mirrored, looks=looks)
        for widened, mirrored in VIEWS
    ]
    vectors = np.full((*image.mask.shape, 3), np.nan)
    vectors[image.mask] = completed(initial_normals.vectors[image.mask] + np.mean(changes, axis=0))
    return NormalField(vectors, image.mask)


def _seen_change(
    mask: BoolArray,
    tones: FloatArray,
    light: FloatArray,
    initial_normals: NormalField,
    widened: float,
    *,
    mirrored: bool,
    looks: int,
) -> FloatArray:
    """Return the change of the object's normals, shape (P, 3), that the network asks for on one square."""
    square = WorkingSquare.around(mask, light[:2]).widened(widened)
    seen_mask = square.sampled(mask)
    if not seen_mask.any():  # a line thinner than the square's pixels
        return np.zeros((int(mask.sum()), 3))
    seen_tones = square.sampled(tones)
    initial = square.turned(square.sampled(np.nan_to_num(initial_normals.vectors)))
    elevation = float(np.arctan2(light[2], np.hypot(light[0], light[1])))
    weights = read_weights("shape_prior")
    normals = initial
    seen = features(seen_tones, seen_mask, normals, initial, elevation)
    need = _need(seen)
    for look in range(looks):
        if look:
            seen = features(seen_tones, seen_mask, normals, initial, elevation)
        normals = completed(normals + _answer(weights, seen, mirrored=mirrored)) * seen_mask[..., None]
    change = need * square.turned_back(normals - initial)
    nearest = distance_transform_edt(~seen_mask, return_distances=False, return_indices=True)
    return square.spread(change[tuple(nearest)], mask)


def features(
    tones: Array, mask: BoolArray, normals: Array, initial_normals: Array, elevation: float
) -> Array:
    """
    Describe a drawing to the network.

    Parameters
    ----------
    tones : ndarray, shape (SIZE, SIZE)
        Tones in [0, 1] of the painted colors.
    mask : ndarray of bool, shape (SIZE, SIZE)
        The object.
    normals, initial_normals : ndarray, shape (SIZE, SIZE, 3)
        Normals as far as they are known, and N0; the light's azimuth is zero.
    elevation : float
        Of the light, radians.

    Returns
    -------
    ndarray of float32, shape (CHANNELS, SIZE, SIZE)
        Mask, normals, N0, illumination, the interval of illumination that rank matching on these normals gives each
        color (Figure 4), tone, rank, and the light's sine and cosine; zero beside the object.
    """
    sine, cosine = np.sin(elevation), np.cos(elevation)
    shining = cosine * normals[..., 0] + sine * normals[..., 2]
    ranks = ToneRanks.of(tones[mask])
    ordered = np.sort(shining[mask])
    seen = np.zeros((CHANNELS, *mask.shape), np.float32)
    seen[0] = mask
    seen[1:4] = np.moveaxis(normals, -1, 0)
    seen[4:7] = np.moveaxis(initial_normals, -1, 0)
    seen[7] = shining
    seen[8][mask] = ordered[ranks.below]
    seen[9][mask] = ordered[ranks.upto - 1]
    seen[10][mask] = ranks.tone
    seen[11][mask] = ranks.rank
    seen[12], seen[13] = sine, cosine
    seen *= mask
    return seen


def _answer(weights: Weights, seen: Array, *, mirrored: bool) -> Array:
    """Return the change of the normals, shape (SIZE, SIZE, 3), asked of the drawing or of its mirror image."""
    if not mirrored:
        return np.moveaxis(field(weights, seen), 0, -1)
    reflected = seen[:, ::-1].copy()
    reflected[[2, 5]] *= -1  # y of the normals
    change = field(weights, reflected)[:, ::-1].copy()
    change[1] *= -1
    return np.moveaxis(change, 0, -1)


def _need(seen: Array) -> float:
    """Return the share of a correction that the normals in the features need: none if they explain the picture."""
    on_object = seen[0] > 0
    shining, lower, upper = (seen[k][on_object] for k in (7, 8, 9))
    missed = float(np.mean((shining - np.clip(shining, lower, upper)) ** 2))
    return missed / (missed + NEGLIGIBLE**2)


def completed(vectors: NDArray[Any]) -> NDArray[Any]:
    """Turn vectors (..., 3) into unit normals that do not look away from the viewer."""
    facing = vectors.copy()
    facing[..., 2] = np.maximum(facing[..., 2], 0.0)
    length = np.linalg.norm(facing, axis=-1, keepdims=True)
    return np.asarray(facing / np.maximum(length, 1e-9))

"""
Normals with a person's corrections, from which the refinement starts.

The refinement measures the change of the normals from those that are made here, and is held to them where a person has
corrected something. So a correction is a soft constraint: in the middle of a part, missing it by some angle costs `HOLD`
times as much as missing the illumination that the painted color allows by the same amount.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import MIN_OBJECT_PIXELS, BoolArray, FloatArray
from toonkit.model.shape_corrections import NormalHint, ShapeCorrections
from toonkit.numerics.masked_grid import OUTSIDE, STEPS, Box, MaskedGrid
from toonkit.numerics.screened_poisson import ScreenedPoisson, solve_screened_poisson, uniform_edge_weights

HOLD = 2.0
"""How firmly a correction holds, relative to a painted color."""

STEEPEST = 0.8
"""Sine of the steepest tilt that a bulge adds, 53 degrees."""

FEATHER = 0.25
"""Share of the half width of a flat part over which it blends into its surroundings."""

FRONT_POWER = 2
"""How quickly a part in front turns away toward its border: the power of the relative distance from its middle."""

TOLERANCE = 1e-3
"""Relative residual at which the solution of a part's Poisson equation is accurate enough."""

EIGHT = np.ones((3, 3), np.bool_)
"""Structuring element for which pixels that touch at a corner belong to one part."""


@dataclass(frozen=True, eq=False)
class CorrectedNormals:
    """
    Normals that a person has corrected.

    Attributes
    ----------
    vectors : ndarray, shape (P, 3)
        Unit normals.
    hold : ndarray, shape (P,)
        How firmly each is held, relative to the weight of a painted color, 0 to `HOLD`; 0 where nothing is corrected.
    """

    vectors: FloatArray
    hold: FloatArray


def correct_normals(
    corrections: ShapeCorrections, grid: MaskedGrid, box: Box, vectors: FloatArray
) -> CorrectedNormals:
    """
    Give normals the properties that a person has asked for.

    Parameters
    ----------
    corrections : ShapeCorrections
        What is asked for, restricted to the object's pixels: see `ShapeCorrections.on`.
    grid : MaskedGrid
        The object on its bounding box.
    box : (slice, slice)
        Rows and columns of that box in the picture.
    vectors : ndarray, shape (P, 3)
        Unit normals of the object's pixels.

    Returns
    -------
    CorrectedNormals
        First the parts are corrected: those in front, then those that bulge, then those that are flat. Then each hint turns
        the normals around its point.
    """
    field, hold = grid.scatter(vectors, 0.0), np.zeros(grid.mask.shape)
    for name, correct in (("in_front", _turn_away), ("bulge", _bulge), ("flat", _flatten)):
        region = getattr(corrections, name)
        if region is not None:
            for part in _parts(region[box], grid.mask):
                correct(part, field, hold)
    rows, columns = box
    for hint in corrections.normals:
        _turn_at(hint, (hint.row - rows.start, hint.column - columns.start), grid.mask, field, hold)
    return CorrectedNormals(grid.gather(field), HOLD * grid.gather(hold))


@dataclass(frozen=True, eq=False)
class _Part:
    """
    A connected part of a region, on its bounding box and a margin of one pixel, as far as the object's box reaches.

    Attributes
    ----------
    box : (slice, slice)
        Rows and columns of that area in the object's box.
    grid : MaskedGrid
        The part's pixels.
    on_object : ndarray of bool, shape (h, w)
        The object's pixels in that area.
    """

    box: Box
    grid: MaskedGrid
    on_object: BoolArray

    def system(self) -> ScreenedPoisson:
        """Return the Poisson equation of the part, whose values beside the part are given."""
        beside = np.count_nonzero(self.grid.neighbors == OUTSIDE, axis=1)
        return ScreenedPoisson(self.grid, uniform_edge_weights(self.grid), beside.astype(np.float64))

    def dome(self) -> NDArray[np.complex128]:
        """
        Return the direction, x + i y, in which the part's surface would fall off if it were a dome, shape (p,).

        The length of that number grows from 0 in the middle of the part to 1 at its border, however wide the part is there.

        Notes
        -----
        With phi = 0 at the border and a Laplacian of -1, |∇phi| / sqrt(|∇phi|² + 2 phi) is exactly the relative
        distance from the middle in a strip, and approximately so elsewhere.
        """
        height, _ = solve_screened_poisson(self.system(), np.ones(self.grid.size), tolerance=TOLERANCE)
        height = np.maximum(height, 0.0)
        framed = np.pad(self.grid.scatter(height, 0.0), 1)
        x = self.grid.gather(framed[1:-1, :-2] - framed[1:-1, 2:]) / 2
        y = self.grid.gather(framed[2:, 1:-1] - framed[:-2, 1:-1]) / 2
        fall: NDArray[np.complex128] = x + 1j * y
        fall /= np.sqrt(np.abs(fall) ** 2 + 2 * height + 1e-12)
        return fall

    def bridged(self, field: FloatArray) -> FloatArray:
        """Return the smoothest normals (p, 3) that continue those around the part, and its own at the object's outline."""
        system, own = self.system(), self.grid.gather(field)
        framed = np.pad(field[..., 0] + 1j * field[..., 1], 1)
        counts = np.pad(self.on_object, 1)
        pull = np.zeros(self.grid.size, np.complex128)
        for direction, (down, along) in enumerate(STEPS):
            place = self.grid.rows + 1 + down, self.grid.columns + 1 + along
            beyond = np.where(counts[place], framed[place], own[:, 0] + 1j * own[:, 1])
            pull += np.where(self.grid.neighbors[:, direction] == OUTSIDE, beyond, 0.0)
        sideways, _ = solve_screened_poisson(system, pull, tolerance=TOLERANCE)
        return _facing(sideways)

    def feather(self) -> FloatArray:
        """Return a weight (p,) that rises from 0 at the border with the rest of the object to 1."""
        inside = self.grid.mask | ~self.on_object
        if inside.all():
            return np.ones(self.grid.size)
        depth = self.grid.gather(ndimage.distance_transform_edt(inside))
        share = np.clip(depth / (FEATHER * depth.max() + 1.0), 0.0, 1.0)
        smooth: FloatArray = share * share * (3.0 - 2.0 * share)
        return smooth

    def put(self, vectors: FloatArray, firmness: FloatArray, field: FloatArray, hold: FloatArray) -> None:
        """Write normals (p, 3), scaled to unit length, and how firmly they hold (p,), to the fields of the object's box."""
        mask = self.grid.mask
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        vectors = np.where(length > 1e-9, vectors / np.maximum(length, 1e-9), (0.0, 0.0, 1.0))
        field[self.box][mask] = vectors
        hold[self.box][mask] = np.maximum(hold[self.box][mask], firmness)


def _parts(region: BoolArray, on_object: BoolArray) -> list[_Part]:
    """Cut a region into connected parts; parts of fewer than `MIN_OBJECT_PIXELS` pixels are ignored."""
    numbers, _ = ndimage.label(region, EIGHT)
    parts = []
    for number, found in enumerate(ndimage.find_objects(numbers), 1):
        box = tuple(
            slice(max(side.start - 1, 0), min(side.stop + 1, length))
            for side, length in zip(found, region.shape, strict=True)
        )
        grid = MaskedGrid(numbers[box] == number)
        if grid.size >= MIN_OBJECT_PIXELS:
            parts.append(_Part((box[0], box[1]), grid, on_object[box]))
    return parts


def _turn_away(part: _Part, field: FloatArray, hold: FloatArray) -> None:
    """Let a part end like an object of its own: toward its border its normals turn outward."""
    own, dome = part.grid.gather(field[part.box]), part.dome()
    share = np.abs(dome) ** FRONT_POWER
    sideways = (1 - share) * (own[:, 0] + 1j * own[:, 1]) + share * dome
    part.put(_facing(sideways), share, field, hold)


def _bulge(part: _Part, field: FloatArray, hold: FloatArray) -> None:
    """Replace a part by a smooth bump on its surroundings: level at its border and in its middle, steepest in between."""
    dome, base = part.dome(), part.bridged(field[part.box])
    tilt = (
        STEEPEST * dome * (1 - np.abs(dome) ** 4) * 5**1.25 / 4
    )  # the most that t (1 - t⁴) can be is 4 / 5^(5/4)
    slope = base[:, 2] * tilt / np.sqrt(1 - np.minimum(np.abs(tilt), STEEPEST) ** 2)
    bumped = base + np.stack([slope.real, slope.imag, np.zeros(len(slope))], axis=1)
    part.put(bumped, np.ones(len(slope)), field, hold)


def _flatten(part: _Part, field: FloatArray, hold: FloatArray) -> None:
    """Give a part its mean direction, with soft borders to the rest of the object."""
    own, feather = part.grid.gather(field[part.box]), part.feather()
    mean = own.mean(axis=0)
    mean /= max(float(np.linalg.norm(mean)), 1e-9)
    part.put(own + feather[:, None] * (mean - own), feather, field, hold)


def _turn_at(
    hint: NormalHint, place: tuple[int, int], on_object: BoolArray, field: FloatArray, hold: FloatArray
) -> None:
    """Turn the normal at a point as a hint says, and those around it about the same axis, less with distance."""
    reach = int(np.ceil(hint.radius))
    box = tuple(
        slice(max(at - reach, 0), min(at + reach + 1, length))
        for at, length in zip(place, on_object.shape, strict=True)
    )
    rows, columns = np.ogrid[box]
    far = np.hypot(rows - place[0], columns - place[1]) / hint.radius
    numbers, _ = ndimage.label(on_object[box] & (far < 1), EIGHT)
    near = numbers == numbers[place[0] - box[0].start, place[1] - box[1].start]  # not across a gap
    share = (1 - far[near] ** 2) ** 2
    field[box][near] = _rotated(field[box][near], field[place].copy(), np.array(hint.normal), share)
    hold[box][near] = np.maximum(hold[box][near], share)


def _rotated(vectors: FloatArray, before: FloatArray, after: FloatArray, share: FloatArray) -> FloatArray:
    """Rotate vectors (n, 3) by shares (n,) of the rotation that takes one normal to another, kept at z >= 0."""
    axis = np.cross(before, after)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return vectors
    axis /= sine
    angle = share[:, None] * np.arctan2(sine, float(before @ after))
    along = (vectors @ axis)[:, None] * axis
    turned = along + np.cos(angle) * (vectors - along) + np.sin(angle) * np.cross(axis, vectors)
    turned[:, 2] = np.maximum(turned[:, 2], 0.0)
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.where(length > 1e-9, turned / np.maximum(length, 1e-9), vectors)


def _facing(sideways: NDArray[np.complex128]) -> FloatArray:
    """Return the unit normals (p, 3), z >= 0, with these nx + i ny."""
    flat = sideways / np.maximum(np.abs(sideways), 1.0)
    up = np.sqrt(np.maximum(1 - np.abs(flat) ** 2, 0.0))
    return np.stack([flat.real, flat.imag, up], axis=1)

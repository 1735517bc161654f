"""Pictures of solids: exact normals, coverage, depth and parts, seen along -z without perspective."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray, refuse
from toonkit.model.normals import NormalField
from toonkit.study.registry import BOUND, Shape, View
from toonkit.study.solids.sphere_tracing import DistanceSolid

if TYPE_CHECKING:
    import trimesh

MARGIN = 0.06
"""Free share of the picture's width (or height) on each side of the silhouette's longer extent."""

MIN_SIZE = 16
"""Smallest size of a picture, in pixels. In smaller ones, parts of the solids fall between two rays."""

SUBPIXELS = 4
"""Rays along each side of a pixel on the outline. Coverage has steps of one sixteenth."""

_FRAMING_RAYS = 64  # along each side of the square in which the silhouette is looked for
_FRAMING_ROUNDS = 5  # each measures its extent four times finer: to 0.00003 in the end
_SIDES = ((0, 1), (0, -1), (1, 1), (1, -1))  # axis, and 1 for its low end, -1 for its high end
_ALL_AROUND = range(0, 360, 45)  # yaws from which a turning shape is framed
_JUST_NOT_HALF = 0.5 - 1e-6


@dataclass(frozen=True, eq=False)
class RenderedShape:
    """
    A rendered solid, pixel by pixel.

    Attributes
    ----------
    normals : NormalField
        Unit normals; its mask is True where the ray through the pixel's center meets the solid.
    coverage : ndarray, shape (H, W)
        Share of the pixel that the solid covers, 0 to 1; at least one half exactly on the mask.
    depth : ndarray, shape (H, W)
        z toward the viewer in pixels, zero at the solid's origin; NaN outside the mask.
    part : ndarray of int, shape (H, W)
        Index of the material; -1 outside the mask.
    """

    normals: NormalField
    coverage: FloatArray
    depth: FloatArray
    part: NDArray[np.intp]

    @property
    def mask(self) -> BoolArray:
        """Where the solid is, shape (H, W)."""
        return self.normals.mask


class _Solid(Protocol):
    """Something that rays along -z can meet."""

    def first_hit(self, x: FloatArray, y: FloatArray) -> FloatArray: ...

    def normals(self, points: FloatArray) -> FloatArray: ...

    def parts(self, points: FloatArray) -> NDArray[np.intp]: ...


@dataclass(frozen=True)
class _Frame:
    """The square that a picture shows: its center and its width in the solid's units."""

    x: float
    y: float
    width: float

    def at(self, row: FloatArray, column: FloatArray, size: int) -> tuple[FloatArray, FloatArray]:
        """Return x and y of places in the picture, where whole rows and columns are pixel centers."""
        pixel = self.width / size
        return self.x + (column - (size - 1) / 2) * pixel, self.y + ((size - 1) / 2 - row) * pixel


def render_shape(shape: Shape, size: int, *, view: View | None = None) -> RenderedShape:
    """
    Render a shape of the study, filling a square picture up to `MARGIN`, from its own view or another.

    Raises `ToonkitError` if the size, in pixels, is not a whole number of at least `MIN_SIZE`.

    Examples
    --------
    >>> from toonkit.study.shapes import SHAPES
    >>> ball = render_shape(SHAPES["sphere"], 33)
    >>> ball.normals.vectors[16, 16].round(6).tolist()
    [0.0, 0.0, 1.0]
    """
    size = _checked_size(size)
    seen = shape.view if view is None else view
    return _render(DistanceSolid(shape, seen.matrix()), _frame_of_shape(shape, seen), size)


def render_turns(shape: Shape, size: int, yaws: Sequence[float]) -> list[RenderedShape]:
    """
    Render a shape of the study turned about its upright axis, once for each yaw in degrees, with the axis in the middle.

    All pictures have the scale at which the shape fits from any side. Raises `ToonkitError` for a bad size.
    """
    size = _checked_size(size)
    seen = [_frame_of_shape(shape, View(yaw=yaw)) for yaw in _ALL_AROUND]
    across = max(2 * abs(frame.x) + frame.width for frame in seen)
    upright = float(np.mean([frame.y for frame in seen]))
    return [
        _render(DistanceSolid(shape, View(yaw=yaw).matrix()), _Frame(0.0, upright, across), size)
        for yaw in yaws
    ]


def render_mesh(
    mesh: trimesh.Trimesh, size: int, *, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0
) -> RenderedShape:
    """
    Render a triangle mesh, y up and its front toward +z, filling a square picture up to `MARGIN`.

    Edges sharper than `mesh_rays.SHARP_EDGE` stay sharp; elsewhere normals are interpolated between vertices. Raises
    `ToonkitError` for a bad size, a mesh without faces, or if embreex is not installed.
    """
    from toonkit.study.solids.mesh_rays import MeshSolid  # noqa: PLC0415  # needs optional packages

    size = _checked_size(size)
    if len(mesh.faces) == 0:
        raise refuse("mesh", "must have faces", "none")
    solid = MeshSolid(mesh, View(yaw, pitch, roll).matrix())
    return _render(solid, _frame_around(solid.vertices[:, :2]), size)


def _checked_size(size: int) -> int:
    if not isinstance(size, int | np.integer) or isinstance(size, bool) or size < MIN_SIZE:
        raise refuse("size", f"must be a whole number of pixels, at least {MIN_SIZE}", size)
    return int(size)


@lru_cache(maxsize=64)
def _frame_of_shape(shape: Shape, view: View) -> _Frame:
    """Measure a shape's silhouette, in a way that does not depend on the picture's size."""
    solid = DistanceSolid(shape, view.matrix())
    line, step = np.linspace(-BOUND, BOUND, _FRAMING_RAYS, retstep=True)
    lattice = _lattice(line, line)
    known = lattice[_is_hit(solid, lattice)]
    low, high = known.min(axis=0), known.max(axis=0)
    sides = [known[np.argmin(sign * known[:, axis])] for axis, sign in _SIDES]
    across = [np.arange(low[1 - axis] - step, high[1 - axis] + step, step / 4) for axis, _ in _SIDES]
    reach = step
    for _ in range(_FRAMING_ROUNDS):
        beyond = [_strip(side, across[i], float(step), *_SIDES[i]) for i, side in enumerate(sides)]
        hit = np.split(
            _is_hit(solid, np.concatenate(beyond)), np.cumsum([len(strip) for strip in beyond])[:-1]
        )
        for i, (axis, sign) in enumerate(_SIDES):
            found = np.concatenate([sides[i][None], beyond[i][hit[i]]])
            sides[i] = found[np.argmin(sign * found[:, axis])]
            # The height of a round tip falls with the square of the way across: that shrinks by the root.
            across[i] = sides[i][1 - axis] + reach * np.linspace(-1, 1, 33)
        step, reach = step / 4, reach / 2
    return _frame_around(np.array(sides))


def _strip(side: FloatArray, across: FloatArray, step: float, axis: int, sign: int) -> FloatArray:
    """Return places, shape (n, 2), farther out than the farthest known of a side, up to a step."""
    along = side[axis] - sign * step * np.arange(1, 9) / 8
    return _lattice(along, across) if axis == 0 else _lattice(across, along)


def _lattice(columns: FloatArray, rows: FloatArray) -> FloatArray:
    return np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)


def _is_hit(solid: _Solid, places: FloatArray) -> BoolArray:
    return np.asarray(np.isfinite(solid.first_hit(places[:, 0], places[:, 1])))


def _frame_around(places: FloatArray) -> _Frame:
    low, high = places.min(axis=0), places.max(axis=0)
    middle = (low + high) / 2
    return _Frame(float(middle[0]), float(middle[1]), float((high - low).max() / (1 - 2 * MARGIN)))


def _render(solid: _Solid, frame: _Frame, size: int) -> RenderedShape:
    row, column = (index.ravel().astype(np.float64) for index in np.mgrid[:size, :size])
    x, y = frame.at(row, column, size)
    z = solid.first_hit(x, y)
    hit = np.isfinite(z)
    points = np.column_stack([x, y, z])[hit]
    mask = hit.reshape(size, size)

    vectors = np.full((size * size, 3), np.nan)
    vectors[hit] = _facing(solid.normals(points))
    part = np.full(size * size, -1, dtype=np.intp)
    part[hit] = solid.parts(points)
    normals = NormalField(vectors.reshape(size, size, 3), mask)
    depth = (z * (size / frame.width)).reshape(size, size)
    return RenderedShape(normals, _coverage(solid, frame, mask), depth, part.reshape(size, size))


def _facing(normals: FloatArray) -> FloatArray:
    """Turn normals that point away (by rounding, at the outline or in a crease) into the picture plane."""
    normals = normals.copy()
    normals[:, 2] = np.maximum(normals[:, 2], 0.0)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals[length[:, 0] == 0] = (
        0.0,
        0.0,
        1.0,
    )  # seen from behind or in a narrow gap, where there is no direction
    return np.asarray(normals / np.where(length > 0, length, 1.0))


def _coverage(solid: _Solid, frame: _Frame, mask: BoolArray) -> FloatArray:
    """Count finer rays in the pixels on either side of the outline; the others are full or empty."""
    square = np.ones((3, 3), dtype=np.bool_)
    # Beyond the picture's edge is no outline: pad as if the mask went on.
    outline = ndimage.binary_dilation(mask, square) & ~ndimage.binary_erosion(mask, square, border_value=1)
    row, column = np.nonzero(outline)
    step = (np.arange(SUBPIXELS) + 0.5) / SUBPIXELS - 0.5
    down, right = (offset.ravel() for offset in np.meshgrid(step, step, indexing="ij"))
    x, y = frame.at(row[:, None] + down, column[:, None] + right, len(mask))
    hit = np.isfinite(solid.first_hit(x.ravel(), y.ravel())).reshape(x.shape)
    coverage = mask.astype(np.float64)
    share = hit.mean(axis=1)
    # The mask asks the pixel's center only; a thin part or a corner may disagree with the majority.
    coverage[outline] = np.where(mask[outline], np.maximum(share, 0.5), np.minimum(share, _JUST_NOT_HALF))
    return coverage

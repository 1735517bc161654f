"""From normals to a height, and from a height to a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from toonkit._validation import (
    BoolArray,
    FloatArray,
    as_array,
    as_mask,
    of_type,
    refuse,
    same_mask,
    same_shape,
)
from toonkit.model.description import describe_object
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import DOWN, LEFT, OUTSIDE, RIGHT, UP, MaskedGrid
from toonkit.numerics.report import SolverReport
from toonkit.numerics.screened_poisson import ScreenedPoisson, solve_screened_poisson, uniform_edge_weights

if TYPE_CHECKING:
    import trimesh

STEEPEST = 0.15
"""Least nz of a slope: at the silhouette the true height drops without bound, a picture's does not."""

BREAK_ANGLE = 50.0
"""Degrees between neighboring normals at which a link is half as stiff: beyond it, the two lie on different parts."""

AT_RIM = 1e4
"""Stiffness that ties the rim to given heights: no other pixel bends it by anything that could be seen."""

TIE = 1e-9
"""Stiffness that ties every pixel to height 0, so that each component has one solution; far too weak to bend it."""


@dataclass(frozen=True, eq=False)
class HeightField:
    """
    Height of the visible surface toward the viewer.

    Attributes
    ----------
    height : ndarray, shape (H, W)
        In pixels, NaN outside the mask; each component's lowest point is at 0.
    mask : ndarray, shape (H, W)
        True on the object.
    report : SolverReport
        How the integration went.

    Raises
    ------
    ToonkitError
        If height and mask differ in size, or the height is unknown on the mask.
    """

    height: FloatArray
    mask: BoolArray
    report: SolverReport

    def __post_init__(self) -> None:
        height, mask = as_array("height", self.height, (None, None)), as_mask("mask", self.mask)
        same_shape("height", height.shape, mask.shape, "the mask")
        if not np.isfinite(height[mask]).all():
            raise refuse("height", "must be known on the mask", "NaN or infinite values")
        of_type("report", self.report, SolverReport)
        object.__setattr__(self, "height", height)
        object.__setattr__(self, "mask", mask)

    def __repr__(self) -> str:
        return f"HeightField({describe_object(self.mask)}, 0 to {np.nanmax(self.height):.1f} pixels high)"


def height_map(normals: NormalField) -> HeightField:
    """
    Integrate normals to a height.

    Parameters
    ----------
    normals : NormalField
        Unit normals.

    Returns
    -------
    HeightField
        Height in pixels.

    Raises
    ------
    ToonkitError
        If the normals are not a `NormalField`.

    Notes
    -----
    Weighted least squares of the height differences between neighbors against the slopes -nx / nz and -ny / nz at their
    common side. A link counts less where its slopes are steep and known badly (weight nz²), and where the normals at its two
    ends turn against each other: there one part of the drawing ends in front of another, and the height may jump.
    """
    of_type("normals", normals, NormalField)
    grid = MaskedGrid(normals.mask)
    vectors = normals.compact
    forward = np.maximum(vectors[:, 2], STEEPEST)
    slopes = -vectors[:, :2] / forward[:, None]
    links = np.zeros((grid.size, 4), np.float32)
    flow = np.zeros((grid.size, 4))
    half = np.cos(np.deg2rad(BREAK_ANGLE))
    for direction, axis, sign in ((RIGHT, 0, 1.0), (UP, 1, 1.0), (LEFT, 0, -1.0), (DOWN, 1, -1.0)):
        there = grid.neighbors[:, direction]
        here = np.flatnonzero(there != OUTSIDE)
        other = there[here]
        facing = np.minimum(forward[here], forward[other]) ** 2
        agreement = np.sum(vectors[here] * vectors[other], axis=1)
        links[here, direction] = facing / (1.0 + ((1.0 - agreement) / (1.0 - half)) ** 2)
        flow[here, direction] = sign * (slopes[here, axis] + slopes[other, axis]) / 2
    membrane = ScreenedPoisson(grid, links, np.full(grid.size, TIE))
    right_side = -np.sum(links * flow, axis=1)
    height, report = solve_screened_poisson(membrane, right_side, tolerance=1e-6)
    return HeightField(grid.scatter(_from_zero(grid, height)), normals.mask, report)


def level_rim(field: HeightField) -> HeightField:
    """
    Bend a height so that it is 0 all along the rim, as that of a body which continues behind the picture.

    Parameters
    ----------
    field : HeightField
        The height.

    Returns
    -------
    HeightField
        The height minus the smoothest surface (its Laplacian is 0) through its values at the rim; 0 where that is higher.

    Raises
    ------
    ToonkitError
        If the field is no `HeightField`.
    """
    of_type("field", field, HeightField)
    grid = MaskedGrid(field.mask)
    height, ties = grid.gather(field.height), np.where(grid.rim, AT_RIM, 0.0)
    smoothest, report = solve_screened_poisson(
        ScreenedPoisson(grid, uniform_edge_weights(grid), ties), ties * height, tolerance=1e-6
    )
    return HeightField(grid.scatter(np.maximum(height - smoothest, 0.0)), field.mask, report)


def height_mesh(field: HeightField, *, color: ToonImage | None = None) -> trimesh.Trimesh:
    """
    Make a triangle mesh of a height field: two triangles for each 2 x 2 block of object pixels.

    Parameters
    ----------
    field : HeightField
        The height.
    color : ToonImage, optional
        Picture over the same pixels, for vertex colors.

    Returns
    -------
    trimesh.Trimesh
        Vertices in pixels, x right, y up, z toward the viewer; one per object pixel, in row-major order.

    Raises
    ------
    ToonkitError
        If the field is no `HeightField`, or the picture no `ToonImage` of the same size and mask.
    """
    of_type("field", field, HeightField)
    import trimesh  # noqa: PLC0415 - takes seconds to import, and only meshes need it

    grid = MaskedGrid(field.mask)
    height = field.mask.shape[0]
    vertices = np.column_stack([grid.columns, height - 1 - grid.rows, field.height[grid.mask]]).astype(
        np.float64
    )
    vertex_colors = None
    if color is not None:
        of_type("color", color, ToonImage)
        same_mask("color", color.mask, field.mask, "the height field")
        vertex_colors = color.to_rgba()[grid.mask]
    return trimesh.Trimesh(vertices, _faces(grid), vertex_colors=vertex_colors, process=False)


def _faces(grid: MaskedGrid) -> NDArray[np.intp]:
    right, down = grid.neighbors[:, RIGHT], grid.neighbors[:, DOWN]
    across = np.where(right != OUTSIDE, grid.neighbors[right, DOWN], OUTSIDE)
    here = np.flatnonzero((right != OUTSIDE) & (down != OUTSIDE) & (across != OUTSIDE))
    a, b, c, d = here, down[here], across[here], right[here]
    # Counter-clockwise seen from +z, so that faces look at the viewer.
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]).astype(np.intp)


def _from_zero(grid: MaskedGrid, height: FloatArray) -> FloatArray:
    """Shift every component so that its lowest point is at 0."""
    labels = label(grid.mask)[0][grid.mask] - 1
    lowest = np.full(labels.max() + 1, np.inf)
    np.minimum.at(lowest, labels, height)
    above: FloatArray = height - lowest[labels]
    return above

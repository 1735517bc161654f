"""The shape of a drawing as a .glb file: its surface, with the base color as texture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from toonkit._validation import BoolArray, FloatArray, is_count, is_number, of_type, one_of, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.heightfield import height_map, level_rim
from toonkit.model.image import nearest_object_pixel
from toonkit.numerics.masked_grid import bounding_box

if TYPE_CHECKING:
    import trimesh

Back = Literal["none", "mirrored", "flat"]

BACKS = ("none", "mirrored", "flat")
"""What may be behind the surface: nothing, the same surface the other way round, or a plane."""

MOST_VERTICES = 512
"""Vertices along the longest side of the object, by default: larger drawings get a coarser mesh."""

PLATE = 0.02
"""How far behind the lowest point of the surface a flat back lies, in longest sides."""

MARGIN = 8
"""Pixels around the object in the texture, for filtering and mipmaps."""

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Surface:
    """Vertices: positions in pixels, normals, places in the picture (row, column), and triangles of them."""

    positions: FloatArray
    normals: FloatArray
    places: FloatArray
    faces: Indices


def write_mesh(
    analysis: ToonAnalysis,
    path: PathLike,
    *,
    back: Back = "none",
    size: float = 1.0,
    vertices: int = MOST_VERTICES,
) -> None:
    """
    Write the shape of a drawing for 3-D programs and engines.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    path : path
        Ends in .glb. An older file is replaced once the new one is complete.
    back, size, vertices
        As for `textured_mesh`.

    Raises
    ------
    ToonkitError
        If an argument breaks these rules, or the file cannot be written.
    """
    suffix_of(path, (".glb",))
    with atomic_write(path) as file:
        mesh = textured_mesh(analysis, back=back, size=size, vertices=vertices)
        file.write(mesh.export(file_type="glb", include_normals=True))


def textured_mesh(
    analysis: ToonAnalysis, *, back: Back = "none", size: float = 1.0, vertices: int = MOST_VERTICES
) -> trimesh.Trimesh:
    """
    Make a mesh of a drawing's shape, with its normals, and its base color as texture.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    back : {"none", "mirrored", "flat"}, optional
        What is behind the surface that the drawing shows: nothing; the same surface mirrored, with the same texture; or a
        plane. The last two close the mesh.
    size : float, optional
        Length of the object's longest side in the units of the mesh.
    vertices : int, optional
        Vertices along that side, 2 to 8192; never more than it has pixels.

    Returns
    -------
    trimesh.Trimesh
        x right, y up, z toward the viewer, as glTF has it; the middle of the object's box is at the origin. The lowest
        points of the surface lie at z = 0, or half a pixel in front of it if it is mirrored.

    Raises
    ------
    ToonkitError
        If an argument breaks these rules, or no 2 x 2 pixels of the mesh lie on the object.

    Notes
    -----
    The height is that of `toonkit.height_map`, for a closed mesh bent so that the rim is level. The vertices have the
    normals of the analysis, which show more than the height does. Two triangles fill each 2 x 2 block of the mesh's pixels
    that lies on the object.
    """
    of_type("analysis", analysis, ToonAnalysis)
    one_of("back", back, BACKS)
    if not is_number(size) or size <= 0:
        raise refuse("size", "must be a number > 0", size)
    if not is_count(vertices, 2, 8192):
        raise refuse("vertices", "must be a whole number from 2 to 8192", vertices)
    import trimesh  # noqa: PLC0415 - takes seconds to import, and only meshes need it
    from trimesh.visual import TextureVisuals  # noqa: PLC0415
    from trimesh.visual.material import PBRMaterial  # noqa: PLC0415

    rows, columns = bounding_box(analysis.image.mask)
    longest = max(rows.stop - rows.start, columns.stop - columns.start)
    surface = _front(analysis, -(-longest // vertices), level=back != "none")
    if back != "none":
        surface = _closed(surface, back, PLATE * longest)
    middle = np.array([columns.start + columns.stop - 1, 1 - rows.start - rows.stop, 0.0]) / 2
    texture, corner = _texture(analysis, (rows, columns))
    height, width = texture.shape[:2]
    within = surface.places - corner + 0.5
    material = PBRMaterial(
        name="base color",
        baseColorTexture=Image.fromarray(texture),
        metallicFactor=0.0,
        roughnessFactor=1.0,
        doubleSided=back == "none",
    )
    return trimesh.Trimesh(
        (surface.positions - middle) * (size / longest),
        surface.faces,
        vertex_normals=surface.normals,
        # Texture coordinates start at the lower left, as OpenGL has them; the .glb file turns them over.
        visual=TextureVisuals(
            np.column_stack([within[:, 1] / width, 1 - within[:, 0] / height]), material=material
        ),
        process=False,
    )


def _front(analysis: ToonAnalysis, step: int, *, level: bool) -> _Surface:
    """Return the surface that the drawing shows, of every so many pixels in both directions, perhaps with a level rim."""
    sample = np.s_[step // 2 :: step, step // 2 :: step]
    field = height_map(analysis.normals)
    height = (level_rim(field) if level else field).height[sample]
    normals, mask = analysis.normals.vectors[sample], analysis.image.mask[sample]
    blocks = mask[:-1, :-1] & mask[1:, :-1] & mask[:-1, 1:] & mask[1:, 1:]
    if not blocks.any():
        raise refuse("vertices", "must be enough for the object to have a face", f"{mask.sum()} in all")
    own, count = _corners(blocks)
    # Counter-clockwise seen from +z, so that faces look at the viewer.
    a, b, c, d = (own[:, corner] for corner in range(4))
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    top, left = np.nonzero(blocks)
    rows, columns = np.zeros((2, count), np.intp)
    for corner, (down, right) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        rows[own[:, corner]], columns[own[:, corner]] = top + down, left + right
    places = np.column_stack([rows, columns]) * step + step // 2
    positions = np.column_stack([places[:, 1], -places[:, 0], height[rows, columns]]).astype(np.float64)
    return _Surface(positions, normals[rows, columns], places.astype(np.float64), faces)


def _corners(blocks: BoolArray) -> tuple[Indices, int]:
    """
    Give the vertices of blocks (h, w) numbers; return those of each block, from the upper left counter-clockwise.

    Where two blocks touch at a corner alone, each has a vertex of its own there, so that no edge has more than two faces.
    """
    height, width = blocks.shape[0] + 1, blocks.shape[1] + 1
    around = np.pad(blocks, 1)
    upper_left, upper_right = around[:-1, :-1], around[:-1, 1:]
    lower_left, lower_right = around[1:, :-1], around[1:, 1:]
    pinched = (upper_left & lower_right & ~upper_right & ~lower_left) | (
        upper_right & lower_left & ~upper_left & ~lower_right
    )
    used = upper_left | upper_right | lower_left | lower_right
    number = np.cumsum(used).reshape(height, width) - 1
    count = int(used.sum())
    second = np.where(pinched, count + np.cumsum(pinched).reshape(height, width) - 1, number)
    top, left = np.nonzero(blocks)
    # Of two blocks that touch at a corner, the lower one takes the second vertex: it is at the block's upper corners.
    corners = [
        second[top, left],
        number[top + 1, left],
        number[top + 1, left + 1],
        second[top, left + 1],
    ]
    return np.column_stack(corners), count + int(pinched.sum())


def _closed(front: _Surface, back: Back, plate: float) -> _Surface:
    """Add a back, and a wall along the rim between both."""
    count = len(front.positions)
    positions, behind = front.positions.copy(), front.positions.copy()
    if back == "mirrored":
        positions[:, 2] += (
            0.5  # a pixel apart, or vertices of both sides would be one where the surface is lowest
        )
        behind[:, 2] = -positions[:, 2]
    else:
        behind[:, 2] = -plate
    mirrored = front.normals * [1, 1, -1]
    rim = _rim(front.faces)
    parts = [(positions, front.normals, front.places)]
    if back == "mirrored":
        parts.append((behind, mirrored, front.places))
        wall = count
    else:
        # The plane meets the wall at an edge, where each has normals of its own.
        outward = front.normals * [1, 1, 0]
        length = np.linalg.norm(outward, axis=1, keepdims=True)
        outward = np.where(length > 0, outward / np.maximum(length, 1e-9), front.normals)
        parts.append((behind, np.broadcast_to([0.0, 0.0, -1.0], front.normals.shape), front.places))
        parts.append((behind, outward, front.places))
        wall = 2 * count
    a, b = rim.T
    faces = np.concatenate(
        [
            front.faces,
            front.faces[:, ::-1] + count,
            np.column_stack([b, a, a + wall]),
            np.column_stack([b, a + wall, b + wall]),
        ]
    )
    positions, normals, places = (np.concatenate(part) for part in zip(*parts, strict=True))
    used, faces = np.unique(faces, return_inverse=True)
    return _Surface(positions[used], normals[used], places[used], faces.reshape(-1, 3))


def _rim(faces: Indices) -> Indices:
    """Return the edges (n, 2) that belong to one face, in its direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, first, count = np.unique(low * (int(high.max()) + 1) + high, return_index=True, return_counts=True)
    return np.asarray(edges[first[count == 1]])


def _texture(analysis: ToonAnalysis, box: tuple[slice, slice]) -> tuple[NDArray[np.uint8], FloatArray]:
    """Return the base color around the object, which goes on outside it, and the row and column of its upper left pixel."""
    rows, columns = (slice(max(span.start - MARGIN, 0), span.stop + MARGIN) for span in box)
    nearest = nearest_object_pixel(analysis.image.mask[rows, columns])
    texture = analysis.base_color.to_rgba()[rows, columns, :3][nearest]
    return texture, np.array([rows.start, columns.start], dtype=np.float64)

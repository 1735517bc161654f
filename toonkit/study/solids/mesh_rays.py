"""Orthographic rays against a triangle mesh, with normals that are smooth except over sharp edges."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray, ToonkitError

if TYPE_CHECKING:
    import trimesh

SHARP_EDGE = 40.0
"""Degrees between two faces beyond which the edge they share stays sharp."""


class MeshSolid:
    """
    A mesh turned into a view.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
        In the view's axes.
    """

    def __init__(self, mesh: trimesh.Trimesh, turn: FloatArray) -> None:
        try:
            from trimesh.ray.ray_pyembree import RayMeshIntersector  # noqa: PLC0415  # optional package
        except ImportError as error:
            raise ToonkitError('render_mesh needs embreex; got none: pip install "toonkit[study]"') from error
        turned = mesh.copy()
        turned.merge_vertices(merge_tex=True, merge_norm=True)
        turned.vertices = turned.vertices @ turn.T
        self.vertices: FloatArray = np.asarray(turned.vertices, dtype=np.float64)
        self._faces: NDArray[np.intp] = np.asarray(turned.faces, dtype=np.intp)
        self._face_normals = _face_normals(self.vertices, self._faces)
        self._corner_normals = _corner_normals(self.vertices, self._faces, self._face_normals)
        self._rays = RayMeshIntersector(turned)
        self._start = float(self.vertices[:, 2].max()) + 0.01 * float(turned.scale)

    def first_hit(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z, shape (n,), of the nearest surface point behind each (x, y); NaN where there is none."""
        face = self._first_face(x, y)
        hit = face >= 0
        depth = np.full(len(x), np.nan)
        corners = self.vertices[self._faces[face[hit]]]
        weights = _barycentric(corners[..., :2], np.column_stack([x[hit], y[hit]]))
        depth[hit] = (weights * corners[..., 2]).sum(axis=1)
        return depth

    def normals(self, points: FloatArray) -> FloatArray:
        """Return the unit normals, shape (n, 3), at surface points, both in the view's axes."""
        face = self._first_face(points[:, 0], points[:, 1])
        weights = _barycentric(self.vertices[self._faces[face]][..., :2], points[:, :2])
        smooth = _unit((weights[..., None] * self._corner_normals[face]).sum(axis=1))
        flat = self._face_normals[face]
        # A face that is seen faces the viewer, however the file winds it.
        side = np.where(flat[:, 2:] < 0, -1.0, 1.0)
        return np.where(smooth[:, 2:] * side < 0, flat * side, smooth * side)

    def parts(self, points: FloatArray) -> NDArray[np.intp]:
        """Return the material index, shape (n,), of surface points: all zero."""
        return np.zeros(len(points), dtype=np.intp)

    def _first_face(self, x: FloatArray, y: FloatArray) -> NDArray[np.intp]:
        origins = np.column_stack([x, y, np.full(len(x), self._start)])
        directions = np.tile([0.0, 0.0, -1.0], (len(x), 1))
        return np.asarray(self._rays.intersects_first(origins, directions), dtype=np.intp)


def _barycentric(triangles: FloatArray, places: FloatArray) -> FloatArray:
    """
    Return weights (n, 3) of the corners of (n, 3, 2) triangles, clipped to the triangle.

    The rays are traced in single precision; solving for their places again in double keeps normals smooth.
    """
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    away = places - triangles[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    area = np.where(np.abs(area) < 1e-300, 1e-300, area)
    along_first = (away[:, 0] * second[:, 1] - away[:, 1] * second[:, 0]) / area
    along_second = (first[:, 0] * away[:, 1] - first[:, 1] * away[:, 0]) / area
    weights = np.clip(np.column_stack([1 - along_first - along_second, along_first, along_second]), 0.0, 1.0)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _face_normals(vertices: FloatArray, faces: NDArray[np.intp]) -> FloatArray:
    corners = vertices[faces]
    return _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _corner_normals(vertices: FloatArray, faces: NDArray[np.intp], face_normals: FloatArray) -> FloatArray:
    """Return normals (F, 3, 3) of face corners: the mean, by angle, of faces around that are not over an edge."""
    corner_face = np.repeat(np.arange(len(faces)), 3)
    weighted = face_normals[corner_face] * _corner_angles(vertices, faces).reshape(-1, 1)
    # Corners sorted by vertex stand in one run; every corner is paired with each other of its run.
    order = np.argsort(faces.ravel(), kind="stable")
    _, begin, count = np.unique(faces.ravel()[order], return_index=True, return_counts=True)
    run = np.repeat(np.arange(len(count)), count)
    total = np.zeros((len(order), 3))
    limit = np.cos(np.deg2rad(SHARP_EDGE))
    for shift in range(int(count.max())):
        near = shift < count[run]
        own = order[near]
        place = np.arange(len(order))[near] - begin[run[near]]
        other = order[begin[run[near]] + (place + shift) % count[run[near]]]
        alike = (face_normals[corner_face[own]] * face_normals[corner_face[other]]).sum(axis=1) >= limit
        total[own] += np.where(alike[:, None], weighted[other], 0.0)
    return _unit(total).reshape(-1, 3, 3)


def _corner_angles(vertices: FloatArray, faces: NDArray[np.intp]) -> FloatArray:
    """Return the angles (F, 3) of faces at their corners, in radians."""
    corners = vertices[faces]
    ahead, behind = (
        _unit(np.roll(corners, -1, axis=1) - corners),
        _unit(np.roll(corners, 1, axis=1) - corners),
    )
    return np.asarray(np.arccos(np.clip((ahead * behind).sum(axis=-1), -1.0, 1.0)))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))

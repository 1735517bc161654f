"""The benchmark on Blender tells what a reader makes of a mesh from what was to be written."""

from __future__ import annotations

import numpy as np
import pytest

import toonkit
from benchmarks.blender import differences
from toonkit.export.mesh import textured_mesh


@pytest.fixture(scope="module")
def mesh():
    return textured_mesh(toonkit.analyze("sample:duck", (135, 45)), vertices=32)


@pytest.fixture
def found(mesh):
    """What a reader finds that makes no mistake."""
    corners, texture = mesh.faces.ravel(), np.asarray(mesh.visual.material.baseColorTexture)
    return {
        "vertices": np.array(len(mesh.vertices)),
        "positions": mesh.vertices[corners],
        "normals": mesh.vertex_normals[corners],
        "texture_coordinates": mesh.visual.uv[corners],
        "texture": np.dstack([texture[..., :3], np.full(texture.shape[:2], 255)]),
    }


def test_a_reader_without_mistakes_differs_in_nothing(mesh, found, tmp_path):
    np.savez(tmp_path / "duck.npz", **found)
    row = differences(mesh, tmp_path / "duck.glb")
    assert row["vertices"] == row["vertices_in_blender"]
    assert row["triangles"] == row["triangles_in_blender"]
    assert row["normal_degrees"] < 1e-4
    assert [row[f"{part}_difference"] for part in ("position", "texture_coordinate")] == [0, 0]
    assert row["texture_steps"] == 0


def test_a_texture_upside_down_is_told(mesh, found, tmp_path):
    found["texture_coordinates"] = found["texture_coordinates"] * [1, -1] + [0, 1]
    np.savez(tmp_path / "duck.npz", **found)
    assert differences(mesh, tmp_path / "duck.glb")["texture_coordinate_difference"] > 0.1

"""What Blender finds in .glb files: run by a Python that has `bpy` and NumPy, for `benchmarks.blender`.

    python benchmarks/blender_reading.py FILE.glb ...

Writes FILE.npz beside each: positions, normals and texture coordinates of the corners of all triangles, and the texture.
"""

import sys
from pathlib import Path

import bpy
import numpy as np


def read(path: Path) -> dict[str, np.ndarray]:
    """Open a file in an empty scene, and return what the mesh in it has, in the axes of glTF."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(path))
    (found,) = (thing for thing in bpy.data.objects if thing.type == "MESH")
    mesh, (slot,) = found.data, found.material_slots
    (image,) = (node.image for node in slot.material.node_tree.nodes if node.type == "TEX_IMAGE")
    corner_vertices = _array(mesh.loops, "vertex_index", 1, np.int32)[:, 0]
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return {
        "vertices": np.array(len(mesh.vertices)),
        "positions": _upright(_array(mesh.vertices, "co", 3, np.float32)[corner_vertices]),
        "normals": _upright(_array(mesh.corner_normals, "vector", 3, np.float32)),
        "texture_coordinates": _array(mesh.uv_layers.active.data, "uv", 2, np.float32),
        "texture": np.rint(pixels.reshape(height, width, 4)[::-1] * 255).astype(np.uint8),
    }


def _array(things: object, name: str, count: int, dtype: type) -> np.ndarray:
    values = np.empty(len(things) * count, dtype)
    things.foreach_get(name, values)
    return values.reshape(-1, count)


def _upright(vectors: np.ndarray) -> np.ndarray:
    """Turn Blender's axes, z up, to those of glTF, y up."""
    return np.stack([vectors[:, 0], vectors[:, 2], -vectors[:, 1]], axis=1)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        np.savez(Path(name).with_suffix(".npz"), **read(Path(name)))

"""Whether Blender opens the meshes of drawings as they are: positions, normals, texture coordinates and texture.

    uv venv /tmp/blender && uv pip install --python /tmp/blender bpy
    python -m benchmarks.blender --blender /tmp/blender/bin/python -o benchmarks/results/blender.csv

Blender as a Python module, `bpy`, asks for an older NumPy than toonkit, and thus for an environment of its own.
Writes one row for each sample and kind of back. What a file holds in 32 bits differs in the seventh digit.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

import toonkit
from benchmarks.shape_rows import Row
from toonkit.export.mesh import BACKS, textured_mesh, write_mesh
from toonkit.samples import sample_names

READING = Path(__file__).with_name("blender_reading.py")


def measured(name: str, blender: str) -> list[Row]:
    """Compare what Blender finds in the files of one sample with what was to be written."""
    analysis = toonkit.analyze(f"sample:{name}")
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / f"{back}.glb" for back in BACKS]
        for back, file in zip(BACKS, files, strict=True):
            write_mesh(analysis, file, back=back)
        subprocess.run([blender, str(READING), *map(str, files)], check=True, stdout=subprocess.DEVNULL)
        return [
            {"drawing": name, "back": back, **differences(textured_mesh(analysis, back=back), file)}
            for back, file in zip(BACKS, files, strict=True)
        ]


def differences(mesh: trimesh.Trimesh, file: Path) -> Row:
    """Return how far corners and texture, as Blender read them from a file, are from those of a mesh."""
    with np.load(file.with_suffix(".npz")) as found:
        corners = mesh.faces.ravel()
        across = np.einsum("cx,cx->c", found["normals"], mesh.vertex_normals[corners])
        texture = np.asarray(mesh.visual.material.baseColorTexture).astype(int)
        return {
            "vertices": len(mesh.vertices),
            "triangles": len(mesh.faces),
            "vertices_in_blender": int(found["vertices"]),
            "triangles_in_blender": len(found["positions"]) // 3,
            "position_difference": float(np.abs(found["positions"] - mesh.vertices[corners]).max()),
            "normal_degrees": float(np.rad2deg(np.arccos(np.clip(across, -1.0, 1.0))).max()),
            "texture_coordinate_difference": float(
                np.abs(found["texture_coordinates"] - mesh.visual.uv[corners]).max()
            ),
            "texture_steps": int(np.abs(found["texture"][..., : texture.shape[2]] - texture).max()),
        }


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Whether Blender opens the meshes of drawings as they are.")
    parser.add_argument("--blender", required=True, metavar="PYTHON", help="a Python that has bpy")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per drawing and back")
    parser.add_argument(
        "--samples", nargs="+", default=["cat", "duck"], choices=sample_names(), metavar="SAMPLE"
    )
    given = parser.parse_args(arguments)
    rows = pd.DataFrame(row for name in given.samples for row in measured(name, given.blender))
    print(rows.to_string(index=False))
    if given.output is not None:
        rows.to_csv(given.output, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()

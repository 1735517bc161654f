"""Digests of a trial's inputs and learned parts: shapes, color maps, network weights, and files of the user's own."""

from __future__ import annotations

import hashlib
from importlib.resources import files
from pathlib import Path

import numpy as np

from toonkit.model.color_map import ColorMap
from toonkit.study.registry import BOUND, Shape
from toonkit.study.scenes import Scene

NETWORKS_USED: dict[str, tuple[str, ...]] = {
    "toonkit": ("shape_prior",),
    **dict.fromkeys(("classical", "todo", "lumo", "lambert", "flat"), ()),
}
"""Networks that toonkit's own methods use under a given light, of drawings in one material, as the study's are; any other
method may use all of them."""

_PROBES = np.random.default_rng(0).uniform(-BOUND, BOUND, (4096, 3))


def scene_digest(scene: Scene) -> str:
    """Return a digest of a scene: its distances at fixed points or its triangles, and its view."""
    digest = hashlib.sha256(repr(scene.view).encode())
    if isinstance(scene, Shape):
        digest.update(np.round(scene.distance(_PROBES), 9).tobytes())
    else:
        digest.update(np.ascontiguousarray(scene.mesh.vertices, dtype=np.float64).tobytes())
        digest.update(np.ascontiguousarray(scene.mesh.faces, dtype=np.int64).tobytes())
    return digest.hexdigest()


def color_map_digest(color_map: ColorMap) -> str:
    """Return a digest of a color map's samples and domain, rounded because their last bits depend on the processor."""
    numbers = np.round(np.append(color_map.colors, color_map.domain), 9)
    return hashlib.sha256(numbers.tobytes()).hexdigest()


def weights_digests() -> dict[str, str]:
    """Return a digest of each network's weight file, by the network's name."""
    weights = sorted(
        (file for file in files("toonkit.estimation.weights").iterdir() if file.name.endswith(".npz")),
        key=lambda file: file.name,
    )
    return {file.name.removesuffix(".npz"): hashlib.sha256(file.read_bytes()).hexdigest() for file in weights}


def file_digest(file: Path) -> str:
    """Return a digest of a file's content."""
    return hashlib.sha256(file.read_bytes()).hexdigest()

"""What is rendered: a shape of the study, or a mesh file as a further shape."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from toonkit._validation import ToonkitError, expand_home, refuse
from toonkit.study.registry import Shape, View
from toonkit.study.rendering import RenderedShape, render_mesh, render_shape

if TYPE_CHECKING:
    import trimesh

EXAMPLE_PREFIX = "pyvista:"
"""`pyvista:bunny` is the mesh that `pyvista.examples.download_bunny` fetches."""


@dataclass(frozen=True, eq=False)
class MeshShape:
    """
    A triangle mesh as a further shape.

    Attributes
    ----------
    name : str
        Its name in the table.
    mesh : trimesh.Trimesh
        The mesh, y up and its front toward +z.
    view : View
        From where it is seen.
    """

    name: str
    mesh: trimesh.Trimesh
    view: View = field(default_factory=View)

    @property
    def kind(self) -> str:
        """Return "mesh"."""
        return "mesh"


Scene = Shape | MeshShape


def load_mesh(source: str | Path, view: View | None = None) -> MeshShape:
    """
    Read a mesh as a further shape of the study, named after its file.

    The source is a file that trimesh reads (obj, ply, stl, glb, off, ...), or `pyvista:NAME` for a mesh that PyVista
    downloads. Raises `ToonkitError` if there is none, or it holds no triangles.
    """
    text = str(source)
    if text.startswith(EXAMPLE_PREFIX):
        name = text.removeprefix(EXAMPLE_PREFIX)
        mesh = _example(name)
    else:
        path = expand_home(source)
        name, mesh = path.stem, _from_file(path)
    if len(mesh.faces) == 0:
        raise refuse("mesh", "must have triangles", f"{text} without any")
    return MeshShape(re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "mesh", mesh, view or View())


def render(scene: Scene, size: int) -> RenderedShape:
    """Render a shape or a mesh from its own view, shape (size, size); for errors see `render_shape` and `render_mesh`."""
    if isinstance(scene, Shape):
        return render_shape(scene, size)
    view = scene.view
    return render_mesh(scene.mesh, size, yaw=view.yaw, pitch=view.pitch, roll=view.roll)


def _from_file(path: Path) -> trimesh.Trimesh:
    import trimesh  # noqa: PLC0415  # takes seconds, and most studies read no mesh

    if not path.is_file():
        raise refuse("mesh", "must be a file", f"{path}")
    try:
        loaded = trimesh.load(path, force="mesh")
    except Exception as error:  # whatever its many readers raise
        raise refuse("mesh", "must be a file that trimesh reads", f"{path} ({error})") from error
    if not isinstance(loaded, trimesh.Trimesh):
        raise refuse("mesh", "must hold triangles", f"{path}")
    return loaded


def _example(name: str) -> trimesh.Trimesh:
    import trimesh  # noqa: PLC0415
    from pyvista import PolyData, examples  # noqa: PLC0415

    download = getattr(examples, f"download_{name}", None)
    if download is None:
        raise refuse("mesh", "must be an example of PyVista after pyvista:", repr(name))
    try:
        mesh = download()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # how to say which surface is meant differs between versions
            surface = (mesh if isinstance(mesh, PolyData) else mesh.extract_surface()).triangulate()
    except Exception as error:  # no network, or an example that is no surface
        raise ToonkitError(f"mesh must be downloadable; got pyvista:{name} ({error})") from error
    return trimesh.Trimesh(surface.points, surface.faces.reshape(-1, 4)[:, 1:])

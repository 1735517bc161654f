"""A PyVista scene in the browser, serialized without any rendering in Python."""

from __future__ import annotations

from typing import Any

from panel.pane.vtk import synchronizable_serializer as serializer
from panel.pane.vtk.vtk import VTKRenderWindow


class HeightPane(VTKRenderWindow):
    """
    Panel's VTK pane, without the rendering that it asks of Python.

    The browser draws; Panel only renders in order to bring the pipeline up to date. On a machine with
    neither a display nor EGL nor OSMesa that rendering ends the process, so the mappers are updated instead.
    """

    priority = None  # never chosen for a render window that somebody else shows

    def __init__(self, object: Any = None, **params: Any) -> None:
        super().__init__(object, **{"serialize_on_instantiation": True, **params})

    def _serialize_ren_win(
        self,
        ren_win: Any,
        context: Any,
        binary: bool = False,
        compression: bool = True,
        exclude_arrays: list[str] | None = None,
    ) -> tuple[dict[str, Any], dict[str, Any], Any]:
        del binary, compression, exclude_arrays  # Panel passes none of them here
        for renderer in ren_win.GetRenderers():
            for actor in renderer.GetActors():
                actor.GetMapper().Update()
            renderer.ResetCameraClippingRange()
        scene = serializer.serializeInstance(None, ren_win, context.getReferenceId(ren_win), context, 0)
        scene["properties"]["numberOfLayers"] = 2  # the page keeps the second one for its orientation widget
        arrays = {
            name: context.getCachedDataArray(name, binary=True, compression=False)
            for name in context.dataArrayCache
        }
        return scene, arrays, context.getAnnotations()

"""Whole estimators: one call signature, one registry."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike, fspath
from typing import Any, Protocol

from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, check_callable, of_type, one_of, refuse, same_mask
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.enlarged_drawing import EnlargedDrawing
from toonkit.estimation.light_fit import assume_light
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.methods.classical import classical
from toonkit.methods.lambert import lambert
from toonkit.methods.lumo import lumo
from toonkit.methods.steps import StepProgress
from toonkit.methods.todo import todo
from toonkit.methods.toonkit import toonkit
from toonkit.model.image import ToonImage
from toonkit.model.layer_loading import load_layers
from toonkit.model.light import direction_of
from toonkit.model.materials import Materials
from toonkit.model.shape_corrections import ShapeCorrections
from toonkit.numerics.parallel import single_threaded_blas
from toonkit.samples import drawing_path


class Method(Protocol):
    """
    An estimator: from a drawing and its light to an analysis.

    Examples
    --------
    A method of one's own finds normals, and ends as all do: with the color maps that fit them.

    >>> import toonkit
    >>> def inflated(drawing, light, *, previous=None, progress=None):
    ...     normals = drawing.initial_normals
    ...     materials = toonkit.fit_color_maps(drawing, toonkit.illumination(normals, light))
    ...     return toonkit.ToonAnalysis(drawing, "inflated", light, normals, normals, materials)
    >>> toonkit.METHODS["inflated"] = inflated
    >>> toonkit.analyze("sample:pear", (135, 45), method="inflated").method
    'inflated'
    >>> del toonkit.METHODS["inflated"]
    """

    def __call__(
        self,
        drawing: PreparedDrawing,
        light: ArrayLike,
        /,
        *,
        previous: ToonAnalysis | None = None,
        progress: StepProgress | None = None,
    ) -> ToonAnalysis:
        """
        Analyze a drawing lit from `light`, and tell `progress` the step and the fraction done.

        It may start from `previous`, an analysis of the same mask, which is passed only where there is one.
        """
        ...


METHODS: dict[str, Method] = {
    "toonkit": toonkit,
    "classical": classical,
    "todo": todo,
    "lumo": lumo,
    "lambert": lambert,
}
"""Name -> estimator. Adding one is `METHODS["name"] = function`, called as `Method` says."""


def analyze(
    image: ToonImage | PreparedDrawing | str | PathLike[str],
    light: ArrayLike | None = None,
    *,
    method: str = "toonkit",
    materials: ArrayLike | Materials | None = None,
    ink: ArrayLike | None = None,
    highlights: ArrayLike | None = None,
    shape: ShapeCorrections | None = None,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Take a cartoon-shaded picture apart into normals and the color maps of its materials.

    Parameters
    ----------
    image : ToonImage or path
        The picture; a file that `load_layers` reads, whose layers then give materials and ink that are not given here; or
        "sample:NAME" for a drawing that toonkit ships.
    light : array_like, shape (3,) or (2,), optional
        Direction from the surface to the light that the artist had in mind, or its azimuth and elevation in degrees;
        estimated if not given, and upper left where the picture does not say: see `ToonAnalysis.light_estimate`.
    method : str, optional
        Name of an estimator in `METHODS`; `METHODS["name"] = function` adds one, of the kind that `Method` describes.
    materials : array_like of int, shape (H, W), or Materials, optional
        Number of the material of each pixel, 0 and up, and -1 where that is left to toonkit; ignored outside the mask.
        Found if not given.
    ink : array_like of bool, shape (H, W), optional
        True where line art covers most of a pixel, False everywhere if there is none; ignored outside the mask. Found if not
        given.
    highlights : array_like of bool, shape (H, W), optional
        True where the paint shows a highlight, or a cast shadow: it says nothing about the shape, and fades as the light
        moves. Found if not given.
    shape : ShapeCorrections, optional
        What a person says about the shape: parts that bulge, are flat or in front, and normals at points. If `image` is
        the `drawing` of an earlier analysis, only what depends on the shape is computed again; empty corrections remove
        the earlier ones.
    previous : ToonAnalysis, optional
        An analysis of the same mask under a nearby light. `toonkit` and `classical` start from it and answer sooner; one of
        the same picture passes on what was derived from it.
    progress : callable, optional
        Called with the name of the running step and the fraction of the whole done, 0 to 1. What it raises cancels.

    Returns
    -------
    ToonAnalysis
        Normals, materials with their color maps, light and how the refinement went.

    Raises
    ------
    ToonkitError
        If the method is unknown, the image is neither a `ToonImage` nor a file that can be read, the light, the materials,
        the ink, the highlights or the shape are refused, the previous analysis is of another mask, or the drawing shows
        nothing but lines and no materials are given.

    Examples
    --------
    >>> import numpy as np
    >>> import toonkit
    >>> y, x = np.mgrid[:64, :64] - 32.0
    >>> mask = x**2 + y**2 < 900
    >>> color = np.where((x - y)[..., None] > 0, [0.9, 0.8, 0.6], [0.4, 0.2, 0.5])
    >>> analysis = toonkit.analyze(toonkit.ToonImage(color, mask), toonkit.light_direction(45, 40))
    >>> analysis.color_map([-0.5, 0.9]).round(2).tolist()
    [[0.4, 0.2, 0.5], [0.9, 0.8, 0.6]]
    """
    if callable(method):
        rule = 'must be a name; toonkit.METHODS["name"] = function adds a method'
        raise refuse("method", rule, f"the function {getattr(method, '__name__', method)}")
    one_of("method", method, METHODS)
    if previous is not None:
        of_type("previous", previous, ToonAnalysis)
    check_callable("progress", progress)
    if isinstance(image, (str, PathLike)):
        layered = load_layers(drawing_path(fspath(image)))
        image = layered.image
        materials = layered.materials if materials is None else materials
        ink = layered.ink if ink is None else ink
    direction = None if light is None else direction_of("light", light)
    nothing_told = materials is None and ink is None and highlights is None
    kept = previous is not None and previous.image is image and nothing_told
    known = previous.drawing if previous is not None and kept else image
    drawing = prepare(known, materials=materials, ink=ink, highlights=highlights, shape=shape)
    if previous is not None:
        same_mask("previous", previous.image.mask, drawing.mask, "the picture")
    if materials is None and drawing.ink.only_lines:
        raise refuse(
            "image",
            "must show paint, or come with its materials; no shading found",
            "a drawing of lines alone",
        )
    options: dict[str, Any] = {} if previous is None else {"previous": previous}
    with single_threaded_blas():
        if direction is not None:
            return _analyzed(method, drawing, direction, progress, options)
        if progress is not None:
            progress("estimating the light", 0.0)
        estimate = assume_light(drawing)
        analysis = _analyzed(method, drawing, estimate.light, progress, options)
    return replace(analysis, light_estimate=estimate)


def _analyzed(
    method: str,
    drawing: PreparedDrawing,
    light: FloatArray,
    progress: StepProgress | None,
    options: dict[str, Any],
) -> ToonAnalysis:
    """Call a method, and refuse what is not an analysis. An enlarged drawing is analyzed at the size it was painted at."""
    if isinstance(drawing, EnlargedDrawing):
        options = {}  # an earlier analysis is as large as the enlarged drawing
    analysis: object = METHODS[method](drawing.as_painted, light, progress=progress, **options)
    if not isinstance(analysis, ToonAnalysis):
        rule = f"must return a ToonAnalysis, as help(toonkit.methods.Method) shows; {method!r} did not"
        raise refuse("method", rule, type(analysis).__name__)
    return _enlarged(analysis, drawing) if isinstance(drawing, EnlargedDrawing) else analysis


def _enlarged(analysis: ToonAnalysis, drawing: EnlargedDrawing) -> ToonAnalysis:
    """Return the analysis of an enlarged drawing from that of the reduced drawing."""
    return replace(
        analysis,
        image=drawing.image,
        normals=drawing.enlarge_normals(analysis.normals),
        initial_normals=drawing.enlarge_normals(analysis.initial_normals),
        materials=replace(drawing.materials, color_maps=analysis.materials.color_maps),
        drawing=drawing,
    )

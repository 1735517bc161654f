"""One shape and color map of the study under the eyes of every method: what the study's pictures looked like."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.estimation.light_fit import estimate_light
from toonkit.estimation.preparation import prepare
from toonkit.metrics import angular_error
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.model.normals import NormalField, encode_normal_map
from toonkit.study.color_maps import load_color_maps
from toonkit.study.estimators import Estimator, list_estimators
from toonkit.study.painting import Angles, Painting, StudySettings, paint
from toonkit.study.records import LightTrack
from toonkit.study.rendering import RenderedShape, render_shape
from toonkit.study.shapes import SHAPES
from toonkit.viz.figures.study_style import format_name

EXAMINED_SIZE = 256
"""Pixels: enough to look at beside five others, and analyzed by all methods in a few seconds."""

RELIT_PICTURES = 4
"""Of the study's new lights, evenly chosen."""

KEPT_SHAPES = 24

Pixels = NDArray[np.uint8]
Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Answer:
    """
    What a method makes of a picture, or the truth about it, ready to be shown.

    Attributes
    ----------
    name : str
        The method, or "truth".
    picture : ndarray, shape (H, W, 4)
        RGBA: the input as explained; the truth's is the input itself.
    normal_map : ndarray, shape (H, W, 4)
        RGBA.
    angle : ndarray, shape (H, W)
        Degrees between the normals and the true ones, NaN outside the object.
    color_map : ColorMap
        The color map.
    relit : tuple of ndarray, shape (H, W, 4)
        RGBA under each of the new lights.
    failure : str
        Why there is nothing to show; all arrays are then empty.
    """

    name: str
    picture: Pixels
    normal_map: Pixels
    angle: FloatArray
    color_map: ColorMap | None
    relit: tuple[Pixels, ...]
    failure: str = ""

    @property
    def mean_error(self) -> float:
        """Mean angle over the object, degrees; NaN after a failure."""
        known = self.angle[np.isfinite(self.angle)]
        return float(known.mean()) if known.size else float("nan")


@dataclass(frozen=True, eq=False)
class Examination:
    """
    All answers to one picture.

    Attributes
    ----------
    shape, color_map : str
        Names.
    light_track : {"given", "estimated"}
        Whether the methods were told the true light.
    size : int
        Width of the pictures in pixels.
    light : (float, float)
        The true light, degrees.
    new_lights : tuple of (float, float)
        Those of the relit pictures, degrees.
    methods : tuple of str
        All that were asked.
    answers : tuple of Answer
        The truth first, then the methods that have answered.
    unavailable : str
        Why this cannot be painted again; there are then no answers.
    """

    shape: str
    color_map: str
    light_track: LightTrack
    size: int
    light: Angles
    new_lights: tuple[Angles, ...]
    methods: tuple[str, ...]
    answers: tuple[Answer, ...] = ()
    unavailable: str = ""


def examine(
    shape: str,
    color_map: str,
    *,
    methods: Sequence[str],
    light_track: LightTrack,
    settings: StudySettings,
    progress: Progress = lambda _step, _fraction: None,
    partly: Callable[[Examination], None] = lambda _: None,
) -> Examination:
    """
    Paint a picture of the study again and let every method analyze it.

    A shape or color map that does not ship with toonkit makes the examination `unavailable`; an unknown method is an
    answer with a failure. `progress` is told what is being done and how much of it is, and may raise to end the
    examination; `partly` is shown the examination each time it has gained an answer.
    """
    lights = settings.new_lights[:: -(-len(settings.new_lights) // RELIT_PICTURES)]
    found = Examination(
        shape, color_map, light_track, settings.size, settings.light, lights, methods=tuple(methods)
    )
    color_maps = load_color_maps()
    for kind, name, known in (("shape", shape, SHAPES), ("color map", color_map, color_maps)):
        if name not in known:
            reason = f"The {kind} “{format_name(name)}” does not ship with toonkit, so its pictures cannot be painted again."
            return replace(found, unavailable=reason)
    progress(f"rendering {format_name(shape)}", 0.0)
    painting = paint(
        _rendered(shape, settings.size), color_maps[color_map], replace(settings, new_lights=lights)
    )
    found = replace(found, answers=(_truth(painting),))
    partly(found)
    light = painting.light if light_track == "given" else estimate_light(painting.image).light
    known_methods = list_estimators()
    for index, method in enumerate(methods):
        progress(f"analyzing with {format_name(method)}", (index + 1) / (len(methods) + 1))
        answer = _answer(method, known_methods.get(method), painting, light)
        found = replace(found, answers=(*found.answers, answer))
        partly(found)
    return found


def _truth(painting: Painting) -> Answer:
    normals = painting.truth.normals
    return Answer(
        name="truth",
        picture=painting.image.to_rgba(),
        normal_map=_normal_map(normals, painting),
        angle=np.where(normals.mask, 0.0, np.nan),
        color_map=painting.color_map,
        relit=tuple(_covered(picture, painting) for picture in painting.relit),
    )


def _answer(method: str, estimator: Estimator | None, painting: Painting, light: FloatArray) -> Answer:
    if estimator is None:
        return _failed(method, "this method is not installed here")
    try:
        analysis = estimator.analyze(prepare(painting.image), light)
        return Answer(
            name=method,
            picture=estimator.picture(analysis).to_rgba(),
            normal_map=_normal_map(analysis.normals, painting),
            angle=angular_error(analysis.normals, painting.truth.normals).map,
            color_map=analysis.materials.color_maps[0],
            relit=tuple(
                estimator.relight(analysis, light_direction(*angles)).to_rgba()
                for angles in painting.settings.new_lights
            ),
        )
    except Exception as error:  # as in the study: whatever a method does wrong is its result
        return _failed(method, f"{type(error).__name__}: {error}")


def _failed(method: str, reason: str) -> Answer:
    nothing = np.zeros((0, 0, 4), dtype=np.uint8)
    return Answer(method, nothing, nothing, np.zeros((0, 0)), None, (), failure=reason)


def _normal_map(normals: NormalField, painting: Painting) -> Pixels:
    return ToonImage(
        encode_normal_map(normals) / 255.0, normals.mask, alpha=painting.truth.coverage
    ).to_rgba()


def _covered(picture: ToonImage, painting: Painting) -> Pixels:
    """Give a true picture the soft outline that those of the methods inherit from their input."""
    return ToonImage(picture.color, picture.mask, alpha=painting.truth.coverage).to_rgba()


@lru_cache(maxsize=KEPT_SHAPES)
def _rendered(shape: str, size: int) -> RenderedShape:
    return render_shape(SHAPES[shape], size)

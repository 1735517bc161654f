"""The methods that the study compares: all of `toonkit.METHODS`, and a trivial one that changes nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.color_map_fit import fit_color_map
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.methods import METHODS, Method
from toonkit.methods.steps import StepProgress
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.model.shading import illumination
from toonkit.relighting import relight

TOWARD_VIEWER = light_direction(0.0, 90.0)


def _relight_model_only(analysis: ToonAnalysis, new_light: FloatArray) -> ToonImage:
    return relight(analysis, new_light, keep_detail=False)


@dataclass(frozen=True)
class Estimator:
    """
    A method, and how its result is painted.

    Attributes
    ----------
    analyze : callable
        A function with the signature of `toonkit.methods.Method`.
    picture : callable, ToonAnalysis -> ToonImage
        Reconstruction of the input by the method.
    relight : callable, (ToonAnalysis, light (3,)) -> ToonImage
        The input under another light. By default it is Eq. 7, without the detail that `toonkit.relight` can keep, so
        that the comparison is about the method.
    """

    analyze: Method
    picture: Callable[[ToonAnalysis], ToonImage] = lambda analysis: analysis.picture
    relight: Callable[[ToonAnalysis, FloatArray], ToonImage] = _relight_model_only


def flat(
    drawing: PreparedDrawing,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """Return the baseline analysis, whose normals all face the viewer; any method must beat it."""
    del previous
    image = drawing.image
    vectors = np.where(image.mask[..., None], TOWARD_VIEWER, np.nan)
    normals = NormalField(vectors, image.mask)
    direction = np.asarray(light, dtype=np.float64)
    color_map = fit_color_map(drawing, illumination(normals, direction))
    if progress is not None:
        progress("done", 1.0)
    materials = Materials.single(image.mask, color_map)
    return ToonAnalysis(image, "flat", direction, normals, normals, materials)


FLAT = Estimator(flat, picture=lambda analysis: analysis.image, relight=lambda analysis, _: analysis.image)
"""Flat normals and the picture unchanged, whatever the light."""


def list_estimators() -> dict[str, Estimator]:
    """Return all methods of the study by name: those of `toonkit.METHODS`, plus `flat`."""
    return {**{name: Estimator(method) for name, method in METHODS.items()}, "flat": FLAT}

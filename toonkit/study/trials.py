"""Trials: a shape painted with a color map, analyzed by a method, and compared with the truth (Sections 4.1 to 4.3)."""

from __future__ import annotations

import copy
import platform
import time
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any, Literal

import numpy as np

import toonkit
from toonkit._validation import FloatArray, is_number, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.light_fit import LightEstimate, estimate_light
from toonkit.estimation.preparation import prepare
from toonkit.metrics import (
    UNCHANGED,
    PictureError,
    angular_error,
    color_difference,
    illumination_error,
    picture_error,
)
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import direction_of, light_direction
from toonkit.model.shading import illumination, shade
from toonkit.study.contestants import Contestant
from toonkit.study.rendering import MIN_SIZE, RenderedShape

LightTrack = Literal["given", "estimated"]
LIGHT_TRACKS: tuple[LightTrack, ...] = ("given", "estimated")
"""Whether a method is given the true light, as in the paper, or works with the estimated one."""

Angles = tuple[float, float]
"""Azimuth and elevation of a light, in degrees."""

NEW_LIGHTS: tuple[Angles, ...] = tuple(
    (azimuth, elevation) for azimuth in (0, 90, 180, 270) for elevation in (25, 60)
)
"""Azimuth and elevation, in degrees, of the lights for relighting."""


@dataclass(frozen=True)
class StudySettings:
    """
    Settings that all trials of a study share.

    Attributes
    ----------
    size : int
        Width and height of the pictures in pixels; the paper's 512.
    light : (float, float)
        Azimuth and elevation, in degrees, of the light L_t under which the shapes are painted.
    new_lights : tuple of (float, float)
        Azimuth and elevation, in degrees, of the lights for relighting.
    """

    size: int = 512
    light: Angles = (129.0, 50.0)
    new_lights: tuple[Angles, ...] = NEW_LIGHTS

    def __post_init__(self) -> None:
        if not isinstance(self.size, int) or isinstance(self.size, bool) or self.size < MIN_SIZE:
            raise refuse("size", f"must be a whole number of pixels, at least {MIN_SIZE}", self.size)
        if not self.new_lights:
            raise refuse("new_lights", "must hold at least one light", "none")
        object.__setattr__(self, "light", _checked_angles("light", self.light))
        lights = tuple(_checked_angles("new_lights", angles) for angles in self.new_lights)
        object.__setattr__(self, "new_lights", lights)


def _checked_angles(argument: str, angles: Angles) -> Angles:
    if len(angles) != 2 or not all(is_number(angle) for angle in angles):
        raise refuse(argument, "must be azimuth and elevation in degrees", angles)
    azimuth, elevation = (float(angle) for angle in angles)
    direction_of(argument, (azimuth, elevation))
    return azimuth, elevation


@dataclass(frozen=True, order=True)
class Trial:
    """
    A shape, a color map, a method and a light track.

    Attributes
    ----------
    shape, color_map, method : str
        Names of the shape, the color map and the method.
    light_track : {"given", "estimated"}
        Whether the method is given the true light or works with an estimate.
    """

    shape: str
    color_map: str
    method: str
    light_track: LightTrack

    @property
    def key(self) -> str:
        """Unique key of the trial, usable as a file name."""
        return "--".join((self.shape, self.color_map, self.method, self.light_track))


@dataclass(frozen=True)
class Record:
    """
    Measurements of one trial: a row of the study's table.

    Every error is a mean (or a root mean square, where the name says so) over the mask; `..._without_rim` leaves out the
    one-pixel rim, where a pixel is half background. Relighting errors are sRGB differences, averaged over the new
    lights. Each method paints with the color map it estimated. `error` is set for failed trials, and their measures are NaN.

    Attributes
    ----------
    shape, shape_kind, color_map, method, light_track : str
        The trial; the kind is "primitive", "complex" or "mesh".
    size : int
        Width of the picture in pixels.
    light_azimuth, light_elevation : float
        The true light, degrees.
    pixels : int
        Number of object pixels.
    light_error, light_confidence : float
        Angle between the light used and the true one, degrees (0 where the light is given), and the confidence of the
        estimate, 0 to 1 (1 where the light is given).
    angular_error, angular_error_without_rim, angular_error_median, angular_error_percentile_95 : float
        Angle between estimated and true normals, degrees.
    illumination_error, illumination_error_without_rim : float
        Difference between estimated and true L · N, each with its own light.
    color_map_rmse, color_map_rmse_without_rim : float
        The true normals painted with the estimated color map, against the input; sRGB.
    input_rmse, input_rmse_without_rim, input_difference : float
        Reconstruction of the input versus the input: sRGB root mean square error, and mean CIEDE2000.
    relight_rmse, relight_rmse_without_rim, relight_rmse_worst : float
        Relit pictures against the true ones, sRGB: the mean over the new lights, and the largest.
    relight_response, relight_response_without_rim : float
        Change of the picture under the new lights relative to the change of the true picture, as root mean squares over
        all lights. 1 is right; 0 is no change.
    iterations : int
        Iterations of the refinement.
    converged : bool
        Whether the refinement met its convergence criterion.
    stopped : str
        Why the refinement stopped.
    seconds : float
        Wall-clock seconds of the analysis; other trials may run at the same time. It is the only column that differs
        between two runs of the same trial.
    error : str
        Error of a failed trial; empty if the trial succeeded.
    toonkit, python, numpy, scipy, numba : str
        Package versions.
    """

    shape: str
    shape_kind: str
    color_map: str
    method: str
    light_track: str
    size: int
    light_azimuth: float
    light_elevation: float
    pixels: int = 0
    light_error: float = np.nan
    light_confidence: float = np.nan
    angular_error: float = np.nan
    angular_error_without_rim: float = np.nan
    angular_error_median: float = np.nan
    angular_error_percentile_95: float = np.nan
    illumination_error: float = np.nan
    illumination_error_without_rim: float = np.nan
    color_map_rmse: float = np.nan
    color_map_rmse_without_rim: float = np.nan
    input_rmse: float = np.nan
    input_rmse_without_rim: float = np.nan
    input_difference: float = np.nan
    relight_rmse: float = np.nan
    relight_rmse_without_rim: float = np.nan
    relight_rmse_worst: float = np.nan
    relight_response: float = np.nan
    relight_response_without_rim: float = np.nan
    iterations: int = 0
    converged: bool = False
    stopped: str = ""
    seconds: float = np.nan
    error: str = ""
    toonkit: str = ""
    python: str = ""
    numpy: str = ""
    scipy: str = ""
    numba: str = ""


@dataclass(frozen=True, eq=False)
class Painting:
    """
    A shape painted with a color map: the input of a trial, with the truth.

    Attributes
    ----------
    truth : RenderedShape
        The shape, with its true normals N_t.
    color_map : ColorMap
        M_t.
    settings : StudySettings
        The lights.
    image : ToonImage
        c_t = M_t(L_t · N_t), with the shape's coverage as alpha.
    relit : tuple of ToonImage
        Ground-truth pictures under each of the new lights.
    """

    truth: RenderedShape
    color_map: ColorMap
    settings: StudySettings
    image: ToonImage
    relit: tuple[ToonImage, ...]

    @property
    def light(self) -> FloatArray:
        """L_t, shape (3,)."""
        return light_direction(*self.settings.light)

    @cached_property
    def changes(self) -> tuple[PictureError, ...]:
        """Change of the ground-truth picture under each of the new lights."""
        return tuple(picture_error(relit, self.image) for relit in self.relit)


def paint(truth: RenderedShape, color_map: ColorMap, settings: StudySettings) -> Painting:
    """
    Paint a shape under the study's light, and under its new lights for comparison.

    Parameters
    ----------
    truth : RenderedShape
        The shape.
    color_map : ColorMap
        The color map.
    settings : StudySettings
        The lights.

    Returns
    -------
    Painting
        The input and the truth.
    """
    painted = shade(truth.normals, light_direction(*settings.light), color_map)
    image = ToonImage(painted.color, painted.mask, alpha=truth.coverage)
    lights = (light_direction(*angles) for angles in settings.new_lights)
    relit = tuple(shade(truth.normals, light, color_map) for light in lights)
    return Painting(truth, color_map, settings, image, relit)


def run_trial(trial: Trial, shape_kind: str, painting: Painting, contestant: Contestant) -> Record:
    """
    Analyze a painting and measure the outcome.

    Parameters
    ----------
    trial : Trial
        The trial.
    shape_kind : str
        The shape's kind.
    painting : Painting
        The input and the truth.
    contestant : Contestant
        The method.

    Returns
    -------
    Record
        The measures, or the error of the method or of the comparison.
    """
    record = unmeasured(trial, shape_kind, painting.settings)
    try:
        return replace(record, pixels=int(painting.image.mask.sum()), **_measure(trial, painting, contestant))
    except Exception as error:  # an error of the method is its result in this trial
        return replace(record, error=f"{type(error).__name__}: {error}")


def unmeasured(trial: Trial, shape_kind: str, settings: StudySettings, *, error: str = "") -> Record:
    """Return the record of a trial without measures, which are NaN."""
    azimuth, elevation = settings.light
    return Record(
        shape=trial.shape,
        shape_kind=shape_kind,
        color_map=trial.color_map,
        method=trial.method,
        light_track=trial.light_track,
        size=settings.size,
        light_azimuth=float(azimuth),
        light_elevation=float(elevation),
        error=error,
        toonkit=toonkit.__version__,
        python=platform.python_version(),
        numpy=version("numpy"),
        scipy=version("scipy"),
        numba=version("numba"),
    )


def _measure(trial: Trial, painting: Painting, contestant: Contestant) -> dict[str, Any]:
    estimate = LightEstimate(painting.light, 1.0)
    if trial.light_track == "estimated":
        estimate = estimate_light(painting.image)
    own = copy.deepcopy(painting.image)  # a method may change its copy of the input, but not that of others
    start = time.perf_counter()
    analysis = contestant.analyze(prepare(own), estimate.light)
    seconds = time.perf_counter() - start
    return {
        "light_error": _angle(estimate.light, painting.light),
        "light_confidence": float(estimate.confidence),
        **_measure_normals(analysis, painting),
        **_measure_reconstruction(analysis, painting, contestant),
        **_measure_relighting(analysis, painting, contestant),
        "iterations": int(analysis.report.iterations),
        "converged": bool(analysis.report.converged),
        "stopped": str(analysis.report.reason),
        "seconds": seconds,
    }


def _measure_normals(analysis: ToonAnalysis, painting: Painting) -> dict[str, float]:
    """Return the errors of the normals and of their illumination."""
    normals = painting.truth.normals
    angle = angular_error(analysis.normals, normals)
    light = illumination_error(
        analysis.illumination, illumination(normals, painting.light), painting.image.mask
    )
    return {
        "angular_error": angle.mean,
        "angular_error_without_rim": angle.mean_without_rim,
        "angular_error_median": angle.median,
        "angular_error_percentile_95": angle.percentile_95,
        "illumination_error": light.mean,
        "illumination_error_without_rim": light.mean_without_rim,
    }


def _measure_reconstruction(
    analysis: ToonAnalysis, painting: Painting, contestant: Contestant
) -> dict[str, float]:
    """Return the errors of the reconstruction, and of its color map evaluated on the true normals."""
    picture = contestant.picture(analysis)
    fit = picture_error(picture, painting.image)
    by_truth = replace(analysis, normals=painting.truth.normals).picture
    color_map = picture_error(by_truth, painting.image)
    return {
        "color_map_rmse": color_map.rmse,
        "color_map_rmse_without_rim": color_map.rmse_without_rim,
        "input_rmse": fit.rmse,
        "input_rmse_without_rim": fit.rmse_without_rim,
        "input_difference": color_difference(picture, painting.image).mean,
    }


def _measure_relighting(
    analysis: ToonAnalysis, painting: Painting, contestant: Contestant
) -> dict[str, float]:
    """Return the errors of the relit pictures, and how much they change relative to the true change."""
    before = contestant.picture(analysis)
    errors, changes = [], []
    for angles, truth in zip(painting.settings.new_lights, painting.relit, strict=True):
        relit = contestant.relight(analysis, light_direction(*angles))
        errors.append(picture_error(relit, truth))
        changes.append(picture_error(relit, before))
    rmse = [error.rmse for error in errors]
    return {
        "relight_rmse": float(np.mean(rmse)),
        "relight_rmse_without_rim": float(np.mean([error.rmse_without_rim for error in errors])),
        "relight_rmse_worst": max(rmse),
        "relight_response": _ratio(
            [change.rmse for change in changes], [change.rmse for change in painting.changes]
        ),
        "relight_response_without_rim": _ratio(
            [change.rmse_without_rim for change in changes],
            [change.rmse_without_rim for change in painting.changes],
        ),
    }


def _ratio(changes: list[float], true_changes: list[float]) -> float:
    """
    Return the ratio of the method's RMS change over all lights to the true one; NaN if the true one is negligible.

    Lights that barely change the true picture have little weight.
    """
    truth = float(np.linalg.norm(true_changes))
    return float(np.linalg.norm(changes)) / truth if truth > UNCHANGED else float("nan")


def _angle(a: FloatArray, b: FloatArray) -> float:
    return float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))

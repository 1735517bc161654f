"""Run a trial: analyze a painting by a method, and compare the result with the truth (Sections 4.1 to 4.3)."""

from __future__ import annotations

import copy
import time
from dataclasses import replace
from typing import Any

import numpy as np

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.light_fit import LightEstimate, estimate_light
from toonkit.estimation.preparation import prepare
from toonkit.metrics import UNCHANGED, angular_error, color_difference, illumination_error, picture_error
from toonkit.model.light import light_direction
from toonkit.model.shading import illumination
from toonkit.study.estimators import Estimator
from toonkit.study.painting import Painting
from toonkit.study.records import LightTrack, Record, Trial, blank_record


def run_trial(trial: Trial, shape_kind: str, painting: Painting, estimator: Estimator) -> Record:
    """Analyze a painting and return the measures, or the error of the method or of the comparison."""
    record = blank_record(trial, shape_kind, painting.settings)
    try:
        return replace(
            record,
            pixels=int(painting.image.mask.sum()),
            **_measure(painting, estimator, light_track=trial.light_track),
        )
    except Exception as error:  # an error of the method is its result in this trial
        return replace(record, error=f"{type(error).__name__}: {error}")


def _measure(painting: Painting, estimator: Estimator, *, light_track: LightTrack) -> dict[str, Any]:
    estimate = LightEstimate(painting.light, 1.0)
    if light_track == "estimated":
        estimate = estimate_light(painting.image)
    own = copy.deepcopy(painting.image)  # a method may change its copy of the input, but not that of others
    start = time.perf_counter()
    analysis = estimator.analyze(prepare(own), estimate.light)
    seconds = time.perf_counter() - start
    return {
        "light_error": _angle(estimate.light, painting.light),
        "light_confidence": float(estimate.confidence),
        **_measure_normals(analysis, painting),
        **_measure_reconstruction(analysis, painting, estimator),
        **_measure_relighting(analysis, painting, estimator),
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
    analysis: ToonAnalysis, painting: Painting, estimator: Estimator
) -> dict[str, float]:
    """Return the errors of the reconstruction, and of its color map evaluated on the true normals."""
    picture = estimator.picture(analysis)
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


def _measure_relighting(analysis: ToonAnalysis, painting: Painting, estimator: Estimator) -> dict[str, float]:
    """Return the errors of the relit pictures, and how much they change relative to the true change."""
    before = estimator.picture(analysis)
    errors, changes = [], []
    for angles, truth in zip(painting.settings.new_lights, painting.relit, strict=True):
        relit = estimator.relight(analysis, light_direction(*angles))
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

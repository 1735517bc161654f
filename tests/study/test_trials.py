"""A trial measures what it says it measures."""

from __future__ import annotations

import numpy as np
import pytest

import toonkit
from toonkit import Materials, NormalField, ToonAnalysis, ToonImage
from toonkit.numerics.report import SolverReport
from toonkit.study.color_maps import load_color_maps
from toonkit.study.estimators import FLAT, Estimator, list_estimators
from toonkit.study.painting import Painting, StudySettings, paint
from toonkit.study.records import Trial
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES
from toonkit.study.trials import run_trial

SETTINGS = StudySettings(size=48)
GIVEN = Trial("pear", "terracotta", "test", "given")
ESTIMATED = Trial("pear", "terracotta", "test", "estimated")


@pytest.fixture(scope="module")
def painting() -> Painting:
    return paint(render_shape(SHAPES["pear"], SETTINGS.size), load_color_maps()["terracotta"], SETTINGS)


def answering(painting: Painting, normals: NormalField | None = None) -> Estimator:
    """A method that knows the answer, except for the normals it is told to give."""

    def analyze(image, light, *, progress=None):
        given = painting.truth.normals if normals is None else normals
        report = SolverReport(3, np.zeros(0), "it knew", converged=True)
        return ToonAnalysis(
            image, "test", light, given, given, Materials.single(image.mask, painting.color_map), report
        )

    return Estimator(analyze)


def test_the_truth_has_no_error_and_the_right_response(painting):
    record = run_trial(GIVEN, "complex", painting, answering(painting))
    assert record.error == ""
    assert (record.angular_error, record.input_rmse, record.color_map_rmse) == pytest.approx((0, 0, 0))
    assert (record.relight_rmse, record.relight_rmse_worst) == pytest.approx((0, 0))
    assert (record.relight_response, record.relight_response_without_rim) == pytest.approx((1, 1))
    assert (record.iterations, record.converged, record.stopped) == (3, True, "it knew")


def test_flat_repeats_its_input_and_ignores_the_light(painting):
    record = run_trial(GIVEN, "complex", painting, FLAT)
    assert (record.input_rmse, record.relight_response) == (0, 0)
    slant = np.rad2deg(np.arccos(painting.truth.normals.vectors[painting.image.mask][:, 2]))
    assert record.angular_error == pytest.approx(slant.mean())


def test_a_turn_of_all_normals_is_the_angular_error(painting):
    normals = painting.truth.normals
    turn = np.deg2rad(10)
    about_z = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    turned = NormalField(normals.vectors @ about_z, normals.mask)
    record = run_trial(GIVEN, "complex", painting, answering(painting, turned))
    inside = normals.vectors[normals.mask]
    across = np.hypot(inside[:, 0], inside[:, 1])  # what a turn about z moves
    expected = np.rad2deg(2 * np.arcsin(across * np.sin(turn / 2)))
    assert record.angular_error == pytest.approx(expected.mean())
    assert record.angular_error_median == pytest.approx(np.median(expected))
    assert record.illumination_error > 0


def test_relit_pictures_are_measured_as_the_public_functions_do(painting):
    record = run_trial(GIVEN, "complex", painting, list_estimators()["lumo"])
    analysis = toonkit.analyze(painting.image, painting.light, method="lumo")
    relit = [
        toonkit.relight(analysis, toonkit.light_direction(*angles), keep_detail=False)
        for angles in SETTINGS.new_lights
    ]
    rmse = [toonkit.color_rmse(ours, true) for ours, true in zip(relit, painting.relit, strict=True)]
    changes = [toonkit.color_rmse(ours, analysis.picture) for ours in relit]
    true_changes = [toonkit.color_rmse(true, painting.image) for true in painting.relit]
    assert len(rmse) >= 8
    assert record.relight_rmse == pytest.approx(np.mean(rmse))
    assert record.relight_rmse_worst == pytest.approx(max(rmse))
    assert record.relight_response == pytest.approx(np.linalg.norm(changes) / np.linalg.norm(true_changes))
    assert record.input_rmse == pytest.approx(toonkit.color_rmse(analysis.picture, painting.image))


def test_the_light_is_the_true_one_or_the_estimate(painting):
    given = run_trial(GIVEN, "complex", painting, FLAT)
    estimated = run_trial(ESTIMATED, "complex", painting, FLAT)
    estimate = toonkit.estimate_light(painting.image)
    angle = np.rad2deg(np.arccos(estimate.light @ painting.light))
    assert (given.light_error, given.light_confidence) == (0, 1)
    assert estimated.light_error == pytest.approx(angle)
    assert estimated.light_confidence == pytest.approx(estimate.confidence)


def test_under_one_light_the_response_is_the_public_one():
    settings = StudySettings(size=48, new_lights=((30, 40),))
    one = paint(render_shape(SHAPES["pear"], 48), load_color_maps()["terracotta"], settings)
    record = run_trial(GIVEN, "complex", one, list_estimators()["lumo"])
    analysis = toonkit.analyze(one.image, one.light, method="lumo")
    relit = toonkit.relight(analysis, toonkit.light_direction(30, 40), keep_detail=False)
    response = toonkit.relight_response(analysis.picture, relit, one.image, one.relit[0])
    assert record.relight_response == pytest.approx(response)


def broken(image: ToonImage, light, *, progress=None) -> ToonAnalysis:
    raise RuntimeError("no idea")


def vandal(image: ToonImage, light, *, progress=None) -> ToonAnalysis:
    """Smears its input."""
    image.color[:] = 0.5
    return toonkit.METHODS["lumo"](image, light)


def test_a_method_that_changes_its_input_changes_nothing_else(painting):
    before = painting.image.color.copy()
    assert run_trial(GIVEN, "complex", painting, Estimator(vandal)).error == ""
    assert np.array_equal(painting.image.color, before, equal_nan=True)


def test_lights_may_be_given_as_any_numbers():
    settings = StudySettings(light=[129, 50], new_lights=[(0, 25), np.array([90, 60], dtype=np.float32)])
    assert settings == StudySettings(light=(129.0, 50.0), new_lights=((0.0, 25.0), (90.0, 60.0)))
    assert hash(settings)


def elsewhere(image: ToonImage, light, *, progress=None) -> ToonAnalysis:
    """Answers about another object than the one it was asked about."""
    mask = np.ones_like(image.mask)
    return toonkit.METHODS["lumo"](ToonImage(np.where(mask[..., None], 0.5, 0.5), mask), light)


@pytest.mark.parametrize(("method", "says"), [(broken, "RuntimeError: no idea"), (elsewhere, "ToonkitError")])
def test_a_failure_is_a_record_with_its_error(painting, method, says):
    record = run_trial(GIVEN, "complex", painting, Estimator(method))
    assert record.error.startswith(says)
    assert np.isnan(record.angular_error)
    assert np.isnan(record.relight_rmse)
    assert (record.shape, record.method) == ("pear", "test")


@pytest.mark.parametrize(
    "wrong", [{"size": 4}, {"size": 64.0}, {"new_lights": ()}, {"light": (10,)}, {"light": (10, -40)}]
)
def test_settings_that_make_no_study_are_refused(wrong):
    with pytest.raises(toonkit.ToonkitError, match=next(iter(wrong))):
        StudySettings(**wrong)

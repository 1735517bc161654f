import numpy as np
import pytest

import toonkit
from tests.analytic import LIGHT, SOFT, TWO_TONE, ellipse, painted
from toonkit import METHODS, ToonImage, ToonkitError, analyze, angular_error, color_rmse
from toonkit.samples import sample_path


@pytest.fixture(scope="module")
def egg():
    shape = ellipse(48, 30)
    return shape, painted(shape.normals, SOFT, alpha=shape.coverage)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_answers_alike(egg, method):
    _, image = egg
    analysis = analyze(image, LIGHT, method=method)
    assert analysis.method == method
    assert np.allclose(np.linalg.norm(analysis.normals.vectors[image.mask], axis=1), 1)
    assert np.isnan(analysis.normals.vectors[~image.mask]).all()
    assert np.isnan(analysis.illumination[~image.mask]).all()
    assert analysis.report.reason
    assert (analysis.light == LIGHT).all()


@pytest.mark.parametrize("method", METHODS)
def test_every_method_reproduces_a_soft_picture(egg, method):
    _, image = egg
    # Rank matching alone already gives most of it; 0.05 is about a tenth of the picture's own contrast.
    assert color_rmse(analyze(image, LIGHT, method=method).picture, image) < 0.05


def test_refinement_beats_inflation_on_a_shape_that_inflation_gets_wrong(egg):
    shape, image = egg
    error = {
        name: angular_error(analyze(image, LIGHT, method=name).normals, shape.normals).mean
        for name in METHODS
    }
    assert error["toonkit"] < error["lumo"]
    assert error["toonkit"] < error["todo"] < error["lambert"]


@pytest.mark.parametrize("color_map", [TWO_TONE, SOFT], ids=["two-tone", "soft"])
def test_a_ball_stays_a_ball(color_map):
    ball = ellipse(48, 48)
    analysis = analyze(painted(ball.normals, color_map, alpha=ball.coverage), LIGHT)
    # Its inflation is right to 0.1 degrees; a band edge read on whole pixels may move it by half a pixel of 48.
    assert angular_error(analysis.normals, ball.normals).mean < 0.6


def test_without_a_light_one_is_estimated(egg):
    _, image = egg
    assert np.allclose(analyze(image).light, toonkit.estimate_light(image).light, atol=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_progress_is_named_and_rises_to_one(egg, method):
    _, image = egg
    seen = []
    analyze(image, LIGHT, method=method, progress=lambda step, fraction: seen.append((step, fraction)))
    fractions = [fraction for _, fraction in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert seen[0][0] == "inflating the silhouette"


def test_what_progress_raises_cancels(egg):
    _, image = egg

    def cancel(_step, fraction):
        if fraction > 0.3:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        analyze(image, LIGHT, progress=cancel)


@pytest.mark.parametrize("method", METHODS)
def test_several_components_and_holes_are_handled(method):
    shape = ellipse(30, 30)
    mask = shape.mask & ~(np.hypot(shape.x, shape.y) < 8)
    mask[:, 20:23] = False
    image = ToonImage(SOFT(np.clip(shape.normals.vectors @ LIGHT, -1, 1)), mask)
    assert np.isfinite(analyze(image, LIGHT, method=method).normals.vectors[mask]).all()


@pytest.mark.parametrize("method", METHODS)
def test_one_single_color_keeps_the_inflated_shape_and_stays_that_color(method):
    shape = ellipse(24, 24)
    image = ToonImage(np.full((*shape.mask.shape, 3), 0.4), shape.mask)
    analysis = analyze(image, LIGHT, method=method)
    assert color_rmse(toonkit.relight(analysis, [1, 0, 1], flat_shading=0), image) < 1e-9


@pytest.mark.parametrize(
    ("light", "words"),
    [
        ([0, 0, 0], "zero vector"),
        ([0, 0.5, -1], "behind"),
        ([np.nan, 0, 1], "finite"),
        ([0, 1, 2, 3], "direction"),
    ],
)
def test_a_light_that_is_none_is_refused(egg, light, words):
    _, image = egg
    with pytest.raises(ToonkitError, match=words):
        analyze(image, light)


def test_an_unknown_method_and_a_bare_array_are_refused(egg):
    _, image = egg
    with pytest.raises(
        ToonkitError, match="must be one of toonkit, classical, todo, lumo, lambert; got 'best'"
    ):
        analyze(image, LIGHT, method="best")
    with pytest.raises(ToonkitError, match="load_image"):
        analyze(image.color, LIGHT)


@pytest.mark.parametrize("method", ["toonkit", "classical"])
def test_under_a_light_nearby_an_earlier_answer_leads_to_the_same_shape(egg, method):
    shape, image = egg
    nearby = toonkit.light_direction(*np.add(toonkit.light_angles(LIGHT), [4.0, -3.0]))
    earlier = analyze(image, LIGHT, method=method)
    again = analyze(image, nearby, method=method, previous=earlier)
    afresh = analyze(image, nearby, method=method)
    assert again.report.iterations <= afresh.report.iterations
    assert angular_error(again.normals, afresh.normals).mean < 0.5  # neither is solved to the end
    off = [angular_error(found.normals, shape.normals).mean for found in (again, afresh)]
    assert off[0] < off[1] + 0.3


@pytest.mark.parametrize("method", ["todo", "lumo", "lambert"])
def test_a_method_that_starts_afresh_does_not_mind_an_earlier_answer(egg, method):
    _, image = egg
    previous = analyze(image, LIGHT, method="classical")
    with_it = analyze(image, LIGHT, method=method, previous=previous)
    without = analyze(image, LIGHT, method=method)
    assert np.array_equal(with_it.normals.vectors, without.normals.vectors, equal_nan=True)


def test_an_earlier_answer_to_another_drawing_is_refused(egg):
    _, image = egg
    other = ellipse(30, 48)
    earlier = analyze(painted(other.normals, SOFT), LIGHT, method="lumo")
    with pytest.raises(ToonkitError, match="previous must"):
        analyze(image, LIGHT, previous=earlier)
    with pytest.raises(ToonkitError, match="previous must be a ToonAnalysis"):
        analyze(image, LIGHT, previous=image)


def test_what_returns_no_analysis_is_refused(monkeypatch):
    monkeypatch.setitem(toonkit.METHODS, "normals", lambda drawing, light, **_: drawing.initial_normals)
    for light in ((135, 45), None):
        with pytest.raises(ToonkitError, match=r"method must return a ToonAnalysis.*got NormalField"):
            toonkit.analyze("sample:pear", light, method="normals")


def test_samples_are_drawings_by_name():
    analysis = toonkit.analyze("sample:pear", (135, 45), method="lumo")
    assert analysis.image.shape == toonkit.load_image(sample_path("pear")).shape
    with pytest.raises(ToonkitError, match="did you mean 'pear'"):
        toonkit.analyze("sample:paer", (135, 45))


def test_a_stroke_is_no_illumination():
    image = toonkit.load_image(sample_path("pear"))
    with pytest.raises(ToonkitError, match="extract_color_map"):
        toonkit.fit_color_map(image, image.mask)

import numpy as np
import pytest

from tests.analytic import SOFT, ellipse, painted
from toonkit import (
    LightEstimate,
    ToonImage,
    ToonkitError,
    analyze,
    estimate_light,
    inflate,
    light_angles,
    light_direction,
)
from toonkit.estimation import light_fit
from toonkit.estimation.light_fit import LOWEST_ELEVATION, RING, SPREADS, TRIED, candidates, sharpen
from toonkit.estimation.light_prior import LightBelief


@pytest.mark.parametrize(("azimuth", "elevation"), [(0, 30), (130, 50), (-100, 45), (45, 75)])
def test_the_light_of_a_softly_shaded_ball_is_found(azimuth, elevation):
    ball = ellipse(48, 48)
    light = light_direction(azimuth, elevation)
    estimate = estimate_light(painted(ball.normals, SOFT, light=light, alpha=ball.coverage))
    angle = np.degrees(np.arccos(np.clip(estimate.light @ light, -1, 1)))
    assert angle < 12
    assert estimate.confidence > 0.8


def test_one_single_color_says_nothing_about_the_light():
    ball = ellipse(20, 20)
    estimate = estimate_light(ToonImage(np.full((*ball.mask.shape, 3), 0.5), ball.mask))
    assert estimate.confidence == 0.0
    assert light_angles(estimate.light)[1] == pytest.approx(90)


def test_the_estimate_never_comes_from_behind():
    ball = ellipse(32, 32)
    color = np.repeat((0.5 - 0.4 * ball.normals.vectors[..., 2])[..., None], 3, axis=2)  # dark in the middle
    assert estimate_light(ToonImage(color, ball.mask)).light[2] >= 0


def test_the_confidence_is_that_of_the_light_which_is_returned():
    ball = ellipse(32, 32)
    x, _, z = np.moveaxis(ball.normals.vectors, -1, 0)
    color = np.repeat(
        (0.6 - 0.4 * z + 0.02 * x)[..., None], 3, axis=2
    )  # bright at the rim: no light in front does that
    assert estimate_light(ToonImage(color, ball.mask)).confidence < 0.1


def test_normals_of_another_mask_are_refused():
    ball, smaller = ellipse(20, 20), ellipse(20, 14)
    image = painted(ball.normals, SOFT)
    with pytest.raises(ToonkitError, match="initial_normals must cover the same mask"):
        estimate_light(image, initial_normals=smaller.normals)


def test_the_lights_that_are_tried_stand_in_a_ring_around_the_believed_one():
    belief = LightBelief(light_direction(60, 70), 1 / 0.05**2)
    lights = candidates(belief)
    assert np.array_equal(lights[0], belief.light)
    assert np.linalg.norm(lights, axis=1) == pytest.approx(1)
    apart = np.arccos(np.clip(lights[1:] @ belief.light, -1, 1))
    assert apart == pytest.approx(np.full(TRIED, 0.05 * RING))
    assert lights.mean(axis=0) / np.linalg.norm(lights.mean(axis=0)) == pytest.approx(belief.light)


def test_no_light_is_tried_that_stands_too_low_or_too_far_away():
    low = candidates(LightBelief(light_direction(200, 1), 0.05))
    assert 1 < len(low) < 1 + TRIED
    assert low[1:, 2].min() > np.sin(np.deg2rad(LOWEST_ELEVATION))
    assert np.arccos(low[1:] @ low[0]).max() <= RING * SPREADS[1] + 1e-9


def test_a_belief_moves_to_the_lights_that_leave_less_unexplained(monkeypatch):
    belief, truth = LightBelief(light_direction(40, 50), 60.0), light_direction(52, 44)
    apart = np.arccos(belief.light @ truth)

    def distance(image, lights, initial_normals):
        return 1e-3 + np.arccos(np.clip(lights @ truth, -1, 1)) ** 2

    monkeypatch.setattr(light_fit, "misfit", distance)
    after = sharpen(belief, None, None)
    assert np.linalg.norm(after.light) == pytest.approx(1)
    assert np.arccos(after.light @ truth) < 0.5 * apart
    assert after.concentration > belief.concentration


@pytest.mark.parametrize("concentration", [0.05, 2.0, 60.0, 2000.0])
@pytest.mark.parametrize("elevation", [6.0, 50.0])
def test_lights_that_all_fit_alike_change_no_belief(concentration, elevation, monkeypatch):
    belief = LightBelief(light_direction(40, elevation), concentration)
    monkeypatch.setattr(light_fit, "misfit", lambda image, lights, normals: np.full(len(lights), 0.1))
    after = sharpen(belief, None, None)
    assert after.light == pytest.approx(belief.light)
    assert after.concentration == pytest.approx(belief.concentration)


def test_trying_lights_brings_the_estimate_nearer_on_the_whole():
    shape = ellipse(60, 34)
    normals = inflate(shape.mask, alpha=shape.coverage)
    believed, after = [], []
    for azimuth in range(0, 360, 60):
        light = light_direction(azimuth, 45)
        image = painted(shape.normals, SOFT, light=light, alpha=shape.coverage)
        belief = LightBelief(light_direction(azimuth + 9, 37), 1 / np.deg2rad(8) ** 2)
        believed.append(np.rad2deg(np.arccos(belief.light @ light)))
        after.append(np.rad2deg(np.arccos(sharpen(belief, image, normals).light @ light)))
    assert np.mean(after) < 0.8 * np.mean(believed)


def test_a_confident_estimate_is_assumed_and_a_guess_is_not(monkeypatch):
    y, x = np.mgrid[:48, :48] - 23.5
    image = ToonImage(np.full((48, 48, 3), 0.5), x**2 + y**2 < 400)
    for confidence, angles in ((0.3, (20, 30)), (0.02, light_fit.CUSTOMARY_LIGHT)):
        found = LightEstimate(light_direction(20, 30), confidence)
        monkeypatch.setattr(light_fit, "estimate_light", lambda _, found=found: found)
        assumed = light_fit.assume_light(image)
        assert assumed.confidence == confidence
        np.testing.assert_allclose(assumed.light, light_direction(*angles))


def test_without_shading_the_light_is_the_customary_one():
    y, x = np.mgrid[:48, :48] - 23.5
    image = ToonImage(np.full((48, 48, 3), 0.5), x**2 + y**2 < 400)
    analysis = analyze(image)
    assert light_angles(analysis.light) == pytest.approx(light_fit.CUSTOMARY_LIGHT)
    assert analysis.light_estimate.confidence == 0
    assert analysis.light_source == "assumed"
    assert repr(analysis).endswith("light at azimuth 130°, elevation 50° (assumed, confidence 0.00))")

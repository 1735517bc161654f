import numpy as np
import pytest

from tests.analytic import SOFT, ellipse, painted
from toonkit import ToonImage, ToonkitError, estimate_light, light_angles, light_direction


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

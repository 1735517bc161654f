"""A traveling light takes the shortest way around, at an even speed, and comes back where it is to loop."""

import numpy as np
import pytest

from toonkit import ToonkitError, light_angles, light_direction
from toonkit.model.light_path import light_path

LIGHTS = [(35, 40), (150, 20), (-100, -25)]


def degrees_between(one, other):
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), (one * other).sum(axis=-1)))


def test_a_path_passes_each_light_and_ends_at_the_last():
    path = light_path(LIGHTS, 9, loop=False)
    np.testing.assert_allclose(path[[0, 4, 8]], [light_direction(*light) for light in LIGHTS], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(path, axis=1), 1)


def test_a_loop_closes_without_showing_the_first_light_twice():
    path = light_path(LIGHTS, 9)
    np.testing.assert_allclose(path[::3], [light_direction(*light) for light in LIGHTS], atol=1e-12)
    np.testing.assert_allclose(degrees_between(path[8], path[0]), degrees_between(path[7], path[8]))


def test_the_light_takes_the_shorter_way_around_at_an_even_speed():
    path = light_path([(170, 0), (-170, 0)], 5, loop=False)
    np.testing.assert_allclose(degrees_between(path[1:], path[:-1]), 5)
    assert abs(light_angles(path[2])[0]) == pytest.approx(180)


@pytest.mark.parametrize(
    ("lights", "between"), [([(0, 0), (180, 0)], (0, 0, 1)), ([(0, 90), (0, -90)], (0, 1, 0))]
)
def test_between_opposite_lights_the_way_leads_past_the_viewer_or_over_the_top(lights, between):
    np.testing.assert_allclose(light_path(lights, 3, loop=False)[1], between, atol=1e-12)


def test_a_light_that_stays_stays():
    np.testing.assert_allclose(
        light_path([(1, 2, 3), (2, 4, 6)], 4), np.tile(np.array([1, 2, 3]) / 14**0.5, (4, 1))
    )


@pytest.mark.parametrize(
    ("lights", "frames", "reason"),
    [
        ([(35, 40)], 8, "lights must be two or more lights"),
        (None, 8, "lights must be two or more lights"),
        (35.0, 8, "lights must be two or more lights"),
        ([(35, 40), (0, 91)], 8, "elevation must lie in -90 to 90"),
        ([(35, 40), (0, 0, 0)], 8, r"lights\[1\] must"),
        ((35, 40), 8, r"lights\[0\] must"),
        (LIGHTS, 1, "frames must be a whole number from 2 to 720"),
    ],
)
def test_what_is_no_path_is_refused(lights, frames, reason):
    with pytest.raises(ToonkitError, match=reason):
        light_path(lights, frames)

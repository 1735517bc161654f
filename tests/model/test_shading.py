"""The forward model: illumination is L · N, and the picture is the color map of it."""

import numpy as np
import pytest

from toonkit import ColorMap, NormalField, ToonImage, ToonkitError, illumination, light_direction, shade

SIZE = 41
ROWS, COLUMNS = np.indices((SIZE, SIZE))
X, Y = (COLUMNS - 20) / 18, (20 - ROWS) / 18
DISC = X**2 + Y**2 < 1
BALL = NormalField(np.stack([X, Y, np.sqrt(np.clip(1 - X**2 - Y**2, 0, 1))], axis=-1), DISC)
RAMP = ColorMap([[0, 0, 0], [1, 1, 1]])


@pytest.mark.parametrize(
    ("azimuth", "row", "column"),
    [
        pytest.param(90, 3, 20, id="a light from azimuth 90 brightens the top: low rows"),
        pytest.param(270, 37, 20, id="from 270 the bottom"),
        pytest.param(0, 20, 37, id="from 0 the right"),
        pytest.param(180, 20, 3, id="from 180 the left"),
    ],
)
def test_the_side_toward_the_light_is_bright(azimuth, row, column):
    lit = illumination(BALL, light_direction(azimuth, 0))
    assert lit[row, column] == np.nanmax(lit)
    assert lit[SIZE - 1 - row, SIZE - 1 - column] == np.nanmin(lit)


def test_a_ball_faces_its_light_where_its_normal_is_the_light():
    light = light_direction(30, 50)
    lit = illumination(BALL, light)
    row, column = np.unravel_index(np.nanargmax(lit), lit.shape)
    # half a pixel of a radius of 18, in both directions
    assert (X[row, column], Y[row, column]) == pytest.approx(light[:2], abs=0.5 / 18)


def test_illumination_is_neither_clamped_nor_shifted():
    lit = illumination(BALL, light_direction(0, 0))
    assert lit[DISC] == pytest.approx(X[DISC], abs=1e-12)
    assert np.nanmin(lit) < -0.9  # the last pixel inside the rim stands at 17 / 18


def test_illumination_is_nan_outside_the_mask():
    assert (np.isnan(illumination(BALL, [0, 0, 1])) == ~DISC).all()


def test_a_lights_length_does_not_matter():
    assert np.array_equal(illumination(BALL, [0, 3, 4]), illumination(BALL, [0, 0.6, 0.8]), equal_nan=True)


def test_shading_is_the_color_map_of_the_illumination():
    light = light_direction(135, 40)
    picture = shade(BALL, light, RAMP)
    assert isinstance(picture, ToonImage)
    assert (picture.mask == DISC).all()
    assert picture.color[DISC] == pytest.approx(RAMP(illumination(BALL, light))[DISC])
    assert np.isnan(picture.color[~DISC]).all()


def test_a_light_straight_from_behind_turns_the_illumination_round():
    assert np.array_equal(illumination(BALL, [0, 0, -1]), -illumination(BALL, [0, 0, 1]), equal_nan=True)


def test_a_light_that_points_nowhere_is_refused():
    with pytest.raises(ToonkitError, match="light must point somewhere"):
        shade(BALL, [0, 0, 0], RAMP)

"""Light directions: where the angles point, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from toonkit import ToonkitError, light_angles, light_direction
from toonkit.model.light import direction_of

ROUNDING = 1e-12  # a handful of floating-point operations on numbers of size 1


@pytest.mark.parametrize(
    ("azimuth", "elevation", "direction"),
    [
        pytest.param(0, 0, (1, 0, 0), id="azimuth 0 is right"),
        pytest.param(90, 0, (0, 1, 0), id="azimuth 90 is up"),
        pytest.param(180, 0, (-1, 0, 0), id="azimuth 180 is left"),
        pytest.param(270, 0, (0, -1, 0), id="azimuth 270 is below"),
        pytest.param(-90, 0, (0, -1, 0), id="azimuth -90 is below"),
        pytest.param(0, 90, (0, 0, 1), id="elevation 90 is the viewer"),
        pytest.param(123, 90, (0, 0, 1), id="at elevation 90 azimuth does not matter"),
        pytest.param(0, -90, (0, 0, -1), id="elevation -90 is straight behind the picture"),
        pytest.param(90, -45, (0, 0.5**0.5, -(0.5**0.5)), id="behind and above"),
        pytest.param(135, 45, (-0.5, 0.5, 0.5**0.5), id="upper left"),
        pytest.param(450, 0, (0, 1, 0), id="azimuth is periodic"),
    ],
)
def test_angles_point_where_they_should(azimuth, elevation, direction):
    assert light_direction(azimuth, elevation) == pytest.approx(direction, abs=ROUNDING)


@given(st.floats(-179.9, 180), st.floats(-89.9, 89.9))
def test_angles_survive_the_way_to_a_vector_and_back(azimuth, elevation):
    # 1e-8 degrees: directions are rounded to 15 digits, and at elevation 89.9 azimuth loses three of them. A light less than
    # 6e-8 degrees behind the picture counts as beside it.
    back = light_angles(light_direction(azimuth, elevation))
    assert back[0] == pytest.approx(azimuth, abs=1e-8)
    assert back[1] == pytest.approx(elevation, abs=6e-8 if elevation < 0 else 1e-8)


@given(st.floats(-1000, 1000), st.floats(0, 90))
def test_every_light_has_unit_length_and_shines_from_the_viewers_side(azimuth, elevation):
    light = light_direction(azimuth, elevation)
    assert np.linalg.norm(light) == pytest.approx(1, abs=ROUNDING)
    assert light[2] >= 0


def test_length_does_not_change_the_angles():
    assert light_angles([-3, 3, 0]) == pytest.approx((135, 0))


@pytest.mark.parametrize("elevation", [-90.001, 90.001, 180])
def test_an_elevation_past_the_poles_is_refused(elevation):
    with pytest.raises(ToonkitError, match="elevation must lie in -90 to 90 degrees"):
        light_direction(0, elevation)


@pytest.mark.parametrize("light", [(0, -0.001), (0, -90), (0.0, 0.6, -0.8)])
def test_a_light_from_behind_is_refused_where_a_drawing_is_shaded_by_it(light):
    with pytest.raises(ToonkitError, match="0 to 90 degrees"):
        direction_of("light", light)
    assert direction_of("light", light, behind=True)[2] < 0


@pytest.mark.parametrize("bad", [np.nan, np.inf, "45", None, [45]])
@pytest.mark.parametrize("argument", ["azimuth", "elevation"])
def test_angles_that_are_no_numbers_are_refused(argument, bad):
    with pytest.raises(ToonkitError, match=f"{argument} must be a finite number"):
        light_direction(**{"azimuth": 0, "elevation": 0, argument: bad})


@pytest.mark.parametrize(
    ("light", "reason"),
    [
        ([0, 0, 0], "must point somewhere"),
        ([np.nan, 0, 1], "must be finite"),
        ([0, 1], r"must be a direction \(x, y, z\)"),
        (["a", "b", "c"], "must be a direction"),
        ([1j, 0, 1], "must be a direction"),
    ],
)
def test_vectors_that_are_no_lights_are_refused(light, reason):
    with pytest.raises(ToonkitError, match=reason):
        light_angles(light)

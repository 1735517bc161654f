"""Color maps: evaluation, and inversion to an interval of illumination."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from toonkit import ColorMap, ToonkitError
from toonkit.model.color_map import HALF_STEP, MONOTONE_TOLERANCE
from toonkit.model.luminance import tone

BLACK, GRAY, WHITE = [0.0] * 3, [0.5] * 3, [1.0] * 3

gray_ramp = ColorMap([BLACK, WHITE])
three_tones = ColorMap(
    np.repeat([[0.2, 0.1, 0.3], [0.6, 0.4, 0.4], [1.0, 0.9, 0.7]], 20, axis=0), (-0.5, 0.9)
)


@st.composite
def color_maps(draw):
    """Ramps of 1 to 12 grays or tinted colors, dark to bright, over any domain."""
    levels = np.sort(draw(arrays(float, st.integers(1, 12), elements=st.floats(0, 1))))
    tint = draw(st.tuples(*[st.floats(0.2, 1)] * 3))
    lo = draw(st.floats(-1, 0.8))
    hi = draw(st.floats(lo + 0.1, 1))
    return ColorMap(levels[:, None] * np.array(tint), (lo, hi))


illuminations = arrays(float, 20, elements=st.floats(-1, 1))


def test_samples_are_met_at_their_own_illumination():
    assert three_tones(three_tones.illumination) == pytest.approx(three_tones.colors, abs=1e-12)


def test_between_two_samples_the_map_is_linear():
    assert gray_ramp([-0.5, 0.0, 0.25]).tolist() == [[0.25] * 3, [0.5] * 3, [0.625] * 3]


def test_rounding_takes_no_color_out_of_the_range_of_the_ramp():
    # At this domain's end the position among the samples comes out 3e-14 beyond the last one.
    steep = ColorMap(np.linspace([0.0, 0.1, 0.0], 1.0, 219) ** 9, (0.09, 0.87))
    colors = steep([0.87, 1.0])
    assert colors.max() == 1


@pytest.mark.parametrize(("value", "end"), [(-1, 0), (-0.51, 0), (0.91, -1), (1, -1)])
def test_outside_its_domain_the_map_takes_its_ends(value, end):
    assert (three_tones(value) == three_tones.colors[end]).all()


def test_nan_illumination_has_no_color():
    colors = three_tones([[0.0, np.nan]])
    assert colors.shape == (1, 2, 3)
    assert np.isnan(colors[0, 1]).all()
    assert np.isfinite(colors[0, 0]).all()


@given(color_maps(), illuminations)
def test_a_colors_interval_contains_the_illumination_it_came_from(color_map, value):
    interval = color_map.invert(color_map(value))
    # 1e-9: the tone of an interpolated color is rounded, and intervals are closed
    assert (interval.lower <= value + 1e-9).all()
    assert (value <= interval.upper + 1e-9).all()


@given(color_maps(), arrays(float, (20, 3), elements=st.floats(0, 1)))
def test_every_color_has_an_ordered_interval_within_minus_one_and_one(color_map, colors):
    interval = color_map.invert(colors)
    assert (interval.lower >= -1).all()
    assert (interval.upper <= 1).all()
    assert (interval.lower <= interval.upper + 1e-12).all()


@given(color_maps(), illuminations, st.floats(0, 0.1))
def test_more_tolerance_never_narrows_an_interval(color_map, value, more):
    colors = color_map(value)
    narrow, wide = color_map.invert(colors), color_map.invert(colors, tolerance=HALF_STEP + more)
    assert (wide.lower <= narrow.lower + 1e-12).all()
    assert (wide.upper >= narrow.upper - 1e-12).all()


def test_a_flat_band_owns_the_interval_it_covers():
    interval = three_tones.invert([0.6, 0.4, 0.4])
    where = three_tones.illumination
    # The tolerance reaches a fraction of one step of the samples into the neighboring bands.
    step = where[1] - where[0]
    assert interval.lower == pytest.approx(where[20], abs=step)
    assert interval.upper == pytest.approx(where[39], abs=step)


@pytest.mark.parametrize(
    ("color", "lower", "upper"),
    [
        pytest.param([0.2, 0.1, 0.3], -1.0, None, id="darkest reaches down to -1"),
        pytest.param(BLACK, -1.0, None, id="darker than darkest, too"),
        pytest.param([1.0, 0.9, 0.7], None, 1.0, id="brightest reaches up to +1"),
        pytest.param(WHITE, None, 1.0, id="brighter than brightest, too"),
    ],
)
def test_the_two_ends_of_a_map_are_open(color, lower, upper):
    interval = three_tones.invert(color)
    assert lower is None or interval.lower == lower
    assert upper is None or interval.upper == upper


def test_one_color_tells_nothing_about_illumination():
    interval = ColorMap([GRAY]).invert(GRAY)
    assert (interval.lower, interval.upper) == (-1.0, 1.0)


def test_a_map_of_one_color_paints_everything_alike():
    assert ColorMap([GRAY], (0.0, 0.4))([-1.0, 0.2, 1.0]).tolist() == [GRAY] * 3


def test_an_exact_color_of_a_steep_ramp_has_a_narrow_interval():
    interval = gray_ramp.invert(GRAY, tolerance=0)
    # 1e-6: encoding and decoding sRGB
    assert interval.lower == pytest.approx(0.0, abs=1e-5)
    assert interval.upper == pytest.approx(0.0, abs=1e-5)


def test_a_dip_in_the_ramp_widens_the_interval_over_it():
    dip = ColorMap([[0.2] * 3, [0.52] * 3, [0.5] * 3, [0.8] * 3])
    interval = dip.invert([0.51] * 3, tolerance=0)
    assert interval.lower < dip.illumination[1] < dip.illumination[2] < interval.upper


def test_nan_colors_have_nan_intervals():
    interval = three_tones.invert([[np.nan] * 3, GRAY])
    assert np.isnan([interval.lower[0], interval.upper[0]]).all()
    assert np.isfinite([interval.lower[1], interval.upper[1]]).all()


def test_resampling_a_linear_ramp_does_not_change_it():
    value = np.linspace(-1, 1, 31)
    assert gray_ramp.resampled(7)(value) == pytest.approx(gray_ramp(value), abs=1e-12)
    assert three_tones.resampled(999).domain == three_tones.domain


def test_the_colors_given_are_not_changed():
    given_colors = np.array([BLACK, WHITE])
    ColorMap(given_colors)(0.3)
    assert given_colors.tolist() == [BLACK, WHITE]


def test_a_wobble_within_tolerance_is_a_ramp_and_beyond_it_is_not():
    ColorMap([[0.5] * 3, [0.5 - 0.9 * MONOTONE_TOLERANCE] * 3])
    with pytest.raises(ToonkitError, match="dark to bright"):
        ColorMap([[0.5] * 3, [0.5 - 1.1 * MONOTONE_TOLERANCE] * 3])


@given(color_maps())
def test_tones_rise_along_the_illumination(color_map):
    tones = tone(color_map(np.linspace(-1, 1, 101)))
    assert (np.diff(tones) >= -1e-6).all()  # the sRGB curve's own step


@pytest.mark.parametrize(
    ("colors", "domain", "reason"),
    [
        ([], (-1, 1), r"colors must have shape"),
        (np.empty((0, 3)), (-1, 1), "at least one color"),
        ([[0.1, 0.2]], (-1, 1), r"colors must have shape"),
        ([[0, 0, 1.1]], (-1, 1), r"sRGB in \[0, 1\]"),
        ([[0, 0, -0.1]], (-1, 1), r"sRGB in \[0, 1\]"),
        ([[0, 0, np.nan]], (-1, 1), r"sRGB in \[0, 1\]"),
        ([BLACK], (0.5, 0.5), "-1 <= lo < hi <= 1"),
        ([BLACK], (0.5, -0.5), "-1 <= lo < hi <= 1"),
        ([BLACK], (-1.5, 1), "-1 <= lo < hi <= 1"),
        ([BLACK], (np.nan, 1), "-1 <= lo < hi <= 1"),
        ([BLACK], (0, 1, 2), "domain must have shape"),
    ],
)
def test_what_is_no_ramp_is_refused(colors, domain, reason):
    with pytest.raises(ToonkitError, match=reason):
        ColorMap(colors, domain)


@pytest.mark.parametrize("tolerance", [-0.1, np.nan])
def test_a_negative_tolerance_is_refused(tolerance):
    with pytest.raises(ToonkitError, match="tolerance must be a number >= 0"):
        gray_ramp.invert(GRAY, tolerance=tolerance)


def test_fewer_than_two_samples_are_refused():
    with pytest.raises(ToonkitError, match="count must be a whole number from 2"):
        gray_ramp.resampled(1)

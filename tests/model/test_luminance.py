"""Luminance and tone: the order of painted colors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from toonkit.model.luminance import linear_to_srgb, luminance, srgb_to_linear, tone

channel = st.floats(0, 1)


@pytest.mark.parametrize(
    ("color", "expected"),
    [((0, 0, 0), 0), ((1, 1, 1), 1), ((1, 0, 0), 0.2126), ((0, 1, 0), 0.7152), ((0, 0, 1), 0.0722)],
)
def test_primaries_have_the_luminance_of_rec_709(color, expected):
    assert luminance(color) == pytest.approx(expected, abs=1e-12)


def test_half_the_light_is_painted_as_188_of_255():
    assert 255 * linear_to_srgb(0.5) == pytest.approx(187.5, abs=0.1)


# 1e-6: the standard's two branches of the curve meet with a step of that size
@given(channel)
def test_the_srgb_curve_and_its_inverse_cancel(value):
    assert linear_to_srgb(srgb_to_linear(value)) == pytest.approx(value, abs=1e-6)


@given(channel)
def test_the_tone_of_a_gray_is_the_gray(value):
    assert tone([value] * 3) == pytest.approx(value, abs=1e-6)


@given(st.tuples(channel, channel, channel), st.tuples(channel, channel, channel))
def test_tone_orders_colors_as_luminance_does(one, other):
    # 1e-6 as above: colors closer than the curve's own step may change places
    if luminance(one) > luminance(other) + 1e-6:
        assert tone(one) >= tone(other)


def test_the_curves_keep_shapes_and_nan():
    color = np.full((4, 5, 3), np.nan)
    assert luminance(color).shape == (4, 5)
    assert np.isnan(tone(color)).all()

"""Tone ramps: a color map as a few tones, and back."""

import numpy as np
import pytest

from toonkit import ColorMap, ToneRamp, ToonkitError
from toonkit.illustration.flat_shading import PLAIN
from toonkit.model.luminance import color_of_hex
from toonkit.model.tone_ramp import MOST_TONES, OFF_RAMP

DARK, MIDDLE, LIT = "#402050", "#905060", "#f0d0a0"
ILLUMINATION = np.linspace(-1.0, 1.0, 401)

GRADIENT = ColorMap(np.linspace([0.1, 0.1, 0.2], [0.9, 0.8, 0.7], 64) ** 1.5, (-0.7, 0.95))
BANDS = ColorMap(np.repeat([[0.2, 0.1, 0.3], [0.6, 0.4, 0.4], [1.0, 0.9, 0.7]], 300, axis=0), (-0.5, 0.9))


def test_between_thresholds_the_ramp_has_its_tones():
    ramp = ToneRamp([DARK, MIDDLE, LIT], [-0.2, 0.5], [0.1, 0.0])
    assert np.allclose(ramp.color_map()([-0.9, 0.2, 0.9]), ramp.colors)


def test_a_soft_step_passes_evenly_over_its_width():
    soft = ToneRamp([DARK, LIT], [0.2], [0.4]).color_map()
    dark, lit = np.array(color_of_hex(DARK)), np.array(color_of_hex(LIT))
    for illumination, share in ((0.0, 0.0), (0.1, 0.25), (0.2, 0.5), (0.3, 0.75), (0.4, 1.0)):
        # A sample of the map is 1/500 of illumination.
        assert np.allclose(soft(illumination), (1 - share) * dark + share * lit, atol=0.005)


@pytest.mark.parametrize("color_map", [GRADIENT, BANDS, PLAIN.color_map(np.array([0.8, 0.3, 0.3]))])
def test_a_color_map_is_described_by_few_tones(color_map):
    ramp = ToneRamp.of(color_map)
    off = np.linalg.norm(ramp.color_map()(ILLUMINATION) - color_map(ILLUMINATION), axis=-1)
    assert len(ramp.tones) <= MOST_TONES
    assert np.quantile(off, 0.97) < 1.5 * OFF_RAMP


def test_bands_are_found_where_they_are():
    ramp = ToneRamp.of(BANDS)
    assert len(ramp.tones) == 3
    assert np.allclose(ramp.thresholds, [-0.5 + 1.4 / 3, -0.5 + 2.8 / 3], atol=0.01)
    assert max(ramp.softness) < 0.02


def test_a_ramp_describes_its_own_color_map():
    ramp = ToneRamp([DARK, MIDDLE, LIT], [-0.2, 0.5], [0.3, 0.1])
    again = ToneRamp.of(ramp.color_map())
    assert again.tones == ramp.tones
    assert np.allclose(again.thresholds, ramp.thresholds, atol=0.01)
    assert np.allclose(again.softness, ramp.softness, atol=0.03)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([[]], "tones must be a list of 1 to 8"),
        ([["red"]], "tones must be colors as #rrggbb"),
        ([[LIT, DARK], [0.0]], "dark to bright"),
        ([[DARK, LIT]], "thresholds must have shape"),
        ([[DARK, MIDDLE, LIT], [0.5, 0.1]], "thresholds must rise"),
        ([[DARK, LIT], [1.5]], "thresholds must rise, from -1 to 1"),
        ([[DARK, LIT], [0.0], [-0.1]], "softness must lie in 0 to 2"),
        ([[DARK, LIT], [0.0], [0.1, 0.2]], "softness must have shape"),
    ],
)
def test_what_is_no_ramp_is_refused(arguments, reason):
    with pytest.raises(ToonkitError, match=reason):
        ToneRamp(*arguments)

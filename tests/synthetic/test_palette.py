import numpy as np
import pytest

from toonkit.model.oklab import srgb_to_oklab
from toonkit.synthetic.palette import (
    APART,
    FAMILIES,
    random_bases,
    random_shading,
    smooth_ramp,
    stepped_ramp,
)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("tones", [1, 2, 3, 4])
def test_a_stepped_ramp_has_so_many_tones_from_dark_to_bright(family, tones):
    rng = np.random.default_rng(tones)
    shading = random_shading(rng)
    while shading.softness > 0:
        shading = random_shading(rng)
    ramp = stepped_ramp(random_bases([family], rng)[0], tones, shading, rng)
    shown = np.unique(ramp(np.linspace(-1, 1, 1001)).round(2), axis=0)
    lightness = srgb_to_oklab(ramp(np.array([-1.0, 1.0])))[:, 0]
    assert len(np.unique(ramp.colors, axis=0)) >= tones  # colors in a step's one sample apart
    assert lightness[0] < lightness[1] if tones > 1 else len(shown) == 1


def test_a_smooth_ramp_has_no_step():
    rng = np.random.default_rng(0)
    ramp = smooth_ramp(random_bases(["red"], rng)[0], random_shading(rng), rng)
    colors = ramp(np.linspace(-1, 1, 401))
    assert np.abs(np.diff(colors, axis=0)).max() < 0.02
    assert len(np.unique(colors.round(3), axis=0)) > 50


def test_base_colors_of_one_drawing_can_be_told_apart():
    bases = random_bases(["any"] * 6, np.random.default_rng(0))
    distances = np.linalg.norm(bases[:, None] - bases, axis=-1)
    assert distances[~np.eye(6, dtype=bool)].min() > APART

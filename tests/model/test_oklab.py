import numpy as np
import pytest

from toonkit.model.oklab import oklab_to_srgb, srgb_to_oklab, tabulated_oklab


def test_oklab_and_back_is_the_same_color():
    colors = np.random.default_rng(0).uniform(size=(50, 20, 3))
    assert np.abs(oklab_to_srgb(srgb_to_oklab(colors)) - colors).max() < 1e-12


@pytest.mark.parametrize(
    ("color", "lab"),
    [
        # As CSS Color Module Level 4 gives them.
        ([1, 0, 0], [0.62796, 0.22486, 0.12585]),
        ([0, 1, 0], [0.86644, -0.23389, 0.17950]),
        ([0, 0, 1], [0.45201, -0.03246, -0.31153]),
        ([1, 1, 1], [1.0, 0.0, 0.0]),
        ([0, 0, 0], [0.0, 0.0, 0.0]),
    ],
)
def test_primaries_lie_where_they_are_published(color, lab):
    assert srgb_to_oklab(color) == pytest.approx(lab, abs=2e-5)


def test_grays_have_no_chroma_and_rising_lightness():
    lab = srgb_to_oklab(np.repeat(np.linspace(0, 1, 11)[:, None], 3, axis=1))
    assert np.abs(lab[:, 1:]).max() < 1e-6  # the published matrices have ten digits
    assert (np.diff(lab[:, 0]) > 0).all()


def test_what_is_outside_the_object_stays_nan():
    assert np.isnan(srgb_to_oklab([np.nan] * 3)).all()


def test_the_quick_conversion_is_as_exact_as_it_says():
    colors = np.random.default_rng(1).random((5000, 3))
    apart = np.abs(tabulated_oklab(colors) - srgb_to_oklab(colors)).max(axis=1)
    assert apart[(colors > 1 / 255).all(axis=1)].max() < 0.003
    assert apart.max() < 0.02

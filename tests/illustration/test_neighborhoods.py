"""Neighborhoods are those of SciPy's filters, at any size of picture and across the bands that threads share."""

import numpy as np
import pytest
from scipy import ndimage

from toonkit.illustration.neighborhoods import grow_mask, range_around, shrink_mask

SHAPES = [(1, 1), (9, 40), (700, 500)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("steps", [0, 1, 2, 17])
@pytest.mark.parametrize("share", [0.01, 0.5, 0.99])
def test_marks_grow_and_shrink_by_squares(shape: tuple[int, int], steps: int, share: float) -> None:
    marked = np.random.default_rng(1).random(shape) < share
    assert np.array_equal(grow_mask(marked, steps), ndimage.maximum_filter(marked, 2 * steps + 1))
    assert np.array_equal(shrink_mask(marked, steps), ndimage.minimum_filter(marked, 2 * steps + 1))


@pytest.mark.parametrize("shape", SHAPES)
def test_the_range_around_a_pixel_is_that_of_its_widest_channel(shape: tuple[int, int]) -> None:
    color = np.random.default_rng(2).random((*shape, 3))
    ranges = ndimage.maximum_filter(color, (3, 3, 1)) - ndimage.minimum_filter(color, (3, 3, 1))
    assert np.array_equal(range_around(color), ranges.max(axis=2))

"""The distinct colors of a drawing, against a list that looks at one pixel after the other."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit.illustration.distinct_colors import BLOCK, beside_their_own, distinct_colors


def few_colors(seed, shape):
    """Colors in runs, as in a drawing, and a number beside each."""
    rng = np.random.default_rng(seed)
    palette = rng.random((6, 3))
    which = np.repeat(rng.integers(0, 6, shape[0] * shape[1]), rng.integers(1, 9, shape[0] * shape[1]))
    which = which[: shape[0] * shape[1]]
    return palette[which], rng.integers(0, 2, which.shape)


@pytest.mark.parametrize("shape", [(1, 1), (7, 9), (3, BLOCK)])
def test_colors_are_listed_in_the_order_of_their_first_pixels(shape):
    colors, beside = few_colors(4, shape)
    listed = [(*color, number) for color, number in zip(colors.tolist(), beside.tolist(), strict=True)]
    expected = list(dict.fromkeys(listed))
    firsts, which = distinct_colors(colors, beside, most=64)
    assert [listed[first] for first in firsts] == expected
    assert [expected[place] for place in which] == listed


def test_colors_that_differ_by_rounding_are_the_same():
    levels = np.arange(256.0)[:, None].repeat(3, axis=1) / 255.0
    noisy = np.concatenate([levels, levels + 1e-9 * (levels < 1.0)])
    firsts, which = distinct_colors(noisy, np.zeros(512, np.int32), most=512)
    assert firsts.tolist() == list(range(256))
    np.testing.assert_array_equal(which, np.tile(np.arange(256), 2))


def test_the_list_ends_early_where_there_are_too_many():
    colors = np.random.default_rng(0).random((5 * BLOCK, 3))
    firsts, which = distinct_colors(colors, np.zeros(len(colors), np.int32), most=64)
    assert 64 < len(firsts) <= BLOCK
    assert len(which) == BLOCK


def test_pixels_know_whether_a_neighbor_has_their_color_or_another():
    rng = np.random.default_rng(1)
    mask, image = rng.random((9, 11)) < 0.8, rng.integers(0, 3, (9, 11))
    alone, edge = beside_their_own(image[mask].astype(np.int32), mask)
    for own, is_alone, is_edge in zip(np.argwhere(mask), alone, edge, strict=True):
        around = [own + step for step in ((-1, 0), (1, 0), (0, -1), (0, 1))]
        inside = [image[r, c] for r, c in around if 0 <= r < 9 and 0 <= c < 11 and mask[r, c]]
        assert is_alone == (image[tuple(own)] not in inside)
        assert is_edge == any(color != image[tuple(own)] for color in inside)

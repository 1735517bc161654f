"""A drawing of which each pixel became a block gives what the drawing before gives, enlarged."""

import numpy as np
import pytest

import toonkit
from tests.pixel_art import LIGHT, sprite
from toonkit import NormalHint, ShapeCorrections, ToonAnalysis, ToonImage
from toonkit.illustration.enlargement import find_enlargement

FACTOR, PLACE = 3, (slice(5, 5 + 3 * 48), slice(7, 7 + 3 * 48))


def blocks(values: np.ndarray) -> np.ndarray:
    return values.repeat(FACTOR, axis=0).repeat(FACTOR, axis=1)


def enlarged(image: ToonImage) -> ToonImage:
    """Three times as large, on a canvas whose size is no multiple of three."""
    color, alpha = np.zeros((160, 155, 3)), np.zeros((160, 155))
    shown = np.where(image.mask[..., None], image.color, np.nan_to_num(image.fringe))
    color[PLACE], alpha[PLACE] = blocks(shown), blocks(image.alpha)
    return ToonImage(color, alpha >= 0.5, alpha=alpha, fringe=color)


@pytest.fixture(scope="module")
def small() -> ToonAnalysis:
    return toonkit.analyze(sprite())


@pytest.fixture(scope="module")
def large() -> ToonAnalysis:
    return toonkit.analyze(enlarged(sprite()))


def test_shape_light_materials_and_ink_are_those_of_the_drawing_before(small, large):
    assert np.array_equal(large.light, small.light)
    assert np.array_equal(large.normals.vectors[PLACE], blocks(small.normals.vectors), equal_nan=True)
    assert np.array_equal(large.materials.labels[PLACE], blocks(small.materials.labels))
    assert np.array_equal(large.drawing.ink_coverage[PLACE], blocks(small.drawing.ink_coverage))
    assert large.drawing.is_pixel_art


@pytest.mark.parametrize(
    "options", [{}, {"keep_detail": False}, {"light_color": (1.0, 0.8, 0.6), "ambient": 0.2}]
)
def test_a_new_light_paints_whole_blocks(small, large, options):
    relit = toonkit.relight(large, (20, 30), **options)
    expected = toonkit.relight(small, (20, 30), **options)
    assert np.array_equal(relit.color[PLACE], blocks(expected.color), equal_nan=True)
    bases = large.base_color.color[PLACE], blocks(small.base_color.color)
    np.testing.assert_allclose(*bases, atol=1 / 255)


def test_corrected_materials_and_another_light_keep_whole_blocks(small, large):
    merged = np.minimum(small.materials.labels, 1)
    again = toonkit.analyze(small.drawing, LIGHT, materials=merged, previous=small)
    whole = np.full(large.image.shape, -1)
    whole[PLACE] = blocks(merged)
    both = toonkit.analyze(large.drawing, LIGHT, materials=whole, previous=large)
    turned = np.abs(both.normals.vectors[PLACE] - blocks(again.normals.vectors))
    assert np.nanmax(turned) < 0.05  # the small one started from its earlier normals
    assert np.array_equal(both.materials.labels[PLACE], blocks(again.materials.labels))


def test_corrections_of_the_shape_are_those_of_the_drawing_before(small, large):
    disc = np.hypot(*(np.indices(small.image.shape) - 24)) < 9
    whole = np.zeros(large.image.shape, bool)
    whole[PLACE] = blocks(disc)
    whole[PLACE][0::FACTOR] = False  # a stroke is finer than the blocks
    hint = NormalHint(20, 30, (0.8, 0, 0.6), radius=6)
    larger = NormalHint(5 + 3 * 20 + 2, 7 + 3 * 30, (0.8, 0, 0.6), radius=18)
    one = toonkit.analyze(small.drawing, LIGHT, shape=ShapeCorrections(bulge=disc, normals=[hint]))
    other = toonkit.analyze(large.drawing, LIGHT, shape=ShapeCorrections(bulge=whole, normals=[larger]))
    assert np.array_equal(other.normals.vectors[PLACE], blocks(one.normals.vectors), equal_nan=True)
    plain = toonkit.analyze(small.drawing, LIGHT)
    assert toonkit.angular_error(one.normals, plain.normals).map[disc].mean() > 5
    back = toonkit.analyze(other.drawing, LIGHT, shape=ShapeCorrections())
    assert np.array_equal(back.normals.vectors[PLACE], blocks(plain.normals.vectors), equal_nan=True)


def test_marks_finer_than_a_block_are_kept_as_they_are(large):
    ink = large.drawing.ink_coverage > 0.5
    ink[60, 60:70] = True
    marked = toonkit.analyze(large.drawing, LIGHT, ink=ink)
    assert np.array_equal(marked.drawing.given_ink, ink)
    assert (marked.drawing.ink_coverage[ink] >= 0.5).all()


def test_an_archive_brings_it_back(large, tmp_path):
    large.save(tmp_path / "large.npz")
    again = toonkit.load_analysis(tmp_path / "large.npz")
    relit, expected = (toonkit.relight(analysis, (200, 30)) for analysis in (again, large))
    assert np.abs(relit.pixels - expected.pixels).max() < 1 / 255


def test_soft_fringes_are_enlarged_too():
    image = sprite()
    alpha = image.alpha.copy()
    color = np.nan_to_num(image.color, nan=0.3)
    alpha[1:-1, 1:-1] = np.maximum(alpha, 0.4)[1:-1, 1:-1]
    soft = ToonImage(color, image.mask, alpha=alpha, fringe=color)
    found = find_enlargement(enlarged(soft))
    assert found is not None
    assert found.factor == FACTOR
    inner = found.image
    assert np.array_equal(inner.alpha, alpha[1:-1, 1:-1])
    assert np.array_equal(inner.fringe_colors, soft.fringe_colors)


def test_what_was_not_enlarged_is_seen_as_it_is():
    ball = sprite()
    assert find_enlargement(ball) is None
    one_off = enlarged(ball)
    color = np.nan_to_num(one_off.color)
    color[80, 80] = 0.5
    assert find_enlargement(ToonImage(color, one_off.mask)) is None
    halves = np.full((90, 90, 3), 0.8)
    halves[:, 45:] = 0.3
    assert find_enlargement(ToonImage(halves, np.ones((90, 90), bool))) is None

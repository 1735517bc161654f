import functools

import numpy as np
import pytest

from toonkit import ToonkitError, light_direction
from toonkit.metrics import color_rmse
from toonkit.synthetic.drawing import DrawnScene, draw_scene
from toonkit.synthetic.recipes import RECIPES

SIZE = 64
SEEDS = range(12)
LIGHT = light_direction(200, 30)


@functools.cache
def scene(seed: int) -> DrawnScene:
    return draw_scene(seed, size=SIZE)


def first(condition) -> DrawnScene:
    return next(scene(seed) for seed in range(60) if condition(scene(seed)))


@pytest.mark.parametrize("name", RECIPES)
def test_every_recipe_shows_three_to_eight_materials(name):
    drawing = draw_scene(3, size=SIZE, recipe=name)
    assert 3 <= len(drawing.materials) <= 8
    assert drawing.recipe == name
    assert drawing.image.mask.mean() > 0.08


def test_there_are_at_least_twelve_recipes():
    assert len(RECIPES) >= 12


def test_a_seed_makes_the_same_drawing_again():
    one, other = draw_scene(5, size=SIZE), draw_scene(np.random.default_rng(5), size=SIZE)
    assert np.array_equal(one.image.to_rgba(), other.image.to_rgba())
    assert np.array_equal(one.labels, other.labels)
    assert not np.array_equal(one.image.to_rgba(), scene(6).image.to_rgba())


@pytest.mark.parametrize("seed", SEEDS)
def test_the_drawing_is_ink_over_paint(seed):
    drawing = scene(seed)
    mask = drawing.image.mask
    share = drawing.ink[mask][:, None]
    mixed = share * np.nan_to_num(drawing.ink_color[mask]) + (1 - share) * drawing.paint.color[mask]
    # Both the drawing and its paint are rounded to 8 bits.
    assert np.abs(mixed - drawing.image.color[mask]).max() <= 1.01 / 255
    assert np.array_equal(np.isnan(drawing.ink_color[mask]).any(axis=1), drawing.ink[mask] == 0)


@pytest.mark.parametrize("seed", SEEDS)
def test_paint_is_each_materials_color_map_of_the_illumination(seed):
    drawing = scene(seed)
    lit = np.clip(drawing.normals.vectors @ drawing.light, -1, 1)
    plain = drawing.image.mask & (drawing.highlight == 0) & (drawing.cast_shadow == 0)
    off = np.zeros(plain.shape)
    for label, color_map in enumerate(drawing.color_maps):
        own = plain & (drawing.labels == label)
        off[own] = np.abs(color_map(lit[own]) - drawing.paint.color[own]).max(axis=-1)
    # Pixels on the edge of a tone or a material mix several colors.
    assert np.median(off[plain]) < 0.02


@pytest.mark.parametrize("seed", SEEDS)
def test_the_truth_at_the_drawings_own_light_is_the_drawing(seed):
    assert color_rmse(scene(seed).relit(scene(seed).light), scene(seed).image) == 0.0


@pytest.mark.parametrize("seed", SEEDS)
def test_labels_cover_the_mask_and_nothing_else(seed):
    drawing = scene(seed)
    assert np.array_equal(drawing.labels >= 0, drawing.image.mask)
    assert drawing.labels.max() < len(drawing.materials) == len(drawing.color_maps)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_new_light_changes_the_paint_but_neither_flat_materials_nor_solid_ink(seed):
    drawing = scene(seed)
    relit = drawing.relit(LIGHT)
    assert color_rmse(relit, drawing.image) > 0
    solid = drawing.image.mask & (drawing.ink == 1)
    assert np.array_equal(relit.color[solid], drawing.image.color[solid])
    one_material = drawing.image.mask & drawing.flat[drawing.labels] & (drawing.cast_shadow == 0)
    one_material &= drawing.highlight == 0
    for label in np.flatnonzero(drawing.flat):
        own = one_material & (drawing.labels == label)
        paint = np.rint(drawing.color_maps[label](0.0) * 255) / 255
        pure = own & (drawing.ink == 0) & (np.abs(drawing.image.color - paint) < 1e-9).all(axis=-1)
        if drawing.cast_shadow.any():
            continue  # a shadow may come to fall on it
        assert np.array_equal(relit.color[pure], drawing.image.color[pure])


def test_highlights_move_with_the_light():
    drawing = first(lambda drawn: drawn.highlight.max() == 1)
    bright = drawing.highlight == 1
    gone = drawing.relit(LIGHT).color[bright & (drawing.ink == 0)]
    assert (gone < drawing.image.color[bright & (drawing.ink == 0)] - 0.02).any()


def test_a_cast_shadow_darkens_what_faces_the_light():
    drawing = first(lambda drawn: (drawn.cast_shadow == 1).sum() > 10)
    under = (drawing.cast_shadow == 1) & drawing.image.mask
    assert (drawing.normals.vectors[under] @ drawing.light > 0).mean() > 0.95
    lit = np.clip(drawing.normals.vectors @ drawing.light, -1, 1)
    unshadowed = np.stack(
        [drawing.color_maps[m](i) for m, i in zip(drawing.labels[under], lit[under], strict=True)]
    )
    assert drawing.paint.color[under].mean() < unshadowed.mean() - 0.03


@pytest.fixture(scope="module")
def many() -> list[DrawnScene]:
    return [draw_scene(seed, size=16) for seed in range(40)]


def test_about_half_of_the_drawings_have_highlights_and_some_a_cast_shadow_or_no_ink(many):
    assert 0.25 < np.mean([drawing.highlight.any() for drawing in many]) < 0.75
    assert 0.05 < np.mean([drawing.cast_shadow.any() for drawing in many]) < 0.45
    assert 0.0 < np.mean([not drawing.ink.any() for drawing in many]) < 0.25


def test_the_light_stands_within_its_elevations(many):
    heights = np.rad2deg(np.arcsin([drawing.light[2] for drawing in many]))
    assert heights.min() >= 20 - 1e-6
    assert heights.max() <= 75 + 1e-6
    assert np.ptp(heights) > 40


@pytest.mark.parametrize(
    ("options", "message"), [({"size": 8}, "size must"), ({"recipe": "cow"}, "recipe must")]
)
def test_what_cannot_be_drawn_is_refused(options, message):
    with pytest.raises(ToonkitError, match=message):
        draw_scene(0, **options)

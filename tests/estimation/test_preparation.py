"""A prepared drawing: derived once, passed on, and independent of what is around the object."""

from dataclasses import replace

import numpy as np
import pytest

from tests.analytic import LIGHT, SOFT, TWO_TONE, blob_mask, ellipse, painted
from toonkit import (
    METHODS,
    ToonImage,
    ToonkitError,
    analyze,
    fit_color_map,
    illumination,
    inflate,
    light_direction,
    relight,
)
from toonkit.estimation import prepared_drawing
from toonkit.estimation.painted_tones import FLAT, MIXING_REACH, PaintedTones, decoded
from toonkit.estimation.preparation import prepare
from toonkit.model.luminance import srgb_to_linear, tone


def soft_ball() -> ToonImage:
    shape = ellipse(20, 15)
    return painted(shape.normals, SOFT, alpha=shape.coverage)


def test_what_is_derived_is_derived_once():
    drawing = prepare(soft_ball())
    assert drawing.initial_normals is drawing.initial_normals
    assert drawing.tones is drawing.tones
    assert prepare(drawing) is drawing


def test_other_materials_share_the_shape_and_the_answer_is_the_same():
    image = soft_ball()
    halves = np.where(np.arange(image.shape[1]) < image.shape[1] // 2, 0, 1) * np.ones(image.shape, int)
    analysis = analyze(image, LIGHT)
    again = analyze(analysis.drawing, LIGHT, materials=halves)
    assert again.initial_normals is analysis.initial_normals
    assert again.drawing.ink is analysis.drawing.ink
    anew = analyze(image, LIGHT, materials=halves)
    np.testing.assert_array_equal(again.materials.labels, anew.materials.labels)
    np.testing.assert_array_equal(again.normals.compact, anew.normals.compact)
    assert analysis.drawing.materials.count == 1


@pytest.mark.parametrize("method", list(METHODS))
def test_an_analysis_keeps_the_prepared_drawing_and_another_light_reuses_it(method):
    image = soft_ball()
    analysis = analyze(image, LIGHT, method=method)
    assert analysis.drawing.image is image
    again = analyze(image, light_direction(60, 40), method=method, previous=analysis)
    assert again.drawing is analysis.drawing


@pytest.mark.parametrize("method", list(METHODS))
def test_an_object_too_large_for_the_memory_is_refused_before_any_work(method, monkeypatch):
    image = soft_ball()
    monkeypatch.setattr(prepared_drawing, "MOST_PIXELS", int(image.mask.sum()) - 1)
    steps = []
    with pytest.raises(
        ToonkitError, match=r"^image must show an object of at most .* reduce the drawing; got 9"
    ):
        analyze(image, LIGHT, method=method, progress=lambda step, _: steps.append(step))
    assert steps == []


def test_another_picture_of_the_same_mask_is_prepared_anew():
    first, second = soft_ball(), soft_ball()
    analysis = analyze(second, LIGHT, previous=analyze(first, LIGHT))
    assert analysis.drawing.image is second
    assert replace(analysis, image=first).drawing.image is first


def test_a_method_passes_a_prepared_drawing_on_wherever_a_picture_is_asked_for():
    image = soft_ball()
    drawing = prepare(image)
    lit = illumination(drawing.initial_normals, LIGHT)
    assert np.array_equal(fit_color_map(drawing, lit).colors, fit_color_map(image, lit).colors)
    analysis = METHODS["lumo"](drawing, LIGHT)
    assert analysis.drawing is drawing
    assert analysis.image is image
    assert np.array_equal(relight(analysis, LIGHT).color, image.color, equal_nan=True)


def test_the_inflated_shape_is_that_of_the_silhouette():
    shape = ellipse(30, 20)
    image = painted(shape.normals, SOFT, alpha=shape.coverage)
    expected = inflate(image.mask, alpha=image.alpha)
    assert np.array_equal(prepare(image).initial_normals.vectors, expected.vectors, equal_nan=True)


def plain_by_hand(image: ToonImage) -> np.ndarray:
    """The slow, readable way: pixel by pixel, as `PaintedTones` tells it."""
    tones = tone(image.color)
    height, width = tones.shape

    def around(row, column, reach):
        for r in range(max(row - reach, 0), min(row + reach + 1, height)):
            for c in range(max(column - reach, 0), min(column + reach + 1, width)):
                if image.mask[r, c] and (r, c) != (row, column):
                    yield r, c

    flat = np.zeros(image.mask.shape, bool)
    for row, column in np.argwhere(image.mask):
        near = list(around(row, column, 1))
        alike = sum(abs(tones[place] - tones[row, column]) < FLAT for place in near)
        flat[row, column] = alike >= min(len(near), 4)
    plain = tones.copy()
    for row, column in np.argwhere(image.mask & ~flat):
        bands = [tones[place] for place in around(row, column, MIXING_REACH) if flat[place]]
        own = tones[row, column]
        if bands and min(bands) + FLAT < own < max(bands) - FLAT:
            plain[row, column] = min(bands) if own - min(bands) < max(bands) - own else max(bands)
    return plain[image.mask]


def softened_steps(seed):
    """Return a drawing of grey bands whose edges are mixtures."""
    random = np.random.default_rng(seed)
    steps = np.kron(random.integers(1, 5, (8, 8)), np.ones((5, 5))) / 5
    soft = np.stack([steps, np.roll(steps, 1, axis=0), np.roll(steps, 1, axis=1)]).mean(axis=0)
    return ToonImage(np.repeat(soft[..., None], 3, axis=2), blob_mask(seed, size=40))


@pytest.mark.parametrize("seed", range(3))
def test_plain_tones_are_those_found_pixel_by_pixel(seed):
    image = softened_steps(seed)
    tones = PaintedTones.of(image.color[image.mask], *np.nonzero(image.mask))
    assert np.allclose(tones.plain, plain_by_hand(image), atol=1e-12)
    assert tones.mixtures.pixels.size
    assert (tones.darkest <= tones.tone).all()
    assert (tones.brightest >= tones.tone).all()


def test_seams_beside_an_edge_take_the_tone_of_their_paint():
    color = np.full((20, 40, 3), 0.8)
    color[:, 20:] = 0.4
    color[:, 18], color[:, 19], color[:, 20], color[:, 21] = 0.808, 0.79, 0.408, 0.393
    beside = np.zeros(color.shape[:2], bool)
    beside[:, 17:23] = True
    places = np.nonzero(np.ones(beside.shape, bool))
    colors = color.reshape(-1, 3)
    told = PaintedTones.of(colors, *places, beside.ravel())
    assert np.unique(told.plain.round(6)).tolist() == [0.4, 0.8]
    assert np.isfinite(told.ordered.sums).all()
    assert np.array_equal(PaintedTones.of(colors, *places).tone, decoded(colors)[1])
    ramp = np.tile(np.linspace(0.2, 0.8, 40), (20, 1))[..., None].repeat(3, axis=2).reshape(-1, 3)
    assert np.array_equal(PaintedTones.of(ramp, *places, np.ones(800, bool)).tone, decoded(ramp)[1])


def test_the_light_of_the_darkest_pixels_adds_up():
    image = painted(ellipse(30, 20).normals, TWO_TONE)
    tones = prepare(image).tones
    light = tones.ordered.of_darkest(np.arange(tones.tone.size + 1))
    assert light[0].tolist() == [0, 0, 0]
    # A mixed pixel counts for one of its bands, so the sum is that of the colors but for a few pixels in a thousand.
    assert np.allclose(light[-1], srgb_to_linear(image.pixels).sum(axis=0), rtol=1e-3)
    assert (np.diff(light @ [1, 1, 1]) >= 0).all()


@pytest.mark.parametrize("seed", range(3))
def test_the_light_in_order_is_that_of_sorted_pixels(seed):
    image = softened_steps(seed)
    tones = prepare(image).tones
    assert tones.mixtures.pixels.size
    grey = np.sort(srgb_to_linear(tones.plain))  # a grey's tone is its color
    for pixels in range(grey.size + 1):
        assert np.allclose(tones.ordered.of_darkest(np.array([pixels])), grey[:pixels].sum())


def test_pixels_of_one_tone_share_their_light():
    red, green = (np.array(color) for color in ((0.5, 0.0, 0.0), (0.0, 0.27979, 0.0)))
    colors = np.where(np.indices((12, 12)).sum(axis=0)[..., None] % 2, red, green)
    tones = prepare(ToonImage(colors, np.ones((12, 12), bool))).tones
    assert np.ptp(tones.tone) < 1e-5
    assert len(tones.ordered.counts) == 2
    mean = srgb_to_linear(colors.reshape(-1, 3)).mean(axis=0)
    for pixels in (1, 10, 144):
        assert np.allclose(tones.ordered.of_darkest(np.array([pixels]))[0], pixels * mean)


def test_what_is_released_is_made_again():
    image = painted(ellipse(40, 25).normals, TWO_TONE)
    fresh, released = (analyze(image, LIGHT) for _ in range(2))
    released.drawing.release()
    assert np.array_equal(released.base_color.pixels, fresh.base_color.pixels)
    for light in (LIGHT, light_direction(60, 40)):
        again = [analyze(image, light, previous=analysis).normals.compact for analysis in (fresh, released)]
        assert np.array_equal(*again)

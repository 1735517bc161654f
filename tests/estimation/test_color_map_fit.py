import numpy as np
import pytest

from tests.analytic import LIGHT, SOFT, TWO_TONE, ellipse, painted
from toonkit import ColorMap, ToonImage, ToonkitError, fit_color_map, illumination, illumination_interval
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.estimation.preparation import prepare

FIVE_TONE = ColorMap(
    np.repeat(
        [[0.1, 0.1, 0.2], [0.3, 0.2, 0.4], [0.5, 0.5, 0.4], [0.8, 0.6, 0.5], [1, 0.95, 0.8]], 400, axis=0
    )
)


def antialiased(disc, color_map, oversampling=4):
    """A picture whose band edges are mixed as a renderer mixes them: mean of the colors within a pixel."""
    size = disc.mask.shape[0]
    fine = (np.arange(size * oversampling) + 0.5) / oversampling - 0.5
    column = np.interp(fine, np.arange(size), disc.x[0])
    row = np.interp(fine, np.arange(size), disc.y[:, 0])
    x, y = np.meshgrid(column, row)
    radius = disc.mask.sum(axis=0).max() / 2
    z = np.sqrt(np.maximum(1 - (x**2 + y**2) / radius**2, 0))
    light = np.clip((x * LIGHT[0] + y * LIGHT[1]) / radius + z * LIGHT[2], -1, 1)
    colors = color_map(light).reshape(size, oversampling, size, oversampling, 3).mean(axis=(1, 3))
    # Without the outermost pixels, where the bands are narrower than a pixel and nothing but mixtures is left.
    return ToonImage(colors, np.hypot(disc.x, disc.y) < radius - 4)


@pytest.mark.parametrize("color_map", [TWO_TONE, SOFT, FIVE_TONE], ids=["two-tone", "soft", "five-tone"])
def test_the_true_map_is_recovered_from_the_true_normals(color_map):
    disc = ellipse(60, 60)
    image = painted(disc.normals, color_map)
    light = illumination(disc.normals, LIGHT)
    fitted = fit_color_map(image, light)
    samples = np.linspace(np.nanmin(light), np.nanmax(light), 5000)
    wrong = np.abs(fitted(samples) - color_map(samples)).max(axis=1) > 0.01
    # Four hard steps at most, each blurred over one sample (of 1024) on either side.
    assert wrong.mean() <= 4 * 2 / 1024


@pytest.mark.parametrize("color_map", [TWO_TONE, SOFT, FIVE_TONE], ids=["two-tone", "soft", "five-tone"])
def test_intervals_of_the_true_map_hold_the_true_illumination(color_map):
    disc = ellipse(60, 60)
    image = painted(disc.normals, color_map)
    light = illumination(disc.normals, LIGHT)
    interval = illumination_interval(image, fit_color_map(image, light))
    inside = image.mask
    sample = 2 / 1024
    assert (interval.lower[inside] <= light[inside] + sample).all()
    assert (interval.upper[inside] >= light[inside] - sample).all()
    assert (interval.lower[inside] <= interval.upper[inside]).all()


def test_the_darkest_color_reaches_to_minus_one_and_the_brightest_to_one():
    disc = ellipse(40, 40)
    image = painted(disc.normals, TWO_TONE)
    interval = illumination_interval(image, fit_color_map(image, illumination(disc.normals, LIGHT)))
    dark = np.isclose(image.color[..., 0], 0.35)
    assert (interval.lower[dark] == -1).all()
    assert (interval.upper[image.mask & ~dark] == 1).all()


def test_one_single_color_allows_every_illumination():
    disc = ellipse(20, 20)
    image = ToonImage(np.full((*disc.mask.shape, 3), 0.4), disc.mask)
    color_map = fit_color_map(image, illumination(disc.normals, LIGHT))
    interval = illumination_interval(image, color_map)
    assert np.allclose(color_map(np.linspace(-1, 1, 9)), 0.4)
    assert (interval.lower[disc.mask] == -1).all()
    assert (interval.upper[disc.mask] == 1).all()


def test_equal_illumination_everywhere_gives_one_color_not_an_error():
    disc = ellipse(20, 20)
    image = painted(disc.normals, SOFT)
    color_map = fit_color_map(image, np.where(disc.mask, 0.5, np.nan))
    assert len(color_map.colors) == 1


def test_pixels_that_share_an_illumination_share_the_mean_of_their_colors():
    light = np.repeat([[-0.5, 0.5]], 8, axis=0).repeat(8, axis=1)
    color = np.where(light[..., None] < 0, 0.2, 0.6) + np.linspace(0, 0.1, 8)[:, None, None] + np.zeros(3)
    image = ToonImage(color, np.ones(light.shape, bool))
    fitted = fit_color_map(image, light)
    assert fitted(-0.5).tolist() == pytest.approx([0.25] * 3, abs=0.01)


def mixed_pixels(image):
    mixed = np.zeros(image.mask.shape, bool)
    tones = prepare(image).tones
    mixed[image.mask] = tones.plain != tones.tone
    return mixed


@pytest.mark.parametrize("color_map", [TWO_TONE, FIVE_TONE], ids=["two-tone", "five-tone"])
def test_mixed_colors_of_a_band_edge_are_no_band(color_map):
    disc = ellipse(60, 60)
    image = antialiased(disc, color_map)
    mixed = mixed_pixels(image)
    fitted = fit_color_map(image, illumination(disc.normals, LIGHT))
    bands = np.unique(color_map.colors, axis=0)
    nearest = np.linalg.norm(fitted.colors[:, None] - bands, axis=2).min(axis=1)
    assert mixed.any()
    share = np.linalg.norm(image.color[image.mask][:, None] - bands, axis=2).min(axis=1) > 0.02
    # Of the mixed pixels, which left in would own as large a share of the map, nine in ten are gone; a hard step is
    # blurred over one sample (of 1024) on either side.
    assert share.mean() > 0.01
    assert (nearest > 0.02).mean() < 0.1 * share.mean() + 2 * (len(bands) - 1) / 1024


def test_a_mixed_pixel_may_lie_in_either_band():
    disc = ellipse(60, 60)
    image = antialiased(disc, TWO_TONE)
    mixed = mixed_pixels(image)
    interval = illumination_interval(image, fit_color_map(image, illumination(disc.normals, LIGHT)))
    assert (interval.lower[mixed] == -1).all()
    assert (interval.upper[mixed] == 1).all()


def test_a_soft_gradient_is_no_band_edge():
    disc = ellipse(60, 60)
    mixed = mixed_pixels(painted(disc.normals, SOFT))
    # At the rim any ramp is as steep as a band edge: a handful of pixels there may be taken for one.
    assert mixed.sum() < 0.002 * disc.mask.sum()
    assert not mixed[np.hypot(disc.x, disc.y) < 45].any()


@pytest.mark.parametrize("sigma", [0.0, 0.01, 0.03])
def test_the_noise_level_is_that_of_the_tones(sigma):
    disc = ellipse(60, 60)
    image = painted(disc.normals, FIVE_TONE)
    noise = sigma * np.random.default_rng(0).normal(size=(*disc.mask.shape, 1))
    noisy = ToonImage(np.clip(image.color + noise, 0, 1), disc.mask)
    # Clipping at white takes a little away from it.
    tones = PaintedTones.of(noisy.color[noisy.mask], *np.nonzero(noisy.mask))
    assert tones.noise == pytest.approx(sigma, rel=0.25, abs=1e-4)


@pytest.mark.parametrize(
    ("light", "words"),
    [
        (np.zeros((3, 3)), "size of the picture"),
        (np.full((49, 49), np.nan), r"must lie in \[-1, 1\]"),
        (np.full((49, 49), 1.5), r"must lie in \[-1, 1\]"),
    ],
)
def test_illumination_that_is_none_is_refused(light, words):
    disc = ellipse(20, 20)
    with pytest.raises(ToonkitError, match=words):
        fit_color_map(painted(disc.normals, SOFT), light)


@pytest.mark.parametrize("layout", ["rows first", "columns first", "channels first"])
def test_the_memory_order_of_a_picture_changes_nothing(layout):
    disc = ellipse(20, 20)
    color = np.random.default_rng(3).choice(FIVE_TONE.colors, size=disc.mask.shape)
    stored = {
        "rows first": np.ascontiguousarray(color),
        "columns first": np.asfortranarray(color),
        "channels first": np.moveaxis(np.ascontiguousarray(np.moveaxis(color, -1, 0)), 0, -1),
    }[layout]
    light = illumination(disc.normals, LIGHT)
    expected = fit_color_map(ToonImage(color, disc.mask), light)
    assert np.array_equal(fit_color_map(ToonImage(stored, disc.mask), light).colors, expected.colors)


def test_two_gradients_of_equal_luminance_give_no_stripes():
    light = np.tile(np.linspace(0.2, 0.8, 120), (40, 1))
    color = np.repeat(light[..., None], 3, axis=2)
    color[::2] *= (0.3, 1.2, 0.3)  # every other row is green, about as bright
    color = np.rint(255 * color) / 255
    fitted = fit_color_map(ToonImage(color, np.ones(light.shape, bool)), light).colors
    way = np.abs(np.diff(fitted, axis=0)).sum(axis=0)
    # Straight from the darkest to the brightest color and, at either end, from one hue to the other.
    assert (way < 3 * np.ptp(fitted, axis=0)).all()


def test_a_narrow_tone_keeps_its_place_in_the_map():
    light = np.tile(np.linspace(-1, 1, 1000), (4, 1))
    dark, between, bright = np.array([[0.2, 0.2, 0.5], [0.5, 0.3, 0.3], [0.9, 0.9, 0.8]])
    color = np.where(light[..., None] < 0, dark, np.where(light[..., None] < 0.02, between, bright))
    fitted = fit_color_map(ToonImage(color, np.ones(light.shape, bool)), light)
    assert fitted([0.01])[0] == pytest.approx(between, abs=0.01)

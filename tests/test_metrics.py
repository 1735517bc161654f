import numpy as np
import pytest

from tests.analytic import LIGHT, SOFT, ellipse, painted, scrambled
from toonkit import (
    NormalField,
    ToonImage,
    ToonkitError,
    angular_error,
    color_difference,
    color_rmse,
    illumination,
    illumination_error,
    relight_response,
    shade,
)
from toonkit.metrics import leak, response
from toonkit.model.oklab import oklab_to_srgb

SHAPE = ellipse(20, 14)
MASK = SHAPE.mask


def turned(degrees: float) -> NormalField:
    """The normals of the shape, each turned by so many degrees about the picture's own axis."""
    angle = np.radians(degrees)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return NormalField(SHAPE.normals.vectors @ turn.T, MASK)


def test_identical_normals_differ_by_exactly_nothing():
    assert angular_error(SHAPE.normals, SHAPE.normals).mean == 0.0


def test_the_angle_is_that_between_the_vectors():
    flat = NormalField(np.broadcast_to([0.0, 0, 1], (*MASK.shape, 3)), MASK)
    tilted = NormalField(np.broadcast_to([np.sin(0.3), 0, np.cos(0.3)], (*MASK.shape, 3)), MASK)
    error = angular_error(tilted, flat)
    for summary in (error.mean, error.median, error.percentile_95, error.mean_without_rim):
        assert summary == pytest.approx(np.degrees(0.3), rel=1e-12)


def padded(image: np.ndarray, fill: float) -> np.ndarray:
    return np.pad(image, [(7, 3), (2, 9)] + [(0, 0)] * (image.ndim - 2), constant_values=fill)


@pytest.mark.parametrize("field", ["mean", "median", "percentile_95", "mean_without_rim"])
def test_padding_the_picture_changes_no_metric(field):
    other = NormalField(scrambled(SHAPE.normals, 0), MASK)
    wide = [
        NormalField(padded(normals.vectors, 0.7), padded(MASK, False)) for normals in (other, SHAPE.normals)
    ]
    assert getattr(angular_error(*wide), field) == getattr(angular_error(other, SHAPE.normals), field)
    pictures = [painted(normals, SOFT) for normals in (other, SHAPE.normals)]
    wide = [ToonImage(padded(picture.color, 0.7), padded(MASK, False)) for picture in pictures]
    assert getattr(color_difference(*wide), field) == getattr(color_difference(*pictures), field)
    assert color_rmse(*wide) == color_rmse(*pictures)


def test_color_rmse_is_the_root_of_the_mean_square_over_channels():
    gray = ToonImage(np.full((*MASK.shape, 3), 0.5), MASK)
    other = ToonImage(gray.color + np.array([0.3, 0.0, 0.0]), MASK)
    assert color_rmse(gray, other) == pytest.approx(0.3 / np.sqrt(3))


def test_ciede2000_of_one_step_of_gray_is_about_one():
    gray = ToonImage(np.full((*MASK.shape, 3), 0.5), MASK)
    lighter = ToonImage(np.full((*MASK.shape, 3), 0.51), MASK)
    assert 0.5 < color_difference(gray, lighter).mean < 1.5


def test_illumination_error_is_the_absolute_difference():
    light = illumination(SHAPE.normals, LIGHT)
    assert illumination_error(0.7 * light + 0.25, 0.7 * light, MASK).mean == pytest.approx(0.25)


def test_relight_response_is_one_for_the_truth_and_zero_for_a_picture_that_ignores_the_light():
    before, after = shade(SHAPE.normals, LIGHT, SOFT), shade(SHAPE.normals, [1, 0, 1], SOFT)
    assert relight_response(before, after, before, after) == pytest.approx(1.0)
    assert relight_response(before, before, before, after) == 0.0
    assert np.isnan(relight_response(before, after, before, before))


def test_metrics_refuse_other_masks():
    other = ellipse(20, 12)
    smaller = NormalField(np.broadcast_to([0.0, 0, 1], (*other.mask.shape, 3)), other.mask)
    with pytest.raises(ToonkitError, match="must cover the same mask"):
        angular_error(SHAPE.normals, smaller)
    with pytest.raises(ToonkitError, match="must be known"):
        illumination_error(np.full(MASK.shape, np.nan), np.zeros(MASK.shape), MASK)


def test_turning_every_normal_about_the_view_axis_changes_steep_ones_most():
    error = angular_error(turned(10), SHAPE.normals)
    middle = (np.abs(SHAPE.x) < 2) & (np.abs(SHAPE.y) < 2)
    assert np.nanmax(error.map) == pytest.approx(10, abs=0.3)
    assert error.map[middle].max() < 2


def of_lab(lightness: float, a: float, b: float) -> ToonImage:
    return ToonImage(np.broadcast_to(oklab_to_srgb([lightness, a, b]), (*MASK.shape, 3)), MASK)


RED = of_lab(0.6, 0.1, 0.0)  # of chroma 0.1: it may move 0.05 + 0.25 * 0.1 = 0.075 off its ray


@pytest.mark.parametrize(
    ("after", "share"),
    [
        (RED, 0),
        (of_lab(0.94, 0.02, 0.0), 0),  # lighter and paler, along the ray
        (of_lab(0.96, 0.02, 0.0), 1),  # lighter than L + 0.35
        (of_lab(0.25, 0.05, 0.0), 0),
        (of_lab(0.23, 0.05, 0.0), 1),  # darker than 0.4 L
        (of_lab(0.6, 0.1, 0.07), 0),
        (of_lab(0.6, 0.1, 0.08), 1),  # another hue
        (of_lab(0.6, -0.07, 0.0), 0),  # behind gray the nearest point of the ray is gray
        (of_lab(0.6, -0.08, 0.0), 1),
        (of_lab(0.6, 0.19, 0.0), 0),  # more of the same hue
    ],
)
def test_a_color_leaks_where_shading_cannot_move_it(after, share):
    assert leak(RED, after) == share


def test_leak_is_the_share_of_pixels_that_leak():
    left = np.arange(MASK.shape[1])[None, :, None] < MASK.shape[1] // 2
    after = ToonImage(np.where(left, of_lab(0.6, 0.0, 0.1).color, RED.color), MASK)
    assert leak(RED, after) == pytest.approx((MASK & left[..., 0]).sum() / MASK.sum())


def test_response_is_the_mean_absolute_change_of_lightness():
    up = np.arange(MASK.shape[0])[:, None, None] < MASK.shape[0] // 2
    after = ToonImage(np.where(up, of_lab(0.8, 0.1, 0.0).color, of_lab(0.5, 0.1, 0.0).color), MASK)
    share = (MASK & up[..., 0]).sum() / MASK.sum()
    assert response(RED, after) == pytest.approx(0.2 * share + 0.1 * (1 - share))
    assert response(RED, RED) == 0.0


@pytest.mark.parametrize("measure", [leak, response])
def test_padding_the_picture_changes_neither_leak_nor_response(measure):
    noise = np.random.default_rng(0).uniform(size=(*MASK.shape, 3))
    pictures = [painted(SHAPE.normals, SOFT), ToonImage(noise, MASK)]
    wide = [ToonImage(padded(picture.color, 0.7), padded(MASK, False)) for picture in pictures]
    assert measure(*wide) == measure(*pictures) > 0


@pytest.mark.parametrize("measure", [leak, response, angular_error, color_rmse, color_difference])
def test_bare_arrays_are_refused(measure):
    with pytest.raises(ToonkitError, match="must be a"):
        measure(SHAPE.x, SHAPE.y)

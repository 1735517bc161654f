"""Parts that do not touch are objects of their own, and what is around an object changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from tests.analytic import LIGHT, SOFT, TWO_TONE, ellipse, painted
from toonkit import METHODS, NormalField, ToonImage, analyze, angular_error, estimate_light, inflate
from toonkit.estimation.islands import LEAST_PIXELS, MOST, islands_of
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES

PADDINGS = [((5, 60), (11, 37)), ((1, 0), (0, 3)), ((64, 64), (64, 64))]


def drawing(name: str = "cat", color_map: str = "terracotta", size: int = 96) -> ToonImage:
    truth = render_shape(SHAPES[name], size)
    return painted(truth.normals, load_color_maps()[color_map], alpha=truth.coverage)


def padded(image: ToonImage, padding: tuple[tuple[int, int], tuple[int, int]]) -> ToonImage:
    return ToonImage(
        np.pad(image.color, (*padding, (0, 0)), constant_values=np.nan),
        np.pad(image.mask, padding),
        alpha=np.pad(image.alpha, padding),
    )


def beside_each_other(images: list[ToonImage], gap: int = 20) -> ToonImage:
    framed = [padded(image, ((0, 0), (0, gap))) for image in images]
    return ToonImage(
        np.concatenate([image.color for image in framed], axis=1),
        np.concatenate([image.mask for image in framed], axis=1),
        alpha=np.concatenate([image.alpha for image in framed], axis=1),
    )


@pytest.mark.parametrize("method", list(METHODS))
@pytest.mark.parametrize("padding", PADDINGS)
def test_padding_changes_no_bit_of_the_normals(method, padding):
    image = drawing()
    tight, loose = (analyze(picture, LIGHT, method=method) for picture in (image, padded(image, padding)))
    assert np.array_equal(tight.normals.compact, loose.normals.compact)
    assert np.array_equal(tight.color_map.colors, loose.color_map.colors)


@pytest.mark.parametrize("padding", PADDINGS)
def test_padding_changes_no_bit_of_an_estimated_light(padding):
    image = drawing()
    tight, loose = (estimate_light(picture) for picture in (image, padded(image, padding)))
    assert np.array_equal(tight.light, loose.light)
    assert tight.confidence == loose.confidence


@pytest.mark.parametrize("padding", PADDINGS)
def test_padding_a_drawing_that_fills_its_frame_changes_no_bit(padding):
    image = drawing("duck")
    rows, columns = (np.flatnonzero(image.mask.any(axis=axis)) for axis in (1, 0))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    cropped = ToonImage(image.color[box], image.mask[box], alpha=image.alpha[box])
    tight, loose = (analyze(picture, LIGHT) for picture in (cropped, padded(cropped, padding)))
    assert np.array_equal(tight.normals.compact, loose.normals.compact)


@pytest.mark.parametrize("copies", [2, 5])
@pytest.mark.parametrize("method", ["toonkit", "classical"])
def test_each_of_several_copies_has_the_normals_of_a_single_one(copies, method):
    image = drawing(size=128)
    alone = analyze(image, LIGHT, method=method).normals
    several = analyze(beside_each_other([image] * copies), LIGHT, method=method).normals
    for vectors in np.split(several.vectors, copies, axis=1):
        one = NormalField(vectors[:, : image.shape[1]], image.mask)
        # The color map is fitted to all copies: rounding is all that differs.
        assert angular_error(one, alone).mean < 0.01


def test_several_copies_have_the_light_of_a_single_one():
    image = drawing(size=128)
    one, three = estimate_light(image), estimate_light(beside_each_other([image] * 3))
    assert one.light @ three.light > np.cos(np.deg2rad(0.5))
    assert three.confidence == pytest.approx(one.confidence, abs=0.02)


def test_an_island_is_inflated_as_if_it_were_alone():
    small, large = ellipse(20, 14), ellipse(40, 40)
    both = np.zeros((100, 160), bool)
    both[: small.mask.shape[0], : small.mask.shape[1]] = small.mask
    both[: large.mask.shape[0], -large.mask.shape[1] :] = large.mask
    vectors = inflate(both).vectors
    found = NormalField(vectors[: small.mask.shape[0], : small.mask.shape[1]], small.mask)
    assert angular_error(found, inflate(small.mask)).mean < 1e-9


def test_pixels_that_touch_at_a_corner_are_on_one_island():
    mask = np.zeros((20, 20), bool)
    mask[:10, :10] = mask[10:, 10:] = True
    assert len(islands_of(mask, mask.astype(float))) == 1


def test_parts_too_small_for_a_shape_of_their_own_form_one_island():
    mask = np.zeros((64, 64), bool)
    mask[::8, ::8] = True
    mask[20:52, 20:52] = True
    islands = islands_of(mask, mask.astype(float))
    assert len(islands) == 2
    assert sorted(island.grid.size for island in islands)[0] < LEAST_PIXELS
    assert sum(island.grid.size for island in islands) == mask.sum()


def test_a_sheet_of_very_many_parts_has_a_limited_number_of_islands():
    mask = np.kron(np.indices((24, 24)).sum(axis=0) >= 0, np.pad(np.ones((8, 8)), 1)) > 0
    islands = islands_of(mask, mask.astype(float))
    assert len(islands) == MOST + 1
    assert sum(island.grid.size for island in islands) == mask.sum()
    analysis = analyze(
        ToonImage(np.where(mask, 0.5, 0.0)[..., None].repeat(3, 2), mask), LIGHT, method="lumo"
    )
    assert np.isfinite(analysis.normals.compact).all()


@pytest.mark.parametrize("color_map", [SOFT, TWO_TONE], ids=["soft", "two tones"])
def test_islands_of_one_ramp_share_its_color_map(color_map):
    balls = [painted(shape.normals, color_map, alpha=shape.coverage) for shape in (ellipse(40, 40),) * 2]
    one, two = analyze(balls[0], LIGHT), analyze(beside_each_other(balls), LIGHT)
    assert np.abs(one.color_map.colors - two.color_map.colors).max() < 0.02

"""The reduced drawing that the networks see."""

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from benchmarks import resolutions
from tests.analytic import TWO_TONE, ellipse, painted
from toonkit import ToonImage
from toonkit.estimation.overview import LONGEST, Overview
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.working_square import WorkingSquare

FROM_ABOVE = np.array([-0.36, 0.8, 0.48])
"""A light under which islands lie as they are drawn."""


def overview(size: int) -> tuple[Overview, float]:
    shape = ellipse(size, 0.6 * size)
    read = prepare(painted(shape.normals, TWO_TONE))
    return overview_of(read), shape.mask.sum()


def seen_in(image: ToonImage) -> Overview:
    return overview_of(prepare(image))


def overview_of(drawing: PreparedDrawing) -> Overview:
    (paint,) = drawing.posed(FROM_ABOVE).reduced_paint
    return Overview.of(paint, drawing.initial_normals.compact)


def drawn_on_blocks(size: int) -> ToonImage:
    """Paint a disc whose outline follows blocks of 8 x 8 pixels, in slanting bands that follow none."""
    down, along = np.indices((size, size))
    blocks = (np.indices((size // 8, size // 8)) + 0.5) / (size // 8) - 0.5
    mask = np.kron(np.hypot(*blocks) < 0.45, np.ones((8, 8))) > 0
    tones = 0.2 + 0.15 * np.floor(5 * (0.7 * down + along) / (1.7 * size))
    return ToonImage(np.repeat(tones[..., None], 3, axis=2), mask)


@pytest.mark.parametrize("radius", [40, 150])
def test_a_small_drawing_is_seen_as_it_is(radius):
    reduced, area = overview(radius)
    assert (reduced.factor, reduced.grid.size) == (1, area)


@pytest.mark.parametrize(("radius", "factor"), [(170, 2), (330, 4), (500, 4)])
def test_a_large_one_is_reduced_by_halves(radius, factor):
    reduced, area = overview(radius)
    assert reduced.factor == factor
    assert max(np.ptp(reduced.grid.rows), np.ptp(reduced.grid.columns)) < LONGEST
    assert reduced.grid.size == pytest.approx(area / factor**2, rel=0.01)
    assert np.allclose(np.linalg.norm(reduced.initial, axis=1), 1)


def test_it_has_the_drawings_own_tones_and_no_mixtures():
    reduced, _ = overview(330)
    bands = np.unique(prepare(painted(ellipse(330, 198).normals, TWO_TONE)).tones.plain.round(9))
    inner = np.abs(reduced.tones[:, None] - bands).min(axis=1) < 1e-6
    assert inner.mean() > 0.99  # at the rim, a block whose middle is outside has the mean of the rest


def test_the_same_drawing_in_four_times_the_pixels_is_seen_alike():
    seen = []
    for size in (150, 300):
        reduced, _ = overview(size)
        square = WorkingSquare.around(reduced.grid, np.array([0.6, 0.8]))
        seen.append(reduced.seen_from(square))
    small, large = seen
    both = small.mask & large.mask
    assert (small.mask ^ large.mask).mean() < 0.01
    assert (np.abs(small.tones - large.tones)[both] > 0.01).mean() < 0.03
    assert np.abs(small.initial - large.initial)[both].mean() < 0.02


@pytest.mark.parametrize("radius", [60, 190])
def test_ink_is_seen_where_it_is_drawn_and_the_paint_beneath_by_its_neighbors(radius):
    shape = ellipse(radius, 0.8 * radius)
    clean = painted(shape.normals, TWO_TONE)
    ink = distance_transform_edt(shape.mask) <= 0.04 * radius
    image = ToonImage(np.where(ink[..., None], 0.02, clean.color), shape.mask)
    reduced = seen_in(image)
    square = WorkingSquare.around(reduced.grid, np.array([1.0, 0.0]))
    seen = reduced.seen_from(square)
    rim = seen.mask & (distance_transform_edt(np.pad(seen.mask, 1))[1:-1, 1:-1] <= 1.0)
    assert seen.ink[rim].mean() > 0.9
    assert not seen.ink[distance_transform_edt(seen.mask) > 5].any()
    assert seen.tones[seen.mask].min() > 0.1


@pytest.mark.parametrize("radius", [60, 190])
def test_materials_are_seen_where_they_are_painted(radius):
    shape = ellipse(radius, 0.8 * radius)
    labels = np.where(shape.x > 0, 1, 0)
    reduced = overview_of(prepare(painted(shape.normals, TWO_TONE), materials=labels))
    seen = reduced.seen_from(WorkingSquare.around(reduced.grid, np.array([1.0, 0.0])))
    middle = seen.labels.shape[1] // 2
    for number, half in enumerate((np.s_[:, : middle - 1], np.s_[:, middle + 1 :])):
        assert (seen.labels[half][seen.mask[half]] == number).all()


def test_without_ink_none_is_seen():
    reduced, _ = overview(60)
    assert not reduced.ink.any()


@pytest.mark.parametrize("factor", [2, 4])
def test_a_large_drawing_is_seen_as_the_same_one_reduced_beforehand(factor):
    large = drawn_on_blocks(800)
    seen = [seen_in(image) for image in (large, resolutions.reduced(large, factor))]
    assert seen[0].factor == factor * seen[1].factor == 4
    assert (seen[0].grid.mask == seen[1].grid.mask).all()
    assert np.allclose(seen[0].tones, seen[1].tones)
    bands = np.unique(large.color[large.mask])
    own = np.abs(seen[0].tones[:, None] - bands).min(axis=1) < 1e-6
    assert own.mean() > 0.99  # no mixtures but at the rim


def test_a_drawing_is_reduced_once_and_its_normals_whenever_they_are_given():
    image = drawn_on_blocks(400)
    drawing = prepare(image)
    first, second = overview_of(drawing), overview_of(drawing)
    assert second.tones is first.tones
    (paint,) = drawing.posed(FROM_ABOVE).reduced_paint
    flat = Overview.of(paint, np.tile([0.0, 0.6, 0.8], (drawing.grid.size, 1)))
    assert flat.tones is first.tones
    assert np.allclose(flat.initial, [0.0, 0.6, 0.8])
    assert np.ptp(second.initial[:, 2]) > 0.5


def test_what_is_narrow_when_reduced_is_a_mixture_at_any_size():
    # A transition 8 pixels wide is as wide as a block: a drawing of that size could not tell it from a mixture.
    tones = np.clip((np.arange(1400) - 694) / 8, 0, 1) * 0.6 + 0.2
    color = np.broadcast_to(tones[None, :, None], (1000, 1400, 3))
    read = prepare(ToonImage(color, np.ones((1000, 1400), bool)))
    reduced = overview_of(read)
    assert reduced.factor == 8
    assert (np.abs(reduced.tones[:, None] - [0.2, 0.8]).min(axis=1) < 1e-6).all()
    assert (np.abs(read.tones.plain[:, None] - [0.2, 0.8]).min(axis=1) > 0.01).any()

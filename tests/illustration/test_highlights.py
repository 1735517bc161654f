"""Highlights: pale spots of light are told from eyes, dots and teeth, whatever materials they lie on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

import toonkit
from tests.illustration.drawings import BLACK, BLUE, GREEN, OVER, RED, Ball, Canvas
from toonkit import ToonImage
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.illustration.materials import label_materials

WHITE = (0.99, 0.99, 0.97)
SAND = ((0.55, 0.45, 0.36), (0.80, 0.71, 0.62))


def two_balls() -> Canvas:
    canvas = Canvas(128)
    canvas.ball(Ball(44, 40, 34, RED), 0)
    canvas.ball(Ball(84, 88, 34, GREEN), 1)
    return canvas


def prepared(canvas: Canvas, labels: np.ndarray | None = None) -> PreparedDrawing:
    drawn = canvas.drawn()
    return prepare(ToonImage(drawn.color, drawn.mask), materials=labels)


def highlit(drawing: PreparedDrawing) -> np.ndarray:
    found = np.zeros(drawing.shape, bool)
    mixed = drawing.mixed
    found[drawing.places(mixed.pixels[mixed.highlit])] = True
    return found


def centers(fine: np.ndarray) -> np.ndarray:
    """Sample a fine mask at the centers of pixels."""
    return fine[OVER // 2 :: OVER, OVER // 2 :: OVER]


def overlap(one: np.ndarray, two: np.ndarray) -> float:
    return (one & two).sum() / (one | two).sum()


def test_highlights_of_one_color_are_found_on_every_material_and_belong_to_it():
    canvas = two_balls()
    beneath = canvas.drawn().label
    spots = canvas.disc(34, 30, 5) | canvas.disc(72, 78, 5)
    canvas.fill(spots, WHITE, 2)
    drawing = prepared(canvas)
    assert drawing.materials.count == 2
    assert overlap(highlit(drawing), centers(spots)) > 0.7  # and their anti-aliased rims
    first, second = (np.unique(drawing.materials.labels[beneath == label]) for label in (0, 1))
    assert len(first) == len(second) == 1
    assert first != second


def test_one_whose_color_fits_a_ramp_is_found_where_another_material_shows_it_too():
    canvas = Canvas(128)
    canvas.ball(Ball(44, 40, 34, RED), 0)
    canvas.ball(Ball(84, 88, 34, SAND), 1)
    first, second = canvas.disc(34, 30, 5), canvas.disc(72, 78, 5)
    canvas.fill(second, WHITE, 1)
    assert not highlit(prepared(canvas)).any()  # it might be the third tone
    canvas.fill(first, WHITE, 0)
    drawing = prepared(canvas)
    assert overlap(highlit(drawing), centers(first | second)) > 0.6
    assert [len(tones) for tones in drawing.materials.tones] == [2, 2]


def test_the_lit_tone_of_a_pattern_is_none():
    canvas = two_balls()
    canvas.ball(Ball(34, 30, 9, SAND), 2)
    canvas.ball(Ball(74, 76, 9, SAND), 2)
    for row, column in ((32, 28), (72, 74)):
        canvas.fill(canvas.disc(row, column, 5) & (canvas.label == 2), WHITE, 2)
        canvas.fill(canvas.disc(row - 6, column - 6, 6) & (canvas.label == 2), SAND[1], 2)
    assert not highlit(prepared(canvas)).any()


def test_a_white_eye_is_none():
    canvas = two_balls()
    canvas.fill(canvas.disc(34, 30, 7), WHITE, 2)
    canvas.fill(canvas.disc(34, 36, 4), BLACK, 3)
    assert not highlit(prepared(canvas)).any()


def test_many_alike_are_a_pattern():
    canvas = two_balls()
    for row, column in ((30, 26), (34, 46), (52, 30), (56, 50)):
        canvas.fill(canvas.disc(row, column, 4), WHITE, 2)
    assert not highlit(prepared(canvas)).any()


def test_a_spot_in_the_shadow_is_none():
    canvas = two_balls()
    canvas.fill(canvas.disc(60, 58, 4), WHITE, 2)
    assert not highlit(prepared(canvas)).any()


@pytest.mark.parametrize("named", [False, True])
def test_a_highlight_is_found_on_materials_that_somebody_named_unless_it_is_named_too(named):
    canvas = two_balls()
    spot = canvas.disc(34, 30, 5)
    labels = canvas.drawn().label
    canvas.fill(spot, WHITE, 0)
    if named:
        labels[centers(spot)] = 2
    drawing = prepared(canvas, labels)
    assert highlit(drawing).any() == (not named)
    np.testing.assert_array_equal(drawing.materials.labels, labels)
    assert [len(tones) for tones in drawing.materials.tones] == ([2, 2, 1] if named else [2, 2])


def test_a_border_that_somebody_drew_loosely_adds_no_tones():
    canvas = two_balls()
    loose = canvas.drawn().label
    disc = canvas.disc(64, 64, 20)
    loose[centers(canvas.disc(64, 64, 18.5)) & (loose >= 0)] = 2
    canvas.fill(disc & (canvas.label >= 0), BLUE[1], 2)
    drawing = prepared(canvas, loose)
    apart = [np.abs(tones - BLUE[1]).max(axis=1).min() for tones in drawing.materials.tones]
    assert apart[0] > 0.2
    assert apart[1] > 0.2
    assert apart[2] < 0.01


def test_one_on_the_border_of_a_material_that_somebody_named_is_found():
    canvas = two_balls()
    labels = canvas.drawn().label
    spot = canvas.disc(62, 44, 5) & (canvas.label == 0)
    canvas.fill(spot, WHITE, 0)
    canvas.fill(canvas.disc(70, 44, 4) & (canvas.label == 0), BLACK, 0)
    assert not highlit(prepared(canvas)).any()
    drawing = prepared(canvas, labels)
    assert overlap(highlit(drawing), centers(spot)) > 0.6
    assert drawing.materials.tones[0].max() < 0.9


def test_pixels_of_materials_that_somebody_named_take_their_paint_from_their_own():
    canvas = two_balls()
    canvas.fill(canvas.disc(34, 38, 5), BLUE[1], 2)
    labels = canvas.drawn().label
    canvas.fill(canvas.disc(34, 30, 5), WHITE, 0)  # and the blue spot's rim is nearest to it in color
    drawing = prepared(canvas, labels)
    frame = drawing.frame
    told = frame.cut(labels)
    found = label_materials(frame, drawing.ink.coverage, drawing.framed_normals, labels=told)
    assert found.highlights.any()
    np.testing.assert_array_equal(told.ravel()[found.sources[frame.mask]], told[frame.mask])


def test_a_seam_around_a_highlight_leaves_no_trace_in_the_shape():
    canvas = two_balls()
    canvas.fill(canvas.disc(34, 30, 9), WHITE, 2)
    drawn = canvas.drawn()
    plain = prepared(canvas)
    ring = ndimage.binary_dilation(highlit(plain), iterations=2) & ~highlit(plain) & drawn.mask
    color = drawn.color.copy()
    color[ring] = np.clip(color[ring] * np.where((np.nonzero(ring)[0] % 2)[:, None], 0.97, 1.03), 0, 1)
    clean, seamed = (
        toonkit.analyze(ToonImage(shown, drawn.mask), (130, 45)).normals.compact
        for shown in (drawn.color, color)
    )
    turned = np.degrees(np.arccos(np.clip((clean * seamed).sum(axis=1), -1, 1)))
    assert turned[highlit(plain)[drawn.mask]].max() < 5

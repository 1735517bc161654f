"""Highlights: pale spots of light are told from eyes, dots and teeth, whatever materials they lie on."""

from __future__ import annotations

import numpy as np
import pytest

from tests.illustration.drawings import BLACK, BLUE, GREEN, OVER, RED, Ball, Canvas
from toonkit import ToonImage
from toonkit.estimation.preparation import PreparedDrawing, prepare

WHITE = (0.99, 0.99, 0.97)


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

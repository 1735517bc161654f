"""Ink is told from paint and shading, whatever its color and width."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from tests.illustration.drawings import BLACK, BLUE, GREEN, LIGHT, RED, SKIN, Ball, Canvas, Drawn
from toonkit.illustration.frame import Frame
from toonkit.illustration.ink import Ink, find_ink
from toonkit.study.color_maps import load_color_maps

BODY = Ball(48, 48, 42, RED)
HEAD = Ball(40, 42, 22, SKIN)


def ink_of(color: np.ndarray, mask: np.ndarray) -> Ink:
    """Find the ink of a picture, on the whole of it."""
    frame = Frame.around(color, mask)
    ink = find_ink(frame)
    coverage = np.zeros(mask.shape)
    coverage[frame.place] = frame.inner(ink.coverage)
    return replace(ink, coverage=coverage)


def two_balls(width: float, color: object = BLACK) -> Drawn:
    canvas = Canvas()
    for label, ball in enumerate((BODY, HEAD)):
        canvas.ball(ball, label)
        canvas.outline(ball, width, color)
    return canvas.drawn()


def f1(drawn: Drawn) -> float:
    found = ink_of(drawn.color, drawn.mask).coverage > 0.5
    true = drawn.ink > 0.5
    return 2 * np.count_nonzero(found & true) / (np.count_nonzero(found) + np.count_nonzero(true))


@pytest.mark.parametrize("width", [1.2, 2.0, 3.0])
@pytest.mark.parametrize(
    "color", [BLACK, (0.30, 0.05, 0.10), (0.10, 0.12, 0.35)], ids=["black", "red", "blue"]
)
def test_lines_of_any_color_and_width_are_found(width: float, color: object) -> None:
    assert f1(two_balls(width, color)) > 0.92


def test_lines_lighter_than_the_darkest_paint_are_found() -> None:
    canvas = Canvas()
    body, patch = Ball(48, 48, 42, SKIN), Ball(56, 52, 14, ((0.02, 0.02, 0.03),), ())
    canvas.ball(body, 0)
    canvas.ball(patch, 1)
    canvas.outline(body, 2.0, (0.25, 0.12, 0.10))
    assert f1(canvas.drawn()) > 0.9


def test_an_outline_may_be_missing_in_places() -> None:
    canvas = Canvas()
    canvas.ball(BODY, 0)
    canvas.outline(BODY, 2.0)
    gap = (canvas.ink) & (canvas.columns > 70) & (canvas.rows < 40)
    canvas.color[gap] = RED[1]
    canvas.ink &= ~gap
    assert f1(canvas.drawn()) > 0.9


def test_tapered_lines_are_found() -> None:
    canvas = Canvas()
    canvas.ball(BODY, 0)
    canvas.outline(BODY, 2.0)
    canvas.line(np.abs(canvas.rows - 40) < 1.8 * (1 - np.abs(canvas.columns - 48) / 30))
    assert f1(canvas.drawn()) > 0.9


def test_inner_lines_without_an_outline_are_found() -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, GREEN), 0)
    arc = np.abs(np.hypot(canvas.rows - 40, canvas.columns - 48) - 20) < 0.8
    canvas.line(arc & (canvas.rows > 48))
    drawn = canvas.drawn()
    found = ink_of(drawn.color, drawn.mask).coverage > 0.5
    assert np.mean(found[drawn.ink > 0.5]) > 0.9
    assert np.mean(drawn.ink[found] > 0.1) > 0.9


@pytest.mark.parametrize("name", list(load_color_maps()))
def test_shading_of_a_ball_is_no_ink(name: str) -> None:
    canvas = Canvas()
    canvas.ball(BODY, 0)
    drawn = canvas.drawn()
    color = np.zeros_like(drawn.color)
    color[drawn.mask] = load_color_maps()[name]((drawn.normals @ LIGHT)[drawn.mask])
    assert not ink_of(color, drawn.mask).coverage.any()


def test_pupils_of_a_color_of_their_own_are_no_ink() -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, SKIN), 0)
    for column in (36, 60):
        canvas.fill(canvas.disc(44, column, 3), (0.15, 0.25, 0.15), 1)
    drawn = canvas.drawn()
    assert not ink_of(drawn.color, drawn.mask).coverage.any()


def test_coverage_and_color_give_the_drawing_back() -> None:
    drawn = two_balls(2.0)
    ink = ink_of(drawn.color, drawn.mask)
    inside = ink.coverage > 0.9
    assert np.abs(ink.colors[inside[ink.coverage > 0]] - BLACK).max() < 0.1
    assert ink.coverage.min() >= 0
    assert ink.coverage.max() <= 1
    assert not ink.coverage[~drawn.mask].any()
    assert np.abs(ink.coverage - drawn.ink)[drawn.mask].mean() < 0.02


def test_a_drawing_of_lines_alone_is_recognized() -> None:
    canvas = Canvas()
    for radius in (20, 40):
        ring = np.abs(np.hypot(canvas.rows - 48, canvas.columns - 48) - radius)
        canvas.fill(ring < 2.5, (0.95, 0.95, 0.97), 0)
        canvas.line(ring < 1.2, (0.2, 0.2, 0.5))
    drawn = canvas.drawn()
    assert ink_of(drawn.color, drawn.mask).only_lines


def test_lines_on_blank_paper_are_lines_alone() -> None:
    canvas = Canvas()
    paper = Ball(48, 48, 44, ((1.0, 1.0, 1.0),), ())
    canvas.ball(paper, 0)
    canvas.outline(paper, 1.5)
    canvas.outline(Ball(48, 48, 25, ()), 1.5)
    drawn = canvas.drawn()
    assert ink_of(drawn.color, drawn.mask).only_lines


def test_a_painted_drawing_is_not_lines_alone() -> None:
    drawn = two_balls(2.0)
    assert not ink_of(drawn.color, drawn.mask).only_lines


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_turned_or_mirrored_drawing_has_turned_or_mirrored_ink(turns: int, mirrored: bool) -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, BLUE), 0)
    canvas.outline(BODY, 2.0)
    canvas.line(np.abs(canvas.rows - 30 - 0.3 * canvas.columns) < 0.9)
    drawn = canvas.drawn()

    def moved(values: np.ndarray) -> np.ndarray:
        values = np.rot90(values, turns)
        return values[:, ::-1] if mirrored else values

    there = ink_of(moved(drawn.color).copy(), moved(drawn.mask).copy()).coverage
    np.testing.assert_allclose(there, moved(ink_of(drawn.color, drawn.mask).coverage), atol=1e-6)


def test_padding_changes_nothing() -> None:
    drawn = two_balls(2.0)
    padded = ink_of(np.pad(drawn.color, ((9, 3), (2, 17), (0, 0))), np.pad(drawn.mask, ((9, 3), (2, 17))))
    inside = padded.coverage[9:-3, 2:-17]
    np.testing.assert_array_equal(inside, ink_of(drawn.color, drawn.mask).coverage)


def test_ink_smeared_by_a_blur_is_found() -> None:
    drawn = two_balls(3.0)
    weight = ndimage.gaussian_filter(drawn.mask.astype(float), 0.6)
    blurred = ndimage.gaussian_filter(drawn.color * drawn.mask[..., None], (0.6, 0.6, 0))
    color = np.where(drawn.mask[..., None], blurred / np.maximum(weight, 1e-9)[..., None], 0)
    assert f1(Drawn(np.clip(color, 0, 1), drawn.mask, drawn.label, drawn.ink, drawn.normals)) > 0.85

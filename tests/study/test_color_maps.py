"""The study's ramps, and the one a stroke takes from a drawing."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest

from toonkit import ColorMap, ToonImage
from toonkit._validation import ToonkitError
from toonkit.model.luminance import luminance, tone
from toonkit.study.color_maps import Ramp, extract_color_map, load_color_maps, load_ramps

NAMES = list(load_ramps())
ROUNDING = 1e-12  # a plateau is computed from the same numbers at each of its samples, up to rounding


def graded_picture(size: int = 40) -> ToonImage:
    """A drawing that goes from violet at the left to cream at the right, empty in its top quarter."""
    ramp = ColorMap([[0.25, 0.1, 0.35], [0.8, 0.4, 0.4], [1.0, 0.9, 0.7]])
    mask = np.ones((size, size), dtype=bool)
    mask[: size // 4] = False
    return ToonImage(np.repeat(ramp(np.linspace(-1, 1, size))[None], size, axis=0), mask)


def row_stroke(size: int, row: int) -> np.ndarray:
    stroke = np.zeros((size, size), dtype=bool)
    stroke[row] = True
    return stroke


def test_the_study_has_twenty_four_color_maps() -> None:
    assert len(load_color_maps()) == 24


@pytest.mark.parametrize("name", NAMES)
def test_a_ramp_never_gets_darker_with_more_illumination(name: str) -> None:
    assert np.diff(luminance(load_color_maps()[name].colors)).min() >= -ROUNDING


@pytest.mark.parametrize("name", NAMES)
def test_a_ramp_has_1024_samples_from_the_darkest_to_the_brightest_illumination(name: str) -> None:
    color_map = load_color_maps()[name]
    assert color_map.colors.shape == (1024, 3)
    assert color_map.domain == (-1.0, 1.0)


@pytest.mark.parametrize("name", NAMES)
def test_a_ramp_has_two_to_six_tones_and_a_step_between_each_two(name: str) -> None:
    ramp = load_ramps()[name]
    assert 2 <= len(ramp.tones) <= 6
    assert len(ramp.steps) == len(ramp.tones) - 1
    assert all(re.fullmatch("#[0-9a-f]{6}", color) for color in ramp.tones)
    assert all(here[0] < there[0] for here, there in pairwise(ramp.steps))


@pytest.mark.parametrize("name", NAMES)
def test_the_ends_of_a_ramp_are_its_first_and_last_tone(name: str) -> None:
    ramp, color_map = load_ramps()[name], load_color_maps()[name]
    ends = [[int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)] for color in (ramp.tones[0], ramp.tones[-1])]
    # Soft steps may reach past the ends of the domain, by less than an eye sees.
    assert np.abs(color_map.colors[[0, -1]] - ends).max() < 0.03


def test_no_two_ramps_look_alike() -> None:
    colors = np.array([color_map.colors for color_map in load_color_maps().values()])
    difference = np.sqrt(((colors[:, None] - colors[None]) ** 2).mean(axis=(2, 3)))
    # Two ramps of one hue and different steps differ by about this much, on average over channels.
    assert difference[~np.eye(len(colors), dtype=bool)].min() > 0.05


def test_ramps_reach_from_hard_to_soft_and_from_low_to_high_contrast() -> None:
    widest = np.array([max(step[1] for step in ramp.steps) for ramp in load_ramps().values()])
    tones = np.array([tone(color_map.colors[[0, -1]]) for color_map in load_color_maps().values()])
    contrast = np.diff(tones, axis=1)
    assert (widest == 0).sum() >= 4
    assert (widest >= 0.25).sum() >= 4
    assert contrast.min() < 0.25
    assert contrast.max() > 0.65


def test_a_hard_step_jumps_at_its_illumination() -> None:
    ramp = Ramp("jump", ("#000000", "#ffffff"), ((0.25, 0.0),), ())
    color_map = ramp.color_map()
    assert color_map(0.24).max() == 0.0
    assert color_map(0.26).min() == pytest.approx(1.0)


def test_a_soft_step_is_half_bright_in_its_middle() -> None:
    middle = Ramp("fade", ("#000000", "#ffffff"), ((0.0, 0.8),), ()).color_map()(0.0)
    # Samples lie on either side of 0, which is 1/1023 of illumination: the steepest rise over that is 0.002.
    assert luminance(middle) == pytest.approx(0.5, abs=0.002)


def test_a_stroke_along_the_gradient_gives_its_colors_back_in_order() -> None:
    picture = graded_picture()
    found = extract_color_map(picture, row_stroke(40, 20))
    assert found.domain == (-1.0, 1.0)
    # To linear light and back.
    assert np.abs(found.colors - picture.color[20]).max() < 1e-9


def test_the_order_of_pixels_under_a_stroke_does_not_matter() -> None:
    picture = graded_picture()
    shuffled = np.random.default_rng(3).permutation(40)
    mixed = ToonImage(picture.color[:, shuffled], picture.mask)
    found = extract_color_map(mixed, row_stroke(40, 30))
    assert np.array_equal(found.colors, extract_color_map(picture, row_stroke(40, 30)).colors)


def test_a_large_stroke_gives_at_most_1024_samples_that_never_get_darker() -> None:
    noise = np.random.default_rng(5).uniform(size=(64, 64, 3))
    found = extract_color_map(ToonImage(noise, np.ones((64, 64), dtype=bool)), np.ones((64, 64), dtype=bool))
    assert found.colors.shape == (1024, 3)
    assert np.diff(luminance(found.colors)).min() >= -ROUNDING


def test_two_pixels_are_enough_for_a_color_map() -> None:
    stroke = np.zeros((40, 40), dtype=bool)
    stroke[20, [39, 0]] = True
    picture = graded_picture()
    assert np.abs(extract_color_map(picture, stroke).colors - picture.color[20, [0, 39]]).max() < 1e-9


def test_what_a_stroke_touches_outside_the_object_is_ignored() -> None:
    picture = graded_picture()
    stroke = row_stroke(40, 20)
    along = extract_color_map(picture, stroke)
    stroke[:10] = True
    assert np.array_equal(extract_color_map(picture, stroke).colors, along.colors)


def test_pixels_that_the_object_covers_in_part_stay_out_of_the_color_map() -> None:
    picture = graded_picture()
    alpha = picture.mask.astype(float)
    alpha[20, :8] = 0.6
    found = extract_color_map(ToonImage(picture.color, picture.mask, alpha=alpha), row_stroke(40, 20))
    assert len(found.colors) == 32


@pytest.mark.parametrize(
    ("stroke", "complaint"),
    [
        (
            np.ones((40, 41), dtype=bool),
            r"stroke must have the size of the picture \(40, 40\); got \(40, 41\)",
        ),
        (np.ones((40, 40, 3), dtype=bool), r"stroke must be a \(H, W\) bool array"),
        (np.ones((40, 40)), r"stroke must be a \(H, W\) bool array; got shape \(40, 40\), float64"),
        (row_stroke(40, 3), "stroke must pass over the object; got 40 pixels, none of them on it"),
        (np.zeros((40, 40), dtype=bool), "stroke must pass over the object"),
        (np.arange(1600).reshape(40, 40) == 800, "stroke must pass over at least 2 object pixels; got 1"),
    ],
)
def test_a_stroke_that_takes_no_color_map_is_refused(stroke: np.ndarray, complaint: str) -> None:
    with pytest.raises(ToonkitError, match=complaint):
        extract_color_map(graded_picture(), stroke)

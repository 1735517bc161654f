"""The study's ramps."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest

from toonkit.model.luminance import luminance, tone
from toonkit.study.color_maps import Ramp, load_color_maps, load_ramps

NAMES = list(load_ramps())
ROUNDING = 1e-12  # a plateau is computed from the same numbers at each of its samples, up to rounding


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

"""Random color maps: tones that never fall with the illumination, in the steps of an 8-bit picture."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit.training.painting import HARD, RandomRamp, random_ramp

ILLUMINATION = np.linspace(-1, 1, 4001)
SEEDS = range(30)


@pytest.mark.parametrize("seed", SEEDS)
def test_more_light_is_never_painted_darker(seed: int) -> None:
    painted = random_ramp(np.random.default_rng(seed))(ILLUMINATION)
    assert (np.diff(painted) >= 0).all()
    assert painted[0] >= 0
    assert painted[-1] <= 1


@pytest.mark.parametrize("seed", SEEDS)
def test_tones_are_those_of_an_8_bit_picture(seed: int) -> None:
    steps = 255 * random_ramp(np.random.default_rng(seed))(ILLUMINATION)
    assert np.abs(steps - np.rint(steps)).max() < 1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_a_color_map_has_two_to_six_tones_that_can_be_told_apart(seed: int) -> None:
    ramp = random_ramp(np.random.default_rng(seed))
    assert 2 <= len(ramp.tones) <= 6
    assert len(ramp.edges) == len(ramp.widths) == len(ramp.tones) - 1
    assert np.diff(ramp.tones).min() > 0.04  # 0.06, before all of them are darkened to stay below one
    assert ramp.tones.max() <= 1
    assert (np.diff(ramp.edges) >= 0).all()
    assert np.abs(ramp.edges).max() < 0.95
    assert ramp.widths.min() >= HARD


def test_far_from_its_edges_a_ramp_has_the_tones_it_was_given() -> None:
    ramp = RandomRamp(np.array([51, 102, 255]) / 255, np.array([-0.2, 0.6]), np.array([HARD, 0.2]))
    painted = ramp(np.array([-1, -0.2 - HARD, -0.2 + HARD, 0.49, 0.71, 1]))
    assert painted * 255 == pytest.approx([51, 51, 102, 102, 255, 255])


def test_a_soft_step_is_halfway_up_at_its_edge_and_a_smoothstep_around_it() -> None:
    ramp = RandomRamp(np.array([0.0, 1.0]), np.array([0.1]), np.array([0.8]))
    painted = ramp(np.array([-0.3, -0.1, 0.1, 0.3, 0.5]))
    assert painted == pytest.approx([0, 0.25**2 * 2.5, 0.5, 1 - 0.25**2 * 2.5, 1], abs=0.5 / 255 + 1e-9)


def test_a_ramp_paints_pictures_of_any_shape_and_leaves_them_alone() -> None:
    ramp = random_ramp(np.random.default_rng(1))
    illumination = np.random.default_rng(2).uniform(-1, 1, (3, 5))
    before = illumination.copy()
    assert np.array_equal(ramp(illumination).ravel(), ramp(illumination.ravel()))
    assert np.array_equal(illumination, before)


def test_a_seed_draws_the_same_color_map_and_another_seed_another() -> None:
    first, again, other = (random_ramp(np.random.default_rng(seed))(ILLUMINATION) for seed in (3, 3, 4))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_steps_are_hard_soft_or_both_and_bands_many_or_few() -> None:
    rng = np.random.default_rng(5)
    ramps = [random_ramp(rng) for _ in range(400)]
    hard = np.array([(ramp.widths == HARD).mean() for ramp in ramps])
    for share in (hard == 1, hard == 0, (hard > 0) & (hard < 1)):
        assert share.mean() > 0.05
    assert {len(ramp.tones) for ramp in ramps} == {2, 3, 4, 5, 6}

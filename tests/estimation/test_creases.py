"""Links hold the change together on smooth ground, and let go across a crease; at any resolution alike."""

from __future__ import annotations

import numpy as np
import pytest

from tests.analytic import LIGHT, ellipse
from toonkit import NormalField, RefinementOptions, ToonkitError, refine
from toonkit.estimation.creases import crease_links
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, MaskedGrid


def roof(size: int) -> NormalField:
    """Two planes that meet in the middle column, under 90 degrees."""
    vectors = np.zeros((size, size, 3))
    side = np.where(np.arange(size) < size // 2, -1.0, 1.0) * np.sqrt(0.5)
    vectors[..., 0], vectors[..., 2] = side, np.sqrt(0.5)
    return NormalField(vectors, np.ones((size, size), bool))


@pytest.mark.parametrize("radius", [20, 40, 80])
def test_a_ball_is_held_together_alike_at_any_resolution(radius):
    ball = ellipse(radius, radius)
    grid = MaskedGrid(ball.mask)
    links = crease_links(grid, ball.normals.vectors[ball.mask], 10.0)
    middle = np.linalg.norm(ball.normals.vectors[ball.mask][:, :2], axis=1) < 0.5
    # In the middle a step of one pixel turns x by 1 / radius: sqrt(pi) radians per sqrt(area), and z by a little more.
    expected = 1 / (1 + np.pi / 10.0**2)
    assert links[middle].mean() == pytest.approx(expected, rel=0.01)


def test_the_links_across_a_crease_let_go_and_the_others_do_not():
    field = roof(32)
    grid = MaskedGrid(field.mask)
    links = crease_links(grid, field.vectors[field.mask], 10.0)
    across = np.zeros((32, 32), bool)
    across[:, 15] = True
    crease = across[field.mask]
    assert links[crease, RIGHT].max() < 0.06
    there = grid.neighbors != OUTSIDE
    there[crease, RIGHT] = False
    there[grid.neighbors[crease, RIGHT], 2] = False
    assert (links[there] == 1.0).all()


def test_a_link_is_the_same_from_both_ends():
    ball = ellipse(12, 9)
    grid = MaskedGrid(ball.mask)
    links = crease_links(grid, ball.normals.vectors[ball.mask], 2.0)
    here = np.flatnonzero(grid.neighbors[:, RIGHT] != OUTSIDE)
    assert np.array_equal(links[here, RIGHT], links[grid.neighbors[here, RIGHT], 2])


def test_one_side_of_a_roof_may_change_without_the_other():
    """The left half is told that it is darker than its normals say: the right half is to stay as it is."""
    field = roof(48)
    shining = field.vectors @ LIGHT
    wide = np.where(np.arange(48) < 24, shining - 0.25, -1.0)
    interval = IlluminationInterval(wide, np.where(np.arange(48) < 24, shining - 0.15, 1.0))

    def moved(turn: float) -> float:
        options = RefinementOptions(
            change_length=0.05, crease_turn=turn, rim_hold=0.0, integrability_length=0.0
        )
        change = refine(field, LIGHT, interval, options=options).normals.vectors - field.vectors
        return float(
            np.linalg.norm(change[:, 24:], axis=2).mean() / np.linalg.norm(change[:, :24], axis=2).mean()
        )

    assert moved(10.0) < 0.5 * moved(1e6)


@pytest.mark.parametrize("turn", [0.0, -1.0, np.nan])
def test_a_turn_that_means_nothing_is_refused(turn):
    with pytest.raises(ToonkitError, match="crease_turn must be a number > 0"):
        RefinementOptions(crease_turn=turn)

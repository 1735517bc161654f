"""Quarter turns and reflections: every drawing is analyzed as one of its eight lies, whichever of them it is."""

import numpy as np
import pytest

import toonkit
from tests.analytic import SOFT, ellipse, painted
from toonkit import ToonImage, light_direction
from toonkit.estimation.islands import islands_of, join_vectors
from toonkit.estimation.turn import AS_DRAWN, TURNS, Turn, turn_under_light
from toonkit.model.loading import load_image
from toonkit.samples import drawing_path

TURN_IDS = [
    "".join(name[0] for name in ("transposed", "flipped", "mirrored") if getattr(turn, name)) or "as drawn"
    for turn in TURNS
]


def directions(shape: tuple[int, int]) -> np.ndarray:
    """Return, at each pixel, where it lies from the middle, x to the right and y up."""
    rows, columns = np.indices(shape) - (np.reshape(shape, (2, 1, 1)) - 1) / 2
    return np.stack([columns, -rows, np.ones(shape)], axis=-1)


@pytest.mark.parametrize("turn", TURNS, ids=TURN_IDS)
def test_vectors_turn_with_the_picture_that_they_are_part_of(turn: Turn) -> None:
    turned = turn.picture(directions((3, 5)))
    assert (turn.vectors(turned) == directions(turned.shape[:2])).all()
    assert (turn.vectors_back(turn.vectors(turned)) == turned).all()


@pytest.mark.parametrize("azimuth", [0, 10, 45, 80, 90, 123, 180, 225, 269, 315, 350])
def test_a_light_comes_to_lie_above_or_up_to_45_degrees_to_the_left(azimuth: float) -> None:
    light = light_direction(azimuth, 30)
    turned = turn_under_light(light, np.array([0.3, -0.1])).vectors(light)
    assert 90 - 1e-9 < np.rad2deg(np.arctan2(turned[1], turned[0])) < 135 + 1e-9


def test_a_light_that_leaves_a_choice_leaves_it_to_the_moment() -> None:
    right, up = np.array([1.0, 0.0]), np.array([0.0, 1.0, 0.0])
    ahead = light_direction(0, 90)
    assert turn_under_light(ahead, right).vectors(np.array([1.0, 0.0, 0.0])) == pytest.approx([0, 1, 0])
    assert turn_under_light(up, -right) == AS_DRAWN
    assert turn_under_light(up, right) == Turn(mirrored=True)


@pytest.mark.parametrize("azimuth", [20, 70, 200])
def test_turned_islands_put_together_are_as_before(azimuth: float) -> None:
    mask = np.zeros((40, 60), bool)
    mask[3:20, 5:25], mask[10:38, 30:58] = True, True
    mask[12:15, 8:11] = False
    islands = islands_of(mask, mask.astype(float))
    field = np.random.default_rng(2).normal(size=(int(mask.sum()), 3))
    light = light_direction(azimuth, 30)
    turned = tuple(island.turned(turn_under_light(light, np.zeros(2))) for island in islands)
    assert all(island.turn == turned[0].turn for island in turned)
    assert (join_vectors(turned, [island.own_vectors(field) for island in turned]) == field).all()


@pytest.mark.parametrize("turn", TURNS[1:], ids=TURN_IDS[1:])
@pytest.mark.parametrize("drawn", ["one material", "several"])
def test_normals_turn_and_reflect_with_the_drawing(turn: Turn, drawn: str) -> None:
    light = light_direction(118, 41)
    if drawn == "several":
        image = load_image(drawing_path("sample:witch"))
    else:
        image = painted(ellipse(61, 43).normals, SOFT, light=light)
    other = ToonImage(turn.picture(image.color), turn.picture(image.mask), alpha=turn.picture(image.alpha))
    straight = toonkit.analyze(image, light)
    turned = toonkit.analyze(other, turn.vectors(light))
    expected = turn.vectors(turn.picture(straight.normals.vectors))
    apart = np.rad2deg(np.arccos(np.clip(np.einsum("hwc,hwc->hw", turned.normals.vectors, expected), -1, 1)))
    assert np.nanmean(apart) < 0.2

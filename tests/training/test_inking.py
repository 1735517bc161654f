"""Random ink: an outline, lines along contours and edges, marks; never more than an object can spare."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from tests.analytic import ellipse
from toonkit.estimation.working_square import SIZE
from toonkit.training import inking
from toonkit.training.inking import random_ink, remove_ink

SHAPE = ellipse(SIZE / 2 - 6, 36)
"""An ellipsoid in the middle of a picture somewhat smaller than the square."""
NORMALS = np.where(SHAPE.mask[..., None], SHAPE.normals.vectors, 0.0).astype(np.float32)
NONE = np.zeros_like(SHAPE.mask)


def inked(seed: int, contours: np.ndarray = NONE, normals: np.ndarray = NORMALS) -> np.ndarray:
    return random_ink(SHAPE.mask, contours, normals, np.random.default_rng(seed))


@pytest.fixture
def only(monkeypatch: pytest.MonkeyPatch):
    """Lines of one kind alone, besides the outline."""

    def chosen(kind: int) -> None:
        monkeypatch.setattr(inking, "LINES", tuple(1.0 if k == kind else 0.0 for k in range(3)))
        monkeypatch.setattr(inking, "KEPT", 1.0)

    return chosen


def test_every_drawing_has_an_outline_of_even_width(only) -> None:
    only(3)
    inward = distance_transform_edt(np.pad(SHAPE.mask, 1))[1:-1, 1:-1]
    widths = set()
    for seed in range(20):
        ink = inked(seed)
        widest = inward[ink].max()
        assert np.array_equal(ink, SHAPE.mask & (inward <= widest))
        widths.add(float(widest))
    assert min(widths) == 1.0
    assert 3.0 <= max(widths) < 4.0


def test_lines_run_along_the_contours(only) -> None:
    only(0)
    contours = NONE.copy()
    contours[20:50, 40] = True
    for seed in range(10):
        ink = inked(seed, contours)
        assert ink[contours].all()
        beside = np.abs(np.arange(ink.shape[1]) - 40) > 3
        assert not ink[25:45][:, beside & (np.abs(np.arange(ink.shape[1]) - 42) < 20)].any()


def test_lines_run_along_sharp_edges(only) -> None:
    only(1)
    roof = NORMALS.copy()
    side = np.where(np.arange(roof.shape[1]) < 45, -0.8, 0.8)
    roof[SHAPE.mask] = np.stack(np.broadcast_arrays(side, 0.0, 0.6), -1)[np.nonzero(SHAPE.mask)[1]]
    for seed in range(10):
        ink = inked(seed, normals=roof)
        assert ink[25:50, 44].all()
        assert not ink[25:50, 25:40].any()


def test_marks_follow_nothing(only) -> None:
    only(2)
    seen = np.mean([inked(seed)[15:55, 25:65] for seed in range(200)], axis=0)
    assert 0.01 < seen.mean() < 0.3
    assert (seen > 0).mean() > 0.5


def test_an_object_hardly_wider_than_its_lines_is_not_inked() -> None:
    sliver = np.zeros((SIZE, SIZE), bool)
    sliver[40:43, 5:90] = True
    normals = np.tile(np.float32([0, 0, 1]), (SIZE, SIZE, 1))
    nothing = np.zeros_like(sliver)
    for seed in range(10):
        ink = random_ink(sliver, nothing, normals, np.random.default_rng(seed))
        assert not ink.any()


def test_the_same_seed_draws_the_same_ink_and_others_do_not() -> None:
    assert np.array_equal(inked(3), inked(3))
    assert not np.array_equal(inked(3), inked(4))


def test_without_ink_all_paint_shows() -> None:
    tones = np.random.default_rng(0).random(SHAPE.mask.shape).astype(np.float32)
    assert remove_ink(tones, NONE, SHAPE.mask) is tones

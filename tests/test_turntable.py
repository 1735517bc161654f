"""Frames of an object that turns once around agree on its shape; those of other motions are left as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.turning_frames import analyzed_alone, change_at_points, error, measured, table
from tests.turning import LIGHT, turning
from toonkit import analyze_frames
from toonkit.frames.turntable import Views, find_turntable
from toonkit.frames.visual_hull import VisualHull, turned_vectors

ROOT = Path(__file__).parents[1]
AROUND = np.linspace(0, 2 * np.pi, 12, endpoint=False)


@pytest.fixture(scope="module")
def frames():
    return turning(12, 64)


def views_of(frames):
    """Return frames with their true materials and normals."""
    masks = np.array([np.isfinite(frame.points[..., 0]) for frame in frames])
    bases = np.array([frame.picture[..., 0] < 100 for frame in frames]) + 0
    normals = np.array([np.nan_to_num(frame.normals) for frame in frames])
    return Views(masks, np.where(masks, bases, -1), normals)


def test_the_hull_of_discs_is_a_ball():
    row, column = np.indices((64, 64)) - 31.5
    disc = row**2 + column**2 < 28**2
    hull = VisualHull.carved([disc] * 12, AROUND.tolist())
    depth = hull.depth(disc, 0.0)
    inner = row**2 + column**2 < 25**2
    true = np.sqrt(28**2 - row[inner] ** 2 - column[inner] ** 2)
    assert np.abs(depth[inner] - true).max() < 2.5  # pixels; between silhouettes it is flat
    outward = np.stack([column[inner], -row[inner], true], axis=-1) / 28
    found = hull.normals(disc, depth, 0.0)[inner[disc]]
    assert np.degrees(np.arccos(np.clip((found * outward).sum(axis=-1), -1, 1))).mean() < 7


def test_to_turn_by_a_quarter_brings_the_front_to_the_right():
    assert turned_vectors(np.pi / 2, np.array([[0.0, 0.0, 1.0]])).round(9).tolist() == [[1, 0, 0]]


@pytest.mark.parametrize("way", [1, -1])
def test_a_whole_turn_is_recognized_and_which_way_it_goes(frames, way):
    turntable = find_turntable(views_of(frames[::way]))
    assert turntable.angles[1] == pytest.approx(way * np.pi / 6)


def bouncing(count=12):
    row, column = np.indices((64, 64)) - 31.5
    stretch = [1 + 0.1 * np.sin(2 * np.pi * number / count) for number in range(count)]
    return np.array([(column * s) ** 2 + (row / s) ** 2 < 24**2 for s in stretch])


MOTIONS = {
    "part of a turn": lambda frames: views_of(turning(12, 64, step=10)),
    "out of order": lambda frames: views_of([frames[k] for k in (0, 5, 2, 9, 7, 1, 11, 3, 8, 4, 10, 6)]),
    "still": lambda frames: views_of([frames[1]] * 12),
    "too few to tell": lambda frames: views_of(frames[::3]),
    "bouncing": lambda _: Views(bouncing(), bouncing() - 1, np.zeros((12, 64, 64, 3))),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_another_motion_is_no_turn(frames, motion):
    assert find_turntable(MOTIONS[motion](frames)) is None


def test_normals_turn_with_the_object_from_frame_to_frame():
    frames = turning(12)
    pictures = [frame.picture for frame in frames]
    alone, together = analyzed_alone(pictures), analyze_frames(pictures, LIGHT).normals()
    assert change_at_points(frames, alone) > 6  # degrees
    assert change_at_points(frames, together) < 2
    assert error(frames, together) < 0.6 * error(frames, alone)


def test_a_row_compares_frames_that_agree_with_those_that_do_not():
    row = measured("duck", 45.0, 8, 32)
    assert row["true_change"] < row["change"] < row["change_alone"]
    assert row["error"] < row["error_alone"]


def test_frames_that_agree_are_relit_as_painted_under_their_own_light(frames):
    pictures = [frame.picture for frame in frames]
    for before, after in zip(pictures, analyze_frames(pictures, LIGHT).relight(LIGHT), strict=True):
        seen = before[..., 3] > 0
        assert np.array_equal(before[seen], after[seen])


def test_the_document_shows_the_changes_that_were_measured():
    rows = pd.read_csv(ROOT / "benchmarks" / "results" / "turning_frames.csv")
    document = (ROOT / "docs" / "exporting.md").read_text()
    assert table(rows.to_dict("records")) in document
    assert f"themselves change by {rows.true_change.mean():.1f}°" in document.replace("\n", " ")

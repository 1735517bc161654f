"""A command that is killed leaves whole files, and the next run removes what it left half done."""

from __future__ import annotations

import random
from pathlib import Path

import pandas as pd
import pytest

from benchmarks import kills
from benchmarks.kills import Findings

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("command", ["analyze", "export"])
def test_a_killed_command_leaves_whole_files_and_the_next_run_is_undisturbed(command, tmp_path):
    found = kills.measured(command, 1, random.Random(1), tmp_path)
    assert found.kills == 1
    assert (found.half, found.stray, found.different) == (0, 0, 0)


@pytest.fixture
def expected(tmp_path):
    """A picture and a report, as an undisturbed run writes them."""
    (tmp_path / "relit.png").write_bytes(b"picture")
    (tmp_path / "report.json").write_text('{"light": 1, "seconds": 2}')
    return kills.contents(tmp_path)


def test_half_a_file_and_what_is_left_over_are_found(expected, tmp_path):
    (tmp_path / "relit.png").write_bytes(b"pict")
    (tmp_path / "report.json").write_text('{"light": 1, "sec')
    (tmp_path / ".relit.png.tmp").touch()
    found = Findings("relight")
    kills.look(tmp_path, expected, found)
    assert (found.half, found.temporary, found.whole) == (2, 1, 0)


def test_times_are_no_difference_and_other_content_is(expected, tmp_path):
    (tmp_path / "report.json").write_text('{"light": 1, "seconds": 3}')
    found = Findings("relight")
    kills.compare(tmp_path, expected, found)
    assert found.different == 0
    (tmp_path / "report.json").write_text('{"light": 2, "seconds": 2}')
    (tmp_path / "relit.png").unlink()
    (tmp_path / ".relit.png.tmp").touch()
    kills.compare(tmp_path, expected, found)
    assert (found.different, found.stray) == (2, 1)


def test_the_report_of_files_that_are_being_replaced_is_whole(expected, tmp_path):
    (tmp_path / "report.json").write_text("{}")
    found = Findings("analyze")
    kills.look(tmp_path, expected, found)
    assert (found.half, found.whole) == (0, 2)


def test_the_text_says_what_was_measured():
    rows = pd.read_csv(ROOT / "benchmarks" / "results" / "kills.csv")
    text = " ".join((ROOT / "SECURITY.md").read_text().split())
    assert list(rows["command"]) == list(kills.COMMANDS)
    assert f"killed {rows['kills'].min()} times each" in text
    assert (rows[["half", "stray", "different"]] == 0).all(axis=None)

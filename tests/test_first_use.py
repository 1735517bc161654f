"""The first analysis on a machine: a second process compiles what the first one needs late."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.analytic import SOFT, ellipse, painted
from toonkit import analyze, light_direction
from toonkit.cli import main
from toonkit.methods import first_use
from toonkit.methods.first_use import LATE, share_compiling

COMPILE = "from toonkit.methods.first_use import compile_late; compile_late()"

ANALYSIS = """
import numpy as np, toonkit, toonkit.methods
from toonkit.methods.first_use import LATE
{prepared}
mask = np.hypot(*(np.mgrid[:96, :96] - 47.5)) < 44
color = np.where(np.mgrid[:96, :96][1][..., None] > 40, [0.9, 0.8, 0.6], [0.4, 0.2, 0.5])
image = toonkit.ToonImage(color, mask)
analysis = toonkit.analyze(image, toonkit.light_direction(30, 40))
toonkit.analyze(image, toonkit.light_direction(40, 40), previous=analysis)
print([(sum(loop.stats.cache_hits.values()), sum(loop.stats.cache_misses.values())) for loop in LATE])
"""

ALONE = ANALYSIS.format(prepared="toonkit.methods.share_compiling = lambda: None")
SHARED = ANALYSIS.format(prepared="toonkit.methods.first_use.cores = lambda: 2")

COMPILED = """
from toonkit.methods import first_use
print([first_use._is_compiled(loop) for loop in first_use.LATE])
"""


class Started:
    """What `Popen` was asked to start, and how often it was waited for."""

    def __init__(self) -> None:
        self.commands: list[list[str]] = []
        self.waited = 0

    def __call__(self, command: list[str], **_: object) -> Started:
        self.commands.append(command)
        return self

    def wait(self) -> int:
        self.waited += 1
        return 0


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Iterator[Started]:
    """A machine of two cores on which nothing is compiled, and nothing started."""
    started = Started()
    share_compiling.cache_clear()
    monkeypatch.setattr(first_use, "Popen", started)
    monkeypatch.setattr(first_use, "cores", lambda: 2)
    monkeypatch.setattr(first_use, "_is_compiled", lambda loop: False)
    monkeypatch.setattr(first_use, "_waiting", [])
    yield started
    share_compiling.cache_clear()


def said_by(program: str, cache: Path) -> str:
    """What a new process prints that keeps what it compiles in a folder of its own."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    run = [sys.executable, "-c", program]
    return subprocess.run(run, env=environment, check=True, capture_output=True, text=True).stdout.strip()


def test_analyses_find_compiled_what_the_second_process_compiled(tmp_path: Path) -> None:
    assert said_by(COMPILED, tmp_path) == str([False] * len(LATE))
    said_by(COMPILE, tmp_path)
    assert said_by(COMPILED, tmp_path) == str([True] * len(LATE))
    assert said_by(ALONE, tmp_path) == str([(1, 0)] * len(LATE))


def test_the_first_process_compiles_none_of_the_longest_loops(tmp_path: Path) -> None:
    _, *longest = ast.literal_eval(said_by(SHARED, tmp_path))  # the shortest one may be needed too early
    assert longest == [(1, 0)] * (len(LATE) - 1)  # found, not compiled


def test_the_first_analysis_starts_a_second_process_once(started: Started) -> None:
    shape = ellipse(12, 9)
    for _ in range(2):
        analyze(painted(shape.normals, SOFT), light_direction(118, 41), method="classical")
    ((program, option, command),) = started.commands
    assert (program, option) == (sys.executable, "-c")
    assert COMPILE in command
    assert started.waited == 1


def test_a_method_without_those_loops_starts_none(started: Started) -> None:
    analyze(painted(ellipse(12, 9).normals, SOFT), light_direction(118, 41), method="lumo")
    assert started.commands == []


def test_the_command_line_starts_it_before_it_reads_the_drawing(started: Started, tmp_path: Path) -> None:
    assert main(["analyze", "--quiet", str(tmp_path / "missing.png"), "-o", str(tmp_path)]) == 2
    assert len(started.commands) == 1


def test_it_finds_modules_where_this_process_does_and_nowhere_else(
    started: Started, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "numpy.py").write_text("raise SystemExit('a file beside the drawings')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place])
    share_compiling()
    ((*_, command),) = started.commands
    assert (
        said_by(command.replace(COMPILE, "import numpy; print('numpy itself')"), tmp_path) == "numpy itself"
    )


@pytest.mark.parametrize(
    ("where", "name", "value"),
    [
        (first_use, "_is_compiled", lambda loop: True),
        (first_use, "cores", lambda: 1),
        (first_use.multiprocessing, "parent_process", lambda: "the one that started this worker"),
        (first_use.sys, "executable", "/opt/painter/painter"),
        (first_use.sys, "executable", None),
    ],
)
def test_none_is_started_where_it_would_not_help(
    where: object, name: str, value: object, started: Started, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(where, name, value)
    share_compiling()
    assert started.commands == []


def test_where_none_can_be_started_the_analysis_goes_on(
    started: Started, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(command: list[str], **_: object) -> None:
        started(command)
        raise PermissionError

    monkeypatch.setattr(first_use, "Popen", refused)
    shape = ellipse(12, 9)
    analyze(painted(shape.normals, SOFT), light_direction(118, 41), method="classical")
    assert len(started.commands) == 1


def test_a_second_process_that_hangs_is_not_waited_for_for_ever(
    started: Started, monkeypatch: pytest.MonkeyPatch
) -> None:
    end = threading.Event()
    monkeypatch.setattr(started, "wait", end.wait)
    monkeypatch.setattr(first_use, "PATIENCE", 0.05)
    shape = ellipse(12, 9)
    analyze(painted(shape.normals, SOFT), light_direction(118, 41), method="classical")
    assert first_use._waiting == []
    end.set()


def test_where_numba_was_told_not_to_compile_there_is_nothing_to_do() -> None:
    assert first_use._is_compiled(lambda: None)

"""The first analysis on a machine: a second process compiles what the first one needs late."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from toonkit.methods import first_use
from toonkit.methods.first_use import COMMAND, LONGEST, share_compiling

ANALYSIS = """
import numpy as np, toonkit
from toonkit.methods import first_use
first_use.share_compiling = lambda: None
mask = np.hypot(*(np.mgrid[:96, :96] - 47.5)) < 44
color = np.where(np.mgrid[:96, :96][1][..., None] > 40, [0.9, 0.8, 0.6], [0.4, 0.2, 0.5])
toonkit.analyze(toonkit.ToonImage(color, mask), toonkit.light_direction(30, 40))
print([(sum(loop.stats.cache_hits.values()), sum(loop.stats.cache_misses.values())) for loop in first_use.LONGEST])
"""


class Started:
    """What `Popen` was asked to start."""

    def __init__(self) -> None:
        self.commands: list[list[str]] = []

    def __call__(self, command: list[str], **_: object) -> Started:
        self.commands.append(command)
        return self

    def wait(self) -> int:
        return 0


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Iterator[Started]:
    """A machine of two cores on which nothing is compiled, and nothing started."""
    started = Started()
    share_compiling.cache_clear()
    monkeypatch.setattr(first_use.subprocess, "Popen", started)
    monkeypatch.setattr(first_use.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(first_use, "_is_compiled", lambda loop: False)
    yield started
    share_compiling.cache_clear()


def test_an_analysis_finds_compiled_what_the_second_process_compiled(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", COMMAND], env=environment, check=True)
    run = [sys.executable, "-c", ANALYSIS]
    said = subprocess.run(run, env=environment, check=True, capture_output=True, text=True).stdout
    assert said.strip() == str([(1, 0)] * len(LONGEST))


def test_a_second_process_is_started_once(started: Started) -> None:
    share_compiling()
    share_compiling()
    assert started.commands == [[sys.executable, "-c", COMMAND]]


@pytest.mark.parametrize(
    ("where", "name", "value"),
    [
        (first_use, "_is_compiled", lambda loop: True),
        (first_use.os, "cpu_count", lambda: 1),
        (first_use.sys, "executable", "/opt/blender/blender"),
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
    def refused(*_: object, **__: object) -> None:
        raise PermissionError

    monkeypatch.setattr(first_use.subprocess, "Popen", refused)
    share_compiling()


def test_a_loop_is_compiled_once_its_index_is_on_file(tmp_path: Path) -> None:
    loop = SimpleNamespace(
        stats=SimpleNamespace(cache_path=str(tmp_path)),
        __module__="toonkit.numerics.unit_field_kernels",
        __name__="slope",
    )
    assert not first_use._is_compiled(loop)
    major, minor = sys.version_info[:2]
    (tmp_path / f"unit_field_kernels.slope-145.py{major}{minor}.nbi").touch()
    assert first_use._is_compiled(loop)
    assert first_use._is_compiled(lambda: None)  # numba was told not to compile

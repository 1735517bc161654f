"""toonkit works for a user who may write neither to the package nor to a cache of his own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

# Numba asks these classes for a folder in turn: the first takes the one that it is told, and has no other.
READ_ONLY = """
from numba.core import caching
caching.CacheImpl._locator_classes = caching.CacheImpl._locator_classes[:1]
"""

COMPILE = """
import os
from toonkit.relighting import detail_weight
detail_weight(0.5, 0.25)
print(os.environ.get("NUMBA_CACHE_DIR", ""), len(detail_weight.stats.cache_misses))
"""


def compiled(program: str, temporary: Path, **settings: str) -> tuple[str, int]:
    """The folder that a new process is told to cache in, and how many loops it compiles."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment |= {"TMPDIR": str(temporary), **settings}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    folder, misses = done.stdout.rstrip("\n").rsplit(" ", 1)
    return folder, int(misses)


def test_where_nothing_can_be_written_a_temporary_folder_lasts_as_long_as_the_process(tmp_path):
    folder, _ = compiled(READ_ONLY + COMPILE, tmp_path)
    assert Path(folder).parent == tmp_path
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_the_user_names_is_used(tmp_path):
    chosen = tmp_path / "chosen"
    first, second = (compiled(READ_ONLY + COMPILE, tmp_path, NUMBA_CACHE_DIR=str(chosen)) for _ in range(2))
    assert first == (str(chosen), 1)
    assert second == (str(chosen), 0)  # found there


def test_where_the_package_can_be_written_to_there_is_no_temporary_folder(tmp_path):
    assert compiled(COMPILE, tmp_path)[0] == ""


FULL = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
"""
NO_TEMPORARY = """
import tempfile
def fail(*_, **__): raise FileNotFoundError(2, "No usable temporary directory found")
tempfile.mkdtemp = fail
"""


def warned(program: str, **settings: str) -> str:
    """What a new process says on stderr; it must end well."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"} | settings
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    return done.stderr


def assert_one_line(said: str) -> None:
    assert said.startswith("toonkit compiles anew")
    assert said.count("\n") == 1


def test_without_any_folder_nothing_is_cached_and_one_line_says_so():
    assert_one_line(warned(READ_ONLY + NO_TEMPORARY + COMPILE))


def test_a_full_disk_is_told_in_one_line(tmp_path):
    assert_one_line(warned(FULL + COMPILE, NUMBA_CACHE_DIR=str(tmp_path)))


@pytest.mark.parametrize(
    ("suffix", "damage"),
    [(".nbi", lambda data: b"\xff" * len(data)), (".nbc", lambda data: data[: len(data) // 2])],
)
def test_damaged_files_are_told_in_one_line_and_replaced(suffix, damage, tmp_path):
    settings = {"NUMBA_CACHE_DIR": str(tmp_path)}
    assert warned(COMPILE, **settings) == ""
    damaged = [path for path in tmp_path.rglob("*") if path.suffix == suffix]
    assert damaged
    for path in damaged:
        path.write_bytes(damage(path.read_bytes()))
    assert_one_line(warned(COMPILE, **settings))
    assert warned(COMPILE, **settings) == ""

"""A file is written whole or not at all."""

import signal
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from toonkit import ToonkitError
from toonkit.export.atomic import atomic_write


def test_a_written_file_is_alone_in_its_folder(tmp_path):
    with atomic_write(tmp_path / "new") as file:
        file.write(b"content")
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
    assert (tmp_path / "new").read_bytes() == b"content"


def test_nothing_shows_under_the_name_before_all_is_written(tmp_path):
    with atomic_write(tmp_path / "new") as file:
        file.write(b"half")
        file.flush()
        assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path, failure):
    (tmp_path / "kept").write_bytes(b"old")

    def write_half():
        with atomic_write(tmp_path / "kept") as file:
            file.write(b"half of the new")
            raise failure

    with pytest.raises(failure):
        write_half()
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]
    assert (tmp_path / "kept").read_bytes() == b"old"


def test_a_full_disk_is_reported_and_leaves_the_old_file(tmp_path):
    (tmp_path / "kept").write_bytes(b"old")
    with (
        pytest.raises(ToonkitError, match=r"must be writable; got .*No space left"),
        atomic_write(tmp_path / "kept"),
    ):
        raise OSError(28, "No space left on device")
    assert (tmp_path / "kept").read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 1


def test_an_older_files_permissions_are_kept(tmp_path):
    path = tmp_path / "private"
    path.write_bytes(b"old")
    path.chmod(0o600)
    with atomic_write(path) as file:
        file.write(b"new")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_link_is_followed(tmp_path):
    (tmp_path / "target").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    with atomic_write(tmp_path / "link") as file:
        file.write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_bytes() == b"new"


@pytest.mark.parametrize(
    ("name", "reason"), [("", "must name a file"), ("nowhere/file", "must lie in an existing folder")]
)
def test_a_path_that_cannot_be_a_file_is_refused(tmp_path, name, reason):
    with pytest.raises(ToonkitError, match=f"path {reason}"), atomic_write(tmp_path / name):
        pass


KILLED = """
import os, signal, sys
from toonkit.export.atomic import atomic_write
with atomic_write(sys.argv[1]) as file:
    file.write(b"half")
    file.flush()
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def leftover(tmp_path):
    """The temporary file of a process that was killed while it wrote."""
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "killed")], check=False)
    assert done.returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    return left


def test_what_a_killed_process_left_is_removed_by_the_next_write_into_its_folder(leftover):
    with atomic_write(leftover.with_name("other")) as file:
        file.write(b"whole")
    assert [path.name for path in leftover.parent.iterdir()] == ["other"]


def test_what_is_being_written_is_no_leftover(tmp_path):
    with atomic_write(tmp_path / "slow") as slow:
        with atomic_write(tmp_path / "quick") as quick:
            quick.write(b"second")
        slow.write(b"first")
    assert (tmp_path / "slow").read_bytes() == b"first"
    assert (tmp_path / "quick").read_bytes() == b"second"


def test_files_and_folders_of_others_are_no_leftovers(leftover):
    others = {
        ".x.tmp",
        ".x.0123456789ab.tmp",
        "x.toonkit-0123456789ab.tmp",
        ".x.toonkit-0123456789ab.tmp.png",
    }
    for name in others:
        leftover.with_name(name).write_bytes(b"")
    folder = leftover.with_name(".x.toonkit-0123456789ab.tmp")
    folder.mkdir()
    with atomic_write(leftover.with_name("new")) as file:
        file.write(b"new")
    assert {path.name for path in leftover.parent.iterdir()} == {*others, folder.name, "new"}


def test_a_leftover_that_a_link_points_away_from_stays(leftover, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / leftover.name).symlink_to(leftover)
    with atomic_write(elsewhere / "new") as file:
        file.write(b"new")
    assert leftover.exists()


def test_many_writers_of_one_folder_lose_nothing(tmp_path):
    def write(number):
        with atomic_write(tmp_path / str(number)) as file:
            file.write(str(number).encode())

    with ThreadPoolExecutor(8) as threads:
        list(threads.map(write, range(200)))
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        str(n): str(n) for n in range(200)
    }


def test_a_name_as_long_as_the_system_allows_can_be_written(tmp_path):
    path = tmp_path / ("ü" * 125 + ".png")
    with atomic_write(path) as file:
        file.write(b"content")
    assert path.read_bytes() == b"content"

"""A file is written whole or not at all."""

import stat

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

"""Files by path or already open: names that start with a tilde, pipes, devices, and files without an end."""

import io
import os
import threading

import pytest

from toonkit import ToonkitError
from toonkit._validation import expand_home
from toonkit.model.file_bytes import read_bytes


def read(source, limit=100):
    return read_bytes("source", source, limit=limit, kind="a picture file")[0]


@pytest.mark.parametrize("name", ["~sketch.png", "~", "~nobody-of-this-name/sketch.png"])
def test_a_name_that_starts_with_a_tilde_is_a_name(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / name
    if name == "~":
        monkeypatch.setenv("HOME", str(path))
        assert expand_home(name) == path
    else:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"content")
        assert read(name) == b"content"


def test_a_tilde_before_a_slash_is_the_home_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "sketch.png").write_bytes(b"content")
    assert read("~/sketch.png") == b"content"


def test_a_pipe_is_refused_before_it_is_waited_for(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    said = []

    def attempt():
        with pytest.raises(ToonkitError, match=r"must be a picture file; got .*a pipe or a device") as raised:
            read(path)
        said.append(raised)

    thread = threading.Thread(target=attempt, daemon=True)
    thread.start()
    thread.join(timeout=10)
    assert said


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="there is no such device")
def test_a_device_is_refused_and_an_open_one_is_read_up_to_the_limit():
    with pytest.raises(ToonkitError, match="a pipe or a device"):
        read("/dev/zero")
    with open("/dev/zero", "rb") as file, pytest.raises(ToonkitError, match="at most 0 MiB; got /dev/zero"):
        read(file)


def test_a_file_over_the_limit_is_refused_by_its_size(tmp_path):
    path = tmp_path / "large.png"
    with path.open("wb") as file:
        file.truncate(2**40)  # takes no space
    with pytest.raises(ToonkitError, match=r"must have at most 1 MiB; got .* of 1048576 MiB"):
        read(path, limit=2**20)


def test_a_file_that_comes_in_pieces_is_read_to_its_end():
    rest = [b"abc", b"d", b"ef"]

    class Pieces(io.RawIOBase):
        def read(self, _size=-1):
            return rest.pop(0) if rest else b""

    assert read(Pieces()) == b"abcdef"

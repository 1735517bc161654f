"""The limits of an upload hold on the server, whatever the page in a browser sends."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from tests.viz.test_relight_state import run
from toonkit import ToonkitError
from toonkit.viz.relight_page import opening, upload
from toonkit.viz.relight_page.state import RelightState
from toonkit.viz.relight_page.upload import FileDropper


@pytest.fixture
def refusals(monkeypatch):
    """Files of ten bytes at most; what visitors are told."""
    told: list[str] = []
    monkeypatch.setattr(upload, "MOST_FILE_BYTES", 10)
    monkeypatch.setattr(opening, "MOST_FILE_BYTES", 10)
    monkeypatch.setattr(upload, "error_reporter", lambda _: lambda error: told.append(str(error)))
    return told


def send(dropper: FileDropper, *parts: bytes, name: str = "a.png") -> None:
    for chunk, data in enumerate(parts, start=1):
        sent = {"name": name, "chunk": chunk, "total_chunks": len(parts), "data": data, "type": "image/png"}
        dropper._process_event(SimpleNamespace(event_name="upload_event", data=sent))


def test_a_file_within_the_limit_arrives(refusals):
    dropper = FileDropper()
    send(dropper, b"12345", b"67890")
    assert dropper.value == {"a.png": b"1234567890"}
    assert refusals == []


def test_a_larger_file_is_refused_while_it_arrives_and_nothing_of_it_is_kept(refusals):
    dropper = FileDropper()
    send(dropper, b"12345", b"678901", b"2", b"3")
    assert dropper.value == {}
    assert dropper._file_buffer == {}
    assert len(refusals) == 1
    assert "must have at most" in refusals[0]


def test_files_that_never_end_do_not_pile_up(refusals):
    dropper = FileDropper()
    for number in range(5):
        sent = {"name": f"{number}", "chunk": 1, "total_chunks": 2, "data": b"12345678", "type": "image/png"}
        dropper._process_event(SimpleNamespace(event_name="upload_event", data=sent))
    assert list(dropper._file_buffer) == ["3", "4"]


def test_two_files_arrive_at_a_time(refusals):
    dropper = FileDropper()
    for chunk in (1, 2):
        for name in ("a.png", "b.png"):
            sent = {"name": name, "chunk": chunk, "total_chunks": 2, "data": name.encode(), "type": ""}
            dropper._process_event(SimpleNamespace(event_name="upload_event", data=sent))
    assert dropper.value == {"a.png": b"a.pnga.png", "b.png": b"b.pngb.png"}
    assert dropper.arrived == ("b.png", b"b.pngb.png")
    assert refusals == []


def test_a_file_that_arrives_again_is_told_of_again(refusals):
    dropper, told = FileDropper(), []
    dropper.param.watch(lambda event: told.append(event.new), "arrived", onlychanged=False)
    for _ in range(2):
        send(dropper, b"12345")
    assert told == [("a.png", b"12345")] * 2


def test_nothing_is_kept_of_who_has_left(refusals):
    dropper = FileDropper()
    send(dropper, b"12345")
    dropper.close()
    assert (dropper.value, dropper.arrived, dropper._file_buffer) == ({}, ("", b""), {})


def test_the_latest_files_are_kept_up_to_a_number_and_a_size(refusals, monkeypatch):
    monkeypatch.setattr(upload, "MOST_FILES", 3)
    monkeypatch.setattr(upload, "MOST_KEPT_BYTES", 25)
    dropper = FileDropper()
    for name in ("a", "b", "a", "c", "d"):
        send(dropper, b"12345", name=name)
    assert list(dropper.value) == ["a", "c", "d"]
    for name in ("e", "f"):
        send(dropper, b"1234567890", name=name)
    assert list(dropper.value) == ["d", "e", "f"]


def test_after_a_refusal_the_next_file_arrives(refusals):
    dropper = FileDropper()
    send(dropper, b"12345678901")
    send(dropper, b"12345", name="b.png")
    assert dropper.value == {"b.png": b"12345"}


@pytest.mark.parametrize("content", [bytes(11), "text"])
def test_what_is_too_large_or_no_file_is_not_opened(refusals, content):
    with pytest.raises(ToonkitError, match="source must"):
        run(RelightState().open_file("drawing.png", content))

"""Computations for visitors take turns, first come, first served, each for a limited time."""

from __future__ import annotations

import asyncio
import threading
import time
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import toonkit
from tests.viz.test_relight_state import run
from toonkit import ToonkitError
from toonkit.viz.relight_page import analyses
from toonkit.viz.relight_page.state import RelightState
from toonkit.viz.turns import Turns

PATIENCE_SECONDS = 60


def silent(step: str, fraction: float) -> None:
    pass


def drawings(count: int) -> list[bytes]:
    """Picture files of that many different discs."""
    y, x = np.mgrid[:24, :24] - 11.5
    files = []
    for red in range(count):
        file = BytesIO()
        pixels = np.zeros((24, 24, 4), np.uint8)
        pixels[np.hypot(x, y) < 10] = (80 + red, 90, 100, 255)
        pixels[np.hypot(x + 3, y + 3) < 5] = (200, 180, 160, 255)
        Image.fromarray(pixels).save(file, "PNG")
        files.append(file.getvalue())
    return files


class Waiter(threading.Thread):
    """Somebody who waits for a turn, and then notes a name."""

    def __init__(self, turns: Turns, name: str, served: list[str]) -> None:
        super().__init__()
        self.turns, self.name, self.served = turns, name, served
        self.waits = threading.Event()

    def run(self) -> None:
        with self.turns.turn(lambda *_: self.waits.set()):
            self.served.append(self.name)

    def join_the_line(self) -> None:
        self.start()
        assert self.waits.wait(PATIENCE_SECONDS)


def test_turns_are_taken_in_the_order_of_arrival() -> None:
    turns, served = Turns(), []
    waiters = [Waiter(turns, name, served) for name in "abcde"]
    with turns.turn(silent):
        for waiter in waiters:
            waiter.join_the_line()
        assert served == []
    for waiter in waiters:
        waiter.join(PATIENCE_SECONDS)
    assert served == list("abcde")


def test_who_no_longer_wants_to_leaves_the_line() -> None:
    turns, served = Turns(), []

    def gone(step: str, fraction: float) -> None:
        raise InterruptedError(step)

    with turns.turn(silent):
        patient = Waiter(turns, "patient", served)
        with pytest.raises(InterruptedError, match="waiting for another drawing"), turns.turn(gone):
            pass
        patient.join_the_line()
    patient.join(PATIENCE_SECONDS)
    assert served == ["patient"]


def test_more_than_may_wait_are_refused_and_told_so() -> None:
    turns, served = Turns(most_waiting=2), []
    waiters = [Waiter(turns, name, served) for name in "ab"]
    with turns.turn(silent):
        for waiter in waiters:
            waiter.join_the_line()
        with (
            pytest.raises(ToonkitError, match="2 other visitors are waiting"),
            turns.turn(silent),
        ):
            pass
    for waiter in waiters:
        waiter.join(PATIENCE_SECONDS)
    assert sorted(served) == ["a", "b"]
    with turns.turn(silent):
        pass


def test_a_turn_that_takes_too_long_ends_and_says_what_to_do() -> None:
    with Turns(most_seconds=0.05).turn(silent) as progress:
        progress("working", 0.1)
        time.sleep(0.06)
        with pytest.raises(ToonkitError, match="open a smaller one"):
            progress("working", 0.2)


def test_a_drawing_that_takes_too_long_leaves_the_other_one_on_screen(monkeypatch) -> None:
    first, second = drawings(2)
    state = RelightState(method="lumo")
    run(state.open_file("drawing.png", first))
    shown = state.analysis

    def endless(*_, progress, **__):
        while True:
            progress("working", 0.5)

    monkeypatch.setattr(toonkit, "analyze", endless)
    monkeypatch.setattr(analyses, "TURNS", Turns(most_seconds=0.05))
    with pytest.raises(ToonkitError, match="takes longer"):
        run(state.open_file("drawing.png", second))
    assert state.analysis is shown
    assert state.step == ""


def test_a_visitor_with_many_drawings_delays_another_by_one_at_most(monkeypatch) -> None:
    *many, other = drawings(6)
    started: list[RelightState] = []
    real = toonkit.analyze
    busy, late = RelightState(method="lumo"), RelightState(method="lambert")
    first_started = threading.Event()
    release = threading.Event()

    def noted(image, light=None, *, method, **others):
        started.append(busy if method == "lumo" else late)
        first_started.set()
        assert release.wait(PATIENCE_SECONDS)
        return real(image, light, method=method, **others)

    async def visit() -> None:
        async def open_many() -> None:
            for content in many:
                await busy.open_file("drawing.png", content)

        visits = asyncio.create_task(open_many())
        await asyncio.to_thread(first_started.wait, PATIENCE_SECONDS)
        later = asyncio.create_task(late.open_file("drawing.png", other))
        async with asyncio.timeout(PATIENCE_SECONDS):
            while late.step != "waiting for another drawing":
                await asyncio.sleep(0.01)
        release.set()
        await asyncio.gather(visits, later)

    monkeypatch.setattr(toonkit, "analyze", noted)
    monkeypatch.setattr(analyses, "TURNS", Turns())
    run(visit())
    assert started.index(late) == 1
    assert len(started) == 6

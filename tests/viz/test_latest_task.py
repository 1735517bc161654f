"""Tasks of a page: one at a time, ended by newer ones, with progress, and to be canceled."""

from __future__ import annotations

import asyncio
import threading

import pytest

from tests.viz.test_relight_state import run
from toonkit.viz import latest_task
from toonkit.viz.latest_task import LatestTask

PATIENCE_SECONDS = 60


@pytest.fixture
def shown(monkeypatch):
    """All that is shown of a task; every report is."""
    monkeypatch.setattr(latest_task, "REPORT_SECONDS", -1.0)
    return []


@pytest.fixture
def task(shown):
    return LatestTask(lambda step, fraction: shown.append((step, fraction)))


def endless(report):
    while True:
        report("working", 0.5)


async def begun(shown):
    async with asyncio.timeout(PATIENCE_SECONDS):
        while ("working", 0.5) not in shown:
            await asyncio.sleep(0.01)


def test_a_task_tells_how_far_it_is_and_returns_what_it_made(task, shown):
    def work(report):
        report("half", 0.5)
        report("too much", 7.0)
        return "made"

    assert run(task.run("first", work)) == "made"
    assert shown[0] == ("first", 0.0)
    assert shown[-1] == ("", 0.0)


def test_reports_are_shown_while_the_task_runs_with_fractions_from_0_to_1(task, shown):
    seen = threading.Event()

    def work(report):
        report("too much", 7.0)
        report.put(seen.set)
        assert seen.wait(PATIENCE_SECONDS)

    run(task.run("first", work))
    assert ("too much", 1.0) in shown


def test_a_canceled_task_is_given_up(task, shown):
    given_up = []

    async def cancel():
        running = asyncio.create_task(task.run("first", endless, give_up=lambda: given_up.append("first")))
        await begun(shown)
        task.cancel()
        return await running

    assert run(cancel()) is None
    assert given_up == ["first"]
    assert shown[-1] == ("", 0.0)


def test_a_newer_task_ends_an_older_one_which_is_not_given_up(task, shown):
    async def overtake():
        older = asyncio.create_task(task.run("first", endless, give_up=lambda: pytest.fail("given up")))
        await begun(shown)
        newer = await task.run("second", lambda _: "newer")
        return await older, newer

    assert run(overtake()) == (None, "newer")


def test_a_task_that_is_overtaken_before_it_begins_never_runs(task, shown):
    async def hurry():
        first = asyncio.create_task(task.run("first", endless))
        await begun(shown)
        second = asyncio.create_task(task.run("second", lambda _: pytest.fail("was run")))
        await asyncio.sleep(0)
        third = await task.run("third", lambda _: "third")
        return await first, await second, third

    assert run(hurry()) == (None, None, "third")


def test_a_task_that_is_canceled_before_it_begins_is_given_up(task, shown):
    given_up = []

    async def cancel():
        first = asyncio.create_task(task.run("first", endless))
        await begun(shown)
        second = asyncio.create_task(
            task.run("second", lambda _: pytest.fail("was run"), give_up=lambda: given_up.append("second"))
        )
        await asyncio.sleep(0)
        task.cancel()
        return await first, await second

    assert run(cancel()) == (None, None)
    assert given_up == ["second"]


def test_a_task_that_fails_is_given_up_and_the_next_one_runs(task, shown):
    given_up = []
    with pytest.raises(ZeroDivisionError):
        run(task.run("first", lambda _: 1 / 0, give_up=lambda: given_up.append("first")))
    assert given_up == ["first"]
    assert shown[-1] == ("", 0.0)
    assert run(task.run("second", lambda _: "made")) == "made"


def test_what_is_overtaken_by_nothing_shows_no_more_and_is_not_given_up(task, shown):
    changes = []

    def work(report):
        while True:
            report.put(lambda: changes.append(1))
            report("working", 0.5)

    async def leave():
        running = asyncio.create_task(task.run("first", work, give_up=lambda: pytest.fail("given up")))
        await begun(shown)
        task.overtake()
        seen = len(changes)
        await running
        return len(changes) - seen

    assert run(leave()) == 0

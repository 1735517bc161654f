"""LatestTask: work in a thread that a newer wish ends, that tells how far it is, and that can be canceled.

A page asks for one thing at a time: whoever wishes for something else does not want to wait for what they wished for before.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor
from typing import TypeVar

REPORT_SECONDS = 0.08
"""Pause between two reports of progress: faster ones only fill the connection."""

Result = TypeVar("Result")


class CancelledError(Exception):
    """Raised inside a task to end it."""


class TaskReport:
    """
    Receives the progress of a task in its thread. Called with a step and the fraction done, it ends a canceled task.

    Parameters
    ----------
    ended : threading.Event
        Set once the task is to end.
    tell : callable, (callable) -> None
        Does something in the event loop of the page, if the task is then still the latest one.
    show : callable, (str, float) -> None
        Shows a step and the fraction done.
    """

    def __init__(
        self,
        ended: threading.Event,
        tell: Callable[[Callable[[], None]], None],
        show: Callable[[str, float], None],
    ) -> None:
        self._ended, self._tell, self._show = ended, tell, show
        self._shown_at = 0.0

    def __call__(self, step: str, fraction: float) -> None:
        """Show what is being done and how much of it is; raises CancelledError if nobody waits for it any more."""
        if self._ended.is_set():
            raise CancelledError
        now = time.monotonic()
        if now - self._shown_at > REPORT_SECONDS:
            self._shown_at = now
            share = min(max(float(fraction), 0.0), 1.0)
            self._tell(lambda: self._show(step, share))

    def put(self, change: Callable[[], None]) -> None:
        """Make a change in the event loop, such as to show a part of the result, as long as the task is the latest one."""
        self._tell(change)


class LatestTask:
    """
    The place where a page's tasks run, one at a time: a newer one ends an older one, and begins when that has ended.

    Parameters
    ----------
    show : callable, (str, float) -> None
        Called in the event loop with the step and the fraction done, and with "" and 0.0 once nothing is done.

    Examples
    --------
    >>> task = LatestTask(lambda step, fraction: None)
    >>> asyncio.run(task.run("adding", lambda report: 1 + 1))  # doctest: +SKIP
    2
    """

    def __init__(self, show: Callable[[str, float], None]) -> None:
        self._show = show
        self._ended = threading.Event()  # of the latest task
        self._turn = asyncio.Lock()
        self._running = False

    async def run(
        self,
        step: str,
        task: Callable[[TaskReport], Result],
        *,
        threads: Executor | None = None,
        give_up: Callable[[], None] = lambda: None,
    ) -> Result | None:
        """
        Run a task in a thread.

        Parameters
        ----------
        step : str
            What is shown until the task reports something else.
        task : callable, (TaskReport) -> Result
            Runs in the thread.
        threads : Executor, optional
            Where threads are from: a task that waits keeps none from those that do not. Those of the event loop by default.
        give_up : callable, optional
            Called if the task fails or is canceled while it is the latest one.

        Returns
        -------
        Result or None
            None if the task was canceled or overtaken. What it raises is raised here.
        """
        self._ended.set()
        ended = self._ended = threading.Event()
        async with self._turn:
            result = None
            if not ended.is_set():
                try:
                    self._running = True
                    self._show(step, 0.0)
                    report = self._report(ended)
                    result = await asyncio.get_running_loop().run_in_executor(threads, task, report)
                except CancelledError:
                    pass
                except BaseException:
                    if ended is self._ended:
                        give_up()
                    raise
                finally:
                    self._running = False
                    self._show("", 0.0)
            if not ended.is_set():
                return result
            if ended is self._ended:
                give_up()
            return None

    def cancel(self) -> None:
        """End the task under way, if there is one."""
        self._ended.set()

    def overtake(self) -> None:
        """End the task under way as if a newer one had begun: nothing of it is shown or given up."""
        self._ended.set()
        self._ended = threading.Event()

    def _report(self, ended: threading.Event) -> TaskReport:
        loop = asyncio.get_running_loop()

        def change(make: Callable[[], None]) -> None:
            # It may arrive after the task has ended, or after another one has begun.
            if self._running and ended is self._ended:
                make()

        def tell(make: Callable[[], None]) -> None:
            loop.call_soon_threadsafe(change, make)

        return TaskReport(ended, tell, self._show)

"""Whose drawing is computed next: one at a time, first come, first served, and none for longer than a limit.

A computation uses every core, and numba's threads do not share. A session waits for one thing at most and joins the end
of the line for the next one, so whoever opens one drawing after another delays each other visitor by one drawing only.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

from toonkit._validation import ToonkitError

MOST_WAITING = 20
"""Sessions that may wait; more would wait longer than anyone looks at a page."""

MOST_SECONDS = 120.0
"""Time that one computation may take: several times that of the largest object on two cores."""

LOOK_SECONDS = 0.08
"""Pause after which whoever waits looks whether they still want to."""

Progress = Callable[[str, float], None]


class Turns:
    """
    The line of those who want to compute, and threads for them to wait in.

    Parameters
    ----------
    most_waiting : int
        How many may wait besides the one whose turn it is.
    most_seconds : float
        Time that one turn may take.
    """

    def __init__(self, most_waiting: int = MOST_WAITING, most_seconds: float = MOST_SECONDS) -> None:
        self.most_waiting = most_waiting
        self.most_seconds = most_seconds
        # One more than have a place: to be refused takes a thread as well.
        self.threads = ThreadPoolExecutor(most_waiting + 2, thread_name_prefix="turn")
        self._line: list[object] = []
        self._moved = threading.Condition()

    @contextmanager
    def turn(self, progress: Progress) -> Iterator[Progress]:
        """
        Wait for a turn, which ends with the block.

        Parameters
        ----------
        progress : callable
            Told that others come first; what it raises ends the wait.

        Yields
        ------
        callable
            The progress callback to compute with: it ends a computation that takes too long.

        Raises
        ------
        ToonkitError
            If too many wait already, or, from the callback, if the turn has taken too long.
        """
        place = object()
        with self._moved:
            if len(self._line) > self.most_waiting:
                raise ToonkitError(
                    f"{self.most_waiting} other visitors are waiting for this server; try again in a few minutes"
                )
            self._line.append(place)
        try:
            with self._moved:
                while self._line[0] is not place:
                    progress("waiting for another drawing", 0.0)
                    self._moved.wait(LOOK_SECONDS)
            yield self._limited(progress)
        finally:
            with self._moved:
                self._line.remove(place)
                self._moved.notify_all()

    def _limited(self, progress: Progress) -> Progress:
        end = time.monotonic() + self.most_seconds

        def report(step: str, fraction: float) -> None:
            if time.monotonic() > end:
                raise ToonkitError(
                    f"this drawing takes longer than the {self.most_seconds:.0f} s that a page gives it; "
                    "open a smaller one, or use `toonkit analyze`"
                )
            progress(step, fraction)

        return report


TURNS = Turns()
"""The one line of this process, for all pages that it serves."""

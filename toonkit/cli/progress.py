"""Progress bars on stderr, where that is a terminal."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toonkit.study.runner import StudyProgress

_BAR = "{desc:<24.24}|{bar}| {percentage:3.0f}% {elapsed}"
_LOG_SECONDS = 30.0  # between two lines of a bar that goes into a file


def show_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning as one line on stderr, above a progress bar if there is one."""
    from tqdm import tqdm  # noqa: PLC0415

    tqdm.write(f"toonkit: warning: {' '.join(str(message).split())}", file=sys.stderr)


class StepBar:
    """Callback that moves a bar on stderr, if that is a terminal, and keeps the time of each step."""

    def __init__(self, *, visible: bool) -> None:
        from tqdm import tqdm  # noqa: PLC0415

        self._bar = tqdm(
            total=1.0, bar_format=_BAR, file=sys.stderr, leave=False, disable=None if visible else True
        )
        self._steps: list[tuple[str, float]] = []

    def __enter__(self) -> StepBar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def __call__(self, step: str, fraction: float) -> None:
        """Show the step that runs, and the fraction of the whole done."""
        self._bar.update(min(max(fraction, 0.0), 1.0) - self._bar.n)
        if not self._steps or self._steps[-1][0] != step:
            self._steps.append((step, time.perf_counter()))
            self._bar.set_description_str(step)

    def seconds(self) -> dict[str, float]:
        """Return the seconds spent in each step so far; a step entered twice counts once, with both times."""
        ends = [start for _, start in self._steps[1:]] + [time.perf_counter()]
        spent: dict[str, float] = {}
        for (step, start), end in zip(self._steps, ends, strict=True):
            spent[step] = round(spent.get(step, 0.0) + end - start, 4)
        return spent


class TrialBar:
    """Callback that counts a study's trials, with the time left; in a log it is a line now and then."""

    def __init__(self, *, visible: bool) -> None:
        self._visible = visible
        self._bar: Any = None
        self._failed = 0

    def __enter__(self) -> TrialBar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def __call__(self, progress: StudyProgress) -> None:
        """Count a trial."""
        if self._bar is None:
            self._start(progress)
        elif progress.record is not None:
            self._failed += bool(progress.record.error)
            failed = f", {self._failed} failed" if self._failed else ""
            now = f"{progress.record.shape} {progress.record.color_map}{failed}"
            self._bar.set_postfix_str(now, refresh=False)
            self._bar.update()

    def _start(self, progress: StudyProgress) -> None:
        self._bar = _counting_bar(progress.total, progress.done, "trial", visible=self._visible)


class DrawingBar:
    """Count the drawings of a batch, with the time left; in a log it is a line now and then."""

    def __init__(self, total: int, done: int, *, visible: bool) -> None:
        self._bar = _counting_bar(total, done, "drawing", visible=visible)

    def __enter__(self) -> DrawingBar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def count(self, name: str, *, failed: int) -> None:
        """Count a drawing; `failed` says how many have failed so far."""
        self._bar.set_postfix_str(f"{name}, {failed} failed" if failed else name, refresh=False)
        self._bar.update()


def _counting_bar(total: int, done: int, unit: str, *, visible: bool) -> Any:
    from tqdm import tqdm  # noqa: PLC0415

    return tqdm(
        total=total,
        initial=done,
        unit=unit,
        smoothing=0.0,  # what is counted differs much: the mean over all says best when it will be done
        mininterval=0.2 if sys.stderr.isatty() else _LOG_SECONDS,
        disable=not visible,
        file=sys.stderr,
    )

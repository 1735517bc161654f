"""A line that shows the progress of a background task, with a button that cancels it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import panel as pn
import panel_material_ui as pmui

from toonkit.viz.latest_task import LatestTask, TaskReport
from toonkit.viz.page_style import WIDE, Insistence, note
from toonkit.viz.turns import TURNS

Result = TypeVar("Result")


class BusyLine(pn.viewable.Viewer):
    """
    The progress of a task that runs beside the page's own; hidden while there is none.

    Examples
    --------
    >>> busy = BusyLine()  # doctest: +SKIP
    >>> await busy.run("painting", lambda report: paint(report))  # doctest: +SKIP
    """

    def __init__(self, **params: Any) -> None:
        super().__init__(**params)
        self._task = LatestTask(self._show)
        self._words = note("", margin=(6, 0))
        self._bar = pmui.LinearProgress(value=0, variant="determinate", margin=(0, 0, 6, 0), **WIDE)
        cancel = pmui.Button(label="Cancel", variant="outlined", size="small", margin=(2, 0), width=80)
        cancel.on_click(lambda _: self._task.cancel())
        self._line = pn.Column(
            pn.FlexBox(self._words, cancel, justify_content="space-between", align_items="center"),
            self._bar,
            visible=False,
            **WIDE,
        )

        self._insist = Insistence(self._line)

    async def run(self, step: str, task: Callable[[TaskReport], Result]) -> Result | None:
        """Run a task in a thread that may wait for its turn: see `LatestTask.run`."""
        try:
            return await self._task.run(step, task, threads=TURNS.threads)
        finally:
            self._insist()

    def cancel(self) -> None:
        """Cancel the task under way, if there is one."""
        self._task.cancel()

    def close(self) -> None:
        """End the task as if a newer one had begun: the visitor has left."""
        self._task.overtake()
        self._insist.end()

    def _show(self, step: str, fraction: float) -> None:
        if step:
            self._words.object = step[0].upper() + step[1:]
        self._bar.value = round(100 * fraction)
        self._line.visible = bool(step)

    def __panel__(self) -> pn.viewable.Viewable:
        return self._line

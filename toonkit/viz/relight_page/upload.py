"""FileDropper: a drop zone for several files, whose limits hold on the server as well, whatever a page sends."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any, ClassVar

import panel as pn
import param

from toonkit._validation import refuse
from toonkit.viz.page_style import error_reporter
from toonkit.viz.relight_page.opening import MOST_FILE_BYTES

MOST_UNDER_WAY = 2
"""Files that a page sends at a time."""

MOST_FILES = 8
"""Files that are kept for going back to them: the latest ones."""

MOST_KEPT_BYTES = 2 * MOST_FILE_BYTES
"""How large they may be together."""


class FileDropper(pn.widgets.FileDropper):
    """A place to drop files of at most `MOST_FILE_BYTES`; parts of a larger one are not kept as they arrive."""

    arrived = param.Tuple(("", b""), doc="Name and content of the file that has arrived last.")

    _rename: ClassVar[dict[str, str | None]] = {"arrived": None}

    def __init__(self, **params: Any) -> None:
        super().__init__(max_file_size=f"{MOST_FILE_BYTES // 10**6}MB", multiple=True, **params)
        self._received: OrderedDict[str, int] = OrderedDict()

    def _process_event(self, event: Any) -> None:
        if event.event_name != "upload_event":
            super()._process_event(event)
            return
        name, part = event.data["name"], event.data["data"]
        if event.data["chunk"] == 1:
            self._begin(name)
        if name not in self._received:  # the rest of a refused one
            return
        self._received[name] += len(part)
        if self._received[name] > MOST_FILE_BYTES:
            self._forget(name)
            rule = f"must have at most {MOST_FILE_BYTES // 10**6} MB"
            error_reporter("relight page")(refuse("the file", rule, "more"))
            return
        last = event.data["chunk"] == event.data["total_chunks"]
        if last:
            self._forget(name, parts=False)
            self.value.pop(name, None)  # so that it comes last
        super()._process_event(event)
        if last:
            self._let_go_of_the_oldest()
            with param.parameterized.discard_events(self):
                self.arrived = name, self.value[name]
            self.param.trigger("arrived")  # also of a file that arrives again

    def _begin(self, name: str) -> None:
        self._forget(name)
        while len(self._received) >= MOST_UNDER_WAY:
            self._forget(next(iter(self._received)))
        self._received[name] = 0

    def _forget(self, name: str, *, parts: bool = True) -> None:
        self._received.pop(name, None)
        if parts:
            self._file_buffer.pop(name, None)

    def let_go(self, name: str) -> None:
        """Keep a file no longer."""
        self.value.pop(name, None)
        self.mime_type.pop(name, None)
        self.param.trigger("value")

    def close(self) -> None:
        """Keep nothing: the visitor has left."""
        self._received.clear()
        self._file_buffer.clear()
        with param.parameterized.discard_events(self):
            self.param.update(value={}, mime_type={}, arrived=("", b""))

    def _let_go_of_the_oldest(self) -> None:
        """Keep as many files as may be kept."""
        while len(self.value) > MOST_FILES or sum(map(len, self.value.values())) > MOST_KEPT_BYTES:
            self.let_go(next(iter(self.value)))

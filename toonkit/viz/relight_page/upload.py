"""PictureDropper: a drop zone whose limits hold on the server as well, whatever a page in a browser sends."""

from __future__ import annotations

from typing import Any

import panel as pn

from toonkit._validation import refuse
from toonkit.viz.page_style import error_reporter
from toonkit.viz.relight_page.opening import MOST_FILE_BYTES


class PictureDropper(pn.widgets.FileDropper):
    """A place to drop one picture file of at most `MOST_FILE_BYTES`; parts of a larger one are not kept as they arrive."""

    def __init__(self, **params: Any) -> None:
        super().__init__(max_file_size=f"{MOST_FILE_BYTES // 10**6}MB", multiple=False, **params)
        self._received: dict[str, int] = {}

    def _process_event(self, event: Any) -> None:
        if event.event_name == "upload_event":
            name, part = event.data["name"], event.data["data"]
            if event.data["chunk"] == 1:
                self._received = {name: 0}  # one file at a time
                self._file_buffer.clear()
            if name not in self._received:  # the rest of a refused one
                return
            self._received[name] += len(part)
            if self._received[name] > MOST_FILE_BYTES:
                del self._received[name]
                self._file_buffer.clear()
                rule = f"must have at most {MOST_FILE_BYTES // 10**6} MB"
                error_reporter("relight page")(refuse("the picture file", rule, "more"))
                return
        super()._process_event(event)

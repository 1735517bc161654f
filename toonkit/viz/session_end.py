"""Let go of a dashboard's page once its visitor has left.

Panel keeps references to the pages of ended sessions: a watcher on its process-wide `state.busy`, and entries of
`state._views` for roots beside the page. Each holds the whole page, with all that its callbacks know.
"""

from __future__ import annotations

import asyncio
import ctypes
import gc
from collections.abc import Callable
from typing import Any

import panel as pn
import panel_material_ui as pmui

COLLECT_SECONDS = (2.0, 12.0)
"""Pauses before memory is collected: once Bokeh has let go of the session, and once Panel has, which waits for a while."""


def free_when_left(page: pmui.Page, *closing: Callable[[], None]) -> None:
    """
    Free what a page holds when its session ends: some half a minute after the browser has left.

    Parameters
    ----------
    page : panel_material_ui.Page
        The page of one visitor.
    *closing : callable
        End what is under way for it, and drop what is large: something of the first page of a process stays.
    """

    def left(context: Any) -> None:
        for close in closing:
            close()
        _forget(page)
        document = context._document
        for reference, (_, _, owner, _) in list(pn.state._views.items()):
            if owner is document:
                del pn.state._views[reference]
        for seconds in COLLECT_SECONDS:
            asyncio.get_running_loop().call_later(seconds, _collect)

    pn.state.on_session_destroyed(left)


def _forget(page: pmui.Page) -> None:
    """Remove the watchers by which Panel's process-wide state knows a page."""
    for kinds in list(pn.state.param.watchers.values()):
        for watcher in [watcher for watchers in kinds.values() for watcher in watchers]:
            if getattr(getattr(watcher.fn, "__self__", None), "self", None) is page:
                pn.state.param.unwatch(watcher)


def _collect() -> None:
    """Collect garbage, and hand what glibc keeps of it back to the system."""
    gc.collect()
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (OSError, AttributeError, TypeError):  # not glibc
        return
    trim(0)

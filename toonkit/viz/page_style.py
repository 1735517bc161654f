"""What every dashboard looks like, how it tells what went wrong, and how what it shows arrives."""

from __future__ import annotations

import asyncio
import logging
import re
from collections.abc import Callable, Iterable
from typing import Any

import panel as pn
import panel_material_ui as pmui

from toonkit._validation import ToonkitError

ACCENT = "#e07a1f"
WIDE: dict[str, Any] = {"sizing_mode": "stretch_width"}
NOTIFICATION_MILLISECONDS = 9000

UNSENT_SECONDS = 0.3, 1.5, 5.0
"""Panel 1.9 can leave an update unsent that was made while another one was on its way, until the next one: after these
pauses some follow that change nothing on screen. The later ones are for large updates on a busy machine."""

_BAR = {"backgroundColor": "#17181b", "color": "#f4f2ee", "boxShadow": "none"}
THEME: dict[str, Any] = {
    "palette": {"primary": {"main": ACCENT}},
    "components": {"MuiAppBar": {"styleOverrides": {"root": _BAR}}},
}


def error_reporter(page: str) -> Callable[[Exception], None]:
    """Return a handler that tells the user of an error and leaves what is on screen; what is no refusal is logged too."""

    def report(error: Exception) -> None:
        if not isinstance(error, ToonkitError):
            logging.getLogger("toonkit.dashboards").error("%s", page, exc_info=error)
        if pn.state.notifications is not None:
            text = str(error) or type(error).__name__
            pn.state.notifications.error(text, duration=NOTIFICATION_MILLISECONDS)

    return report


def tell_remarks(remarks: Iterable[str]) -> None:
    """Tell the user what of their file is ignored or only assumed."""
    if pn.state.notifications is not None:
        for remark in remarks:
            text = f"This file: {remark.removeprefix('source: ')}"
            pn.state.notifications.warning(text, duration=NOTIFICATION_MILLISECONDS)


def plain(text: str) -> str:
    """Return Markdown that shows a text as it is: names from files must not become HTML."""
    return re.sub(r"([!-/:-@\[-`{-~])", r"\\\1", text)


def heading(text: str) -> pmui.Typography:
    """Return the title of a part of the sidebar."""
    return pmui.Typography(text, variant="overline", margin=(8, 12, 0, 12))


def note(text: str, **params: Any) -> pmui.Typography:
    """Return a line of advice beside what it is about."""
    usual = {"variant": "body2", "color": "text.secondary", "margin": (8, 10, 4, 10)}
    return pmui.Typography(text, **{**usual, **params})


async def after_updates(follow: Callable[[], object]) -> None:
    """Send updates that change nothing on screen after one that must arrive."""
    for pause in UNSENT_SECONDS:
        await asyncio.sleep(pause)
        follow()


class Insistence:
    """
    Ensures that updates arrive, by `after_updates`; a new call starts over.

    Parameters
    ----------
    component : Viewable
        A component of the page, whose tags it changes: this is not visible.
    """

    def __init__(self, component: pn.viewable.Viewable) -> None:
        self._component, self._count = component, 0
        self._following: asyncio.Future[None] | None = None

    def __call__(self) -> None:
        """Follow the updates that were made just now."""
        self.end()
        self._following = asyncio.ensure_future(after_updates(self._tag))

    def end(self) -> None:
        """Stop following."""
        if self._following is not None:
            self._following.cancel()

    def _tag(self) -> None:
        self._count += 1
        self._component.tags = [self._count]

"""CopyButtons: buttons that put on the clipboard what Python answers, and show it in a box."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import panel as pn
import param
from panel.models.esm import DataEvent

from toonkit.viz.page_style import after_updates


class CopyButtons(pn.custom.JSComponent):
    """
    A button for each text that can be copied; a text is made when its button is pressed.

    Parameters
    ----------
    texts : mapping of str to callable
        What each button says, and what returns the text to copy and a sentence about it.

    Examples
    --------
    >>> CopyButtons({"Copy the answer": lambda: ("42", "It is the answer.")})  # doctest: +SKIP
    """

    choices = param.List([], doc="Number and label of each button.")
    answered = param.Integer(0, doc="Grows after each answer, which must arrive: see `after_updates`.")
    disabled = param.Boolean(False, doc="Whether there is nothing to copy.")

    _esm = Path(__file__).with_name("copy_buttons.js")

    def __init__(self, texts: Mapping[str, Callable[[], tuple[str, str]]], **params: Any) -> None:
        super().__init__(choices=list(enumerate(texts)), **params)

        async def pressed(message: DataEvent) -> None:
            label = list(texts)[message.data["action"]]
            text, note = texts[label]()
            self._send_msg({"text": text, "note": note, "label": label})
            await after_updates(lambda: self.param.update(answered=self.answered + 1))

        self.on_msg(pressed)

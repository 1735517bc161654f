"""Cards to choose one from: thumbnails of pictures, or titles with a line of text."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

import panel as pn
import param
from PIL import Image

THUMBNAIL_PIXELS = 144
"""Twice the width on screen, for sharp displays."""


class ChoiceCards(pn.custom.JSComponent):
    """
    A radio group whose options are cards.

    Examples
    --------
    >>> ChoiceCards(choices=[{"value": "a", "title": "A", "text": "the first"}], value="a")  # doctest: +SKIP
    """

    choices = param.List([], item_type=dict, doc="Cards: value, title, and text or picture (a data address).")
    value = param.String("", doc='Value of the chosen card; "" for none.')
    columns = param.Integer(1, bounds=(1, None), doc="Cards side by side.")
    label = param.String("", doc="What is being chosen, for screen readers.")

    _esm = Path(__file__).with_name("choice_cards.js")


def text_choices(descriptions: Mapping[str, tuple[str, str]]) -> list[dict[str, str]]:
    """Return cards for values described by a title and a line of text."""
    return [{"value": value, "title": title, "text": text} for value, (title, text) in descriptions.items()]


def picture_choices(pictures: Mapping[str, tuple[str, Path]]) -> list[dict[str, str]]:
    """Return cards for values with a title and a picture file."""
    return [
        {"value": value, "title": title, "picture": _thumbnail(path)}
        for value, (title, path) in pictures.items()
    ]


def _thumbnail(path: Path) -> str:
    with Image.open(path) as image:
        small = image.convert("RGBA")
    small.thumbnail((THUMBNAIL_PIXELS, THUMBNAIL_PIXELS))
    buffer = BytesIO()
    small.save(buffer, "WEBP", quality=80)
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()

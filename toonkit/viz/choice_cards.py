"""Cards to choose one from: thumbnails of pictures, or titles with a line of text."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

import numpy as np
import panel as pn
import param
from PIL import Image

from toonkit.model.color_map import ColorMap

THUMBNAIL_PIXELS = 144
"""Twice the width on screen, for sharp displays."""

RAMP_PIXELS = 256
"""Length of the picture of a ramp."""


class ChoiceCards(pn.custom.JSComponent):
    """
    A radio group whose options are cards.

    Examples
    --------
    >>> ChoiceCards(choices=[{"value": "a", "title": "A", "text": "the first"}], value="a")  # doctest: +SKIP
    """

    choices = param.List([], item_type=dict, doc="Cards: value, title, and text, picture or both.")
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


def ramp_choices(ramps: Mapping[str, tuple[str, str, ColorMap]]) -> list[dict[str, str]]:
    """Return cards for values with a title, a word of text, and a color map, shown over all illuminations."""
    return [
        {"value": value, "title": title, "text": text, "picture": _ramp(color_map)}
        for value, (title, text, color_map) in ramps.items()
    ]


def _ramp(color_map: ColorMap) -> str:
    colors = color_map(np.linspace(-1.0, 1.0, RAMP_PIXELS))[None]
    return _address(Image.fromarray(np.round(255 * colors).astype(np.uint8)), "PNG")


def _thumbnail(path: Path) -> str:
    with Image.open(path) as image:
        small = image.convert("RGBA")
    small.thumbnail((THUMBNAIL_PIXELS, THUMBNAIL_PIXELS))
    return _address(small, "WEBP", quality=80)


def _address(picture: Image.Image, kind: str, **options: int) -> str:
    """Return a picture as a data address, which a page needs no request for."""
    buffer = BytesIO()
    picture.save(buffer, kind, **options)
    return f"data:image/{kind.lower()};base64," + base64.b64encode(buffer.getvalue()).decode()

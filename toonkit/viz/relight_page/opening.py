"""Files that a visitor of the relight page opens. Knows no panel."""

from __future__ import annotations

from io import BytesIO

import toonkit
from toonkit import ToonImage
from toonkit._validation import collect_warnings, refuse

MOST_FILE_BYTES = 60 * 10**6
"""Largest file that a visitor may open."""


def check_size(content: object) -> bytes:
    """Return the content of a file; raises ToonkitError if it is text, or too large."""
    if not isinstance(content, bytes):
        raise refuse("source", "must be a picture file", "a text")
    if len(content) > MOST_FILE_BYTES:
        rule = f"must have at most {MOST_FILE_BYTES // 10**6} MB"
        raise refuse("source", rule, f"{len(content) / 10**6:.0f} MB")
    return content


def read_picture(content: bytes) -> tuple[ToonImage, list[str]]:
    """Read a picture, and what of it is ignored or only assumed, a line each."""
    with collect_warnings() as warned:
        return toonkit.load_image(BytesIO(content)), warned

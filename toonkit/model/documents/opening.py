"""Which files are layered documents, and how they are opened."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from toonkit._validation import as_path, expand_home, refuse
from toonkit.model.decoding import MAX_BYTES, PictureSource
from toonkit.model.documents import photoshop
from toonkit.model.documents.document import Document
from toonkit.model.documents.krita import DESCRIPTION, open_krita
from toonkit.model.documents.open_raster import open_raster
from toonkit.model.documents.picture_folder import open_folder
from toonkit.model.documents.zip_members import ZipMembers
from toonkit.model.file_bytes import read_bytes

_ZIP = b"PK\x03\x04"
_START = 100
"""Bytes that tell the format: an archive's first member says what it is, as both formats demand."""


def open_document(argument: str, source: PictureSource) -> Document | None:
    """
    Open a Photoshop, OpenRaster or Krita file, whatever its name, or a folder of pictures.

    Returns None for anything else; an open file is then where it was. Raises `ToonkitError` if it is a document that
    cannot be read.
    """
    try:
        if isinstance(source, str | os.PathLike):
            path = expand_home(as_path(argument, source))
            if os.path.isdir(path):  # where Path would raise for a name that is too long
                return open_folder(argument, path)
            return _open_file(argument, path, _start_of(path))
        if hasattr(source, "read") and _can_seek(source):
            file: Any = source
            at = file.tell()
            start = file.read(_START)
            file.seek(at)
            return _open_file(argument, source, start if isinstance(start, bytes) else b"")
    except RecursionError as error:
        raise refuse(
            argument, "must be a document of reasonable depth", "thousands of nested groups"
        ) from error
    return None


def _open_file(argument: str, source: Any, start: bytes) -> Document | None:
    if start.startswith(photoshop.SIGNATURE):
        data, name = read_bytes(argument, source, limit=MAX_BYTES, kind="a picture file")
        return photoshop.open_photoshop(argument, data, name)
    raster = b"image/openraster" in start
    if not start.startswith(_ZIP) or not (raster or b"application/x-krita" in start):
        return None
    data, name = read_bytes(argument, source, limit=MAX_BYTES, kind="a picture file")
    if raster:
        return open_raster(argument, ZipMembers(argument, data, name, "an OpenRaster document"))
    members = ZipMembers(argument, data, name, "a Krita document")
    if DESCRIPTION not in members:
        raise members.damaged(f"{DESCRIPTION} is missing")
    return open_krita(argument, members)


def _start_of(path: Path) -> bytes:
    """Return the first bytes of a regular file; whatever is wrong with it is told by who reads it."""
    try:
        if not path.is_file():
            return b""
        with path.open("rb") as file:
            return file.read(_START)
    except (OSError, ValueError):
        return b""


def _can_seek(file: Any) -> bool:
    try:
        return bool(file.seekable())
    except (AttributeError, ValueError):  # no such method, or a closed file
        return False

"""Bytes of a file given by its path or already open, of limited size: no pipe is waited for, no device read for ever."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import Any

from toonkit._validation import expand_home, refuse

_PIECE = 1 << 24


def read_bytes(
    argument: str, source: str | os.PathLike[str] | Any, *, limit: int, kind: str
) -> tuple[bytes, str]:
    """
    Read a regular file, or anything with a `read` method that returns bytes; return its content, and its name for messages.

    Raises `ToonkitError` if there is no such file, it is empty, a folder, a pipe or a device, cannot be read or has
    more than `limit` bytes.
    """
    if isinstance(source, str | os.PathLike):
        path = expand_home(source)
        name = str(path)
        content = _read_path(argument, path, limit, kind)
    else:
        name = str(getattr(source, "name", "a file object"))
        content = _read_open(argument, source, limit)
    if not content:
        raise refuse(argument, f"must be {kind}", f"{name}, which is empty")
    if len(content) > limit:
        raise refuse(argument, f"must have at most {limit // 2**20} MiB", f"{name}, which has more")
    return content, name


def _read_path(argument: str, path: Path, limit: int, kind: str) -> bytes:
    try:
        found = path.stat()
        if stat.S_ISDIR(found.st_mode):
            raise refuse(argument, f"must be {kind}", f"the folder {path}")
        if not stat.S_ISREG(found.st_mode):
            raise refuse(argument, f"must be {kind}", f"{path}, which is a pipe or a device")
        if found.st_size > limit:
            shown = f"{path} of {found.st_size // 2**20} MiB"
            raise refuse(argument, f"must have at most {limit // 2**20} MiB", shown)
        with path.open("rb") as file:
            # As much as there is, which may have grown: memory for the limit would be set aside for every file.
            return _read_open(argument, file, limit)
    except FileNotFoundError:
        raise refuse(argument, "must be an existing file", f"{path}, which does not exist") from None
    except OSError as error:
        raise refuse(argument, "must be a readable file", f"{path} ({error.strerror or error})") from error
    except ValueError as error:
        if "null" not in str(error):
            raise
        raise refuse(argument, "must be a readable file", f"{str(path)!r} ({error})") from error


def _read_open(argument: str, file: Any, limit: int) -> bytes:
    pieces: list[bytes] = []
    size = 0
    while size <= limit:
        try:
            piece: Any = file.read(_PIECE)
        except (OSError, ValueError) as error:  # ValueError: a closed file
            raise refuse(argument, "must be a readable file", f"{file!r} ({error})") from error
        if not isinstance(piece, bytes):
            raise refuse(
                argument, 'must be opened in binary mode ("rb")', f"a file of {type(piece).__name__}"
            )
        if not piece:
            break
        pieces.append(piece)
        size += len(piece)
    return b"".join(pieces)

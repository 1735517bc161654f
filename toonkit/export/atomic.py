"""atomic_write: a file is written whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from toonkit._validation import refuse

PathLike = str | os.PathLike[str]


@contextmanager
def atomic_write(path: PathLike) -> Iterator[BinaryIO]:
    """
    Open a file for writing that takes its place only when everything is written.

    Parameters
    ----------
    path : path
        The file to write; its folder must exist. A link is followed; an older file's permissions are
        kept.

    Yields
    ------
    binary file
        A temporary file in the same folder. If the block raises, it is removed and an older file
        stays intact.

    Raises
    ------
    ToonkitError
        If the folder does not exist, `path` is itself a folder, or the disk refuses.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with atomic_write(Path(folder) / "note.txt") as file:
    ...         _ = file.write(b"whole")
    ...     os.listdir(folder)
    ['note.txt']
    """
    target = Path(os.path.realpath(Path(path).expanduser()))
    if target.is_dir():
        raise refuse("path", "must name a file", f"the folder {path}")
    if not target.parent.is_dir():
        raise refuse("path", "must lie in an existing folder", f"{path}")
    # Opened by name and not by tempfile, whose files nobody else may read.
    temporary = target.with_name(f".{target.name[:100]}.{uuid.uuid4().hex[:12]}.tmp")
    try:
        with temporary.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())  # or a power cut could leave the new name on an empty file
        if target.exists():
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise refuse("path", "must be writable", f"{path} ({error.strerror or error})") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files that a process left in a folder when it was killed; nobody may write there meanwhile."""
    for path in folder.glob(".*.tmp"):
        if re.fullmatch(r"\..+\.[0-9a-f]{12}\.tmp", path.name):
            with suppress(OSError):
                path.unlink()


def suffix_of(path: PathLike, allowed: tuple[str, ...], argument: str = "path") -> str:
    """Return the lower-case suffix of a path, refusing one that is not among those allowed."""
    suffix = Path(path).suffix.lower()
    if suffix not in allowed:
        raise refuse(argument, f"must end in {' or '.join(allowed)}", f"{path}")
    return suffix

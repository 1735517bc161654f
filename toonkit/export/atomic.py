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

from toonkit._validation import as_path, expand_home, refuse

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

PathLike = str | os.PathLike[str]

_TEMPORARY = re.compile(r"\..*\.toonkit-[0-9a-f]{12}\.tmp", re.DOTALL)


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
        If the folder does not exist, `path` is itself a folder or no path, or the disk refuses.

    Notes
    -----
    A process that is killed leaves its temporary file behind. The next write into the folder removes it: each writer
    holds a lock on its own file, which the system releases when the process ends.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with atomic_write(Path(folder) / "note.txt") as file:
    ...         _ = file.write(b"whole")
    ...     os.listdir(folder)
    ['note.txt']
    """
    path = as_path("path", path)
    temporary: Path | None = None
    try:
        target = Path(os.path.realpath(expand_home(path)))
        if target.is_dir():
            raise refuse("path", "must name a file", f"the folder {path}")
        if not target.parent.is_dir():
            raise refuse("path", "must lie in an existing folder", f"{path}")
        _remove_leftovers(target.parent)
        temporary, created = _create_beside(target)
        with created as file:
            yield file
            file.flush()
            os.fsync(file.fileno())  # or a power cut could leave the new name on an empty file
            if target.exists():
                shutil.copymode(target, temporary)
            if fcntl is not None:  # while it is locked, or another process could take it for a leftover
                os.replace(temporary, target)
        if fcntl is None:  # Windows renames no open file
            os.replace(temporary, target)
    except OSError as error:
        raise refuse("path", "must be writable", f"{path} ({error.strerror or error})") from error
    finally:
        if temporary is not None:
            with suppress(OSError):
                temporary.unlink()


def _create_beside(target: Path) -> tuple[Path, BinaryIO]:
    """Create and lock a temporary file. It is opened by name and not by tempfile, whose files nobody else may read."""
    while True:
        # A name has 255 bytes at most, and a character of the target's up to four.
        temporary = target.with_name(f".{target.name[:40]}.toonkit-{uuid.uuid4().hex[:12]}.tmp")
        file = temporary.open("xb")
        if fcntl is None:
            return temporary, file
        with suppress(OSError):  # file systems without locks
            fcntl.flock(file, fcntl.LOCK_EX)
        if temporary.exists():
            return temporary, file
        file.close()  # another process took it for a leftover before it was locked


def _remove_leftovers(folder: Path) -> None:
    """Remove temporary files whose writers were killed: those that nobody holds a lock on."""
    if fcntl is None:
        return
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _TEMPORARY.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with suppress(OSError), open(entry.path, "r+b") as left:
                    fcntl.flock(left, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(entry.path)


def suffix_of(path: PathLike, allowed: tuple[str, ...], argument: str = "path") -> str:
    """Return the lower-case suffix of a path, refusing one that is not among those allowed."""
    suffix = as_path(argument, path).suffix.lower()
    if suffix not in allowed:
        raise refuse(argument, f"must end in {' or '.join(allowed)}", f"{path}")
    return suffix

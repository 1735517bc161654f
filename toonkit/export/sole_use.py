"""sole_use: a folder that one run at a time writes to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toonkit._validation import refuse

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

LOCK_NAME = ".lock"


@contextmanager
def sole_use(home: Path) -> Iterator[None]:
    """Hold a folder for one run at a time; the system lets go of it when the process ends, however it does."""
    try:
        lock = (home / LOCK_NAME).open("w")
    except OSError as error:
        raise refuse("folder", "must be writable", f"{home / LOCK_NAME} ({error.strerror})") from error
    with lock:
        if fcntl is not None:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise refuse("folder", "must not be in use by another run", f"{home}") from error
        yield

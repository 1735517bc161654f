"""A study's folder: whose it is, and the sidecar that says where its numbers come from."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from toonkit._validation import refuse
from toonkit.export.atomic import atomic_write
from toonkit.study.table import PROVENANCE_NAME, load_provenance, settings_from

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


def opened_sidecar(fresh: dict[str, Any], home: Path) -> dict[str, Any]:
    """Return the folder's provenance, extended by that of a plan; refuse a folder whose study has other settings."""
    fresh = {**fresh, "runs": []}
    if not (home / PROVENANCE_NAME).is_file():
        write_sidecar(fresh, home)
        return fresh
    known = load_provenance(home)
    if settings_from(known.get("settings")) != settings_from(fresh["settings"]):
        raise refuse("folder", "must hold a study with the same size and lights, or be new", f"{home}")
    fresh["shapes"] = {**known["shapes"], **fresh["shapes"]}
    for group, digests in fresh["digests"].items():
        fresh["digests"][group] = {**known["digests"].get(group, {}), **digests}
    for group in ("color_maps", "methods", "light_tracks"):
        fresh[group] = list(dict.fromkeys([*known[group], *fresh[group]]))
    fresh["runs"] = known["runs"]
    write_sidecar(fresh, home)
    return fresh


def write_sidecar(sidecar: dict[str, Any], home: Path) -> None:
    """Write the sidecar, whole or not at all."""
    with atomic_write(home / PROVENANCE_NAME) as file:
        file.write((json.dumps(sidecar, indent=2) + "\n").encode())

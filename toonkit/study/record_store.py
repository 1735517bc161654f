"""RecordStore: the records of a study, one file per trial, written atomically."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Collection, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, cast

from toonkit._validation import refuse
from toonkit.export.atomic import atomic_write
from toonkit.study.digests import NETWORKS_USED
from toonkit.study.records import LightTrack, Record, Trial

FOLDER = "records"

LOST = "WorkerLost: "
"""Prefix of the error of a trial whose worker died repeatedly. The next run tries such a trial again."""


_TYPES: dict[str, tuple[type, ...]] = {"str": (str,), "int": (int,), "float": (float, int), "bool": (bool,)}
_LARGEST = 2**63


class RecordStore:
    """
    The records of a study.

    Parameters
    ----------
    folder : path
        The study's folder; the records lie in `records/` below it.
    sidecar : mapping
        The study's provenance. A record belongs to the study if it was made with the same version of toonkit, the same
        settings, and the same inputs by their digests. A damaged record does not count, so that its trial is measured
        again.

    Raises
    ------
    ToonkitError
        If the folder cannot be written to.
    """

    def __init__(self, folder: Path, sidecar: Mapping[str, Any]) -> None:
        self._folder = folder / FOLDER
        self._common = [sidecar["toonkit"], sidecar["settings"]]
        self._digests: Mapping[str, Mapping[str, str | None]] = sidecar["digests"]
        try:
            self._folder.mkdir(exist_ok=True)
        except OSError as error:
            raise refuse("folder", "must be writable", f"{self._folder} ({error.strerror})") from error

    def save(self, trial: Trial, record: Record) -> None:
        """Write a record; an older one of the same trial is replaced."""
        stored = {
            "fingerprint": self._fingerprint(trial),
            "record": {
                name: None if isinstance(value, float) and math.isnan(value) else value
                for name, value in asdict(record).items()
            },
        }
        with atomic_write(self._folder / f"{trial.key}.json") as file:
            file.write(json.dumps(stored, indent=1).encode())

    def is_done(self, trial: Trial, *, retry_failed: bool = False) -> bool:
        """Tell whether a trial was measured with its present inputs."""
        record = self._current(self._folder / f"{trial.key}.json")
        if record is None:
            return False
        return not (record.error and (retry_failed or record.error.startswith(LOST)))

    def forget(self, methods: Collection[str]) -> None:
        """Delete all records of some methods; raises `ToonkitError` if the disk refuses."""
        for path in self._folder.glob("*.json"):
            stored = _read(path)
            if stored is not None and stored[1].method in methods:
                try:
                    path.unlink()
                except OSError as error:
                    raise refuse("folder", "must be writable", f"{path} ({error.strerror})") from error

    def records(self) -> list[Record]:
        """Return all records whose trials have the same inputs now."""
        found = (self._current(path) for path in sorted(self._folder.glob("*.json")))
        return [record for record in found if record is not None]

    def _current(self, path: Path) -> Record | None:
        stored = _read(path)
        if stored is None:
            return None
        fingerprint, record = stored
        track = cast("LightTrack", record.light_track)
        trial = Trial(record.shape, record.color_map, record.method, track)
        return record if trial.key == path.stem and fingerprint == self._fingerprint(trial) else None

    def _fingerprint(self, trial: Trial) -> str:
        """Return a digest of a trial's inputs."""
        method_file = self._digest("method_file", trial.method)
        networks = NETWORKS_USED.get(trial.method)
        if networks is None or method_file is not None or trial.light_track == "estimated":
            networks = tuple(sorted(self._digests.get("weights", {})))
        inputs = [
            *self._common,
            self._digest("shape", trial.shape),
            self._digest("color_map", trial.color_map),
            method_file,
            [(name, self._digest("weights", name)) for name in networks],
        ]
        return hashlib.sha256(json.dumps(inputs).encode()).hexdigest()

    def _digest(self, group: str, name: str) -> str | None:
        return self._digests.get(group, {}).get(name)


def _read(path: Path) -> tuple[object, Record] | None:
    """Return what a file holds, the fingerprint and the record; None if it is missing or damaged."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        values: dict[str, Any] = {
            name: math.nan if value is None else value for name, value in stored["record"].items()
        }
        record = Record(**values)
        return (stored["fingerprint"], record) if _is_typed(record) else None
    except (AttributeError, KeyError, OSError, RecursionError, TypeError, ValueError):
        return None


def _is_typed(record: Record) -> bool:
    """Tell whether each value is of its column's type, and fits into it."""
    for field in fields(record):
        value, kind = getattr(record, field.name), str(field.type)
        if not isinstance(value, _TYPES[kind]) or (isinstance(value, bool) and kind != "bool"):
            return False
        if isinstance(value, int) and not -_LARGEST <= value < _LARGEST:
            return False
    return True

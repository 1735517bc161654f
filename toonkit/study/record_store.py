"""RecordStore: the records of a study as files, one a trial, each written whole or not at all."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from toonkit.export.atomic import atomic_write
from toonkit.study.trials import Record, Trial

FOLDER = "records"

LOST = "WorkerLost: "
"""How the error of a trial begins whose worker died time and again: the next run tries it anew."""


class RecordStore:
    """
    The records of a study.

    Parameters
    ----------
    folder : path
        The study's folder; the records lie in `records/` below it.
    digests : dict
        Of the shapes, color maps and methods as they are now, as `StudyPlan.digests` returns them.
    """

    def __init__(self, folder: Path, digests: dict[str, dict[str, str]]) -> None:
        self._folder = folder / FOLDER
        self._digests = digests
        self._folder.mkdir(exist_ok=True)

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
            file.write(json.dumps(stored, indent=1, allow_nan=True).encode())

    def is_current(self, trial: Trial) -> bool:
        """Tell whether a trial was measured, with its shape, color map and method as they are now."""
        path = self._folder / f"{trial.key}.json"
        if not path.is_file():
            return False
        stored = json.loads(path.read_text(encoding="utf-8"))
        known = stored["fingerprint"] == self._fingerprint(trial)
        return known and not stored["record"]["error"].startswith(LOST)

    def records(self) -> list[Record]:
        """Return all records on file."""
        return [_read(path) for path in sorted(self._folder.glob("*.json"))]

    def _fingerprint(self, trial: Trial) -> str:
        parts = (
            self._digests["shape"][trial.shape],
            self._digests["color_map"][trial.color_map],
            self._digests["method"][trial.method],
        )
        return hashlib.sha256("".join(parts).encode()).hexdigest()


def _read(path: Path) -> Record:
    values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["record"]
    values |= {name: math.nan for name, value in values.items() if value is None}
    return Record(**values)

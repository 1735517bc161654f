"""RecordStore: the records of a study as files, one a trial, each written whole or not at all."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

from toonkit.export.atomic import atomic_write
from toonkit.study.trials import LightTrack, Record, Trial

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
    sidecar : mapping
        The study's provenance: its code, its settings, and the digests of its shapes, color maps, methods and light tracks.
        A record that was made with others is not one of this study any more.
    """

    def __init__(self, folder: Path, sidecar: Mapping[str, Any]) -> None:
        self._folder = folder / FOLDER
        self._common = json.dumps([sidecar["code"], sidecar["settings"]])
        self._digests = sidecar["digests"]
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
            file.write(json.dumps(stored, indent=1).encode())

    def is_done(self, trial: Trial, *, retry_failed: bool = False) -> bool:
        """Tell whether a trial was measured, with its shape, color map and method as they are now."""
        record = self._current(self._folder / f"{trial.key}.json")
        if record is None:
            return False
        return not (record.error and (retry_failed or record.error.startswith(LOST)))

    def records(self) -> list[Record]:
        """Return all records that are of this study as it is now."""
        found = (self._current(path) for path in sorted(self._folder.glob("*.json")))
        return [record for record in found if record is not None]

    def outdated(self) -> int:
        """Return how many records on file were made with a shape, color map or method that is another by now."""
        return sum(self._current(path) is None for path in self._folder.glob("*.json"))

    def _current(self, path: Path) -> Record | None:
        if not path.is_file():
            return None
        stored = json.loads(path.read_text(encoding="utf-8"))
        values: dict[str, Any] = stored["record"]
        values |= {name: math.nan for name, value in values.items() if value is None}
        record = Record(**values)
        track = cast("LightTrack", record.light_track)
        trial = Trial(record.shape, record.color_map, record.method, track)
        return record if stored["fingerprint"] == self._fingerprint(trial) else None

    def _fingerprint(self, trial: Trial) -> str:
        parts = (
            self._common,
            self._digests["shape"].get(trial.shape, ""),
            self._digests["color_map"].get(trial.color_map, ""),
            self._digests["method"].get(trial.method, ""),
            self._digests["light_track"][trial.light_track],
        )
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

"""The study's table on disk: one row per trial, as Parquet or CSV, with its provenance in a sidecar."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, fields
from pathlib import Path
from types import NoneType
from typing import Any

import pandas as pd

from toonkit._validation import ToonkitError, expand_home, refuse
from toonkit.export.atomic import PathLike, atomic_write
from toonkit.study.painting import StudySettings
from toonkit.study.record_store import FOLDER, RecordStore
from toonkit.study.records import LIGHT_TRACKS, Record

TABLE_NAME = "trials.parquet"
CSV_NAME = "trials.csv"
PROVENANCE_NAME = "study.json"

TRIAL_COLUMNS = ["shape", "color_map", "method", "light_track"]
"""The columns that identify a trial, and the order of the rows."""

TIMING_COLUMNS = ["seconds"]
"""The columns that differ between two runs of the same trials on the same machine."""

_TYPES = {"str": "str", "int": "int64", "float": "float64", "bool": "bool"}
COLUMN_TYPES: dict[str, str] = {field.name: _TYPES[str(field.type)] for field in fields(Record)}
"""The columns of the table, and their types."""

CSV_DIGITS = 6

_EACH = "*"
_FORM: dict[str, Any] = {
    "toonkit": str,
    "settings": dict,
    "refinement_as_printed": dict,
    "shapes": dict,
    "color_maps": [str],
    "methods": [str],
    "light_tracks": [str],
    "digests": {
        "shape": {_EACH: (str, NoneType)},
        "color_map": {_EACH: (str, NoneType)},
        "method_file": {_EACH: (str, NoneType)},
        "weights": {_EACH: str},
    },
    "runs": [
        {
            "started": str,
            "seconds": (int, float, NoneType),
            "trials": (int, NoneType),
            "workers": (int, str),
            "commit": (str, NoneType),
            "machine": {"processor": str, "cores": (int, NoneType), "system": str},
            "versions": dict,
        }
    ],
}
"""What a study's provenance holds: for each name a type, or lists and dicts of types."""


def as_table(records: Iterable[Record]) -> pd.DataFrame:
    """Return records as a table sorted by `TRIAL_COLUMNS`, with the columns and types of `COLUMN_TYPES`."""
    rows = pd.DataFrame([asdict(record) for record in records], columns=list(COLUMN_TYPES))
    return rows.astype(COLUMN_TYPES).sort_values(TRIAL_COLUMNS, ignore_index=True)


def write_table(trials: pd.DataFrame, folder: PathLike) -> Path:
    """Write a table into a study's folder as Parquet, atomically; return its path."""
    path = Path(folder) / TABLE_NAME
    with atomic_write(path) as file:
        trials.to_parquet(file, index=False)
    return path


def write_csv(trials: pd.DataFrame, path: PathLike) -> Path:
    """Write a table as CSV with `CSV_DIGITS` significant digits, atomically; return its path."""
    text = trials.to_csv(index=False, float_format=f"%.{CSV_DIGITS}g")
    with atomic_write(path) as file:
        file.write(text.encode())
    return Path(path)


def load_trials(source: PathLike) -> pd.DataFrame:
    """
    Read a study's table.

    Parameters
    ----------
    source : path
        A study's folder, or its `trials.parquet` or `trials.csv`.

    Returns
    -------
    pandas.DataFrame
        One row a trial; the columns are the fields of `toonkit.study.records.Record`.

    Raises
    ------
    ToonkitError
        If there is no table, or a file is not one or holds no trial.
    """
    place = expand_home(source)
    if _has_newer_records(place):
        return as_table(RecordStore(place, load_provenance(place)).records())
    path = _table_path(place)
    texts = {name: kind for name, kind in COLUMN_TYPES.items() if kind == "str"}
    try:
        table = pd.read_csv(path, dtype=texts) if path.suffix == ".csv" else pd.read_parquet(path)
    except Exception as error:  # pandas and pyarrow raise nearly every type there is for a damaged file
        raise refuse("source", "must be the table of a study", f"{path} ({error})") from error
    missing = [name for name in COLUMN_TYPES if name not in table.columns]
    if missing:
        raise refuse("source", f"must have the column {missing[0]}", f"{path} without it")
    if table.empty:
        raise refuse("source", "must hold at least one trial", f"{path} without any")
    try:
        trials = table[list(COLUMN_TYPES)].fillna(dict.fromkeys(texts, "")).astype(COLUMN_TYPES)
    except (OverflowError, TypeError, ValueError) as error:
        raise refuse("source", "must have the columns of a study's table", f"{path} ({error})") from error
    unknown = set(trials["light_track"]) - set(LIGHT_TRACKS)
    if unknown:
        rule = f"must be of the light tracks {' and '.join(LIGHT_TRACKS)}"
        raise refuse("source", rule, f"{path} with {min(unknown)!r}")
    return trials


def load_provenance(source: PathLike) -> dict[str, Any]:
    """Read the sidecar of a study's table; raises `ToonkitError` if it is not what a study writes."""
    provenance, path = _read_provenance(source)
    for name, form in _FORM.items():
        if name not in provenance or not _fits(provenance[name], form):
            raise refuse(
                "source",
                f"must have a {PROVENANCE_NAME} of a study",
                f"{path}, where {name} is missing or odd",
            )
    settings_from(provenance["settings"])
    return provenance


def _read_provenance(source: PathLike) -> tuple[dict[str, Any], Path]:
    """Read the sidecar of a study's table, whatever it holds by name, and tell where it lies."""
    path = expand_home(source)
    path = (path if path.is_dir() else path.parent) / PROVENANCE_NAME
    try:
        provenance = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, RecursionError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        rule = f"must have a readable {PROVENANCE_NAME} beside its table"
        raise refuse("source", rule, f"{path} ({reason})") from error
    if not isinstance(provenance, dict):
        raise refuse("source", f"must have a {PROVENANCE_NAME} of a study", f"{path}, which names nothing")
    return provenance, path


def _fits(value: object, form: Any) -> bool:
    """Tell whether a value has a form: a type, several, a list of a form, or a dict whose values have forms."""
    if isinstance(form, list):
        return isinstance(value, list) and all(_fits(item, form[0]) for item in value)
    if isinstance(form, dict):
        if not isinstance(value, dict):
            return False
        if _EACH in form:
            return all(_fits(item, form[_EACH]) for item in value.values())
        return all(name in value and _fits(value[name], part) for name, part in form.items())
    return isinstance(value, form)


def settings_of(source: PathLike) -> StudySettings:
    """Return the settings under which a study's trials were made; raises `ToonkitError` where there are none."""
    return settings_from(_read_provenance(source)[0].get("settings"))


def settings_from(stored: Any) -> StudySettings:
    """Return settings from their JSON form; raises `ToonkitError` for anything else."""
    try:
        return StudySettings(
            size=stored["size"], light=stored["light"], new_lights=tuple(stored["new_lights"])
        )
    except (KeyError, TypeError, ToonkitError) as error:
        raise refuse(
            "source", f"must have the settings of a study in its {PROVENANCE_NAME}", f"{stored}"
        ) from error


def _has_newer_records(place: Path) -> bool:
    """Tell whether a study was killed before it could write its table: a folder changes with each new file in it."""
    records, table = place / FOLDER, place / TABLE_NAME
    if not records.is_dir() or not any(records.glob("*.json")):
        return False
    return not table.is_file() or records.stat().st_mtime_ns > table.stat().st_mtime_ns


def _table_path(source: Path) -> Path:
    if not source.is_dir():
        if not source.is_file():
            raise refuse(
                "source", "must be a study's folder or table; `toonkit study run` makes one", f"{source}"
            )
        return source
    for name in (TABLE_NAME, CSV_NAME):
        if (source / name).is_file():
            return source / name
    raise ToonkitError(
        f"source must hold {TABLE_NAME} or {CSV_NAME}; got {source} without them: `toonkit study run -o {source}` makes one"
    )

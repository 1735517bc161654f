"""The sidecar in a study's folder, which records where the numbers come from."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from toonkit._validation import refuse
from toonkit.export.atomic import atomic_write
from toonkit.study.table import PROVENANCE_NAME, load_provenance, settings_from


def open_sidecar(fresh: dict[str, Any], home: Path) -> dict[str, Any]:
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
    """Write the sidecar atomically."""
    with atomic_write(home / PROVENANCE_NAME) as file:
        file.write((json.dumps(sidecar, indent=2) + "\n").encode())

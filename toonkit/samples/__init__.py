"""The sample drawings that ship with toonkit: made by `python -m toonkit.study.sample_drawings` from our own shapes."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from toonkit._validation import one_of

FOLDER = Path(__file__).parent

PREFIX = "sample:"
"""What a sample's name starts with where a path may stand, too."""


def sample_names() -> tuple[str, ...]:
    """Return the names of the sample drawings, the best one to start with first."""
    return tuple(_records())


def sample_path(name: str) -> Path:
    """Return the path of a sample's PNG; raises `ToonkitError` for a name that is none."""
    return FOLDER / f"{_record(name)['name']}.png"


def drawing_path(drawing: str) -> str | Path:
    """Return the path of a sample's PNG for `sample:NAME`, and any other text as it is."""
    return sample_path(drawing.removeprefix(PREFIX)) if drawing.startswith(PREFIX) else drawing


def sample_title(name: str) -> str:
    """Return a sample's title, a few words; raises `ToonkitError` for a name that is none."""
    return str(_record(name)["title"])


def sample_light(name: str) -> tuple[float, float]:
    """Return the azimuth and elevation, in degrees, of a sample's light; raises `ToonkitError` for a name that is none."""
    azimuth, elevation = _record(name)["light"]
    return float(azimuth), float(elevation)


def _record(name: str) -> dict[str, Any]:
    one_of("sample", name, _records())
    return _records()[name]


@cache
def _records() -> dict[str, dict[str, Any]]:
    records = json.loads((FOLDER / "samples.json").read_text(encoding="utf-8"))
    return {record["name"]: record for record in records}

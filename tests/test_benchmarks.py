"""The numbers in README are those of the files that the benchmarks wrote."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

from benchmarks import speed

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def numbers(name: str) -> list[dict[str, str | float]]:
    """Rows of a result file, numbers as numbers."""
    with (ROOT / "benchmarks" / "results" / name).open(newline="") as file:
        return [{key: _number(value) for key, value in row.items()} for row in csv.DictReader(file)]


def _number(value: str) -> str | float:
    try:
        return float(value)
    except ValueError:
        return value


def shown(name: str) -> str:
    """Return the table that stands in README under a name."""
    (table,) = re.findall(rf"<!-- {name}: begin -->\n(.*?)<!-- {name}: end -->", README, re.DOTALL)
    return table.strip()


def test_readme_shows_the_speed_that_was_measured():
    rows = [row for row in numbers("speed.csv") if (row["shape"], row["size"]) == ("cat", 512)]
    assert shown("speed") == speed.table(rows)


def test_readme_shows_the_drag_rate_that_was_measured():
    figures = json.loads((ROOT / "benchmarks" / "results" / "drag_rate.json").read_text())
    text = " ".join(README.split())
    assert f"{figures['pictures_per_second']:.0f} pictures a second" in text
    assert f"{figures['first_picture_cold_s']:.0f} s after" in text

"""The numbers in README are those of the files that the benchmarks wrote."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

import toonkit
from benchmarks import accuracy, speed

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


def test_readme_shows_the_accuracy_that_was_measured():
    assert shown("accuracy") == accuracy.table(numbers("accuracy.csv"))


def test_readme_shows_the_speed_that_was_measured():
    rows = [row for row in numbers("speed.csv") if (row["shape"], row["size"]) == ("cat", 512)]
    assert shown("speed") == speed.table(rows)


def test_readme_shows_the_drag_rate_that_was_measured():
    figures = json.loads((ROOT / "benchmarks" / "results" / "drag_rate.json").read_text())
    text = " ".join(README.split())
    assert f"{figures['pictures_per_second']:.0f} pictures a second" in text
    assert f"{figures['first_picture_cold_s']:.0f} s after" in text


def test_the_result_file_has_a_row_for_every_trial():
    rows = numbers("accuracy.csv")
    trials = {(row["shape"], row["color_map"], row["method"]) for row in rows}
    assert (
        len(rows)
        == len(trials)
        == len(accuracy.SHAPE_NAMES) * len(accuracy.COLOR_MAP_NAMES) * len(toonkit.METHODS)
    )


def test_the_default_method_is_the_best_of_the_result_file():
    rows = numbers("accuracy.csv")

    def mean(method, measure):
        values = [row[measure] for row in rows if row["method"] == method]
        return sum(values) / len(values)

    angle = {method: mean(method, "angular_error") for method in toonkit.METHODS}
    assert angle["toonkit"] < angle["todo"] < angle["lumo"]
    for measure in ("angular_error", "relight_rmse"):
        assert min(toonkit.METHODS, key=lambda method: mean(method, measure)) == "toonkit"


def test_a_trial_measured_now_agrees_with_its_row():
    truth = accuracy.render_shape(accuracy.SHAPES["ellipsoid"], 256)
    measured = accuracy.measured(truth, accuracy.load_color_maps()["terracotta"], "toonkit")
    (row,) = [
        row
        for row in numbers("accuracy.csv")
        if (row["shape"], row["color_map"], row["method"]) == ("ellipsoid", "terracotta", "toonkit")
    ]
    for measure, value in measured.items():
        # Two machines may round sums differently; the file keeps five decimals.
        assert value == pytest.approx(row[measure], rel=0.01, abs=1e-4)

"""The numbers in docs/speed.md are those of the files that the benchmarks wrote."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks import end_to_end, other_solvers, speed
from toonkit.numerics.screened_poisson import solve_screened_poisson
from toonkit.numerics.unit_field import solve_unit_field

ROOT = Path(__file__).parent.parent
SPEED = (ROOT / "docs" / "speed.md").read_text()
TEXT = " ".join(SPEED.split())


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
    """Return the table that stands in docs/speed.md under a name."""
    (table,) = re.findall(rf"<!-- {name}: begin -->\n(.*?)<!-- {name}: end -->", SPEED, re.DOTALL)
    return table.strip()


def test_the_document_shows_the_speed_that_was_measured():
    rows = [row for row in numbers("speed.csv") if (row["shape"], row["size"]) == ("cat", 512)]
    assert shown("speed") == speed.table(rows)


def test_the_document_shows_how_the_analysis_scales():
    rows = [row for row in numbers("speed.csv") if row["method"] == "toonkit"]
    assert shown("scaling") == speed.table(rows)
    assert {row["size"] for row in rows} == set(speed.SIZES)
    first = {row["shape"]: row["first_seconds"] for row in rows if row["size"] == max(speed.SIZES)}
    assert (
        f"The first drawing of {max(speed.SIZES)}² in a process takes {first['sphere']:.0f} s for the disc "
        f"and {first['cat']:.0f} s for the cat" in TEXT
    )


@pytest.mark.parametrize("shape", ["sphere", "cat"])
def test_the_time_per_pixel_does_not_grow_with_the_picture(shape):
    times = {
        row["size"]: row["analyze_microseconds_per_pixel"]
        for row in numbers("speed.csv")
        if (row["shape"], row["method"]) == (shape, "toonkit")
    }
    assert f"From 512² to {max(speed.SIZES)}² the time per pixel does not grow" in TEXT
    assert times[max(speed.SIZES)] <= times[512]


def test_the_document_shows_the_solvers_that_were_compared():
    rows = [row for row in numbers("solvers.csv") if row["shape"] == "cat"]
    assert shown("solvers") == speed.solver_table(rows)
    assert f"Solvers were stopped after {speed.LIMIT:.0f} s" in TEXT


def test_the_document_says_how_the_papers_sweeps_compare():
    assert shown("sweeps") == speed.sweeps_text(numbers("solvers.csv"))


def test_the_document_shows_the_first_use_that_was_measured():
    (row,) = numbers("first_use.csv")
    assert f"takes {row['first_process_seconds']:.1f} s for the cat at 512²" in TEXT
    assert f"Later processes take {row['later_process_seconds']:.1f} s" in TEXT


@pytest.fixture(scope="module")
def posed():
    return speed.problems("cat", 64)


@pytest.mark.parametrize("solve", [other_solvers.factorized, other_solvers.by_pyamg])
def test_the_other_solvers_find_the_same_inflation(posed, solve):
    other = other_solvers.solve_poisson_with(posed.system, posed.right_side, solve)
    ours, _ = solve_screened_poisson(posed.system, posed.right_side, tolerance=1e-8)
    # pyamg is asked for the residual that toonkit asks for.
    assert np.abs(other[:, 0] + 1j * other[:, 1] - ours).max() < 1e-3


@pytest.mark.parametrize("solve", [other_solvers.factorized, other_solvers.by_pyamg])
@pytest.mark.parametrize("name", ["field", "printed"])
def test_newton_meets_the_energy_of_the_multigrid(posed, name, solve):
    problem = getattr(posed, name)
    goal = solve_unit_field(problem, tolerance=1e-5)[1].energies[-1] * (1 + 1e-4)
    assert other_solvers.newton(problem, goal, 60.0, solve)[1] <= goal


@pytest.mark.parametrize("name", ["field", "printed"])
def test_over_relaxed_sweeps_meet_the_energy_of_the_multigrid(posed, name):
    problem = getattr(posed, name)
    goal = solve_unit_field(problem, tolerance=1e-5)[1].energies[-1] * (1 + 1e-4)
    assert other_solvers.swept(problem, goal, 60.0)[1] <= goal


def test_the_document_shows_the_time_from_file_to_files_that_was_measured():
    rows = pd.read_csv(ROOT / "benchmarks" / "results" / "end_to_end.csv")
    assert shown("end to end") == end_to_end.table(rows)


def test_the_document_shows_the_drag_rate_that_was_measured():
    figures = json.loads((ROOT / "benchmarks" / "results" / "drag_rate.json").read_text())
    width, height = figures["picture"]
    rate = figures["pictures_per_second"]
    assert f"it draws {rate:.0f} pictures of {width} x {height} pixels per second" in TEXT
    assert f"the first relit picture {figures['first_picture_cold_s']:.0f} s after" in TEXT

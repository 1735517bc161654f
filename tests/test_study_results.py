"""The committed table of the whole study: complete, of this code, and what README says of it."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd
import pytest

from benchmarks import publish_study, sweeps
from toonkit import METHODS
from toonkit.study.color_maps import load_color_maps
from toonkit.study.contestants import contestants
from toonkit.study.digests import CODE, light_track_digests, method_digest
from toonkit.study.reporting.cells import on_track
from toonkit.study.reporting.text import sweeps_text
from toonkit.study.shapes import SHAPES
from toonkit.study.subjects import render
from toonkit.study.table import load_provenance, load_trials, settings_of
from toonkit.study.trials import StudySettings, Trial, paint, run_trial

ROOT = Path(__file__).parent.parent
STUDY = ROOT / "notebooks" / "study"
README = (ROOT / "README.md").read_text()


@pytest.fixture(scope="module")
def trials() -> pd.DataFrame:
    """The trials in which the light was given."""
    return on_track(load_trials(STUDY), "given")


def test_the_table_has_a_row_for_every_trial_and_none_failed(trials):
    assert len(trials) == 20 * 24 * 6
    assert len(trials) == len(SHAPES) * len(load_color_maps()) * len(contestants())
    assert not trials.duplicated(["shape", "color_map", "method"]).any()
    assert (trials["error"] == "").all()
    assert (trials["size"] == StudySettings().size).all()
    assert settings_of(STUDY) == StudySettings()


def test_the_sidecar_tells_how_the_table_was_made():
    known = load_provenance(STUDY)
    assert known["code"] == CODE, (
        "the code that measures has changed: toonkit study run, benchmarks/publish_study.py"
    )
    now = {name: method_digest(contestant.analyze) for name, contestant in contestants().items()}
    assert known["digests"]["method"] == now, "a method has changed: toonkit study run runs its trials again"
    assert known["digests"]["light_track"]["given"] == light_track_digests()["given"]
    assert known["refinement_as_printed"]["max_sweeps"] == 500
    measured = [run["trials"] for run in known["runs"]]  # None: a run that was killed cannot tell
    assert measured[-1] is not None
    assert None in measured or sum(measured) >= len(load_trials(STUDY))  # a later run replaces rows


def test_readme_shows_the_means_of_the_table(trials):
    assert publish_study.BLOCK.findall(README) == [publish_study.overview(trials)]


def test_the_default_method_is_the_best_of_the_table(trials):
    means = trials.groupby("method")[["angular_error", "relight_rmse"]].mean().loc[list(METHODS)]
    assert means.idxmin().tolist() == ["toonkit", "toonkit"]


@pytest.mark.parametrize(
    ("shape", "method"),
    [
        ("ellipsoid", "toonkit"),
        ("cone", "lumo"),
        ("torus", "flat"),
        ("cylinder", "todo"),
        ("cone", "lambert"),
    ],
)
def test_a_trial_measured_now_agrees_with_its_row(trials, shape, method):
    settings = settings_of(STUDY)
    painting = paint(render(SHAPES[shape], settings.size), load_color_maps()["terracotta"], settings)
    trial = Trial(shape, "terracotta", method, "given")
    now = run_trial(trial, SHAPES[shape].kind, painting, contestants()[method])
    (row,) = trials.query("shape == @shape and color_map == 'terracotta' and method == @method").to_dict(
        "records"
    )
    for measure in ("angular_error", "illumination_error", "input_rmse", "relight_rmse", "relight_response"):
        # Another machine may round sums differently; the file keeps six digits.
        assert getattr(now, measure) == pytest.approx(row[measure], rel=0.01, abs=1e-4)


def test_the_table_of_sweeps_is_the_one_its_benchmark_makes():
    table = pd.read_csv(STUDY / "sweeps.csv")
    assert list(table.columns) == list(sweeps.COLUMNS)
    assert table["sweeps"].tolist() == list(sweeps.SWEEPS)
    assert table["energy"].is_monotonic_decreasing


def test_readme_says_what_the_minimum_of_the_papers_energy_is_worth():
    (said,) = re.findall(r"<!-- minimum: begin -->\n(.*?)\n<!-- minimum: end -->", README, re.DOTALL)
    assert said == sweeps_text(pd.read_csv(STUDY / "sweeps.csv"))

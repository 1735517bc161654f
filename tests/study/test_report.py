"""The report tells all that the table holds, failures first of all, and no number that is not in it."""

from __future__ import annotations

import re

import pandas as pd
import pytest

from tests.synthetic_study import COLOR_MAPS, SHAPES, failed, study_table, with_newcomers
from toonkit import ToonkitError
from toonkit.study.measures import MEASURES
from toonkit.study.reporting.report import REPORT_NAME, report_tables, write_report
from toonkit.study.reporting.statistics import breakdown, method_means
from toonkit.study.reporting.tables import best_methods, extremes, refinements, show_means, show_refinements
from toonkit.study.reporting.text import means_text, report_text

PROVENANCE = {
    "digests": {"weights": {"light_prior": "f00dfacedead" + 52 * "0", "shape_prior": 64 * "1"}},
    "settings": {"size": 64, "light": [129, 50], "new_lights": [[0, 25], [90, 60]]},
    "refinement_as_printed": {"relaxation": 1.5, "max_sweeps": 500, "tolerance": 1e-5},
    "runs": [
        {
            "started": "2026-01-01T00:00:00+00:00",
            "seconds": seconds,
            "trials": trials,
            "workers": 2,
            "commit": commit,
            "versions": {"python": "3.11", "dask": "2026.1"},
            "machine": {"system": "Linux", "processor": "a fast one", "cores": 2},
        }
        for seconds, trials, commit in ((3700.0, 2000, "abc123"), (80.0, 5, None), (None, None, "abc123+"))
    ],
}


@pytest.fixture(scope="module")
def trials():
    return study_table()


@pytest.fixture(scope="module")
def text(trials):
    return report_text(trials, PROVENANCE)


def cells_of(text, start):
    """Cells of the first row of any table that starts with a word."""
    (row, *_) = re.findall(rf"^\| {re.escape(start)} \|(.*)\|$", text, re.MULTILINE)
    return [cell.strip() for cell in row.split("|")]


def test_the_report_is_written_with_its_tables(trials, tmp_path):
    written = write_report(trials, PROVENANCE, tmp_path / "new" / "report")
    assert next(path.name for path in written) == REPORT_NAME
    assert all(path.is_file() and what for path, what in written.items())
    assert sorted(path.name for path in (tmp_path / "new" / "report").iterdir()) == sorted(
        path.name for path in written
    )
    means = pd.read_csv(tmp_path / "new" / "report" / "method_means.csv")
    assert set(means["measure"]) == set(MEASURES)
    assert list(means.columns[:3]) == ["light_track", "measure", "method"]


def test_two_reports_of_the_same_table_are_the_same(trials, text):
    assert report_text(trials.sample(frac=1, random_state=1), PROVENANCE) == text


def test_the_report_opens_with_what_was_compared(text):
    assert text.startswith("# Study: 6 shapes x 6 color maps x 5 methods\n")
    assert "64 x 64 pixels" in text


def test_means_in_the_report_are_those_of_the_table(trials, text):
    shown = cells_of(text, "normals, mean error")
    for cell, method in zip(shown, ("toonkit", "todo", "lumo", "lambert", "flat"), strict=True):
        mean = trials.loc[trials["method"] == method, "angular_error"].mean()
        assert cell.strip("*").startswith(f"{mean:.1f}° [")


def test_the_best_of_each_measure_is_bold_and_flat_never_is(trials, text):
    assert cells_of(text, "normals, mean error")[0].startswith("**")
    assert "**" not in cells_of(text, "input, RMSE (sRGB)")[-1]
    assert "flat" not in {name for names in best_methods(method_means(trials)).values() for name in names}


def test_methods_that_the_decimals_do_not_tell_apart_are_equally_good(trials):
    means = method_means(trials, ("relight_response",))
    means["departure"] = [0.011, 0.012, 0.2, 0.3, 1.0]
    assert best_methods(means) == {"response to the light, median": ["toonkit", "todo"]}


def test_every_claim_has_a_verdict_in_the_report(text):
    for key in "abcdef":
        assert cells_of(text, key)[2] in {"agrees", "partly", "disagrees", "undecided"}


def test_the_report_lists_every_check_with_its_outcome(text):
    section = text.split("### Checks\n\n")[1].split("\n\n## ")[0]
    outcomes = re.findall(r"^\| [a-f] \| .*? \| (holds|does not hold|undecided) \|", section, re.MULTILINE)
    assert len(outcomes) == 23
    # Six color maps cannot decide claim (c); nothing is contradicted.
    assert "does not hold" not in outcomes


def test_a_failed_trial_is_in_the_report_with_its_error(trials):
    broken = failed(trials, shape="cat", color_map="candy", method="todo")
    text = report_text(broken, PROVENANCE)
    assert "35 of the 36" not in text.split("## Failures")[1]
    assert "Means are over the 35 of 36 pairs" in text
    assert "1 of 180 trials ended in an error" in text
    assert r"ValueError: it \| broke" in text  # a bar would end the cell
    assert cells_of(text.split("## Refinements")[1], "todo")[:2] == ["35", "1"]


def test_a_measure_that_is_undefined_in_some_trials_says_over_how_many_it_is(trials):
    table = trials.copy()
    table.loc[0, "relight_response"] = float("inf")
    assert "response to the light over 35 of 36 pairs" in report_text(table, {})


def test_the_most_frequent_errors_are_named_first_and_cut_short(trials):
    broken = failed(failed(trials, method="lumo"), shape="cat", color_map="candy", method="todo")
    rare = broken["error"].ne("") & (broken["method"] == "todo")
    broken.loc[rare, "error"] = "MemoryError: " + "very " * 100 + "large"
    section = report_text(broken, {}).split("## Failures")[1].split("\n## ")[0]
    first, second = re.findall(r"^- (\d+ x .*)$", section, re.MULTILINE)
    assert first == r"36 x ValueError: it \| broke"
    assert second == "1 x " + ("MemoryError: " + "very " * 100)[:100] + " …"
    assert "large" not in section


def test_a_newcomer_has_its_rows_among_the_pairs(trials):
    section = (
        report_text(with_newcomers(trials, "dome"), {}).split("## Pairs of methods")[1].split("\n## ")[0]
    )
    for other in ("toonkit", "todo", "lumo", "lambert", "flat"):
        assert f"| dome | {other} |" in section
    two = report_text(with_newcomers(trials[trials["method"] == "lumo"], "dome"), {})
    assert "| dome | lumo |" in two
    assert "There is none to compare" not in two


def test_pairs_are_told_by_their_interval_and_no_test_is_called_independent(text):
    assert "interval is the primary evidence" in text
    assert "p is approximate" in text
    assert "p, shapes" not in text


def test_one_picture_has_no_interval_and_no_verdict(trials):
    one = trials[(trials["shape"] == "cat") & (trials["color_map"] == "candy")]
    text = report_text(one, {})
    assert "(too few for an interval)" in text
    assert not re.search(r"\bnan\b", text)
    assert {cells_of(text, key)[2] for key in "abcdef"} == {"undecided"}


def test_time_is_no_contest_and_says_how_it_was_taken(trials, text):
    assert "time to analyze" not in text
    assert best_methods(method_means(trials, ("seconds", "input_rmse"))).keys() == {"input, RMSE (sRGB)"}
    assert "wall time, all cores busy" in show_refinements(refinements(trials)).columns


def test_means_are_shown_with_a_row_per_measure_or_per_method(trials):
    means = method_means(trials, ("angular_error",))
    upright, flat = (means_text(means, row_per=row).splitlines() for row in ("measure", "method"))
    assert upright[0].startswith("| measure | toonkit |")
    assert [line.split(" | ")[0] for line in flat[:3]] == ["| method", "| ---", "| toonkit"]
    assert upright[2].split(" | ")[1] == flat[2].split(" | ")[1].removesuffix(" |")


def test_no_failure_is_said_plainly(text):
    assert "No trial ended in an error." in text


def test_provenance_tells_size_lights_versions_sweeps_and_time(text):
    section = text.split("## Provenance")[1]
    assert "azimuth 129°, elevation 50°" in section
    assert "azimuth 90°, elevation 60°" in section
    assert "max sweeps 500" in section
    assert cells_of(section, "digests of the weights") == [
        "light_prior f00dfacedead, shape_prior 111111111111"
    ]
    runs = [cells_of(section, f"run {number}")[0] for number in (1, 2, 3)]
    assert "2,000 trials in 1 h 1 min" in runs[0]
    assert "commit abc123; a fast one, 2 cores, Linux; python 3.11, dask 2026.1" in runs[0]
    assert "commit unknown" in runs[1]
    assert "killed" in runs[2]


def test_a_report_without_provenance_tells_what_the_table_knows(trials):
    section = report_text(trials, {}).split("## Provenance")[1]
    assert "azimuth 129°, elevation 50°" in section
    assert "| run 1 |" not in section
    assert cells_of(section, "wall time of the analyses, all cores busy") == ["1 min 30 s"]


def test_figures_are_shown_by_their_address_beside_the_report(trials, tmp_path):
    figures = {tmp_path / "pairs.png": "Pairs.", tmp_path / "pairs.pdf": "Pairs."}
    write_report(trials, {}, tmp_path, figures=figures)
    assert re.findall(r"!\[.*\]\((.*)\)", (tmp_path / REPORT_NAME).read_text()) == ["pairs.png"]


def test_each_light_track_has_its_means_and_the_claims_are_about_the_true_light(trials):
    worse = trials.assign(light_track="estimated", angular_error=trials["angular_error"] + 10)
    both = pd.concat([worse, trials], ignore_index=True)
    text = report_text(both, {})
    assert text.index("the true light given") < text.index("the light estimated")
    only_given = report_text(trials, {})
    claims = only_given.split("## The paper's claims")[1].split("## Provenance")[0]
    assert text.split("## The paper's claims")[1].split("## Provenance")[0] == claims.replace(
        "of 180 trials", "of 360 trials"
    )
    means = report_tables(failed(both, shape="cat", method="lumo"))["method_means"][1]
    assert means.groupby("light_track").size().tolist() == [len(MEASURES) * 5] * 2


def test_a_study_of_one_method_still_has_a_report(trials, tmp_path):
    write_report(trials[trials["method"] == "todo"], {}, tmp_path)
    assert "There is none to compare" in (tmp_path / REPORT_NAME).read_text()


def test_a_study_in_which_all_failed_still_has_a_report(trials, tmp_path):
    broken = trials.copy()
    for method in trials["method"].unique():
        broken = failed(broken, method=method)
    write_report(broken, {}, tmp_path)
    assert "180 of 180 trials ended in an error" in (tmp_path / REPORT_NAME).read_text()


def test_an_empty_table_has_no_report(trials, tmp_path):
    with pytest.raises(ToonkitError, match="at least one trial"):
        write_report(trials.iloc[:0], {}, tmp_path)


def test_extremes_name_the_best_and_the_worst_groups(trials):
    groups = breakdown(trials, "angular_error", "shape")
    named = extremes(groups, "angular_error").loc["todo"]
    assert named["best"].startswith(f"{groups['todo'].idxmin()} ")
    assert named["worst"].startswith(f"{groups['todo'].idxmax()} ")
    assert not set(re.findall("[a-z]+", named["best"])) & set(re.findall("[a-z]+", named["worst"]))


def test_a_method_that_is_alike_everywhere_has_no_extremes(trials):
    groups = breakdown(trials, "angular_error", "shape").assign(lumo=20.0)
    assert extremes(groups, "angular_error").loc["lumo", "best"] == "alike on all"


def test_the_response_is_headed_as_a_median(trials):
    assert "response to the light, median" in show_means(method_means(trials)).columns


def test_refinements_are_counted_over_completed_trials(trials):
    table = refinements(failed(trials, shape=SHAPES[0], color_map=COLOR_MAPS[0], method="todo"))
    assert table.loc["todo", ["completed", "failed", "iterations, median"]].tolist() == [35, 1, 50]
    assert table.loc["todo", "seconds"] == pytest.approx(35 * 0.5)

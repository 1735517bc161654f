"""What the study page knows and shows, without a page."""

from __future__ import annotations

import asyncio
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from tests.synthetic_study import failed, study_table
from toonkit import ToonkitError
from toonkit.study.color_maps import load_color_maps
from toonkit.study.estimators import FLAT, list_estimators
from toonkit.study.painting import StudySettings, paint
from toonkit.study.records import Record, Trial
from toonkit.study.rendering import render_shape
from toonkit.study.reporting.comparisons import compare
from toonkit.study.reporting.statistics import breakdown, method_means
from toonkit.study.shapes import SHAPES
from toonkit.study.table import as_table
from toonkit.study.trials import run_trial
from toonkit.viz.study_page import examination as study_examination
from toonkit.viz.study_page import state as study_state
from toonkit.viz.study_page.elements import MatrixLayout, difference_colors, heat_map
from toonkit.viz.study_page.examination import Examination, examine
from toonkit.viz.study_page.matrix import trial_matrix
from toonkit.viz.study_page.sheet import trial_sheet
from toonkit.viz.study_page.state import StudyState
from toonkit.viz.turns import Turns

SIZE = 48
SETTINGS = StudySettings(size=SIZE)

# shape -> color map -> method -> angular error; porcelain stands behind ocean in the study's own order.
ANGLES = {
    "cat": {"porcelain": {"toonkit": 9.0, "todo": 12.0}, "ocean": {"toonkit": 10.0, "todo": 14.0}},
    "sphere": {"porcelain": {"toonkit": 3.0, "todo": 2.0}, "ocean": {"toonkit": 4.0, "todo": 5.0}},
}
RESPONSES = {"toonkit": 0.9, "todo": 1.3}


def run(work):
    """Run a coroutine in a thread of its own: the browser tests may have left an event loop running in this one."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        return pool.submit(asyncio.run, work).result()


def record(shape, color_map, method, **measures):
    kind = SHAPES[shape].kind if shape in SHAPES else "mesh"
    return Record(shape, kind, color_map, method, "given", SIZE, 900, 129.0, 50.0, **measures)


def table(*, without=None, failed=None, extra=()):
    rows = []
    for shape, maps in ANGLES.items():
        for color_map, methods in maps.items():
            for method, angle in methods.items():
                key = (shape, color_map, method)
                measures = {"angular_error": angle, "relight_response": RESPONSES[method]}
                measures = {"error": "ToonkitError: no <shape>"} if key == failed else measures
                rows += [] if key == without else [record(*key, **measures)]
    return as_table([*rows, *extra])


def angles(trials, **what):
    return trial_matrix(trials, measure="angular_error", **{"method": "toonkit", **what})


@pytest.fixture(autouse=True)
def nothing_kept():
    study_state._kept.clear()


@pytest.fixture
def state():
    return StudyState(table(), SETTINGS)


def test_rows_are_ordered_by_kind_and_columns_as_the_study_lists_its_color_maps():
    bunny = record("bunny", "ocean", "toonkit", angular_error=1.0)
    matrix = angles(table(extra=[bunny]))
    assert matrix.shapes == ("sphere", "cat", "bunny")
    assert matrix.kinds == ("primitive", "complex", "mesh")
    assert matrix.color_maps == ("ocean", "porcelain")


def test_a_method_alone_shows_its_values_and_their_means():
    matrix = angles(table())
    np.testing.assert_allclose(matrix.values, [[4, 3], [10, 9]])
    np.testing.assert_allclose(matrix.row_means, [3.5, 9.5])
    np.testing.assert_allclose(matrix.column_means, [7, 6])
    assert matrix.label == "toonkit: normals, mean error (°)"
    assert matrix.shown(matrix.mean) == "6.5°"


def test_a_difference_of_two_methods_is_negative_where_the_first_is_better():
    matrix = angles(table(), versus="todo")
    np.testing.assert_allclose(matrix.values, [[-1, 1], [-4, -3]])
    assert matrix.center == 0
    assert matrix.limits[0] == -matrix.limits[1]
    assert "toonkit is better in 3 of 4 trials" in matrix.summary
    assert matrix.shown(-1.25) == "−1.2°"


def test_a_difference_of_responses_is_one_of_distances_from_one():
    matrix = trial_matrix(table(), measure="relight_response", method="toonkit", versus="todo")
    np.testing.assert_allclose(matrix.values, -0.2)
    assert trial_matrix(table(), measure="relight_response", method="todo").center == 1


def test_two_methods_are_shown_on_one_scale():
    assert angles(table()).limits == angles(table(), method="todo").limits


@pytest.mark.parametrize(
    ("hole", "reason"),
    [("failed", "toonkit: ToonkitError: no <shape>"), ("without", "toonkit: not in the table")],
)
def test_a_trial_without_a_value_stays_in_the_picture_with_its_reason(hole, reason):
    matrix = angles(table(**{hole: ("cat", "ocean", "toonkit")}), versus="todo")
    np.testing.assert_array_equal(np.isnan(matrix.values), [[False, False], [True, False]])
    assert matrix.cell_text(1, 0) == matrix.gaps[1, 0] == reason
    np.testing.assert_allclose(matrix.row_means, [0, -3])
    assert "toonkit is better in 2 of 3 trials; the mean is −1.0°." in matrix.summary
    assert "1 of 4 cells have no value" in matrix.summary


@pytest.mark.parametrize("measure", ["angular_error", "relight_response"])
def test_means_are_those_of_the_report_whatever_failed(measure):
    trials = failed(study_table(noise=0.2), shape="cat", color_map="candy", method="lumo")
    # Not in what lumo failed at: a mean over toonkit's own trials would see it.
    there = (trials["shape"] == "cat") & (trials["color_map"] == "candy") & (trials["method"] == "toonkit")
    trials.loc[there, measure] = 1000.0
    trials.loc[trials.index[0], "relight_response"] = 50.0
    report = method_means(trials, (measure,)).set_index("method")
    page = StudyState(trials, SETTINGS)
    page.measure = measure
    for method, text in page.means().items():
        matrix = trial_matrix(trials, measure=measure, method=method)
        assert matrix.mean == pytest.approx(report.loc[method, "center"], rel=1e-12)
        center = "median" if measure == "relight_response" else "mean"
        assert text == f"{center} {matrix.shown(report.loc[method, 'center'])}"
        for by, means in (("shape", matrix.row_means), ("color_map", matrix.column_means)):
            groups = breakdown(trials, measure, by)
            names = matrix.shapes if by == "shape" else matrix.color_maps
            np.testing.assert_allclose(means, groups.loc[list(names), method])
    name = "Median" if measure == "relight_response" else "Mean"
    summary = trial_matrix(trials, measure=measure, method="toonkit").summary
    assert summary.startswith(name)
    assert "over the 35 trials that every method completed" in summary


@pytest.mark.parametrize("measure", ["angular_error", "relight_response"])
def test_the_mean_of_a_difference_is_that_of_the_report(measure):
    trials = failed(study_table(noise=0.2), shape="cat", color_map="candy", method="lumo")
    found = compare(trials, "toonkit", "todo", measure)
    matrix = trial_matrix(trials, measure=measure, method="toonkit", versus="todo")
    assert matrix.mean == pytest.approx(found.difference.center, rel=1e-12)
    assert int(matrix.counted.sum()) == found.difference.trials == 36


def test_without_a_trial_that_all_completed_there_is_no_mean():
    trials = table(without=("sphere", "porcelain", "todo"), failed=("cat", "porcelain", "todo"))
    trials = trials[(trials["color_map"] == "porcelain") | (trials["method"] == "todo")]
    matrix = angles(trials)
    assert np.isnan(matrix.mean)
    assert matrix.summary == (
        "No mean: there is no trial that every method completed. 2 of 4 cells have no value."
    )
    assert StudyState(trials, SETTINGS).means() == {"toonkit": "no value", "todo": "no value"}


def test_a_track_with_fewer_trials_keeps_every_cell_in_its_place():
    only = replace(record("cat", "porcelain", "todo", angular_error=20.0), light_track="estimated")
    trials = table(extra=[only])
    np.testing.assert_allclose(
        angles(trials, method="todo", light_track="estimated").values, [[np.nan, np.nan], [np.nan, 20]]
    )
    assert np.isnan(angles(trials, light_track="estimated").values).all()
    assert angles(trials, light_track="estimated").summary == "No trial has a value here."


def test_the_page_opens_with_a_difference_and_its_median_trial(state):
    assert (state.method, state.versus, state.measure) == ("toonkit", "todo", "angular_error")
    assert (state.shape, state.color_map) == state.typical() == ("sphere", "ocean")
    assert state.best() == ("cat", "ocean")
    assert state.worst() == ("sphere", "porcelain")


def test_a_method_is_not_compared_with_itself(state):
    state.method = "todo"
    assert state.versus == ""
    assert list(state.param.versus.objects) == ["", "toonkit"]


def test_an_empty_table_is_refused_with_what_to_run():
    with pytest.raises(ToonkitError, match="toonkit study run"):
        StudyState(table().iloc[:0], SETTINGS)


def test_an_examination_gives_the_numbers_of_the_study_at_the_same_size():
    truth = render_shape(SHAPES["cone"], SIZE)
    painting = paint(truth, load_color_maps()["ocean"], SETTINGS)
    rows = [
        run_trial(Trial("cone", "ocean", name, "given"), "primitive", painting, method)
        for name, method in list_estimators().items()
    ]
    state = StudyState(as_table(rows), SETTINGS)
    run(state.examine())
    answers = {answer.name: answer for answer in state.examination.answers}
    assert list(answers) == ["truth", *state.methods]
    assert state.examination.size == SIZE
    for row in rows:
        assert answers[row.method].mean_error == pytest.approx(row.angular_error, rel=1e-9)
    np.testing.assert_array_equal(answers["truth"].picture, painting.image.to_rgba())
    assert (state.step, state.fraction) == ("", 0.0)


def test_a_newer_selection_ends_an_older_examination(state, monkeypatch):
    def slow_for_the_sphere(shape, color_map, *, progress, light_track, settings, methods, **_):
        while shape == "sphere":
            progress("working", 0.5)
            time.sleep(0.01)
        return Examination(shape, color_map, light_track, settings.size, settings.light, (), tuple(methods))

    async def two_selections():
        older = asyncio.create_task(state.examine())
        await asyncio.sleep(0.1)
        state.select("cat", "ocean")
        await asyncio.gather(older, state.examine())

    monkeypatch.setattr(study_state, "examine", slow_for_the_sphere)
    run(two_selections())
    assert (state.examination.shape, state.step) == ("cat", "")


def test_an_examination_that_fails_leaves_the_other_one_on_screen(state, monkeypatch):
    run(state.examine())
    before = state.examination

    def fail(*_, **__):
        raise ToonkitError("no light")

    monkeypatch.setattr(study_state, "examine", fail)
    state.select("cat", "ocean")
    with pytest.raises(ToonkitError, match="no light"):
        run(state.examine())
    assert state.examination is before
    assert (state.shape, state.color_map) == ("sphere", "ocean")


def test_an_examination_is_kept(state, monkeypatch):
    run(state.examine())
    before = state.examination
    monkeypatch.setattr(study_state, "examine", None)
    run(state.examine())
    assert state.examination is before


def test_the_next_visitor_finds_a_kept_examination_on_the_page(state):
    run(state.examine())
    assert StudyState(table(), SETTINGS).examination is state.examination


def test_a_mesh_that_is_not_at_hand_is_said_to_be_none():
    state = StudyState(as_table([record("bunny", "ocean", "todo", angular_error=7.0)]), SETTINGS)
    run(state.examine())
    page = trial_sheet(state.examination, state.records(state.examination), measure="angular_error")
    assert "“bunny” does not ship with toonkit" in page
    assert "7.0°" in page


def test_a_method_that_fails_is_an_answer_that_says_so(monkeypatch):
    def fail(*_, **__):
        raise ToonkitError("no <shape>")

    monkeypatch.setattr(
        study_examination, "list_estimators", lambda: {"flat": FLAT, "todo": type(FLAT)(fail)}
    )
    found = examine(
        "sphere", "ocean", methods=["flat", "todo", "mine"], light_track="given", settings=SETTINGS
    )
    assert [bool(answer.failure) for answer in found.answers] == [False, False, True, True]
    page = trial_sheet(found, {name: {} for name in found.methods}, measure="angular_error")
    assert "ToonkitError: no &lt;shape&gt;" in page
    assert "this method is not installed here" in page


def test_a_sheet_shows_every_picture_and_sets_off_the_best_number():
    found = examine(
        "sphere", "ocean", methods=["toonkit", "flat"], light_track="estimated", settings=SETTINGS
    )
    numbers = {"toonkit": {"angular_error": 5.0}, "flat": {"angular_error": 2.0}}
    page = trial_sheet(found, numbers, measure="angular_error")
    assert (
        page.count("<img") == 3 + 3 + 2 + 5 + 3 * 4
    )  # pictures, normals, errors, color maps, four new lights
    assert '<div class="number best">5.0°</div>' in page  # the trivial method does not compete
    assert '<div class="number best">2.0°</div>' not in page


def test_a_place_in_the_heat_map_is_a_cell_or_none():
    layout = MatrixLayout(angles(table()))
    assert layout.cell_at(1.1, layout.rows[1] + 0.3) == (1, 1)
    assert layout.cell_at(layout.mean_column, 0.0) is None
    assert layout.cell_at(0.0, -0.72) is None  # between the kinds


def test_the_heat_map_has_a_rectangle_for_each_trial_and_mean_and_a_cross_for_a_gap():
    matrix = angles(table(failed=("cat", "ocean", "toonkit")), versus="todo")
    cells, crosses, means = heat_map(matrix)
    assert len(cells) == 4 + 2 + 2 + 1
    assert list(cells.dimension_values("text"))[2] == "toonkit: ToonkitError: no <shape>"
    np.testing.assert_allclose(crosses.array(), [[0, MatrixLayout(matrix).rows[1]]])
    assert list(means.dimension_values("text")) == ["±0.0", "−3.0", "−1.0", "−1.0", "−1.0"]


def test_a_difference_is_blue_where_better_dark_where_even_and_orange_where_worse():
    colors = difference_colors()
    assert (colors[0], colors[128], colors[-1]) == ("#58b4f0", "#26282c", "#f08a3c")


def test_a_trial_that_takes_too_long_to_examine_is_ended_and_the_user_told(state, monkeypatch):
    monkeypatch.setattr(study_state, "TURNS", Turns(most_seconds=-1))
    with pytest.raises(ToonkitError, match="takes longer"):
        run(state.examine())
    assert state.step == ""

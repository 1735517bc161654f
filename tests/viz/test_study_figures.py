"""The study's figures show what the table holds, with axes that say what they are, and nothing is cut off."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from tests.synthetic_study import COLOR_MAPS, SHAPES, failed, study_table
from toonkit.study.reporting.findings import findings
from toonkit.study.reporting.statistics import breakdown
from toonkit.viz.figures.study import CAPTIONS, FIGURES, write_figures
from toonkit.viz.figures.study_groups import difference_map, error_by_tones, errors_by_group
from toonkit.viz.figures.study_methods import error_distributions, fit_against_response, sweeps_figure
from toonkit.viz.figures.study_tables import (
    comparisons_table,
    extremes_table,
    findings_table,
    means_table,
    refinements_table,
    sweeps_table,
)
from toonkit.viz.figures.style import METHOD_COLORS

SWEEPS = pd.DataFrame(
    {
        "sweeps": [50, 500, 5000],
        "angular_error": [20.0, 18.0, 17.0],
        "relight_rmse": [0.12, 0.11, 0.1],
        "input_rmse": [0.05, 0.03, 0.02],
        "energy": [90000.0, 50000.0, 40000.0],
    }
)


@pytest.fixture(scope="module")
def trials():
    return study_table()


@pytest.fixture(scope="module")
def drawn(trials):
    figures = {name: draw(trials) for name, draw in FIGURES.items()}
    figures["sweeps"] = sweeps_figure(SWEEPS)
    for figure in figures.values():
        FigureCanvasAgg(figure).draw()
    return figures


ALL = (*FIGURES, "sweeps")


def texts_off_the_page(figure):
    """Texts that are cut off; the labels of ticks beyond an axis' ends are not drawn at all."""
    renderer, page = figure.canvas.get_renderer(), figure.bbox.padded(0.5)  # an edge may fall on half a pixel
    hidden = set()
    for axis in (axis for axes in every_axes(figure) for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            if not (axis.axes.axison and low - 1e-9 <= tick.get_loc() <= high + 1e-9):
                hidden |= {tick.label1, tick.label2}
    boxes = [
        (text.get_text(), text.get_window_extent(renderer))
        for text in figure.findobj(Text)
        if text.get_text().strip() and text.get_visible() and text not in hidden
    ]
    assert boxes
    return [
        text
        for text, box in boxes
        if box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1
    ]


def every_axes(figure):
    return [one for axes in figure.axes for one in (axes, *axes.child_axes)]


@pytest.mark.parametrize("name", ALL)
def test_no_text_leaves_the_page(drawn, name):
    assert texts_off_the_page(drawn[name]) == []


@pytest.mark.parametrize("name", ALL)
def test_every_axis_with_numbers_says_what_they_are(drawn, name):
    for axes in drawn[name].axes:
        for axis in (axes.xaxis, axes.yaxis):
            shown = [label.get_text() for label in axis.get_ticklabels() if label.get_visible()]
            if any(text.strip("−-").replace(".", "").isdigit() for text in shown):
                assert axis.get_label_text() or axes.get_title() or axis.axes.get_label() == "<colorbar>"


def test_dots_stand_where_the_breakdown_says(trials):
    figure = errors_by_group(trials, "shape", ("angular_error",))
    table = breakdown(trials, "angular_error", "shape")
    axes = figure.axes[1]
    (todo,) = (line for line in axes.lines if to_hex(line.get_color()) == METHOD_COLORS["todo"])
    names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert dict(zip(names, todo.get_xdata(), strict=True)) == pytest.approx(table["todo"].to_dict())


def test_every_color_map_stands_beside_its_ramp(trials):
    figure = errors_by_group(trials, "color_map")
    strips = [axes for axes in figure.axes[0].child_axes if axes.images]
    assert len(strips) == len(COLOR_MAPS)


def test_the_difference_is_centered_at_zero_between_the_colors_of_the_two(trials):
    figure = difference_map(trials)
    picture = figure.axes[0].images[0]
    assert picture.norm.vmin == -picture.norm.vmax
    assert to_hex(picture.cmap(0.0)) == METHOD_COLORS["toonkit"]
    assert to_hex(picture.cmap(1.0)) == METHOD_COLORS["todo"]
    values = np.asarray(picture.get_array())
    assert values.shape == (len(SHAPES), len(COLOR_MAPS))
    pairs = trials.pivot_table(index=["shape", "color_map"], columns="method", values="angular_error")
    assert np.sort(values.ravel()) == pytest.approx(np.sort(pairs["toonkit"] - pairs["todo"]))


def test_a_failed_trial_is_a_cross_in_the_difference(trials):
    figure = difference_map(failed(trials, shape="cat", color_map="candy", method="todo"))
    main = figure.axes[0]
    (crosses,) = main.lines
    ((column, row),) = zip(crosses.get_xdata(), crosses.get_ydata(), strict=True)
    assert main.get_yticklabels()[row].get_text() == "cat"
    assert np.ma.masked_invalid(main.images[0].get_array()).mask.sum() == 1
    assert np.isnan(np.ma.filled(main.images[0].get_array(), np.nan)[row, column])


def test_responses_beyond_the_frame_are_counted(trials):
    wild = trials.copy()
    wild.loc[:2, "relight_response"] = 50.0
    texts = [text.get_text() for text in fit_against_response(wild).axes[0].texts]
    assert "3 trials above 1.6 not shown" in texts


def test_shares_of_trials_end_at_one(trials):
    figure = error_distributions(failed(trials, shape="cat", method="lumo"))
    for line in figure.axes[0].lines:
        assert line.get_ydata()[0] == 0.0
        assert line.get_ydata()[-1] == 1.0


def test_tones_are_those_of_the_hard_color_maps(trials):
    left = error_by_tones(trials).axes[0]
    assert left.get_xticks().tolist() == [2, 3, 4, 5]  # of the table's four hard color maps


def test_figures_are_written_for_screen_and_print(trials, tmp_path):
    small = trials[trials["shape"].isin(SHAPES[:3]) & trials["color_map"].isin(COLOR_MAPS[:3])]
    written = write_figures(small, tmp_path)
    assert sorted(path.name for path in written) == sorted(
        f"{name}.{kind}" for name in FIGURES for kind in ("png", "pdf")
    )
    assert all(path.stat().st_size > 5000 for path in written)
    assert set(written.values()) == set(CAPTIONS.values())


@pytest.mark.parametrize(
    ("spoil", "left_out"),
    [
        (lambda table: table[table["method"] == "lumo"], {"pairs", "difference"}),
        (
            lambda table: table.replace({"color_map": {"candy": "mine"}}).query("color_map == 'mine'"),
            {"tones"},
        ),
    ],
)
def test_a_figure_that_the_table_cannot_fill_is_left_out(trials, tmp_path, spoil, left_out, monkeypatch):
    asked = []
    for name in FIGURES:
        monkeypatch.setitem(FIGURES, name, lambda _, name=name: asked.append(name) or Figure((1, 1)))
    write_figures(spoil(trials), tmp_path)
    assert set(FIGURES) - set(asked) == left_out


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize(
    "part",
    [
        lambda table: failed(table, method="todo"),
        lambda table: table[(table["shape"] == "cat") & (table["color_map"] == "candy")],
    ],
    ids=["a method that always fails", "a single picture"],
)
def test_a_poor_table_is_drawn_all_the_same(trials, name, part):
    FigureCanvasAgg(FIGURES[name](part(trials))).draw()


def test_tables_show_methods_in_their_colors_and_the_best_in_bold(trials):
    shown = means_table(trials).to_html()
    assert METHOD_COLORS["todo"] in shown
    assert "font-weight: 700" in shown


def test_tables_show_few_decimals(trials):
    found = findings(trials)
    tables = (
        means_table(trials),
        comparisons_table(trials),
        extremes_table(trials, "angular_error", "shape"),
        findings_table(found),
        refinements_table(trials),
        sweeps_table(SWEEPS),
    )
    for table in tables:
        shown = re.sub("<style.*?</style>", "", table.to_html(), flags=re.DOTALL)
        assert "<td" in shown
        assert re.findall(r"\d\.\d{5,}", shown) == []

"""The study's figures show what the table holds, with axes that say what they are, and nothing is cut off."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from skimage.color import deltaE_ciede2000, rgb2lab

from notebooks.plots.study_tables import (
    checks_table,
    claims_table,
    comparisons_table,
    extremes_table,
    means_table,
    refinements_table,
    sweeps_table,
)
from notebooks.plots.sweeps import describe_sweeps, draw_sweeps
from tests.synthetic_study import COLOR_MAPS, SHAPES, failed, study_table, with_newcomers
from tests.viz.test_figures import COLOR_VISION
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear
from toonkit.study.reporting.claims import check_claims
from toonkit.study.reporting.statistics import breakdown
from toonkit.viz.figures import style
from toonkit.viz.figures.study import CAPTIONS, FIGURES, write_figures
from toonkit.viz.figures.study_groups import difference_map, error_by_tones, errors_by_group
from toonkit.viz.figures.study_methods import (
    error_distributions,
    fit_against_response,
    paired_differences,
)
from toonkit.viz.figures.study_style import SPARE_COLORS, method_colors
from toonkit.viz.figures.style import INK, METHOD_COLORS

FONTS = ("DejaVu Sans", "DejaVu Sans Mono")
"""Matplotlib's own: the one of the figures, and a wide one, in which a layout that holds has room to spare."""

SWEEPS = pd.DataFrame(
    {
        "sweeps": [0, 20, 50, 100, 200, 500, 1000, 2000, 5000, np.inf],
        "angular_error": [24.0, 21.5, 20.0, 19.0, 18.5, 18.0, 17.6, 17.2, 17.0, 16.9],
        "relight_rmse": [0.15, 0.13, 0.12, 0.118, 0.115, 0.11, 0.105, 0.102, 0.1, 0.099],
        "input_rmse": [0.1, 0.07, 0.05, 0.04, 0.035, 0.03, 0.025, 0.022, 0.02, 0.019],
        "energy": [1.0, 0.7, 0.5, 0.4, 0.35, 0.3, 0.27, 0.26, 0.25, 0.24],
    }
)


@pytest.fixture(scope="module")
def trials():
    return study_table()


@pytest.fixture(scope="module")
def drawn(trials):
    figures = {name: draw(trials) for name, draw in FIGURES.items()}
    figures["sweeps"] = draw_sweeps(SWEEPS)
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
def test_no_text_leaves_the_page_in_a_wide_font(trials, name, monkeypatch):
    monkeypatch.setattr(style, "FONT", FONTS[1])
    figure = draw_sweeps(SWEEPS) if name == "sweeps" else FIGURES[name](trials)
    FigureCanvasAgg(figure).draw()
    assert texts_off_the_page(figure) == []


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
    assert left.get_xticks().tolist() == [2, 3, 4, 5, 6]  # of the table's five hard color maps


def test_no_sweep_at_all_stands_left_of_the_first_ones_and_apart_from_the_axis(drawn):
    for axes in drawn["sweeps"].axes:
        line = axes.lines[0]
        places = axes.transData.transform(np.column_stack([line.get_xdata(), line.get_ydata()]))[:, 0]
        assert line.get_xdata()[0] == 0
        assert np.isfinite(places).all()
        assert places[0] >= axes.bbox.x0 - 0.5
        assert (np.diff(places) > 3).all()
        labels = [text for text in axes.get_xticklabels() if text.get_text()]
        assert [text.get_text() for text in labels] == ["0", "20", "100", "1,000"]
        boxes = [text.get_window_extent() for text in labels]
        assert all(one.x1 < next_one.x0 for one, next_one in itertools.pairwise(boxes))


def rows_of(figure):
    return [label.get_text() for label in figure.axes[0].get_yticklabels()]


def test_pairs_of_a_newcomer_are_drawn(trials):
    figure = paired_differences(with_newcomers(trials, "dome"))
    FigureCanvasAgg(figure).draw()
    assert texts_off_the_page(figure) == []
    assert [row for row in rows_of(figure) if "dome" in row] == [
        f"dome − {name}" for name in ("toonkit", "Todo & Yamaguchi", "Lumo", "Lambert", "Flat")
    ]
    two = paired_differences(with_newcomers(trials[trials["method"] == "lumo"], "dome"))
    FigureCanvasAgg(two).draw()
    assert rows_of(two) == ["dome − Lumo"]
    assert texts_off_the_page(two) == []


def test_a_dot_is_filled_by_the_corrected_p_over_shapes_and_color_maps(trials):
    table = trials.sort_values(["method", "color_map", "shape"], ignore_index=True)
    table = pd.concat([table[table["method"] == name] for name in ("todo", "lumo")], ignore_index=True)
    table.loc[:35, "angular_error"], table.loc[36:, "angular_error"] = 20.0, 25.0
    # All six shapes and all six color maps agree: p is 2 in 64 over either.
    (sure,) = dots(paired_differences(table, ("angular_error",)))
    assert to_hex(sure.get_markerfacecolor()) != "#ffffff"
    table.loc[36:, "angular_error"] = 20.0 + np.repeat([5.0, 4.0, 3.0, 2.0, -1.0, -1.5], 6)
    (unsure,) = dots(
        paired_differences(table, ("angular_error",))
    )  # by shapes alone, p is as small as before
    assert to_hex(unsure.get_markerfacecolor()) == "#ffffff"


def dots(figure):
    return [line for line in figure.axes[0].lines if line.get_marker() == "o"]


def test_pairs_of_one_picture_are_drawn_without_intervals_and_say_so(trials):
    one = trials[(trials["shape"] == "cat") & (trials["color_map"] == "candy")]
    figure = paired_differences(one, ("angular_error",))
    assert "too few for an interval" in figure.get_supxlabel()
    assert {to_hex(dot.get_markerfacecolor()) for dot in dots(figure)} == {"#ffffff"}


def test_newcomers_have_colors_of_their_own_in_every_figure(trials):
    table = with_newcomers(trials, "dome", "bowl")
    colors = method_colors(["toonkit", "dome", "bowl"])
    assert len({*METHOD_COLORS.values(), INK, colors["dome"], colors["bowl"]}) == len(METHOD_COLORS) + 3
    for draw in (FIGURES["distributions"], FIGURES["trade_off"], FIGURES["by_shape"], FIGURES["tones"]):
        figure = draw(table)
        (legend,) = figure.legends
        shown = {
            text.get_text(): to_hex(handle.get_color())
            for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True)
        }
        assert (shown["dome"], shown["bowl"]) == (colors["dome"], colors["bowl"])
        drawn_with = {to_hex(line.get_color()) for axes in figure.axes for line in axes.lines}
        assert {colors["dome"], colors["bowl"]} <= drawn_with
    assert colors["bowl"] in means_table(table).to_html()


def test_a_newcomer_keeps_its_color_when_another_one_fails(trials):
    table = failed(with_newcomers(trials, "dome", "bowl"), method="dome")
    (legend,) = error_distributions(table).legends
    assert to_hex(legend.legend_handles[-1].get_color()) == SPARE_COLORS[1]


@pytest.mark.parametrize("vision", COLOR_VISION)
def test_spare_colors_stay_apart_for_color_blind_readers(vision):
    linear = srgb_to_linear([to_rgb(color) for color in (*METHOD_COLORS.values(), *SPARE_COLORS)])
    seen = linear_to_srgb(np.clip(linear @ np.transpose(COLOR_VISION[vision]), 0, 1))
    lab = rgb2lab(np.clip(seen, 0, 1))
    assert min(deltaE_ciede2000(one, other) for one, other in itertools.combinations(lab, 2)) > 13


@pytest.mark.parametrize("font", FONTS)
def test_the_difference_of_a_ratio_on_one_shape_fits_the_page(trials, font, monkeypatch):
    monkeypatch.setattr(style, "FONT", font)
    figure = difference_map(trials[trials["shape"] == "cat"], "relight_response")
    FigureCanvasAgg(figure).draw()
    assert texts_off_the_page(figure) == []


@pytest.mark.parametrize("name", FIGURES)
def test_many_newcomers_fit_the_page(trials, name):
    figure = FIGURES[name](with_newcomers(trials, *(f"newcomer_{number}" for number in range(5))))
    FigureCanvasAgg(figure).draw()
    assert texts_off_the_page(figure) == []


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
        lambda table: table[table["shape"] == "cat"],
    ],
    ids=["a method that always fails", "a single picture", "a single shape"],
)
@pytest.mark.parametrize("font", FONTS)
def test_a_poor_table_is_drawn_all_the_same(trials, name, part, font, monkeypatch):
    monkeypatch.setattr(style, "FONT", font)
    figure = FIGURES[name](part(trials))
    FigureCanvasAgg(figure).draw()
    assert texts_off_the_page(figure) == []


def test_tables_show_methods_in_their_colors_and_the_best_in_bold(trials):
    shown = means_table(trials).to_html()
    assert METHOD_COLORS["todo"] in shown
    assert "font-weight: 700" in shown


def test_the_minimum_is_a_level_below_the_sweeps_and_a_row_after_them(drawn):
    for axes, least in zip(drawn["sweeps"].axes, SWEEPS.iloc[-1, 1:], strict=True):
        sweeps, level = axes.lines[0], axes.lines[-1]
        assert len(sweeps.get_xdata()) == len(SWEEPS) - 1
        assert set(level.get_ydata()) == {least}
        assert axes.get_ylim()[0] <= least
    assert "at the minimum" in sweeps_table(SWEEPS).to_html()


def test_tables_show_few_decimals(trials):
    claims = check_claims(trials)
    tables = (
        means_table(trials),
        comparisons_table(trials),
        extremes_table(trials, "angular_error", "shape"),
        claims_table(claims),
        checks_table(claims),
        refinements_table(trials),
        sweeps_table(SWEEPS),
    )
    for table in tables:
        shown = re.sub("<style.*?</style>", "", table.to_html(), flags=re.DOTALL)
        assert "<td" in shown
        assert re.findall(r"\d\.\d{5,}", shown) == []


@pytest.mark.parametrize(
    ("least", "said"),
    [
        (11.0, "a lower energy means better normals"),
        (13.0, "stopping early helps"),
        (18.0, "because it stops early"),
    ],
)
def test_the_minimum_is_weighed_against_the_sweeps(least, said):
    table = pd.DataFrame({"sweeps": [0, 500, 5000, np.inf], "angular_error": [15.0, 12.0, 12.5, least]})
    assert "smallest after 500 sweeps, at 12.0°" in describe_sweeps(table)
    assert f"{least:.1f}° at the minimum" in describe_sweeps(table)
    assert said in describe_sweeps(table)

"""Summary figures of a study by its methods: distributions, the trade-off of Section 4.3, and pairs of methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import gaussian_kde

from toonkit._validation import FloatArray
from toonkit.study.measures import MEASURES
from toonkit.study.reporting.comparisons import COMPARED, comparisons
from toonkit.study.reporting.measure_table import arrange, names_in
from toonkit.study.reporting.statistics import TOO_FEW, is_ratio, method_means
from toonkit.viz.figures.study_style import (
    ROW,
    draw_grid,
    format_name,
    jitter,
    method_colors,
    method_legend,
    panel_width,
)
from toonkit.viz.figures.style import INK, QUIET, SMALL, figure_style, fold, new_figure

RESPONSE_LIMIT = 1.6
"""End of the axis of responses; the few beyond are counted in the figure."""

SIGNIFICANT = 0.05


def error_distributions(
    trials: pd.DataFrame, measures: Sequence[str] = ("angular_error", "relight_rmse")
) -> Figure:
    """
    Draw how the errors of all trials are distributed; a column for each measure.

    Above, the share of trials below an error; below, for every method the density, the quartiles with the median, and
    the trials.
    """
    tables = {column: arrange(trials, column) for column in measures}
    methods = tables[measures[0]].working
    colors = method_colors(tables[measures[0]].methods)
    with figure_style():
        figure = new_figure(2.0 + 0.5 * len(methods), gap=0.03)
        panels = figure.subplots(
            2,
            len(measures),
            sharex="col",
            sharey="row",
            squeeze=False,
            height_ratios=[1.5, 0.5 * len(methods)],
        )
        for (above, below), (column, table) in zip(panels.T, tables.items(), strict=True):
            for row, method in enumerate(methods):
                values = table.shared(method)
                values = values[np.isfinite(values)]
                _draw_shares(above, values, colors[method])
                _draw_cloud(below, values, row, colors[method])
            above.set_ylim(0, 1)
            draw_grid(above, "both")
            draw_grid(below, "x")
            below.set_xlabel(MEASURES[column].axis)
            below.set_xlim(left=0)
            below.tick_params(axis="y", length=0)
            below.spines["left"].set_visible(False)
        panels[0, 0].set_ylabel("share of trials below")
        panels[1, 0].set_yticks(range(len(methods)), [format_name(method) for method in methods])
        panels[1, 0].set_ylim(len(methods) - 0.55, -0.6)
        method_legend(figure, methods, colors)
    return figure


def fit_against_response(trials: pd.DataFrame) -> Figure:
    """
    Draw the paper's trade-off: how well a method repeats its input, and how much it answers a new light.

    A small dot is a trial; a large one a method's center, with 95 % intervals along both axes.
    """
    fit, response = arrange(trials, "input_rmse"), arrange(trials, "relight_response")
    centers = method_means(trials, ("input_rmse", "relight_response")).set_index(["method", "measure"])
    colors = method_colors(response.methods)
    beyond = 0
    with figure_style():
        figure = new_figure(3.6, width=5.2)
        axes = figure.subplots()
        axes.axhline(1.0, color=QUIET, linewidth=0.7, linestyle=(0, (4, 3)), zorder=1)
        for method in response.working:
            color = colors[method]
            x, y = fit.of(method).ravel(), response.of(method).ravel()
            beyond += int((y > RESPONSE_LIMIT).sum())
            axes.plot(x, y, ".", color=color, markersize=3.0, alpha=0.3, markeredgewidth=0, zorder=2)
            at, answer = (centers.loc[(method, column)] for column in ("input_rmse", "relight_response"))
            axes.plot([at.low, at.high], [answer.center] * 2, color=INK, linewidth=1.0, zorder=4)
            axes.plot([at.center] * 2, [answer.low, answer.high], color=INK, linewidth=1.0, zorder=4)
            axes.plot(
                at.center,
                answer.center,
                "o",
                color=color,
                markersize=8,
                markeredgecolor=INK,
                markeredgewidth=0.8,
                zorder=5,
            )
        axes.set(
            xlabel=f"{MEASURES['input_rmse'].axis}: better to the left",
            ylabel=MEASURES["relight_response"].axis,
            ylim=(-0.06, RESPONSE_LIMIT),
        )
        axes.set_xlim(left=-0.006)
        right = axes.get_xlim()[1]
        axes.text(right, 1.012, "as the truth", ha="right", va="bottom", color=QUIET, fontsize=SMALL)
        if beyond:
            text = f"{beyond} trial{'s' if beyond > 1 else ''} above {RESPONSE_LIMIT:g} not shown"
            axes.text(right, RESPONSE_LIMIT, text, ha="right", va="top", color=QUIET, fontsize=SMALL)
        method_legend(figure, response.working, colors)
    return figure


def paired_differences(trials: pd.DataFrame, measures: Sequence[str] = COMPARED) -> Figure:
    """
    Draw the differences between pairs of methods, with their intervals; a panel for each measure.

    A row has the share of trials that its first method wins. A dot is filled if p is small, after correction. Of too
    few shapes or color maps there is neither p nor interval.
    """
    table = comparisons(trials, measures=measures)
    pairs = list(dict.fromkeys(zip(table["method"], table["versus"], strict=True)))
    colors = method_colors(names_in(trials, "method"))
    with figure_style():
        figure = new_figure(1.0 + 1.3 * ROW * len(pairs))
        panels = figure.subplots(1, len(measures), sharey=True, squeeze=False)[0]
        names = [f"{format_name(method)} − {format_name(versus)}" for method, versus in pairs]
        width = panel_width(names, len(measures))
        for axes, column in zip(panels, measures, strict=True):
            _draw_pairs(axes, table[table["measure"] == column], pairs, colors)
            measure = MEASURES[column]
            what = f"{measure.label}, distance from 1" if is_ratio(measure) else measure.label
            axes.set_title(",\n".join(fold(part, width) for part in what.split(", ")))
            unit = f" ({measure.unit})" if measure.unit else ""
            axes.set_xlabel(f"difference{unit}")
        panels[0].set_yticks(range(len(pairs)), names)
        panels[0].set_ylim(len(pairs) - 0.5, -0.75)
        figure.supxlabel(
            "Percentages: trials won by the method named first. "
            + (
                f"Filled: p < {SIGNIFICANT} (approximate), corrected."
                if table["low"].notna().any()
                else f"No intervals: {TOO_FEW}."
            ),
            fontsize=SMALL,
            color=QUIET,
        )
    return figure


def _draw_shares(axes: Axes, values: FloatArray, color: str) -> None:
    ordered = np.sort(values)
    axes.step(
        np.concatenate([[0.0], ordered]), np.linspace(0.0, 1.0, len(ordered) + 1), where="post", color=color
    )


def _draw_cloud(axes: Axes, values: FloatArray, row: int, color: str) -> None:
    """Draw the density above the row's line, the quartiles on it, and the trials below it."""
    if not values.size:
        return
    if np.ptp(values) > 1e-9 * np.abs(values).max():  # else there is no density to speak of
        places = np.linspace(values.min(), values.max(), 200)
        density = gaussian_kde(values)(places)
        axes.fill_between(
            places,
            row - 0.08 - 0.42 * density / density.max(),
            row - 0.08,
            color=color,
            alpha=0.45,
            linewidth=0,
        )
    first, middle, third = np.quantile(values, [0.25, 0.5, 0.75])
    axes.plot([first, third], [row, row], color=color, linewidth=2.4, solid_capstyle="butt", zorder=3)
    axes.plot(middle, row, "o", color="white", markeredgecolor=color, markersize=4.5, zorder=4)
    axes.plot(
        values,
        row + 0.22 + jitter(len(values), 0.11),
        ".",
        color=color,
        markersize=2.0,
        alpha=0.35,
        markeredgewidth=0,
    )


def _draw_pairs(
    axes: Axes, table: pd.DataFrame, pairs: Sequence[tuple[str, str]], colors: Mapping[str, str]
) -> None:
    axes.axvline(0.0, color=QUIET, linewidth=0.7)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.margins(x=0.14)  # room for the shares beside the outermost dots
    for row in table.itertuples():
        place, color = pairs.index((row.method, row.versus)), colors[row.versus]
        axes.plot([row.low, row.high], [place, place], color=color, linewidth=1.4, zorder=2)
        sure = row.p_holm < SIGNIFICANT  # not if NaN
        axes.plot(
            row.difference,
            place,
            "o",
            color=color if sure else "white",
            markeredgecolor=color,
            markersize=4.5,
            zorder=3,
        )
        axes.annotate(
            f"{100 * row.won:.0f} %",
            (row.difference, place),
            xytext=(0, 3.5),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=SMALL - 1,
            color=QUIET,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
        )

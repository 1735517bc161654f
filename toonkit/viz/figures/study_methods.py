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
from toonkit.study.reporting.cells import cells, names_in
from toonkit.study.reporting.comparisons import COMPARED, comparisons
from toonkit.study.reporting.statistics import TOO_FEW, is_ratio, method_means
from toonkit.viz.figures.study_style import (
    ROW,
    axis_label,
    dot,
    guide,
    method_colors,
    method_label,
    method_legend,
    panel_width,
    spread,
)
from toonkit.viz.figures.style import INK, QUIET, SMALL, figure_style, fold, new_figure

RESPONSE_LIMIT = 1.6
"""End of the axis of responses; the few beyond are counted in the figure."""

SIGNIFICANT = 0.05

FEW_SWEEPS = 20
SWEEP_TICKS = (0, 20, 100, 1000, 10_000)
"""Where the axis of sweeps turns from linear to logarithmic, and its labels."""


def error_distributions(
    trials: pd.DataFrame, measures: Sequence[str] = ("angular_error", "relight_rmse")
) -> Figure:
    """
    Draw how the errors of all trials are distributed.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.
    measures : sequence of str, optional
        Keys of `MEASURES`; each has a column of two panels: the share of trials below an error, and for every method the
        density, the quartiles with the median, and the trials.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page.
    """
    tables = {column: cells(trials, column) for column in measures}
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
            guide(above, "both")
            guide(below, "x")
            below.set_xlabel(MEASURES[column].axis)
            below.set_xlim(left=0)
            below.tick_params(axis="y", length=0)
            below.spines["left"].set_visible(False)
        panels[0, 0].set_ylabel("share of trials below")
        panels[1, 0].set_yticks(range(len(methods)), [method_label(method) for method in methods])
        panels[1, 0].set_ylim(len(methods) - 0.55, -0.6)
        method_legend(figure, methods, colors)
    return figure


def fit_against_response(trials: pd.DataFrame) -> Figure:
    """
    Draw the paper's trade-off: how well a method repeats its input, and how much it answers a new light.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.

    Returns
    -------
    matplotlib.figure.Figure
        A dot for each trial; a large one for each method's center, with 95 % intervals along both axes.
    """
    fit, response = cells(trials, "input_rmse"), cells(trials, "relight_response")
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
    Draw the differences between pairs of methods, with their intervals.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.
    measures : sequence of str, optional
        Keys of `MEASURES`; each has a panel.

    Returns
    -------
    matplotlib.figure.Figure
        A row for each pair, with the share of trials that its first method wins. A dot is filled if p is small, after
        correction for the number of all comparisons. Of too few shapes or color maps there is neither p nor interval.
    """
    table = comparisons(trials, measures=measures)
    pairs = list(dict.fromkeys(zip(table["method"], table["versus"], strict=True)))
    colors = method_colors(names_in(trials, "method"))
    with figure_style():
        figure = new_figure(1.0 + 1.3 * ROW * len(pairs))
        panels = figure.subplots(1, len(measures), sharey=True, squeeze=False)[0]
        names = [f"{method_label(method)} − {method_label(versus)}" for method, versus in pairs]
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


def sweeps_figure(sweeps: pd.DataFrame, *, method: str = "todo") -> Figure:
    """
    Draw what more sweeps of the refinement would have bought.

    Parameters
    ----------
    sweeps : DataFrame
        Columns `sweeps`, `angular_error`, `relight_rmse`, `input_rmse` and `energy`; rows of equal sweeps are averaged,
        and those of infinitely many are drawn as a level: what the minimum of Eq. 5 is worth.
    method : str, optional
        Whose sweeps they are.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each of the four.
    """
    shown = ("angular_error", "relight_rmse", "input_rmse", "energy")
    means = sweeps.groupby("sweeps")[list(shown)].mean()
    least = means[np.isinf(means.index)]
    means = means.drop(least.index)
    color = method_colors([method])[method]
    ticks = [tick for tick in SWEEP_TICKS if means.index.min() <= tick <= means.index.max()]
    with figure_style():
        figure = new_figure(1.9, gap=0.05)
        for axes, column in zip(figure.subplots(1, len(shown)), shown, strict=True):
            axes.plot(means.index, means[column], color=color, linewidth=1.0)
            dot(axes, means.index, means[column], color)
            # No sweep at all has a place too: left of this many, the axis is linear.
            axes.set_xscale("symlog", linthresh=FEW_SWEEPS, linscale=0.6)
            axes.set_xticks(ticks, [f"{tick:,}" for tick in ticks], minor=False)
            axes.set_xticks([], minor=True)
            axes.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
            axes.set_xlim(means.index.min(), means.index.max())
            axes.set_ylim(0, 1.08 * float(max(means[column].max(), *least[column])))
            for level in least[column]:
                axes.axhline(level, color=color, linewidth=1.0, linestyle=":")
                if column == shown[0]:
                    axes.annotate(
                        "at the minimum of Eq. 5",
                        (means.index.max(), level),
                        xytext=(-4, -3),
                        textcoords="offset points",
                        ha="right",
                        va="top",
                        fontsize="small",
                        color=color,
                    )
            axes.set_xlabel("sweeps")
            axes.set_title(axis_label(column) if column in MEASURES else "energy of Eq. 5")
            guide(axes, "y")
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
        row + 0.22 + spread(len(values), 0.11),
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

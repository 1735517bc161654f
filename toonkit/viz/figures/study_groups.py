"""Summary figures of a study by its shapes and its color maps (Sections 4.2 and 4.3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.image import AxesImage

from toonkit._validation import FloatArray
from toonkit.study.color_maps import Ramp, load_ramps
from toonkit.study.reporting.measure_table import MeasureTable, arrange
from toonkit.study.reporting.statistics import Grouping, breakdown, is_ratio
from toonkit.viz.figures.ramp import draw_ramp
from toonkit.viz.figures.study_style import (
    ROW,
    axis_label,
    draw_dots,
    draw_grid,
    format_name,
    method_colors,
    method_legend,
    separate,
)
from toonkit.viz.figures.style import QUIET, SMALL, figure_style, fold, new_figure

BEYOND = 0.98
"""Share of the differences that the color bar covers; the rest have the color of its ends."""

BAR_LENGTH = 1.6
"""Inches along the color bar of the smallest map of differences, and so for its label."""


def errors_by_group(
    trials: pd.DataFrame, by: Grouping, measures: Sequence[str] = ("angular_error", "relight_rmse")
) -> Figure:
    """
    Draw the mean of every method for every shape, or for every color map beside its ramp; a panel for each measure.

    Rows are sorted by the first measure's mean over the methods.
    """
    tables = {column: breakdown(trials, column, by).drop(columns="trials") for column in measures}
    first = tables[measures[0]]
    palette = method_colors(first.columns)
    names = list(first.mean(axis=1).sort_values(ascending=False, kind="stable").index)
    ramps = load_ramps() if by == "color_map" else {}
    with figure_style():
        figure = new_figure(0.75 + ROW * len(names))
        beside = 0.17 if ramps else 0.001
        grid = GridSpec(1, 1 + len(measures), figure, width_ratios=[beside, *[1.0] * len(measures)])
        label = figure.add_subplot(grid[0, 0])
        _draw_names(label, names, ramps)
        for place, (column, table) in enumerate(tables.items(), start=1):
            axes = figure.add_subplot(grid[0, place], sharey=label)
            _draw_dots(axes, table.loc[names], palette)
            axes.set_xlabel(axis_label(column))
            axes.tick_params(axis="y", left=False, labelleft=False)
        label.set_ylim(-0.6, len(names) - 0.4)
        method_legend(figure, first.columns, palette)
    return figure


def difference_map(
    trials: pd.DataFrame, measure: str = "angular_error", *, method: str = "toonkit", versus: str = "todo"
) -> Figure:
    """
    Draw a method's difference to another on every shape and color map, with the means of rows and columns.

    A measure whose ideal is 1 is compared by its distance from 1. A cross marks where one of them has no result.
    """
    table = arrange(trials, measure).departures
    difference = table.of(method) - table.of(versus)
    rows, columns = _rank(difference, axis=1), _rank(difference, axis=0)
    values = difference[np.ix_(rows, columns)]
    limit = float(np.nanquantile(np.abs(values), BEYOND)) if np.isfinite(values).any() else 1.0
    norm = TwoSlopeNorm(0.0, -(limit or 1.0), limit or 1.0)
    palette = method_colors(table.methods)
    colors = LinearSegmentedColormap.from_list("difference", [palette[method], "#f7f6f3", palette[versus]])
    with figure_style():
        figure = new_figure(max(1.6 + 0.205 * len(table.shapes), 3.2))
        grid = GridSpec(
            3,
            3,
            figure,
            width_ratios=[len(columns), 1.0, 0.55],
            height_ratios=[len(rows), 1.0, 1.1],
        )
        main, right, below = (figure.add_subplot(grid[place]) for place in ((0, 0), (0, 1), (1, 0)))
        middle = np.nanmedian if is_ratio(table.measure) else np.nanmean
        for axes, block in (
            (main, values),
            (right, _collapse(values, 1, middle)),
            (below, _collapse(values, 0, middle)),
        ):
            picture = _draw_block(axes, block, colors, norm)
        main.set_yticks(range(len(rows)), [format_name(table.shapes[row]) for row in rows])
        word = "median" if is_ratio(table.measure) else "mean"
        right.set_title(word, fontsize=SMALL)
        below.set_yticks([0], [word])
        _draw_ramps_below(figure, grid, [table.color_maps[column] for column in columns])
        bar = figure.colorbar(picture, cax=figure.add_subplot(grid[:2, 2]), extend="both", extendfrac=0.03)
        _label_bar(bar, table, method, versus, palette)
    return figure


def error_by_tones(trials: pd.DataFrame, measure: str = "angular_error") -> Figure:
    """Draw an error against the number of tones of hard color maps, and against how soft steps are; a dot is a color map."""
    means = breakdown(trials, measure, "color_map").drop(columns="trials")
    palette = method_colors(means.columns)
    ramps = {name: ramp for name, ramp in load_ramps().items() if name in means.index}
    hard = [name for name, ramp in ramps.items() if "hard" in ramp.tags]
    tones = np.array([len(ramps[name].tones) for name in hard])
    # Most widths are small, and 0 is one of them: their roots are evenly spread.
    widths = np.sqrt([ramp.softness for ramp in ramps.values()])
    with figure_style():
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=[1, 1.25])
        for method in means.columns:
            color, values = palette[method], means[method]
            counts = np.unique(tones)
            middles = [
                values[[name for name in hard if len(ramps[name].tones) == count]].mean() for count in counts
            ]
            left.plot(counts, middles, color=color, linewidth=1.0)
            draw_dots(left, separate(tones, 0.07), values[hard], color)
            draw_dots(right, widths, values[list(ramps)], color)
        left.set(xlabel="tones of a hard color map", ylabel=axis_label(measure), xticks=np.unique(tones))
        right.set_xlabel("mean width of the steps between tones,\nin L · N (square-root scale)")
        right.set_xticks(np.sqrt(_WIDTHS), [f"{width:g}" for width in _WIDTHS])
        left.set_ylim(bottom=0)
        draw_grid(left, "y")
        draw_grid(right, "y")
        _name_worst(right, means.loc[list(ramps)], widths)
        method_legend(figure, means.columns, palette)
    return figure


_WIDTHS = (0.0, 0.05, 0.2, 0.5, 1.0, 2.0)


def _name_worst(axes: Axes, means: pd.DataFrame, places: FloatArray) -> None:
    worst = means.max(axis=1).to_numpy()
    if np.isfinite(worst).any():
        row = int(np.nanargmax(worst))
        axes.annotate(
            format_name(means.index[row]),
            (places[row], worst[row]),
            xytext=(5, 0),
            textcoords="offset points",
            va="center",
            fontsize=SMALL,
            color=QUIET,
        )


def _draw_names(axes: Axes, names: Sequence[str], ramps: dict[str, Ramp]) -> None:
    """Name the rows, each beside its ramp if it has one."""
    for row, name in enumerate(names):
        if name in ramps:
            strip = axes.inset_axes((0.0, row - 0.3, 1.0, 0.6), transform=axes.transData)
            draw_ramp(strip, ramps[name].color_map())
            strip.set_xticks([])
    axes.set(xlim=(0, 1), xticks=[])
    axes.set_yticks(range(len(names)), [format_name(name) for name in names])
    axes.tick_params(axis="y", length=0)
    axes.spines[:].set_visible(False)


def _draw_dots(axes: Axes, table: pd.DataFrame, palette: Mapping[str, str]) -> None:
    rows = np.arange(len(table))
    axes.hlines(rows, table.min(axis=1), table.max(axis=1), color="#c4c3be", linewidth=0.6, zorder=1)
    for method in reversed(table.columns):  # the first lies on top
        draw_dots(axes, table[method].to_numpy(), rows, palette[method])
    axes.set_xlim(left=0)
    draw_grid(axes, "x")
    axes.spines["left"].set_visible(False)


def _draw_block(
    axes: Axes, block: FloatArray, colors: LinearSegmentedColormap, norm: TwoSlopeNorm
) -> AxesImage:
    picture = axes.imshow(block, cmap=colors, norm=norm, aspect="auto", interpolation="nearest")
    row, column = np.nonzero(~np.isfinite(block))
    axes.plot(column, row, "x", color=QUIET, markersize=3.5, markeredgewidth=0.7)
    axes.set(xticks=[], yticks=[])
    axes.set_xticks(np.arange(1, block.shape[1]) - 0.5, minor=True)
    axes.set_yticks(np.arange(1, block.shape[0]) - 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=0.6)
    axes.tick_params(which="both", length=0)
    axes.spines[:].set_visible(False)
    return picture


def _draw_ramps_below(figure: Figure, grid: GridSpec, names: Sequence[str]) -> None:
    """Stand each column on its color map, dark below, and name it."""
    axes = figure.add_subplot(grid[2, 0])
    axes.set(xlim=(-0.5, len(names) - 0.5), ylim=(0, 1), yticks=[])
    axes.set_xticks(range(len(names)), [format_name(name) for name in names], rotation=90)
    axes.tick_params(axis="x", length=0)
    axes.spines[:].set_visible(False)
    ramps = load_ramps()
    for column, name in enumerate(names):
        if name in ramps:
            strip = axes.inset_axes((column - 0.36, 0.0, 0.72, 1.0), transform=axes.transData)
            draw_ramp(strip, ramps[name].color_map(), upright=True)
            strip.set_yticks([])


def _label_bar(
    bar: Colorbar, table: MeasureTable, method: str, versus: str, palette: Mapping[str, str]
) -> None:
    measure = table.measure
    what = f"distance of the {measure.label} from 1" if is_ratio(measure) else measure.axis
    bar.set_label(f"{fold(what, BAR_LENGTH)}\n{format_name(method)} − {format_name(versus)}")
    bar.outline.set_visible(False)
    for place, name in ((-0.05, method), (1.05, versus)):
        text = bar.ax.text(
            0.5,
            place,
            format_name(name).replace(" & ", " &\n") + "\nbetter",
            transform=bar.ax.transAxes,
            ha="center",
            va="top" if place < 0 else "bottom",
            color=palette[name],
            fontsize=SMALL,
        )
        text.set_in_layout(place > 0)  # below, there is room beside the row of means


def _rank(difference: FloatArray, axis: int) -> list[int]:
    """Order rows or columns by their mean, those without any last."""
    means = _collapse(difference, axis, np.nanmean).ravel()
    return [int(place) for place in np.argsort(np.where(np.isfinite(means), means, np.inf), kind="stable")]


def _collapse(values: FloatArray, axis: int, middle: Callable[..., FloatArray]) -> FloatArray:
    """Take the middle along an axis, which stays as one of length 1; NaN where there is nothing."""
    there = np.isfinite(values).any(axis=axis, keepdims=True)
    return np.where(there, middle(np.where(there, values, 0.0), axis=axis, keepdims=True), np.nan)

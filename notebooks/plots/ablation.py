"""What each part of our method buys: figures and a table of `benchmarks/ablation.py`, and the steps of one example."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray, as_light, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.metrics import angular_error, color_rmse
from toonkit.relighting import relight
from toonkit.study.measures import MEASURES, Measure
from toonkit.study.reporting.measure_table import arrange
from toonkit.study.reporting.statistics import TOO_FEW, Interval, contrast, resample
from toonkit.study.reporting.tables import heading
from toonkit.viz.figures.study_style import ROW, draw_grid, format_name, panel_width
from toonkit.viz.figures.style import METHOD_COLORS, PAGE_WIDTH, QUIET, SMALL, figure_style, fold, new_figure

from .panels import (
    angles_text,
    bare,
    caption,
    draw_light,
    draw_normal_map,
    draw_picture,
    draw_values,
    error_scale,
    fill,
    proportion,
)
from .paper_results import Comparison

ORACLES = ("toonkit with the true color map",)
"""Variants that are told what no method can know: drawn hollow."""

COMPARED = ("angular_error", "relight_rmse")
"""Measures in which variants are compared trial by trial."""


class Entry(NamedTuple):
    """
    A variant's mean, and its difference from another variant on the same pictures.

    Attributes
    ----------
    mean : float
        Over all pictures.
    difference : Interval or None
        None from itself.
    """

    mean: float
    difference: Interval | None


def draw_ablation(
    table: pd.DataFrame,
    measures: Sequence[str] = COMPARED,
    *,
    versus: str = "todo",
) -> Figure:
    """
    Draw how much better or worse every variant of a method is than one of them, on the same pictures.

    Parameters
    ----------
    table : DataFrame
        Of `benchmarks/ablation.py`: a row for each `variant`, `shape` and `color_map`, with the measures.
    measures : sequence of str, optional
        Keys of `MEASURES`; each has a panel.
    versus : str, optional
        The variant that the others are compared with.

    Returns
    -------
    matplotlib.figure.Figure
        A row for each variant, in the order of the table: the mean difference with its 95 % interval, of a bootstrap over
        shapes and color maps, and at the right the variant's own mean.

    Raises
    ------
    ToonkitError
        If the table does not hold the variant that is compared with, or one of the measures is unknown.
    """
    names = _variants(table, versus)
    found: dict[str, dict[str, Entry]] = {}
    with figure_style():
        figure = new_figure(0.75 + 1.15 * ROW * len(names), gap=0.03)
        panels = figure.subplots(1, len(measures), sharey=True, squeeze=False)[0]
        labels = [format_name(name) for name in names]
        width = panel_width(labels, len(measures))
        for axes, column in zip(panels, measures, strict=True):
            measure = MEASURES[column]
            found[column] = _differences(table, column, versus)
            _draw_differences(axes, found[column], measure)
            axes.set_title(measure.label)
            unit = f" ({measure.unit})" if measure.unit else ""
            axes.set_xlabel(fold(f"difference from {format_name(versus)}{unit}", width))
        panels[0].set_yticks(range(len(names)), labels)
        panels[0].set_ylim(len(names) - 0.5, -0.6)
        figure.supxlabel(fold(_legend(names, found), PAGE_WIDTH, size=SMALL), fontsize=SMALL, color=QUIET)
    return figure


def ablation_table(table: pd.DataFrame, *, versus: str = "toonkit") -> pd.DataFrame:
    """
    Return every variant's means, and its differences from one of them on the same pictures, as text.

    Parameters
    ----------
    table : DataFrame
        As in `draw_ablation`.
    versus : str, optional
        The variant that the others are compared with.

    Returns
    -------
    DataFrame of str
        A row for each variant; differences with their 95 % intervals, positive where the variant is worse.

    Raises
    ------
    ToonkitError
        If the table does not hold that variant.
    """
    _variants(table, versus)
    shown: dict[str, dict[str, str]] = {}
    for column in ("angular_error", "relight_rmse", "input_rmse", "seconds"):
        found = _differences(table, column, versus)
        measure = MEASURES[column]
        shown[heading(column)] = {name: measure.shown(one.mean) for name, one in found.items()}
        if column in COMPARED:
            shown[f"{measure.label.partition(',')[0]}, from {format_name(versus)}"] = {
                name: "" if one.difference is None else one.difference.shown(measure, sign=True)
                for name, one in found.items()
            }
    return pd.DataFrame(shown).rename(index=format_name)


def draw_stages(comparison: Comparison, new_light: ArrayLike, *, limit: float = 60.0) -> Figure:
    """
    Draw normals on their way from the first step to the last, beside the truth.

    Parameters
    ----------
    comparison : Comparison
        The shape, and one analysis for each stage, with the stage's name for its method.
    new_light : array_like, shape (3,)
        The light under which all are relit, each by its own color map.
    limit : float, optional
        Degrees at the end of the color bar.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page: a column for what is given, each stage, and the truth; normals, their error, and the relit
        picture.

    Raises
    ------
    ToonkitError
        If the light is refused.
    """
    light, scale = as_light("new_light", new_light), error_scale(limit)
    ratio, columns = proportion(comparison.image), len(comparison.analyses) + 2
    with figure_style():
        figure = new_figure(3 * ((PAGE_WIDTH - 0.3) / columns * ratio + 0.2) + 0.2)
        panels = figure.subplots(3, columns, squeeze=False)
        given, *stages, truth = panels.T
        _draw_given(given, comparison, light)
        for column, analysis in zip(stages, comparison.analyses, strict=True):
            _draw_stage(column, analysis, comparison, light, scale)
        truth[0].set_title("truth")
        draw_normal_map(truth[0], comparison.truth.normals, alpha=comparison.image.alpha)
        draw_picture(truth[2], comparison.relit_truth(light))
        for axes in panels.flat:
            fill(axes, ratio)
        bare(truth[1])
        figure.colorbar(
            scale, cax=truth[1].inset_axes((0.1, 0.08, 0.09, 0.84)), extend="max", label="error (degrees)"
        )
    return figure


def _draw_given(column: NDArray[np.object_], comparison: Comparison, new_light: FloatArray) -> None:
    """Draw the picture, its light, and the light under which it is shown anew."""
    column[0].set_title("input")
    draw_picture(column[0], comparison.image)
    for axes, light, name in (
        (column[1], comparison.light, "its light"),
        (column[2], new_light, "new light"),
    ):
        draw_light(axes, light, comparison.color_map)
        caption(axes, f"{name}: {angles_text(light)}")


def _draw_stage(
    column: NDArray[np.object_],
    analysis: ToonAnalysis,
    comparison: Comparison,
    new_light: FloatArray,
    scale: ScalarMappable,
) -> None:
    wrong = angular_error(analysis.normals, comparison.truth.normals)
    relit = relight(analysis, new_light, keep_detail=False)
    column[0].set_title(analysis.method)
    draw_normal_map(column[0], analysis.normals, alpha=comparison.image.alpha)
    draw_values(column[1], wrong.map, scale, alpha=comparison.image.alpha)
    caption(column[1], f"mean {wrong.mean:.1f}°")
    draw_picture(column[2], relit)
    caption(column[2], f"RMSE {color_rmse(relit, comparison.relit_truth(new_light)):.3f}")


def _variants(table: pd.DataFrame, versus: str) -> list[str]:
    """Return the names of all variants in the order of the table."""
    names = list(dict.fromkeys(map(str, table["variant"])))
    if versus not in names:
        raise refuse("versus", f"must be one of {', '.join(names)}", repr(versus))
    return names


def _differences(table: pd.DataFrame, column: str, versus: str) -> dict[str, Entry]:
    """Return every variant's mean, and its difference from one of them: none from itself."""
    found = arrange(table.rename(columns={"variant": "method"}).assign(error=""), column)
    draws = resample(found)
    return {
        name: Entry(
            float(np.nanmean(found.shared(name))),
            contrast(found, {name: 1.0, versus: -1.0}, draws) if name != versus else None,
        )
        for name in _variants(table, versus)
    }


def _draw_differences(axes: Axes, found: Mapping[str, Entry], measure: Measure) -> None:
    axes.axvline(0.0, color=QUIET, linewidth=0.7)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    draw_grid(axes, "x")
    whole = found.get("toonkit")
    if whole is not None and whole.difference is not None:
        axes.axvline(
            whole.difference.center, color=METHOD_COLORS["toonkit"], linewidth=0.7, linestyle=(0, (4, 3))
        )
    for row, (name, (mean, difference)) in enumerate(found.items()):
        color = METHOD_COLORS.get(name, QUIET)
        center = 0.0 if difference is None else difference.center
        if difference is not None:
            axes.plot([difference.low, difference.high], [row, row], color=color, linewidth=1.6, zorder=2)
        axes.plot(
            center,
            row,
            "o",
            color="white" if name in ORACLES else color,
            markeredgecolor=color,
            markersize=5.0,
            zorder=3,
        )
        axes.annotate(
            measure.shown(mean),
            (1.02, row),
            xycoords=("axes fraction", "data"),
            va="center",
            fontsize=SMALL,
            color=METHOD_COLORS.get(name, "black"),
        )


def _legend(names: Sequence[str], found: Mapping[str, Mapping[str, Entry]]) -> str:
    text = "Left of 0 is better. At the right, each variant's own mean."
    if set(ORACLES) & set(names):
        text += " Hollow: told what no method can know."
    differences = [
        one.difference for of in found.values() for one in of.values() if one.difference is not None
    ]
    if not any(np.isfinite(difference.low) for difference in differences):
        text += f" No intervals: {TOO_FEW}."
    return text

"""What the summary figures of a study share: colors and names of methods, dots, legends, and labels of measures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray
from toonkit.study.measures import MEASURES
from toonkit.study.reporting.statistics import is_ratio
from toonkit.viz.figures.style import METHOD_COLORS, METHOD_LABELS, PAD, PAGE_WIDTH, SMALL, text_width

PALE = "#e4e3df"
"""Grids."""

ROW = 0.19
"""Inches for a row of names in `SMALL` type."""

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
"""Its multiples fill an interval evenly."""


SPARE_COLORS = ("#a60014", "#1000cc", "#331a1d")
"""Colors of newcomers, in order: any two of these and of the house's stay apart for color-blind readers."""


def method_colors(methods: Sequence[str]) -> dict[str, str]:
    """
    Return the color of every method of a table, in the table's order: the same in every figure of the table.

    Newcomers have the spare colors, from the first again if these run out.
    """
    colors = {name: METHOD_COLORS[name] for name in methods if name in METHOD_COLORS}
    newcomers = [name for name in methods if name not in METHOD_COLORS]
    return colors | {name: SPARE_COLORS[place % len(SPARE_COLORS)] for place, name in enumerate(newcomers)}


def method_legend(figure: Figure, methods: Iterable[str], colors: Mapping[str, str]) -> None:
    """Name the colors of methods above all panels."""
    handles = [
        Line2D(
            [],
            [],
            marker="o",
            linestyle="",
            markersize=4.5,
            color=colors[name],
            label=format_name(name),
        )
        for name in methods
    ]
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=min(len(handles), int(figure.get_figwidth())),  # a long name takes an inch
        handletextpad=0.2,
        columnspacing=1.6,
    )


def panel_width(names: Iterable[str], count: int) -> float:
    """Return inches across each of `count` panels side by side on a page, beside the names of their rows."""
    beside = max(text_width(name, SMALL) for name in names)
    return (PAGE_WIDTH - beside) / count - 2 * PAD


def draw_grid(axes: Axes, axis: Literal["x", "y", "both"]) -> None:
    """Draw a grid below everything else."""
    axes.set_axisbelow(True)
    axes.grid(axis=axis, color=PALE, linewidth=0.5)


def draw_dots(axes: Axes, x: ArrayLike, y: ArrayLike, color: str, *, size: float = 4.2) -> None:
    """Draw dots that stay apart where they overlap."""
    axes.plot(
        np.asarray(x),
        np.asarray(y),
        linestyle="",
        marker="o",
        markersize=size,
        color=color,
        markeredgecolor="white",
        markeredgewidth=0.4,
        zorder=3,
    )


def jitter(count: int, width: float) -> FloatArray:
    """Return deterministic jitter in [-width, width]."""
    return np.asarray(width * (2.0 * ((np.arange(count) * GOLDEN) % 1.0) - 1.0))


def separate(places: FloatArray, step: float) -> FloatArray:
    """Return places with those that are equal set a step apart, around where they were."""
    moved = np.asarray(places, dtype=np.float64).copy()
    for place in np.unique(places):
        same = np.flatnonzero(places == place)
        moved[same] += step * (np.arange(len(same)) - (len(same) - 1) / 2)
    return moved


def axis_label(column: str) -> str:
    """Return a measure's label and unit, and whether it stands for a median."""
    return f"{MEASURES[column].axis}, median" if is_ratio(MEASURES[column]) else MEASURES[column].axis


def format_name(name: str) -> str:
    """Return a method, shape or color map as it is written in figures and on the page."""
    return METHOD_LABELS.get(name, name.replace("_", " "))

"""What more sweeps of the paper's method are worth: a figure and a sentence for the notebook of the study."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from toonkit.study.measures import MEASURES
from toonkit.viz.figures.study_style import axis_label, draw_dots, draw_grid, method_colors
from toonkit.viz.figures.style import figure_style, new_figure

FEW_SWEEPS = 20
SWEEP_TICKS = (0, 20, 100, 1000, 10_000)
"""Where the axis of sweeps turns from linear to logarithmic, and its labels."""


def draw_sweeps(sweeps: pd.DataFrame, *, method: str = "todo") -> Figure:
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
            draw_dots(axes, means.index, means[column], color)
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
            draw_grid(axes, "y")
    return figure


def describe_sweeps(sweeps: pd.DataFrame) -> str:
    """Say how accurate the paper's method is after more sweeps, and at the minimum of its Eq. 5."""
    errors = sweeps.groupby("sweeps")["angular_error"].mean()
    start, least = errors.loc[0], errors.loc[math.inf]
    granted = errors.drop([0, math.inf])
    text = (
        f"The mean error of the normals is {start:.1f}° before the first sweep and {least:.1f}° at the minimum of Eq. 5. "
        f"It is smallest after {granted.idxmin():,.0f} sweeps, at {granted.min():.1f}°."
    )
    if least <= granted.min():
        return f"{text} At the minimum it is no larger: a lower energy means better normals."
    worth = "the method is accurate because it stops early" if least > start else "stopping early helps"
    return f"{text} A lower energy does not always mean better normals: {worth}."

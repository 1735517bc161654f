"""How well the light is found, and whether the estimate knows: a figure and a table of `benchmarks/lights.py`."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from toonkit.estimation.light_fit import CLOSE
from toonkit.study.reporting.statistics import FEWEST, LEVEL, RESAMPLES, SEED
from toonkit.viz.figures.study_style import draw_grid
from toonkit.viz.figures.style import METHOD_COLORS, QUIET, SMALL, figure_style, new_figure

PARTS = 10
"""As many pictures are taken together in each, from the least sure estimates to the surest."""

DEGREES = (0.3, 1, 3, 10, 30, 100)
"""Labels of the logarithmic axis of errors."""

LEAST_DEGREES = 0.2
"""Where that axis begins: what is smaller is drawn there."""

SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)

COLOR = METHOD_COLORS["toonkit"]


def draw_light_errors(table: pd.DataFrame, *, within: float = CLOSE) -> Figure:
    """
    Draw how far estimated lights are from the true ones, and whether the estimate knows.

    Parameters
    ----------
    table : DataFrame
        Of `benchmarks/lights.py`: a row for each picture, with `shape`, `elevation`, `error` and `confidence`.
    within : float, optional
        Degrees; a confidence is the probability of an error no larger than this.

    Returns
    -------
    matplotlib.figure.Figure
        Three panels: the error against the confidence, the error by the light's elevation, and the share of pictures
        within the bound against the confidence. Dots are medians with quartiles, or shares with 95 % intervals of a
        bootstrap over shapes; along a confidence, each of a tenth of the pictures.
    """
    parts = table.groupby(pd.qcut(table["confidence"], PARTS, duplicates="drop"), observed=True)
    with figure_style():
        figure = new_figure(2.7, gap=0.04)
        by_confidence, by_elevation, calibration = figure.subplots(1, 3, width_ratios=[1.35, 0.6, 1.1])
        by_elevation.sharey(by_confidence)
        errors = table["error"].clip(lower=LEAST_DEGREES)
        by_confidence.plot(
            table["confidence"], errors, ".", color=COLOR, markersize=2.5, alpha=0.2, markeredgewidth=0
        )
        for _, part in parts:  # from the least sure to the surest
            _draw_quartiles(by_confidence, part["confidence"].mean(), part["error"])
            _draw_share(calibration, part, within)
        groups = table.groupby("elevation")["error"]
        for place, (_, part) in enumerate(groups):
            _draw_quartiles(by_elevation, place, part)
        by_elevation.set_xticks(range(len(groups)), [f"{elevation:g}°" for elevation, _ in groups])
        by_elevation.set(xlim=(-0.6, len(groups) - 0.4), xlabel="elevation of the light")
        _finish_errors(by_confidence, by_elevation, within)
        _finish_calibration(calibration, within)
    return figure


def light_errors(table: pd.DataFrame, *, within: float = CLOSE) -> pd.DataFrame:
    """
    Summarize how far estimated lights are from the true ones.

    Parameters
    ----------
    table : DataFrame
        As in `draw_light_errors`.
    within : float, optional
        Degrees.

    Returns
    -------
    DataFrame
        A row for all pictures, for the half of them with the most confident estimates and for the rest, and for each
        elevation: how many, mean and median error in degrees, the share within the bound, and the mean confidence.
    """
    surer = table["confidence"].rank(method="first") > len(table) / 2
    parts = {"all pictures": table, "the surer half": table[surer], "the rest": table[~surer]}
    parts |= {f"elevation {elevation:g}°": part for elevation, part in table.groupby("elevation")}
    rows = {
        name: {
            "pictures": len(part),
            "mean error (°)": part["error"].mean(),
            "median error (°)": part["error"].median(),
            f"share within {within:g}°": (part["error"] <= within).mean(),
            "mean confidence": part["confidence"].mean(),
        }
        for name, part in parts.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index")


def _draw_quartiles(axes: Axes, place: float, errors: pd.Series) -> None:
    first, middle, third = errors.clip(lower=LEAST_DEGREES).quantile([0.25, 0.5, 0.75])
    axes.plot([place, place], [first, third], color=COLOR, linewidth=1.6, solid_capstyle="butt", zorder=3)
    axes.plot(place, middle, "o", color="white", markeredgecolor=COLOR, markersize=4.5, zorder=4)


def _draw_share(axes: Axes, part: pd.DataFrame, within: float) -> None:
    """Draw how many of some pictures are within the bound, against how many should be."""
    place, hits = part["confidence"].mean(), part["error"] <= within
    low, high = _interval(hits, part["shape"])
    axes.plot([place, place], [low, high], color=COLOR, linewidth=1.2, zorder=2)
    axes.plot(place, hits.mean(), "o", color=COLOR, markersize=4.0, zorder=3)


def _interval(values: pd.Series, shapes: pd.Series) -> tuple[float, float]:
    """Return the ends of the interval of a mean if shapes are drawn anew; NaN of too few shapes."""
    groups = values.groupby(shapes)
    sums, counts = groups.sum().to_numpy(), groups.count().to_numpy()
    number = len(counts)
    if number < FEWEST:
        return np.nan, np.nan
    generator = np.random.default_rng(SEED)
    drawn = generator.multinomial(number, np.full(number, 1 / number), size=RESAMPLES)
    low, high = np.quantile(drawn @ sums / (drawn @ counts), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def _finish_errors(by_confidence: Axes, by_elevation: Axes, within: float) -> None:
    by_confidence.set_yscale("log")
    by_confidence.set_yticks(DEGREES, [f"{angle:g}" for angle in DEGREES])
    by_confidence.set_yticks([], minor=True)
    by_confidence.set(xlim=(0, 1), xticks=SHARES, ylim=(LEAST_DEGREES * 0.9, 190.0))
    by_confidence.set(xlabel="confidence of the estimate", ylabel="error of the light (degrees)")
    by_confidence.set_title("error against confidence")
    by_elevation.set_title("by elevation")
    by_elevation.tick_params(axis="y", left=False, labelleft=False)
    for axes in (by_confidence, by_elevation):
        draw_grid(axes, "y")
        axes.axhline(within, color=QUIET, linewidth=0.7, linestyle=(0, (4, 3)), zorder=1)


def _finish_calibration(axes: Axes, within: float) -> None:
    axes.plot([0, 1], [0, 1], color=QUIET, linewidth=0.7, linestyle=(0, (4, 3)), zorder=1)
    axes.text(0.98, 0.03, "dashed: as sure as right", ha="right", va="bottom", color=QUIET, fontsize=SMALL)
    axes.set(xlim=(0, 1), ylim=(0, 1), xticks=SHARES, yticks=SHARES)
    axes.set(xlabel="confidence of the estimate", ylabel=f"share within {within:g}°")
    axes.set_title("calibration")
    draw_grid(axes, "both")

"""Statistics of the study's table: centers with intervals, of methods and of differences between them (Section 4).

Trials that share a shape are not independent samples, and neither are trials that share a color map. The bootstrap
therefore resamples both shapes and color maps and takes every trial of a drawn shape with a drawn color map. This is
the crossed or pigeonhole bootstrap of A. B. Owen, Annals of Applied Statistics 1(2), 2007, doi:10.1214/07-AOAS122. Its
intervals are about other shapes and color maps of the same kind. With twenty of each they are slightly too narrow: in
simulations, intervals of nominally 95 % contained the true mean 93 times in 100.

The center is the mean. A measure whose best value is 1 is a ratio to the truth, and its center is the median, which a
few trials in which the truth hardly changes cannot distort.

With too few shapes or color maps, resampling gives no meaningful interval, and none is reported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from toonkit._validation import FloatArray, refuse
from toonkit.study.measures import MEASURES, Measure
from toonkit.study.reporting.measure_table import MeasureTable, arrange, check, failed

SEED = 2016
RESAMPLES = 10_000
LEVEL = 0.95

HEADLINE = (
    *("angular_error", "illumination_error", "color_map_rmse", "input_rmse", "input_difference"),
    *("relight_rmse", "relight_response"),
)
"""The measures of the report's first table. Time is not among them, because other trials run at the same time."""

FEWEST = 5
"""Shapes, and color maps, below which there is no interval."""

TOO_FEW = "too few for an interval"

Grouping = Literal["shape", "color_map", "shape_kind"]
GROUPINGS: tuple[Grouping, ...] = ("shape", "color_map", "shape_kind")


@dataclass(frozen=True)
class Interval:
    """
    A center and its interval.

    Attributes
    ----------
    center, low, high : float
        Mean or median, and the ends of its 95 % bootstrap interval. The ends are NaN if there were too few shapes or
        color maps for them (see `enough`), and all three if there was nothing to measure.
    trials : int
        Pairs of shape and color map that it is over.
    """

    center: float
    low: float
    high: float
    trials: int

    def shown(self, measure: Measure, *, sign: bool = False) -> str:
        """Return it as text with the measure's decimals and unit; with a sign if it is a difference."""
        if not self.trials:
            return "not measured"
        form = f"{'+' if sign else ''}.{measure.decimals}f"
        unit = measure.shown(0.0).removeprefix(f"{0.0:.{measure.decimals}f}")
        ends = f"[{self.low:{form}}, {self.high:{form}}]" if np.isfinite(self.low) else f"({TOO_FEW})"
        return f"{self.center:{form}}{unit} {ends}".replace("-", "−")


@dataclass(frozen=True, eq=False)
class Resamples:
    """
    How often each shape and each color map was drawn in each resample.

    Attributes
    ----------
    shapes, color_maps : ndarray, shapes (n, shapes) and (n, color maps)
        Counts of n resamples; each row sums to the number of shapes or color maps.
    """

    shapes: FloatArray
    color_maps: FloatArray


def resample(table: MeasureTable, *, generator: np.random.Generator | None = None) -> Resamples:
    """Draw shapes and color maps with replacement; by default from `SEED`, so that all measures use the same resamples."""
    source = np.random.default_rng(SEED) if generator is None else generator
    counts = (
        source.multinomial(number, np.full(number, 1 / number), size=RESAMPLES).astype(np.float64)
        for number in (len(table.shapes), len(table.color_maps))
    )
    return Resamples(*counts)


def center(values: FloatArray, draws: Resamples, *, median: bool = False) -> Interval:
    """
    Take the center of values (shapes, color maps), NaN where there is none, with its interval if there is `enough`.

    The center is the mean, or the median.
    """
    there = np.isfinite(values)
    if not there.any():
        return Interval(np.nan, np.nan, np.nan, 0)
    observed, count = float((np.median if median else np.mean)(values[there])), int(there.sum())
    if not enough(values):
        return Interval(observed, np.nan, np.nan, count)
    drawn = (_medians if median else _means)(values, draws)
    low, high = np.nanquantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(observed, float(low), float(high), count)


def enough(values: FloatArray) -> bool:
    """Tell whether values, shape (shapes, color maps), are of at least `FEWEST` of each, holes left out."""
    there = np.isfinite(values)
    return bool(min(there.any(axis=0).sum(), there.any(axis=1).sum()) >= FEWEST)


def contrast(table: MeasureTable, weights: Mapping[str, float], draws: Resamples) -> Interval:
    """
    Return the center of a weighted sum of methods over the pairs that all of them completed.

    The weights {"todo": 1, "lumo": -1} give the difference of two methods. Of ratios the center is the median.
    """
    combined = sum((weight * table.of(method) for method, weight in weights.items()), np.zeros(1))
    return center(np.asarray(combined), draws, median=is_ratio(table.measure))


def is_ratio(measure: Measure) -> bool:
    """Tell whether a measure is a ratio to the truth, whose center is the median."""
    return measure.ideal == 1.0


def method_means(
    trials: pd.DataFrame, measures: Sequence[str] = HEADLINE, *, generator: np.random.Generator | None = None
) -> pd.DataFrame:
    """
    Take the center of every method in several measures, over the pairs that every method completed.

    Returns a row for each measure and method: `measure`, `method`, `center` with `low` and `high`, `departure` (the
    center of the distances from the ideal), `trials` (pairs) and `failed` (trials of this method that ended in an
    error).
    """
    check(trials)
    wrong = trials.loc[failed(trials), "method"].value_counts()
    draws: Resamples | None = None
    rows = []
    for column in measures:
        table = arrange(trials, column)
        draws = draws or resample(table, generator=generator)
        median = is_ratio(table.measure)
        for method in table.methods:
            found = center(table.shared(method), draws, median=median)
            away = center(table.departures.shared(method), draws, median=median)
            rows.append(
                {
                    "measure": column,
                    "method": method,
                    "center": found.center,
                    "low": found.low,
                    "high": found.high,
                    "departure": away.center,
                    "trials": found.trials,
                    "failed": int(wrong.get(method, 0)),
                }
            )
    return pd.DataFrame(rows)


def breakdown(trials: pd.DataFrame, measure: str, by: Grouping) -> pd.DataFrame:
    """
    Take the center of every method by shape, color map or kind of shape, over the pairs that every method completed.

    Returns a row for each group in the order of the study, a column for each method, and `trials`, the number of pairs.
    """
    if by not in GROUPINGS:
        raise refuse("by", f"must be one of {', '.join(GROUPINGS)}", repr(by))
    table = arrange(trials, measure)
    names = _groups(trials, table, by)
    flat = pd.DataFrame({name: table.shared(name).ravel() for name in table.methods})
    groups = flat.groupby(names.ravel(), sort=False)
    centers = groups.median() if is_ratio(MEASURES[measure]) else groups.mean()
    centers["trials"] = groups.count().max(axis=1).astype(int)
    return centers.rename_axis(by)


def _groups(trials: pd.DataFrame, table: MeasureTable, by: Grouping) -> NDArray[np.object_]:
    """Return the group of each pair, shape (shapes, color maps)."""
    size = len(table.shapes), len(table.color_maps)
    if by == "color_map":
        return np.broadcast_to(np.array(table.color_maps, dtype=object), size)
    kinds = trials.groupby("shape")["shape_kind"].first()
    names = table.shapes if by == "shape" else tuple(kinds[list(table.shapes)])
    return np.broadcast_to(np.array(names, dtype=object)[:, None], size)


def _means(values: FloatArray, draws: Resamples) -> FloatArray:
    there = np.isfinite(values)
    total = _summed(np.where(there, values, 0.0), draws)
    with np.errstate(invalid="ignore"):  # a resample of holes only has no mean
        return np.asarray(total / _summed(there.astype(np.float64), draws))


def _summed(values: FloatArray, draws: Resamples) -> FloatArray:
    """Sum over each resample."""
    return np.asarray(((draws.shapes @ values) * draws.color_maps).sum(axis=1))


def _medians(values: FloatArray, draws: Resamples) -> FloatArray:
    """Weighted medians: of the sorted values, the first that has half the weight below or at it."""
    row, column = np.nonzero(np.isfinite(values))
    order = np.argsort(values[row, column], kind="stable")
    row, column = row[order], column[order]
    ranked = values[row, column]
    weight = np.cumsum(draws.shapes[:, row] * draws.color_maps[:, column], axis=1)
    found = ranked[(weight >= weight[:, -1:] / 2).argmax(axis=1)]
    return np.where(weight[:, -1] > 0, found, np.nan)

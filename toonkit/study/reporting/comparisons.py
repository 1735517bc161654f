"""Comparisons: two methods on the same trials, and how significant the difference is (Section 4)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from toonkit._validation import FloatArray, as_array, refuse
from toonkit.study.measures import Measure
from toonkit.study.reporting.measure_table import MeasureTable, arrange, names_in
from toonkit.study.reporting.statistics import Interval, Resamples, contrast, enough, is_ratio, resample

TIE = 1e-9
"""Two values closer than this are a tie: they come from the same result, rounded."""

PAIRS = (
    *(("toonkit", other) for other in ("classical", "todo", "lumo", "lambert", "flat")),
    ("classical", "todo"),
    *(("todo", other) for other in ("lumo", "lambert")),
)
"""Method and what it is compared with, of the methods that come with toonkit."""

_KNOWN = {name for pair in PAIRS for name in pair}

COMPARED = ("angular_error", "illumination_error", "input_rmse", "relight_rmse", "relight_response")

BY_CONSTRUCTION = ("input_rmse", "input_difference", "relight_response")
"""Measures that are fixed for `flat`, whose picture is always the input."""


@dataclass(frozen=True)
class Comparison:
    """
    One method against another in one measure.

    Attributes
    ----------
    measure : Measure
        What is compared; where 1 is best, distances from 1.
    method, versus : str
        Whose difference is taken, and from whom: below 0, `method` is better.
    difference : Interval
        Center of the differences over the trials that both completed, with its crossed-bootstrap interval.
    won, lost, tied : float
        Shares of the trials that either completed. One that failed is lost to one that did not.
    p_shapes, p_color_maps : float
        Wilcoxon's signed-rank test, two-sided, over the centers of the shapes and over those of the color maps. Neither
        test alone is enough, because shapes share color maps and color maps share shapes.
    p : float
        The larger of the two; NaN if there are too few shapes or color maps for an interval. It is approximate. The
        interval of the difference is the primary evidence.
    """

    measure: Measure
    method: str
    versus: str
    difference: Interval
    won: float
    lost: float
    tied: float
    p_shapes: float
    p_color_maps: float
    p: float


def compare(
    trials: pd.DataFrame,
    method: str,
    versus: str,
    measure: str,
    *,
    generator: np.random.Generator | None = None,
) -> Comparison:
    """
    Compare two methods on the same pictures in one of `MEASURES`; p is not corrected for other comparisons.

    A measure whose ideal is 1 is compared by its distance from 1. Raises `ToonkitError` if a method is not in the table.
    """
    table = arrange(trials, measure)
    return _compare(table, method, versus, resample(table, generator=generator))


def comparisons(
    trials: pd.DataFrame,
    *,
    pairs: Sequence[tuple[str, str]] | None = None,
    measures: Sequence[str] = COMPARED,
    generator: np.random.Generator | None = None,
) -> pd.DataFrame:
    """
    Compare pairs of methods in several measures, corrected for their number.

    Returns a row for each comparison: the fields of `Comparison`, and `p_holm`. Pairs are those of `pairs_in` by
    default. Left out are pairs that are not in the table, and `flat` in measures that are fixed for it.
    """
    if pairs is None:
        pairs = pairs_in(names_in(trials, "method"))
    rows = []
    draws: Resamples | None = None
    for measure in measures:
        table = arrange(trials, measure)
        draws = draws or resample(table, generator=generator)
        for method, versus in pairs:
            chosen = measure not in BY_CONSTRUCTION or "flat" not in (method, versus)
            if {method, versus} <= set(table.methods) and chosen:
                rows.append(_row(_compare(table, method, versus, draws)))
    if not rows:
        raise refuse("trials", "must hold two methods to compare", ", ".join(names_in(trials, "method")))
    table = pd.DataFrame(rows)
    return table.assign(p_holm=holm(table["p"]))


def pairs_in(methods: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """
    Choose what is compared: `PAIRS`, and every newcomer with all others; no two methods twice.

    Examples
    --------
    >>> pairs_in(["todo", "lumo", "dome"])
    (('todo', 'lumo'), ('dome', 'todo'), ('dome', 'lumo'))
    """
    names = list(dict.fromkeys(methods))
    pairs = [pair for pair in PAIRS if set(pair) <= set(names)]
    for new in (name for name in names if name not in _KNOWN):
        pairs += [(new, other) for other in names if other != new and (other, new) not in pairs]
    return tuple(pairs)


def has_pairs(trials: pd.DataFrame) -> bool:
    """Tell whether a table holds any two methods that are compared."""
    return bool(pairs_in(names_in(trials, "method")))


def holm(p_values: ArrayLike) -> FloatArray:
    """
    Correct p-values (n,) for their number by Holm's step-down method; NaN, which is no test, stays NaN.

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03]).round(6).tolist()
    [0.03, 0.06, 0.06]
    """
    raw = as_array("p_values", p_values, (None,))
    tested = np.flatnonzero(np.isfinite(raw))
    order = tested[np.argsort(raw[tested], kind="stable")]
    corrected = np.full_like(raw, np.nan)
    factors = np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(raw[order] * factors), 1.0)
    return corrected


def signed_rank(differences: FloatArray, *, median: bool = False) -> float:
    """
    Return the two-sided p of Wilcoxon's signed-rank test of the centers of rows, shape (rows, columns), against 0.

    Centers are means, or medians. p is 1 where nothing differs, NaN where there is nothing. Rows that have columns in common
    are not independent, and p is then too small.
    """
    middle = np.median if median else np.mean
    centers = np.array([middle(row[np.isfinite(row)]) for row in differences if np.isfinite(row).any()])
    if not centers.size:
        return float("nan")
    apart = centers[np.abs(centers) > TIE]
    return float(stats.wilcoxon(apart).pvalue) if apart.size else 1.0


def _compare(table: MeasureTable, method: str, versus: str, draws: Resamples) -> Comparison:
    table = table.departures
    ours, theirs = table.of(method), table.of(versus)
    difference = ours - theirs
    entered = np.isfinite(ours) | np.isfinite(theirs)
    # A hole is worse than any number.
    margin = (
        np.where(np.isfinite(ours), ours, np.inf)[entered]
        - np.where(np.isfinite(theirs), theirs, np.inf)[entered]
    )
    outcomes = np.array([margin < -TIE, margin > TIE, np.abs(margin) <= TIE])
    won, lost, tied = outcomes.mean(axis=1).tolist() if margin.size else [np.nan] * 3
    median = is_ratio(table.measure)
    p_shapes, p_color_maps = (signed_rank(values, median=median) for values in (difference, difference.T))
    return Comparison(
        table.measure,
        method,
        versus,
        contrast(table, {method: 1.0, versus: -1.0}, draws),
        won,
        lost,
        tied,
        p_shapes,
        p_color_maps,
        max(p_shapes, p_color_maps) if enough(difference) else np.nan,
    )


def _row(comparison: Comparison) -> dict[str, str | float]:
    difference = comparison.difference
    return {
        "measure": comparison.measure.column,
        "method": comparison.method,
        "versus": comparison.versus,
        "difference": difference.center,
        "low": difference.low,
        "high": difference.high,
        "trials": difference.trials,
        "won": comparison.won,
        "lost": comparison.lost,
        "tied": comparison.tied,
        "p_shapes": comparison.p_shapes,
        "p_color_maps": comparison.p_color_maps,
        "p": comparison.p,
    }

"""Comparisons: two methods on the same trials, and how much of the difference could be chance (Section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from toonkit._validation import FloatArray, as_array, refuse
from toonkit.study.measures import Measure
from toonkit.study.reporting.cells import Cells, cells, names_in
from toonkit.study.reporting.statistics import Interval, Resamples, contrast, is_ratio, resample

TIE = 1e-9
"""Two values closer than this are a tie: they come from the same result, rounded."""

PAIRS = (
    *(("toonkit", other) for other in ("todo", "lumo", "lambert", "flat")),
    *(("todo", other) for other in ("lumo", "lambert")),
)
"""Method and what it is compared with."""

COMPARED = ("angular_error", "illumination_error", "input_rmse", "relight_rmse", "relight_response")

BY_CONSTRUCTION = ("input_rmse", "input_difference", "relight_response")
"""Measures in which `flat`, whose picture is always the input, has no choice."""


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
    p_trials : float
        Wilcoxon's signed-rank test over trials, two-sided. It takes them for independent, which they are not.
    p_shapes : float
        The same over the shapes' own centers: few and independent, hence conservative.
    """

    measure: Measure
    method: str
    versus: str
    difference: Interval
    won: float
    lost: float
    tied: float
    p_trials: float
    p_shapes: float


def compare(
    trials: pd.DataFrame,
    method: str,
    versus: str,
    measure: str,
    *,
    generator: np.random.Generator | None = None,
) -> Comparison:
    """
    Compare two methods on the same pictures.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.
    method, versus : str
        The methods.
    measure : str
        Key of `MEASURES`; one whose ideal is 1 is compared by its distance from 1.
    generator : numpy.random.Generator, optional
        As in `toonkit.study.reporting.statistics.resample`.

    Returns
    -------
    Comparison
        Not corrected for there being others.

    Raises
    ------
    ToonkitError
        If a method is not in the table, or as `toonkit.study.reporting.cells.cells` does.
    """
    table = cells(trials, measure)
    return _compared(table, method, versus, resample(table, generator=generator))


def comparisons(
    trials: pd.DataFrame,
    *,
    pairs: Sequence[tuple[str, str]] = PAIRS,
    measures: Sequence[str] = COMPARED,
    generator: np.random.Generator | None = None,
) -> pd.DataFrame:
    """
    Compare pairs of methods in several measures, corrected for their number.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.
    pairs : sequence of (str, str), optional
        Methods; a pair of which one is not in the table is left out, and so is `flat` where it has no choice.
    measures : sequence of str, optional
        Keys of `MEASURES`.
    generator : numpy.random.Generator, optional
        As in `toonkit.study.reporting.statistics.resample`.

    Returns
    -------
    DataFrame
        A row for each comparison, with the fields of `Comparison`; the interval is `difference`, `low`, `high`, `trials`.
        `p_trials_holm` and `p_shapes_holm` are corrected over all rows.
    """
    rows = []
    draws: Resamples | None = None
    for measure in measures:
        table = cells(trials, measure)
        draws = draws or resample(table, generator=generator)
        for method, versus in pairs:
            chosen = measure not in BY_CONSTRUCTION or "flat" not in (method, versus)
            if {method, versus} <= set(table.methods) and chosen:
                rows.append(_row(_compared(table, method, versus, draws)))
    if not rows:
        raise refuse("trials", "must hold two methods to compare", ", ".join(names_in(trials, "method")))
    corrected = pd.DataFrame(rows)
    for unit in ("trials", "shapes"):
        corrected[f"p_{unit}_holm"] = holm(corrected[f"p_{unit}"])
    return corrected


def has_pairs(trials: pd.DataFrame) -> bool:
    """Tell whether a table holds both methods of any of the `PAIRS`."""
    methods = set(trials["method"])
    return any(set(pair) <= methods for pair in PAIRS)


def holm(p_values: ArrayLike) -> FloatArray:
    """
    Correct p-values for their number, by Holm's step-down method.

    Parameters
    ----------
    p_values : array_like, shape (n,)
        In [0, 1]; NaN is no test, and stays NaN.

    Returns
    -------
    ndarray, shape (n,)
        The chance of any false alarm among all n tests, if one rejects whatever has no larger value.

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


def _compared(table: Cells, method: str, versus: str, draws: Resamples) -> Comparison:
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
    middle = np.median if is_ratio(table.measure) else np.mean
    by_shape = np.array([middle(row[np.isfinite(row)]) for row in difference if np.isfinite(row).any()])
    return Comparison(
        table.measure,
        method,
        versus,
        contrast(table, {method: 1.0, versus: -1.0}, draws),
        won,
        lost,
        tied,
        _signed_rank(difference[np.isfinite(difference)]),
        _signed_rank(by_shape),
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
        "p_trials": comparison.p_trials,
        "p_shapes": comparison.p_shapes,
    }


def _signed_rank(differences: FloatArray) -> float:
    """Two-sided p; 1 where nothing differs, NaN where there is nothing."""
    if not differences.size:
        return float("nan")
    apart = differences[np.abs(differences) > TIE]
    return float(stats.wilcoxon(apart).pvalue) if apart.size else 1.0

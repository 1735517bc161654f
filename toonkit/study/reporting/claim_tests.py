"""ClaimTests: tests of claims on the study's table, each with its numbers and an outcome."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pandas as pd
from scipy import stats

from toonkit._validation import BoolArray, FloatArray
from toonkit.study.color_maps import load_ramps
from toonkit.study.measures import MEASURES
from toonkit.study.reporting.measure_table import MeasureTable, arrange
from toonkit.study.reporting.statistics import (
    FEWEST,
    LEVEL,
    Interval,
    Resamples,
    center,
    contrast,
    enough,
    is_ratio,
)

Outcome = Literal["holds", "does not hold", "undecided"]

AS_THE_TRUTH = 0.1
"""Greatest distance of a response from 1 to count as the true one."""


@dataclass(frozen=True)
class Check:
    """
    A statement that follows from a claim, and whether it holds.

    Attributes
    ----------
    says : str
        The statement in words.
    numbers : str
        The numbers that were compared.
    outcome : {"holds", "does not hold", "undecided"}
        "holds" if the 95 % interval of the number lies entirely on the claimed side, "does not hold" if entirely on the
        other, else "undecided", also without an interval because of too few shapes or color maps.
    """

    says: str
    numbers: str
    outcome: Outcome

    def __str__(self) -> str:
        return f"{self.says}: {self.outcome} ({self.numbers})"


@dataclass(frozen=True, eq=False)
class ClaimTests:
    """
    Tests on a table. `run` calls one by its name; each returns a `Check`.

    Attributes
    ----------
    trials : DataFrame
        The study's table, of one light track.
    draws : Resamples
        The same for all checks.
    tables : dict
        Measures that were asked for, arranged.
    """

    trials: pd.DataFrame
    draws: Resamples
    tables: dict[str, MeasureTable] = field(default_factory=dict)

    def table(self, measure: str) -> MeasureTable:
        """Return a measure, arranged."""
        if measure not in self.tables:
            self.tables[measure] = arrange(self.trials, measure)
        return self.tables[measure]

    def run(self, test: str, **arguments: Any) -> Check:
        """Run a test by its name in `claims.json`."""
        tests: dict[str, Callable[..., Check]] = {
            "less": self.less,
            "nearer_to": self.nearer_to,
            "no_worse": self.no_worse,
            "as_the_truth": self.as_the_truth,
            "ranked": self.ranked,
        }
        return tests[test](**arguments)

    def less(self, measure: str, method: str, than: str) -> Check:
        """Check that one method has the smaller value."""
        says = f"{MEASURES[measure].label}: {method} below {than}"
        return self._contrast(says, measure, {method: 1.0, than: -1.0})

    def nearer_to(self, measure: str, method: str, good: str, poor: str) -> Check:
        """Check that a method is closer to a good one than to a poor one: below the middle between them."""
        says = f"{MEASURES[measure].label}: {method} closer to {good} than to {poor}"
        return self._contrast(says, measure, {method: 1.0, good: -0.5, poor: -0.5})

    def no_worse(self, measure: str, method: str, than: str, margin: float) -> Check:
        """Check that a method is better, or worse by less than a margin."""
        shown = MEASURES[measure].shown(margin)
        says = f"{MEASURES[measure].label}: {method} at most {shown} above {than}"
        return self._contrast(says, measure, {method: 1.0, than: -1.0}, limit=margin)

    def as_the_truth(self, measure: str, method: str) -> Check:
        """Check that a response is the truth's, give or take `AS_THE_TRUTH`."""
        says = f"{MEASURES[measure].label}: {method} within {AS_THE_TRUTH:.0%} of the truth's"
        table = self.table(measure)
        if method not in table.working:
            return Check(says, f"{method} completed no trial", "undecided")
        found = center(table.of(method), self.draws, median=is_ratio(table.measure))
        within = abs(found.low - 1) <= AS_THE_TRUTH and abs(found.high - 1) <= AS_THE_TRUTH
        outside = found.low > 1 + AS_THE_TRUTH or found.high < 1 - AS_THE_TRUTH
        outcome: Outcome = "holds" if within else "does not hold" if outside else "undecided"
        return Check(
            says,
            f"{_kind(table).removesuffix('s')} {found.shown(table.measure)}, {found.trials} trials",
            outcome,
        )

    def ranked(self, says: str, method: str, than: str, ramps: Literal["softness", "tones"]) -> Check:
        """
        Check that the excess error of a method's normals over another's falls with a property of the color maps.

        The property is the softness of a ramp, or the number of tones of a hard one. The check is of Spearman's correlation
        over color maps.
        """
        order = {
            name: ramp.softness if ramps == "softness" else float(len(ramp.tones))
            for name, ramp in load_ramps().items()
            if ramps == "softness" or "hard" in ramp.tags
        }
        table = self.table("angular_error")
        if not {method, than} <= set(table.working):
            return Check(says, "a method completed no trial", "undecided")
        chosen = np.array([name in order for name in table.color_maps])
        excess = (table.of(method) - table.of(than))[:, chosen]
        values = np.array([order[name] for name in table.color_maps if name in order])
        found = _rank_correlation(excess, values, self.draws, chosen)
        if not found.trials:
            text = f"needs {FEWEST} shapes and {FEWEST} color maps that are not alike"
            return Check(says, text, "undecided")
        numbers = f"rank correlation {found.center:+.2f} [{found.low:+.2f}, {found.high:+.2f}]".replace(
            "-", "−"
        )
        return Check(says, f"{numbers} over {len(values)} color maps", _side(found, 0.0))

    def _contrast(self, says: str, measure: str, weights: dict[str, float], limit: float = 0.0) -> Check:
        table = self.table(measure)
        absent = [method for method in weights if method not in table.working]
        if absent:
            return Check(says, f"{', '.join(absent)} completed no trial", "undecided")
        found = contrast(table, weights, self.draws)
        if not found.trials:
            return Check(says, "no trial that all of them completed", "undecided")
        both = np.isfinite(sum(table.of(method) for method in weights))
        middle = np.median if is_ratio(table.measure) else np.mean
        centers = ", ".join(
            f"{method} {table.measure.shown(float(middle(table.of(method)[both])))}" for method in weights
        )
        what = "difference" if len(weights) == 2 else "from the middle of the two"
        text = (
            f"{_kind(table)} {centers}; {what} {found.shown(table.measure, sign=True)}, {found.trials} trials"
        )
        return Check(says, text, _side(found, limit))


def _side(found: Interval, limit: float) -> Outcome:
    """Tell whether an interval lies below a limit, or wholly above what it would be if nothing differed."""
    if found.high < limit:
        return "holds"
    return "does not hold" if found.low > limit else "undecided"


def _kind(table: MeasureTable) -> str:
    return "medians" if is_ratio(table.measure) else "means"


def _rank_correlation(excess: FloatArray, order: FloatArray, draws: Resamples, chosen: BoolArray) -> Interval:
    """Spearman's correlation over color maps between a property and the mean excess over shapes, with its interval."""
    there = np.isfinite(excess)
    filled = np.where(there, excess, 0.0)
    used = there.any(axis=0)
    observed_means = filled.sum(axis=0)[used] / there.sum(axis=0)[used]
    if not enough(excess) or np.ptp(order[used]) == 0 or np.ptp(observed_means) == 0:
        return Interval(np.nan, np.nan, np.nan, 0)
    observed = float(stats.spearmanr(observed_means, order[used]).statistic)
    with np.errstate(invalid="ignore"):  # a draw without a single color map of a kind has no correlation
        means = (draws.shapes @ filled) / (draws.shapes @ there)
        weights = draws.color_maps[:, chosen] * np.isfinite(means)
        drawn = _weighted_correlation(
            stats.rankdata(np.nan_to_num(means), axis=1), stats.rankdata(order), weights
        )
    low, high = np.nanquantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(observed, float(low), float(high), int(there.sum()))


def _weighted_correlation(a: FloatArray, b: FloatArray, weights: FloatArray) -> FloatArray:
    """Correlation of the rows of `a` with `b`, each pair counted as often as it was drawn."""
    share = weights / weights.sum(axis=1, keepdims=True)
    a = a - (share * a).sum(axis=1, keepdims=True)
    b = b - (share * b).sum(axis=1, keepdims=True)
    covariance = (share * a * b).sum(axis=1)
    variances = (share * a**2).sum(axis=1) * (share * b**2).sum(axis=1)
    # Of ranks: anything this small is the rounding of 0.
    return np.asarray(covariance / np.sqrt(np.where(variances > 1e-12, variances, np.nan)))

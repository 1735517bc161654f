"""The tables of the report as text, with units and few decimals, and the best method of each column."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from toonkit.study.measures import MEASURES
from toonkit.study.reporting.cells import completeness, failed
from toonkit.study.reporting.findings import Finding
from toonkit.study.reporting.statistics import Interval, is_ratio

EXTREMES = 3
"""Best and worst groups that are named."""

UNRANKED = ("seconds",)
"""Measures without a best method: trials are timed while others run."""

IDLE = "flat"
"""The contestant that estimates nothing, and is never called the best."""


def heading(column: str) -> str:
    """Return what a measure's column is headed: label, unit if its values do not carry it, and whether it is a median."""
    measure = MEASURES[column]
    carried = measure.unit in ("°", "s")
    label = measure.label if carried else measure.axis
    return f"{label}, median" if is_ratio(measure) else label


def shown_means(means: pd.DataFrame) -> pd.DataFrame:
    """
    Show centers with their intervals.

    Parameters
    ----------
    means : DataFrame
        Of `toonkit.study.reporting.statistics.method_means`.

    Returns
    -------
    DataFrame of str
        A row for each method, a column for each measure.
    """
    columns = {}
    for column, group in means.groupby("measure", sort=False):
        columns[heading(str(column))] = {
            row.method: Interval(row.center, row.low, row.high, row.trials).shown(MEASURES[str(column)])
            for row in group.itertuples()
        }
    return pd.DataFrame(columns).rename_axis("method")


def best_methods(means: pd.DataFrame) -> dict[str, list[str]]:
    """Return for each measure's `heading` the methods closest to its ideal, as far as its decimals tell them apart."""
    rivals = means[(means["method"] != IDLE) & means["departure"].notna() & ~means["measure"].isin(UNRANKED)]
    best = {}
    for column, group in rivals.groupby("measure", sort=False):
        shown = group["departure"].round(MEASURES[str(column)].decimals)
        best[heading(str(column))] = group.loc[shown == shown.min(), "method"].tolist()
    return best


def shown_comparisons(table: pd.DataFrame) -> pd.DataFrame:
    """
    Show comparisons of pairs.

    Parameters
    ----------
    table : DataFrame
        Of `toonkit.study.reporting.comparisons.comparisons`.

    Returns
    -------
    DataFrame of str
        A row for each comparison.
    """
    return pd.DataFrame(
        [
            {
                "measure": _compared(row.measure),
                "method": row.method,
                "against": row.versus,
                "difference": Interval(row.difference, row.low, row.high, row.trials).shown(
                    MEASURES[row.measure], sign=True
                ),
                "trials won": _share(row.won),
                "tied": _share(row.tied),
                "p, corrected": _p_value(row.p_holm),
            }
            for row in table.itertuples()
        ]
    )


def shown_breakdown(groups: pd.DataFrame, column: str) -> pd.DataFrame:
    """
    Show the centers of groups.

    Parameters
    ----------
    groups : DataFrame
        Of `toonkit.study.reporting.statistics.breakdown`.
    column : str
        The measure that it is of.

    Returns
    -------
    DataFrame of str
        The same rows and columns.
    """
    measure = MEASURES[column]
    shown = groups.drop(columns="trials").map(
        lambda value: measure.shown(value) if np.isfinite(value) else "not measured"
    )
    return shown.assign(trials=groups["trials"].astype(str))


def extremes(groups: pd.DataFrame, column: str) -> pd.DataFrame:
    """
    Name each method's best and worst groups.

    Parameters
    ----------
    groups : DataFrame
        Of `toonkit.study.reporting.statistics.breakdown`.
    column : str
        The measure that it is of.

    Returns
    -------
    DataFrame of str
        A row for each method: `best` and `worst`, at most `EXTREMES` groups each, the extreme one first.
    """
    measure = MEASURES[column]
    rows = {}
    for method in groups.columns.drop("trials"):
        value = groups[method].dropna()
        if value.map(measure.shown).nunique() < 2:
            rows[method] = {"best": "alike on all", "worst": "alike on all"}
            continue
        ranked = value[(value - measure.ideal).abs().sort_values(kind="stable").index]
        count = min(EXTREMES, len(ranked) // 2) or len(ranked)
        named = [f"{name} {measure.shown(number)}" for name, number in ranked.items()]
        rows[method] = {"best": ", ".join(named[:count]), "worst": ", ".join(named[::-1][:count])}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("method")


def shown_findings(found: Sequence[Finding]) -> pd.DataFrame:
    """Show the claims with their verdicts: a row for each."""
    rows = [
        {
            "claim": finding.claim,
            "section": finding.section,
            "verdict": finding.verdict,
            "checks that hold": f"{len(finding.checks_that('holds'))} of {len(finding.checks)}",
        }
        for finding in found
    ]
    return pd.DataFrame(rows, index=pd.Index([finding.key for finding in found], name="key"))


def refinements(trials: pd.DataFrame) -> pd.DataFrame:
    """
    Tell how the methods' refinements ended.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.

    Returns
    -------
    DataFrame
        A row for each method: `completed` and `failed` trials, median and largest number of `iterations` (sweeps, or
        cycles of the multigrid), the share that `converged`, the most frequent reason why it `stopped`, and the
        `seconds` of wall time of all its analyses together, while all cores were busy.
    """
    completed = trials[~failed(trials)]
    groups = completed.groupby("method")
    counts = completeness(trials)
    table = pd.DataFrame(
        {
            "completed": counts["completed"],
            "failed": counts["failed"],
            "iterations, median": groups["iterations"].median(),
            "iterations, most": groups["iterations"].max(),
            "converged": groups["converged"].mean(),
            "stopped": groups["stopped"].agg(lambda reasons: reasons.mode().iloc[0]),
            "seconds": groups["seconds"].sum(),
        }
    )
    return table.reindex(counts.index).rename_axis("method")


def shown_refinements(table: pd.DataFrame) -> pd.DataFrame:
    """Show `refinements` as text."""
    whole = ["completed", "failed", "iterations, median", "iterations, most"]
    shown = table[whole].map(lambda value: f"{value:.0f}" if np.isfinite(value) else "none")
    shown["converged"] = table["converged"].map(_share)
    shown["usual reason to stop"] = table["stopped"].fillna("none")
    shown["wall time, all cores busy"] = table["seconds"].map(
        lambda value: f"{value:,.0f} s" if np.isfinite(value) else "none"
    )
    return shown


def _compared(column: str) -> str:
    return f"{heading(column)} of the distance from 1" if is_ratio(MEASURES[column]) else heading(column)


def _share(value: float) -> str:
    return f"{100 * value:.1f} %" if np.isfinite(value) else "none"


def _p_value(value: float) -> str:
    return "none" if not np.isfinite(value) else "< 0.001" if value < 0.001 else f"{value:.3f}"

"""The tables of the report as text, with units and few decimals, and the best method of each column."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from toonkit.study.measures import MEASURES
from toonkit.study.reporting.claims import Claim
from toonkit.study.reporting.measure_table import completeness, failed
from toonkit.study.reporting.statistics import Interval, is_ratio

EXTREMES = 3
"""Best and worst groups that are named."""

UNRANKED = ("seconds",)
"""Measures without a best method: trials are timed while others run."""

IDLE = "flat"
"""The estimator that estimates nothing, and is never called the best."""


def heading(column: str) -> str:
    """Return what a measure's column is headed: label, unit if its values do not carry it, and whether it is a median."""
    measure = MEASURES[column]
    carried = measure.unit in ("°", "s")
    label = measure.label if carried else measure.axis
    return f"{label}, median" if is_ratio(measure) else label


def show_means(means: pd.DataFrame) -> pd.DataFrame:
    """Show what `method_means` returned: a row for each method, a column for each measure, centers with their intervals."""
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


def show_comparisons(table: pd.DataFrame) -> pd.DataFrame:
    """Show what `comparisons` returned, a row for each."""
    return pd.DataFrame(
        [
            {
                "measure": _label_difference(row.measure),
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


def show_breakdown(groups: pd.DataFrame, column: str) -> pd.DataFrame:
    """Show what `breakdown` returned for a measure."""
    measure = MEASURES[column]
    shown = groups.drop(columns="trials").map(
        lambda value: measure.shown(value) if np.isfinite(value) else "not measured"
    )
    return shown.assign(trials=groups["trials"].astype(str))


def extremes(groups: pd.DataFrame, column: str) -> pd.DataFrame:
    """Name for each method the `best` and `worst` groups of a breakdown: at most `EXTREMES` each, the extreme one first."""
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


def claim_checks(claims: Sequence[Claim]) -> pd.DataFrame:
    """List all checks of all claims, a row each, with the claim's verdict."""
    return pd.DataFrame(
        [
            {
                "key": claim.key,
                "section": claim.section,
                "claim": claim.text,
                "verdict": claim.verdict,
                "check": check.says,
                "outcome": check.outcome,
                "numbers": check.numbers,
            }
            for claim in claims
            for check in claim.checks
        ]
    )


def show_claims(claims: Sequence[Claim]) -> pd.DataFrame:
    """Show the claims with their verdicts: a row for each."""
    rows = {
        claim.key: {"claim": claim.text, "section": claim.section, "verdict": claim.verdict}
        for claim in claims
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("key")


def show_checks(claims: Sequence[Claim]) -> pd.DataFrame:
    """Show the checks of all claims: a row for each, with its outcome."""
    return claim_checks(claims)[["key", "check", "outcome", "numbers"]].set_index("key")


def refinements(trials: pd.DataFrame) -> pd.DataFrame:
    """
    Tell how the methods' refinements ended, a row for each method.

    `iterations` are sweeps, or cycles of the multigrid; `stopped` is the most frequent reason; `seconds` is the wall time of
    all analyses of the method, while all cores were busy.
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


def show_refinements(table: pd.DataFrame) -> pd.DataFrame:
    """Show `refinements` as text."""
    whole = ["completed", "failed", "iterations, median", "iterations, most"]
    shown = table[whole].map(lambda value: f"{value:.0f}" if np.isfinite(value) else "none")
    shown["converged"] = table["converged"].map(_share)
    shown["usual reason to stop"] = table["stopped"].fillna("none")
    shown["wall time, all cores busy"] = table["seconds"].map(
        lambda value: f"{value:,.0f} s" if np.isfinite(value) else "none"
    )
    return shown


def _label_difference(column: str) -> str:
    return f"{heading(column)} of the distance from 1" if is_ratio(MEASURES[column]) else heading(column)


def _share(value: float) -> str:
    return f"{100 * value:.1f} %" if np.isfinite(value) else "none"


def _p_value(value: float) -> str:
    return "none" if not np.isfinite(value) else "< 0.001" if value < 0.001 else f"{value:.3f}"

"""The study's tables for notebooks: each method beside its color, the best in bold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from toonkit.study.measures import MEASURES
from toonkit.study.reporting.claims import Claim
from toonkit.study.reporting.comparisons import comparisons
from toonkit.study.reporting.measure_table import names_in
from toonkit.study.reporting.statistics import Grouping, breakdown, method_means
from toonkit.study.reporting.tables import (
    best_methods,
    extremes,
    heading,
    refinements,
    show_checks,
    show_claims,
    show_comparisons,
    show_means,
    show_refinements,
)
from toonkit.viz.figures.study_style import format_name, method_colors

VERDICT_COLORS = {"agrees": "#1a7f4b", "partly": "#9a6700", "disagrees": "#b3261e", "undecided": "#75757a"}

OUTCOME_COLORS = {"holds": "inherit", "does not hold": "#b3261e", "undecided": "#75757a"}

_LOOK: list[dict[str, Any]] = [
    {"selector": "th, td", "props": "text-align: left; padding: 0.25em 0.8em;"},
    {"selector": "th", "props": "font-weight: 600;"},
    {"selector": "td", "props": "font-variant-numeric: tabular-nums;"},
]


def means_table(trials: pd.DataFrame) -> Any:
    """Return the centers of all methods with their intervals; measures down, methods across."""
    means = method_means(trials)
    table, best = show_means(means), best_methods(means)

    def weight(row: pd.Series) -> list[str]:
        return ["font-weight: 700" if method in best.get(row.name, ()) else "" for method in row.index]

    return _styled(table.T, _methods(trials)).apply(weight, axis=1)


def comparisons_table(trials: pd.DataFrame) -> Any:
    """Return the pairs of methods with differences, shares of trials won, and corrected p-values."""
    return _styled(show_comparisons(comparisons(trials)), _methods(trials)).hide(axis="index")


def extremes_table(trials: pd.DataFrame, measure: str, by: Grouping) -> Any:
    """Return on which shapes or color maps each method is best and worst."""
    return _styled(extremes(breakdown(trials, measure, by), measure), _methods(trials))


def claims_table(claims: list[Claim]) -> Any:
    """Return the paper's claims with their verdicts, in color."""
    return _styled(show_claims(claims)).map(
        lambda verdict: f"color: {VERDICT_COLORS[verdict]}; font-weight: 700", subset=["verdict"]
    )


def checks_table(claims: list[Claim]) -> Any:
    """Return the checks of all claims with their numbers; those that do not hold in color."""
    return (
        _styled(show_checks(claims).reset_index())
        .hide(axis="index")
        .map(lambda outcome: f"color: {OUTCOME_COLORS[outcome]}", subset=["outcome"])
    )


def refinements_table(trials: pd.DataFrame) -> Any:
    """Return how the methods' refinements ended."""
    return _styled(show_refinements(refinements(trials)), _methods(trials))


def sweeps_table(sweeps: pd.DataFrame) -> Any:
    """Return what more sweeps would have bought, with few decimals; infinitely many are the minimum of Eq. 5."""
    shown = {
        heading(name) if name in MEASURES else format_name(name): [
            "at the minimum" if value == math.inf else _number(name, value) for value in sweeps[name]
        ]
        for name in sweeps.columns
    }
    return _styled(pd.DataFrame(shown)).hide(axis="index")


def _methods(trials: pd.DataFrame) -> tuple[str, ...]:
    return names_in(trials, "method")


def _styled(table: pd.DataFrame, methods: Sequence[str] = ()) -> Any:
    """Return a `Styler` in which whatever is named after a method carries its color."""
    # A name of the index would have a row of its own.
    styler = table.rename_axis(index=None, columns=None).style.set_table_styles(_LOOK)
    for axis in ("index", "columns"):
        styler = styler.map_index(_marked, axis=axis, colors=method_colors(methods))
    return styler


def _number(name: str, value: Any) -> str:
    if not isinstance(value, int | float):
        return str(value)
    if name in MEASURES:
        return MEASURES[name].shown(value)
    return f"{value:,.0f}" if abs(value) >= 1000 or float(value).is_integer() else f"{value:.4g}"


def _marked(name: object, *, colors: Mapping[str, str]) -> str:
    color = colors.get(str(name), "")
    return f"border-left: 0.5em solid {color};" if color else ""

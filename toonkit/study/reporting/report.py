"""write_report: a study in words and tables, as Markdown and CSV; its figures are drawn by `toonkit.viz`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from toonkit._validation import refuse
from toonkit.export.atomic import PathLike, atomic_write
from toonkit.export.folder import make_folder
from toonkit.study.measures import MEASURES
from toonkit.study.reporting.claims import check_claims
from toonkit.study.reporting.comparisons import comparisons, has_pairs
from toonkit.study.reporting.measure_table import failures, on_track, tracks
from toonkit.study.reporting.statistics import GROUPINGS, Grouping, breakdown, method_means
from toonkit.study.reporting.tables import claim_checks, refinements
from toonkit.study.reporting.text import report_text
from toonkit.study.table import write_csv

REPORT_NAME = "report.md"

BROKEN_DOWN = ("angular_error", "input_rmse", "relight_rmse", "relight_response")
"""Measures by shape and by color map in the CSV files."""


def write_report(
    trials: pd.DataFrame,
    provenance: Mapping[str, Any],
    folder: PathLike,
    *,
    figures: Mapping[Path, str] | None = None,
) -> dict[Path, str]:
    """
    Write a study's report and its tables into a folder.

    Parameters
    ----------
    trials : DataFrame
        The study's table. Of several light tracks, each has its table of means; the rest is about the first, the paper's.
    provenance : mapping
        The sidecar `study.json`, or whatever is known; all of it is optional.
    folder : path
        Created if need be; files of the same names are replaced, each once its successor is complete.
    figures : mapping of Path to str, optional
        Figures that the report shows, with their captions: what `toonkit.viz.figures.study.write_figures` returned for the
        same folder.

    Returns
    -------
    dict
        The files written, in order, each with what it is.

    Raises
    ------
    ToonkitError
        If the table is empty or holds a trial twice, or the folder cannot be written to.
    """
    target = make_folder(folder)
    tables = report_tables(trials)
    written = {target / REPORT_NAME: "the report"}
    text = report_text(trials, provenance, figures=_relative_addresses(figures or {}, target))
    with atomic_write(target / REPORT_NAME) as file:
        file.write(text.encode())
    for name, (what, table) in tables.items():
        written[write_csv(table, target / f"{name}.csv")] = what
    return written


def report_tables(trials: pd.DataFrame) -> dict[str, tuple[str, pd.DataFrame]]:
    """Compute the report's tables in numbers: name -> what it is, and the table with the light track in its first column."""
    if trials.empty:
        raise refuse("trials", "must hold at least one trial", "an empty table")
    parts = [(track, on_track(trials, track)) for track in tracks(trials)]
    tables = {
        "method_means": (
            "means and medians of every method, with intervals",
            [method_means(part, tuple(MEASURES)) for _, part in parts],
        ),
        "paired_comparisons": (
            "methods against each other, trial by trial",
            [comparisons(part) if has_pairs(part) else pd.DataFrame() for _, part in parts],
        ),
        **{
            f"by_{by}": (
                f"means and medians by {by.replace('_', ' ')}",
                [_break_down(part, by) for _, part in parts],
            )
            for by in GROUPINGS
        },
        "refinements": ("how the refinements ended", [refinements(part).reset_index() for _, part in parts]),
        "claims": (
            "the paper's claims, check by check",
            [claim_checks(check_claims(part)) for _, part in parts],
        ),
        "failures": ("trials that ended in an error", [failures(part) for _, part in parts]),
    }
    return {name: (what, _concatenate(parts, group)) for name, (what, group) in tables.items()}


def _break_down(trials: pd.DataFrame, by: Grouping) -> pd.DataFrame:
    parts = [breakdown(trials, column, by).reset_index().assign(measure=column) for column in BROKEN_DOWN]
    table = pd.concat(parts, ignore_index=True)
    return table[["measure", *table.columns.drop("measure")]]


def _concatenate(parts: list[tuple[Any, pd.DataFrame]], tables: list[pd.DataFrame]) -> pd.DataFrame:
    named = []
    for (track, _), table in zip(parts, tables, strict=True):
        named.append(table.drop(columns="light_track", errors="ignore"))
        named[-1].insert(0, "light_track", track)
    return pd.concat(named, ignore_index=True)


def _relative_addresses(figures: Mapping[Path, str], folder: Path) -> dict[str, str]:
    """Return the pictures that a page can show, by their address as seen from the report's folder."""
    pictures = {path: caption for path, caption in figures.items() if path.suffix == ".png"}
    return {
        (path.relative_to(folder) if path.is_relative_to(folder) else path).as_posix(): caption
        for path, caption in pictures.items()
    }

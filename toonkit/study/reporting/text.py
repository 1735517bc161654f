"""report_text: a study in words and tables, as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal

import pandas as pd

from toonkit.study.measures import MEASURES
from toonkit.study.provenance import SHOWN_DIGITS
from toonkit.study.reporting.claims import RULE, check_claims
from toonkit.study.reporting.comparisons import comparisons, has_pairs
from toonkit.study.reporting.measure_table import arrange, failures, on_track, statement, tracks
from toonkit.study.reporting.statistics import (
    GROUPINGS,
    HEADLINE,
    RESAMPLES,
    Grouping,
    breakdown,
    method_means,
)
from toonkit.study.reporting.tables import (
    best_methods,
    extremes,
    refinements,
    show_breakdown,
    show_checks,
    show_claims,
    show_comparisons,
    show_means,
    show_refinements,
)

SHOWN_BY_GROUP = ("angular_error", "relight_rmse")
"""Measures whose means by shape and by color map stand in the text."""

FREQUENT = 3
"""Errors that are named before all others."""

ERROR_LENGTH = 100
"""Characters of an error that are shown; `failures.csv` has the rest."""

TRACK_NAMES = {"given": "the true light given", "estimated": "the light estimated"}

P_VALUES = (
    "The interval is the primary evidence. p is approximate: Wilcoxon's signed-rank test is made over the shapes' own "
    "centers and over the color maps' own, and the larger p is shown, since shapes share their color maps and color maps "
    "their shapes, so that neither test alone is enough."
)
"""How p-values are reached, for readers."""

_HOW = (
    f"Brackets hold 95 % intervals of a bootstrap over shapes and color maps, both drawn anew for each of {RESAMPLES:,} "
    "resamples. **Bold** is the best of the methods that estimate something; `flat` leaves the picture as it is, so that "
    "its input error and its response are 0 by construction. The response is a ratio and its center a median; 1 is right."
)
_HOW_PAIRS = (
    "A difference below 0 means that the first method is better. Trials in which one method failed are lost to the other. "
    f"{P_VALUES} p is corrected by Holm's method for all rows of this table."
)


def report_text(
    trials: pd.DataFrame, provenance: Mapping[str, Any], *, figures: Mapping[str, str] | None = None
) -> str:
    """Write a study's report as Markdown, with figures by address and caption; see `write_report`."""
    parts = {track: on_track(trials, track) for track in tracks(trials)}
    first = next(iter(parts.values()), trials)
    claims = check_claims(first)
    sections = [
        _opening(first),
        *(_means_section(track, part) for track, part in parts.items()),
        f"## The paper's claims\n\n{_markdown(show_claims(claims))}",
        f"### Checks\n\n{_markdown(show_checks(claims))}\n\n{RULE}",
        _pairs_section(first),
        *(_breakdown_section(first, by) for by in GROUPINGS),
        _failures_section(trials),
        "## Refinements\n\n" + _markdown(show_refinements(refinements(first))),
        f"## Provenance\n\n{provenance_text(first, provenance)}",
    ]
    if figures:
        shown = (f"![{caption}]({address})\n\n*{caption}*" for address, caption in figures.items())
        sections.append("## Figures\n\n" + "\n\n".join(shown))
    return "\n\n".join(sections) + "\n"


def means_text(means: pd.DataFrame, *, row_per: Literal["measure", "method"] = "measure") -> str:
    """Write what `toonkit.study.reporting.statistics.method_means` returns as a table in Markdown, the best in bold."""
    shown = show_means(means)
    for column, methods in best_methods(means).items():
        for method in methods:
            shown.loc[method, column] = f"**{shown.loc[method, column]}**"
    # More than four measures side by side do not fit a page.
    return _markdown(shown if row_per == "method" else shown.T.rename_axis("measure"))


def _opening(trials: pd.DataFrame) -> str:
    table = arrange(trials, HEADLINE[0])
    counts = f"{len(table.shapes)} shapes x {len(table.color_maps)} color maps x {len(table.methods)} methods"
    size = int(trials["size"].iloc[0])
    return f"# Study: {counts}\n\nPictures of {size} x {size} pixels."


def _means_section(track: str, trials: pd.DataFrame) -> str:
    means = method_means(trials)
    text = f"## Methods, {TRACK_NAMES.get(track, track)}\n\n{means_text(means)}\n\n{_HOW}"
    kept = means.groupby("measure", sort=False)["trials"].first()
    fewer = kept[kept < kept.max()]
    notes = [
        f"{MEASURES[str(name)].label} over {count} of {kept.max()} pairs" for name, count in fewer.items()
    ]
    text += f"\n\n{statement(trials)}"
    return text + (f" Undefined in some, and so over fewer: {'; '.join(notes)}." if notes else "")


def _pairs_section(trials: pd.DataFrame) -> str:
    if not has_pairs(trials):
        return "## Pairs of methods\n\nThere is none to compare."
    return f"## Pairs of methods\n\n{_markdown(show_comparisons(comparisons(trials)), index=False)}\n\n{_HOW_PAIRS}"


def _breakdown_section(trials: pd.DataFrame, by: Grouping) -> str:
    parts = [f"## By {by.replace('_', ' ')}"]
    for column in SHOWN_BY_GROUP:
        groups = breakdown(trials, column, by)
        parts.append(f"### {MEASURES[column].axis}")
        parts.append(_markdown(show_breakdown(groups, column)))
        if len(groups) > 2:
            parts.append(_markdown(extremes(groups, column)))
    return "\n\n".join(parts)


def _failures_section(trials: pd.DataFrame) -> str:
    table = failures(trials)
    if table.empty:
        return "## Failures\n\nNo trial ended in an error."
    shown = table.assign(error=table["error"].map(_shortened))
    counts = shown["error"].value_counts()
    named = "\n".join(f"- {count} x {_cell(error)}" for error, count in counts.head(FREQUENT).items())
    return (
        f"## Failures\n\n{len(table)} of {len(trials)} trials ended in an error. Most frequent:\n\n{named}\n\n"
        f"{_markdown(shown, index=False)}"
    )


def _shortened(error: str) -> str:
    line = " ".join(str(error).split())
    return line if len(line) <= ERROR_LENGTH else f"{line[:ERROR_LENGTH]} …"


def provenance_text(trials: pd.DataFrame, provenance: Mapping[str, Any]) -> str:
    """Write as a table in Markdown where the numbers come from: size, lights, versions, sweeps granted, and time."""
    # What the table itself says comes first; then the sidecar, but for its long lists.
    row = trials.iloc[0]
    facts: dict[str, Any] = {
        "size": f"{int(row['size'])} pixels",
        "light": _angles((row["light_azimuth"], row["light_elevation"])),
    }
    settings = provenance.get("settings", {})
    if "new_lights" in settings:
        facts["new lights"] = "; ".join(_angles(angles) for angles in settings["new_lights"])
    granted = provenance.get("refinement_as_printed", {})
    if granted:
        facts["granted to todo and lambert"] = ", ".join(
            f"{name.replace('_', ' ')} {value}" for name, value in granted.items()
        )
    for column in ("toonkit", "python", "numpy", "scipy", "numba"):
        facts[column] = ", ".join(map(str, trials[column].unique()))
    weights = provenance.get("digests", {}).get("weights", {})
    if weights:
        facts["digests of the weights"] = ", ".join(
            f"{name} {digest[:SHOWN_DIGITS]}" for name, digest in weights.items()
        )
    for number, run in enumerate(provenance.get("runs", []), 1):
        facts[f"run {number}"] = _run_text(run)
    facts["wall time of the analyses, all cores busy"] = _duration(float(trials["seconds"].sum()))
    table = pd.DataFrame({"": facts.values()}, index=pd.Index(facts, name="what"))
    return _markdown(table)


def _run_text(run: Mapping[str, Any]) -> str:
    done = "killed" if run["seconds"] is None else f"{run['trials']:,} trials in {_duration(run['seconds'])}"
    machine, versions = run["machine"], run["versions"]
    return (
        f"{run['started']}, {done}, workers: {run['workers']}; commit {run['commit'] or 'unknown'}; "
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; "
        + ", ".join(f"{name} {value}" for name, value in versions.items())
    )


def _markdown(table: pd.DataFrame, *, index: bool = True) -> str:
    shown = table.reset_index() if index else table
    rows = [[str(name) for name in shown.columns], ["---"] * len(shown.columns)]
    rows += [[_cell(value) for value in row] for row in shown.itertuples(index=False)]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def _cell(value: Any) -> str:
    # A line break or a bar would end the cell.
    return " ".join(str(value).replace("|", "\\|").split())


def _angles(angles: Iterable[float]) -> str:
    azimuth, elevation = angles
    return f"azimuth {azimuth:g}°, elevation {elevation:g}°"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return (
        f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{seconds:.1f} s"
    )

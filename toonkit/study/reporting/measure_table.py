"""MeasureTable: the study's table as shapes x color maps for every method, with its holes (Section 4.1).

A trial that failed or was not run is a hole. Means are taken over the pairs of shape and color map without a hole in
any method, so that every method is measured on the same pictures. This module counts the pairs that are left out, and
for which method. The report prints the counts beside every mean.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from toonkit._validation import BoolArray, FloatArray, refuse
from toonkit.study.color_maps import load_ramps
from toonkit.study.estimators import list_estimators
from toonkit.study.measures import MEASURES, Measure
from toonkit.study.records import LIGHT_TRACKS, LightTrack
from toonkit.study.shapes import SHAPES

_KEYS = ["shape", "color_map", "method"]


@dataclass(frozen=True, eq=False)
class MeasureTable:
    """
    One measure of all trials.

    Attributes
    ----------
    measure : Measure
        What was measured.
    methods, shapes, color_maps : tuple of str
        Names along the three axes, in the order of `names_in`.
    values : ndarray, shape (methods, shapes, color maps)
        NaN where a trial failed or is not in the table.
    """

    measure: Measure
    methods: tuple[str, ...]
    shapes: tuple[str, ...]
    color_maps: tuple[str, ...]
    values: FloatArray

    def of(self, method: str) -> FloatArray:
        """Return a method's values, shape (shapes, color maps)."""
        return np.asarray(self.values[self._place(method)])

    @property
    def departures(self) -> MeasureTable:
        """The same as distances from the ideal of the measure, for measures whose best value is 1."""
        return replace(self, values=np.abs(self.values - self.measure.ideal))

    @property
    def working(self) -> tuple[str, ...]:
        """Methods that completed any trial."""
        return tuple(np.array(self.methods)[np.isfinite(self.values).any(axis=(1, 2))].tolist())

    @property
    def common(self) -> BoolArray:
        """Pairs that all `working` methods completed, shape (shapes, color maps); none if nothing works."""
        working = [self._place(method) for method in self.working]
        if not working:
            return np.zeros(self.values.shape[1:], dtype=np.bool_)
        return np.asarray(np.isfinite(self.values[working]).all(axis=0))

    def shared(self, method: str) -> FloatArray:
        """Return a method's values on the `common` pairs, NaN elsewhere."""
        return np.where(self.common, self.of(method), np.nan)

    def _place(self, method: str) -> int:
        if method not in self.methods:
            raise refuse("method", f"must be one of {', '.join(self.methods)}", repr(method))
        return self.methods.index(method)


def arrange(trials: pd.DataFrame, column: str) -> MeasureTable:
    """
    Arrange one of `MEASURES` by method, shape and color map.

    Raises `ToonkitError` if the measure is unknown, or the table is empty, mixes light tracks or sizes, or has a trial
    twice.
    """
    if column not in MEASURES:
        raise refuse("measure", f"must be one of {', '.join(MEASURES)}", repr(column))
    check(trials)
    axes = {key: names_in(trials, key) for key in ("method", "shape", "color_map")}
    values = np.full([len(names) for names in axes.values()], np.nan)
    places = tuple(pd.Index(names).get_indexer(trials[key]) for key, names in axes.items())
    measured = trials[column].to_numpy(dtype=np.float64)
    # An infinite ratio, of a truth that does not change, is as little a number as a failed one.
    values[places] = np.where(~failed(trials) & np.isfinite(measured), measured, np.nan)
    return MeasureTable(MEASURES[column], axes["method"], axes["shape"], axes["color_map"], values)


def names_in(trials: pd.DataFrame, key: str) -> tuple[str, ...]:
    """Return the methods, shapes or color maps of a table: ours in the order of the study, then others as they come."""
    orders = {"method": [*list_estimators()], "shape": [*SHAPES], "color_map": [*load_ramps()]}
    known = orders[key]
    found = dict.fromkeys(map(str, trials[key]))
    return tuple([name for name in known if name in found] + [name for name in found if name not in known])


def check(trials: pd.DataFrame) -> None:
    """Refuse a table that cannot be averaged: empty, of several light tracks or sizes, or with a trial twice."""
    missing = [key for key in (*_KEYS, "error") if key not in trials]
    if missing:
        raise refuse("trials", "must be a study's table", f"no column {', '.join(missing)}")
    if trials.empty:
        raise refuse("trials", "must hold at least one trial", "an empty table")
    for column, what in (("light_track", "light track"), ("size", "size")):
        if column in trials and trials[column].nunique() > 1:
            found = ", ".join(map(str, trials[column].unique()))
            raise refuse("trials", f"must be of one {what} (see on_track)", found)
    twice = trials.duplicated(_KEYS)
    if twice.any():
        raise refuse(
            "trials", "must hold each trial once", " / ".join(map(str, trials.loc[twice, _KEYS].iloc[0]))
        )


def tracks(trials: pd.DataFrame) -> list[LightTrack]:
    """Return the light tracks that a table holds, the paper's first."""
    found = set(trials["light_track"])
    return [track for track in LIGHT_TRACKS if track in found]


def on_track(trials: pd.DataFrame, track: LightTrack) -> pd.DataFrame:
    """Return the trials in which the light was given, or estimated."""
    return trials[trials["light_track"] == track]


def failed(trials: pd.DataFrame) -> BoolArray:
    """Tell for each row whether its trial ended in an error; a CSV file's empty text is no error."""
    error = trials["error"]
    return np.asarray(error.notna() & (error.astype(str).str.len() > 0))


def failures(trials: pd.DataFrame) -> pd.DataFrame:
    """Return the trials that ended in an error, with the error."""
    columns = [name for name in ("shape", "color_map", "method", "light_track", "error") if name in trials]
    return trials.loc[failed(trials), columns].reset_index(drop=True)


def completeness(trials: pd.DataFrame) -> pd.DataFrame:
    """Count for each method the `planned` pairs of shape and color map, and those `completed`, `failed` and `missing`."""
    check(trials)
    planned = trials["shape"].nunique() * trials["color_map"].nunique()
    groups = pd.Series(failed(trials), index=trials.index).groupby(trials["method"])
    counts = pd.DataFrame({"planned": planned, "completed": groups.size() - groups.sum()})
    counts["failed"] = groups.sum()
    counts["missing"] = planned - groups.size()
    return counts.loc[list(names_in(trials, "method"))].rename_axis("method")


def statement(trials: pd.DataFrame) -> str:
    """Describe in a sentence or two which trials the means cover, and which failures they leave out."""
    counts = completeness(trials)
    arranged = arrange(trials, "angular_error")
    total, kept = arranged.common.size, int(arranged.common.sum())
    if not (counts["failed"].any() or counts["missing"].any()):
        return f"Every method completed all {total} pairs of shape and color map; every mean is over all of them."
    blame = [
        f"{name}: " + ", ".join(f"{row[what]} {what}" for what in ("failed", "missing") if row[what])
        for name, row in counts.iterrows()
        if row["failed"] or row["missing"]
    ]
    text = f"Means are over the {kept} of {total} pairs of shape and color map that every method completed. "
    idle = [name for name in arranged.methods if name not in arranged.working]
    if idle:
        text += f"{', '.join(idle)} completed none: no mean, and no hole in the others'. "
    return text + f"Left out on account of {'; '.join(blame)}."

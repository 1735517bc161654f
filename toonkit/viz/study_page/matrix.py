"""A measure of the study over shapes and color maps: of one method, or the difference of two."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.study.measures import Measure
from toonkit.study.records import LightTrack
from toonkit.study.reporting.measure_table import MeasureTable, arrange, names_in, on_track
from toonkit.study.reporting.statistics import is_ratio
from toonkit.viz.figures.study_style import format_name

KINDS = ("primitive", "complex", "mesh")
"""Kinds of shapes, in the order in which they are listed."""

REFERENCE = "flat"
"""The trivial method: its errors do not stretch the scale of the others."""

COVERED = 98.0
"""Percentile of the values at which their scale ends: a few outliers must not darken all others."""

LONG = 1e4
"""Values from here on are written as powers of ten."""

NOT_RUN = "not in the table"


@dataclass(frozen=True, eq=False)
class TrialMatrix:
    """
    One value per trial, as a shape by color-map matrix.

    Attributes
    ----------
    measure : Measure
        What was measured.
    method, versus : str
        Name of the method, and of the one it is compared with ("" for none).
    shapes, kinds : tuple of str
        Names of the rows, ordered by kind, and their kinds.
    color_maps : tuple of str
        Names of the columns.
    ours, theirs : ndarray, shape (S, M)
        The measure of the method and of the other one; NaN where there is none. `theirs` is all NaN without another.
    values : ndarray, shape (S, M)
        What the heat map shows: the measure or, when comparing, the difference of the two methods' distances from the
        measure's ideal value.
    counted : ndarray of bool, shape (S, M)
        Trials included in the means, as in the study's report: those that every method completed or, in a comparison,
        those that both completed.
    gaps : ndarray of str, shape (S, M)
        Why a value is missing: the error of a failed trial, or `NOT_RUN`; "" where there is one.
    limits : (float, float)
        Ends of the color scale: shared by all methods so that plots are comparable; a comparison has its own.
    """

    measure: Measure
    method: str
    versus: str
    shapes: tuple[str, ...]
    kinds: tuple[str, ...]
    color_maps: tuple[str, ...]
    ours: FloatArray
    theirs: FloatArray
    values: FloatArray
    counted: BoolArray
    gaps: NDArray[np.object_]
    limits: tuple[float, float]

    @property
    def center(self) -> float | None:
        """The value in the middle of a scale with two sides; None if it has one."""
        if self.versus:
            return 0.0
        return self.measure.ideal if self.measure.ideal else None

    @property
    def row_means(self) -> FloatArray:
        """Mean, or median of a ratio, of each shape over its `counted` cells, shape (S,)."""
        return self._centers(self._compared)

    @property
    def column_means(self) -> FloatArray:
        """Mean, or median of a ratio, of each color map over its `counted` cells, shape (M,)."""
        return self._centers(self._compared.T)

    @property
    def mean(self) -> float:
        """Mean, or median of a ratio, of all `counted` cells; NaN if there is none."""
        return float(self._centers(self._compared.reshape(1, -1))[0])

    @property
    def center_name(self) -> str:
        """What `mean`, `row_means` and `column_means` are: "mean", or "median" of a ratio."""
        return "median" if is_ratio(self.measure) else "mean"

    @property
    def _compared(self) -> FloatArray:
        return np.where(self.counted, self.values, np.nan)

    def _centers(self, rows: FloatArray) -> FloatArray:
        middle = np.median if is_ratio(self.measure) else np.mean
        known = [row[np.isfinite(row)] for row in rows]
        return np.array([middle(row) if row.size else np.nan for row in known], dtype=np.float64)

    @property
    def title(self) -> str:
        """What is shown, in one line."""
        name = self.measure.label[0].upper() + self.measure.label[1:]
        return f"{name}: {self._methods}"

    @property
    def label(self) -> str:
        """Label of the color bar, with the unit and, for a difference, which side is the better one."""
        if not self.versus:
            return f"{self._methods}: {self.measure.axis}"
        name = self.measure.axis
        if self.measure.ideal:
            name = f"{name}, distance from {self.measure.ideal:g}"
        return f"{self._methods}: {name}. Below 0 {format_name(self.method)} is better"

    @property
    def _methods(self) -> str:
        ours = format_name(self.method)
        return f"{ours} minus {format_name(self.versus)}" if self.versus else ours

    def shown(self, value: float) -> str:
        """Return a value of the heat map as text, a difference with its sign."""
        # A ratio to something that hardly changes may have any number of digits.
        text = self.measure.shown(abs(value)) if abs(value) < LONG else f"{abs(value):.0e}"
        if not self.versus:
            return text
        return ("−" if value < 0 else "+" if value > 0 else "±") + text

    def cell_text(self, row: int, column: int) -> str:
        """Return what is known of a cell: both methods' values and their difference, or why there is none."""
        if self.gaps[row, column]:
            return str(self.gaps[row, column])
        ours = f"{format_name(self.method)} {self.measure.shown(self.ours[row, column])}"
        if not self.versus:
            return ours
        theirs = f"{format_name(self.versus)} {self.measure.shown(self.theirs[row, column])}"
        return f"{ours}, {theirs}: {self.shown(self.values[row, column])}"

    @property
    def summary(self) -> str:
        """The whole matrix in a sentence or two, with what is missing from it."""
        known = np.isfinite(self.values)
        missing = int((~known).sum())
        gaps = f" {missing} of {known.size} cells have no value." if missing else ""
        if not known.any():
            return "No trial has a value here."
        if not self.versus:
            best = f"{self.measure.ideal:g} is best" if self.measure.ideal else "smaller is better"
            name = self.center_name.capitalize()
            count = int((self.counted & known).sum())
            if not count:
                return f"No {self.center_name}: there is no trial that every method completed.{gaps}"
            return f"{name} {self.shown(self.mean)} over the {count} trials that every method completed; {best}.{gaps}"
        ours, theirs = format_name(self.method), format_name(self.versus)
        wins = int((self.values[known] < 0).sum())
        return (
            f"Blue: {ours} is better; orange: {theirs} is. {ours} is better in {wins} of {int(known.sum())} trials; "
            f"the {self.center_name} is {self.shown(self.mean)}.{gaps}"
        )


def trial_matrix(
    trials: pd.DataFrame, *, measure: str, method: str, versus: str = "", light_track: LightTrack = "given"
) -> TrialMatrix:
    """
    Arrange a measure over all shapes and color maps of a table, for a method, or for its difference to another.

    A difference is one of distances from the ideal, so that a negative one always says that the method is better. Means
    are those of `method_means` and `compare`; of a ratio, whose ideal is 1, they are medians.
    """
    on_one_track = on_track(trials, light_track)
    arranged = arrange(on_one_track, measure)
    # Of the whole table: the places of cells do not depend on what one track has.
    kinds, columns = _kinds(trials), names_in(trials, "color_map")
    departures = arranged.departures

    def placed(part: MeasureTable, name: str) -> FloatArray:
        values = part.of(name) if name in part.methods else np.full(part.common.shape, np.nan)
        return _placed(part, values, tuple(kinds), columns, np.nan)

    ours, our_departure = (placed(part, method) for part in (arranged, departures))
    theirs, their_departure = (placed(part, versus) for part in (arranged, departures))
    values = our_departure - their_departure if versus else ours
    return TrialMatrix(
        measure=arranged.measure,
        method=method,
        versus=versus,
        shapes=tuple(kinds),
        kinds=tuple(kinds.values()),
        color_maps=columns,
        ours=ours,
        theirs=theirs,
        values=values,
        counted=np.isfinite(values)
        if versus
        else _placed(arranged, arranged.common, tuple(kinds), columns, False),
        gaps=_gaps(on_one_track, values, [method, versus], tuple(kinds), columns),
        limits=_limits(values, 0.0, two_sided=True) if versus else _scale(arranged, method),
    )


def _placed(
    arranged: MeasureTable,
    values: NDArray[Any],
    shapes: tuple[str, ...],
    color_maps: tuple[str, ...],
    missing: Any,
) -> NDArray[Any]:
    """Return an array over the cells as one over all shapes and color maps."""
    placed = np.full((len(shapes), len(color_maps)), missing)
    rows = [shapes.index(name) for name in arranged.shapes]
    columns = [color_maps.index(name) for name in arranged.color_maps]
    placed[np.ix_(rows, columns)] = values
    return placed


def _gaps(
    trials: pd.DataFrame,
    values: FloatArray,
    methods: list[str],
    shapes: tuple[str, ...],
    color_maps: tuple[str, ...],
) -> NDArray[np.object_]:
    """Say of each cell without a value which method has none there, and why."""
    said = dict(
        zip(
            zip(trials["shape"], trials["color_map"], trials["method"], strict=True),
            trials["error"],
            strict=True,
        )
    )
    gaps = np.full(values.shape, "", dtype=object)
    for row, column in np.argwhere(~np.isfinite(values)):
        errors = {
            name: said.get((shapes[row], color_maps[column], name), NOT_RUN) for name in methods if name
        }
        reasons = [f"{format_name(name)}: {error}" for name, error in errors.items() if error]
        gaps[row, column] = "; ".join(reasons) or "no value"
    return gaps


def _scale(arranged: MeasureTable, method: str) -> tuple[float, float]:
    """Return the limits of a measure that serve all methods."""
    shown = [name for name in arranged.methods if method == REFERENCE or name != REFERENCE]
    values = np.array([arranged.of(name) for name in shown])
    return _limits(values, arranged.measure.ideal, two_sided=arranged.measure.ideal != 0)


def _limits(values: FloatArray, center: float, *, two_sided: bool) -> tuple[float, float]:
    known = np.abs(values[np.isfinite(values)] - center)
    reach = float(np.percentile(known, COVERED)) if known.size else 0.0
    reach = reach or 1.0  # all values alike: any scale will do
    return center - reach if two_sided else center, center + reach


def _kinds(trials: pd.DataFrame) -> dict[str, str]:
    """Return shape -> kind, ordered by kind, then as the study lists its shapes."""
    kinds = dict(zip(trials["shape"], trials["shape_kind"], strict=True))
    place = {kind: index for index, kind in enumerate(KINDS)}
    names = sorted(names_in(trials, "shape"), key=lambda name: place.get(kinds[name], len(KINDS)))
    return {name: kinds[name] for name in names}

"""What the study page knows: the table, what of it is looked at, and the trial under examination. Knows no panel."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace

import numpy as np
import pandas as pd
import param

from toonkit._validation import refuse
from toonkit.study.measures import MEASURES
from toonkit.study.painting import StudySettings
from toonkit.study.records import LightTrack
from toonkit.study.reporting.measure_table import names_in, tracks
from toonkit.viz.figures.study_style import format_name
from toonkit.viz.latest_task import LatestTask, TaskReport
from toonkit.viz.study_page.examination import EXAMINED_SIZE, Examination, examine
from toonkit.viz.study_page.matrix import TrialMatrix, trial_matrix
from toonkit.viz.turns import TURNS

FIRST_MEASURE = "angular_error"
FIRST_METHODS = ("toonkit", "todo")
"""What the page opens with: the first minus the second, where the table has both."""

KEPT_EXAMINATIONS = 8
"""Examinations kept for going back to a trial without waiting; each takes some 10 MB."""

TRACK_LABELS = {"given": "told to every method", "estimated": "estimated from the picture"}
"""Where the light of a track comes from."""

Cell = tuple[str, str]
Key = tuple[Cell, LightTrack, tuple[str, ...], StudySettings]

_kept: OrderedDict[Key, Examination] = OrderedDict()


class StudyState(param.Parameterized):
    """
    A study's table, the heat map that is made of it, and the trial that is examined.

    Parameters
    ----------
    trials : pandas.DataFrame
        The table, as of `toonkit.study.table.load_trials`.
    settings : StudySettings
        Under which it was made.

    Raises
    ------
    ToonkitError
        If the table has no trial.

    Examples
    --------
    >>> state = StudyState(load_trials("study"), settings_of("study"))  # doctest: +SKIP
    >>> state.matrix().row_means  # doctest: +SKIP
    >>> asyncio.run(state.examine())  # doctest: +SKIP
    """

    measure = param.Selector(doc="Column of MEASURES that the heat map shows.")
    method = param.Selector(doc="Method whose values are shown.")
    versus = param.Selector(doc='Method whose values are subtracted; "" for none.')
    light_track = param.Selector(doc="Whether the methods were told the light.")
    shape = param.Selector(doc="Shape of the trial under examination.")
    color_map = param.Selector(doc="Its color map.")
    examination = param.Parameter(None, doc="The Examination on screen, perhaps still without some answers.")
    step = param.String("", doc='What is being computed; "" when idle.')
    fraction = param.Number(0.0, bounds=(0, 1), doc="How much of it is done.")

    def __init__(self, trials: pd.DataFrame, settings: StudySettings) -> None:
        if trials.empty:
            raise refuse(
                "trials", "must hold at least one trial; `toonkit study run -o study/` runs them", "none"
            )
        super().__init__()
        self.trials = trials
        self.settings = settings
        self.methods = names_in(trials, "method")
        self.shapes = names_in(trials, "shape")
        self.color_maps = names_in(trials, "color_map")
        self._task = LatestTask(lambda step, fraction: self.param.update(step=step, fraction=fraction))
        self._offer()
        self.select(*self.typical())
        self.examination = _kept.get(self._key())

    def _offer(self) -> None:
        """Fill the selectors with what the table has."""
        measured = {name: measure for name, measure in MEASURES.items() if self.trials[name].notna().any()}
        if not measured:
            measured = {FIRST_MEASURE: MEASURES[FIRST_MEASURE]}  # every trial failed: the gaps say why
        light_tracks = tracks(self.trials)
        first = [name for name in FIRST_METHODS if name in self.methods] or [self.methods[0]]
        for name, objects, value in (
            ("measure", {m.label: key for key, m in measured.items()}, None),
            ("method", {format_name(method): method for method in self.methods}, first[0]),
            ("shape", {format_name(shape): shape for shape in self.shapes}, None),
            ("color_map", {format_name(color_map): color_map for color_map in self.color_maps}, None),
            ("light_track", {TRACK_LABELS[track]: track for track in light_tracks}, light_tracks[0]),
        ):
            self.param[name].objects = objects
            setattr(self, name, value or next(iter(objects.values())))
        if FIRST_MEASURE in measured:
            self.measure = FIRST_MEASURE
        self._offer_others()
        self.versus = first[1] if len(first) > 1 else ""

    @param.depends("method", watch=True)
    def _offer_others(self) -> None:
        """Offer all methods but the one shown for comparison."""
        if self.versus == self.method:
            self.versus = ""
        others = {format_name(method): method for method in self.methods if method != self.method}
        self.param.versus.objects = {"nothing": "", **others}

    def matrix(self) -> TrialMatrix:
        """Return what the heat map shows."""
        return trial_matrix(
            self.trials,
            measure=self.measure,
            method=self.method,
            versus=self.versus or "",
            light_track=self.light_track,
        )

    def means(self) -> dict[str, str]:
        """Return each method's mean (or median) of the measure as text, as in the report: over the trials all completed."""
        means = {}
        for method in self.methods:
            matrix = trial_matrix(
                self.trials, measure=self.measure, method=method, light_track=self.light_track
            )
            shown = f"{matrix.center_name} {matrix.shown(matrix.mean)}"
            means[method] = shown if np.isfinite(matrix.mean) else "no value"
        return means

    @property
    def about(self) -> str:
        """The study in a sentence."""
        size = self.settings.size
        sizes = f"{len(self.shapes)} shapes × {len(self.color_maps)} color maps × {len(self.methods)} methods"
        return f"{sizes} at {size} × {size} pixels: {len(self.trials)} trials."

    def records(self, trial: Examination) -> dict[str, dict[str, object]]:
        """Return the rows of an examined trial by method; empty for a method that the table has none of."""
        found = self.trials[
            (self.trials["shape"] == trial.shape)
            & (self.trials["color_map"] == trial.color_map)
            & (self.trials["light_track"] == trial.light_track)
        ]
        rows = {row["method"]: row for row in found.to_dict("records")}
        return {method: rows.get(method, {}) for method in trial.methods}

    def select(self, shape: str, color_map: str) -> None:
        """Select a trial, both of its names at once."""
        self.param.update(shape=shape, color_map=color_map)

    def typical(self) -> Cell:
        """Return the cell whose value is the median of the heat map's."""
        return self._ranked(0.5)

    def best(self) -> Cell:
        """Return the cell in which the method does best, or gains most on the other."""
        return self._ranked(0.0)

    def worst(self) -> Cell:
        """Return the cell in which the method does worst, or loses most against the other."""
        return self._ranked(1.0)

    def close(self) -> None:
        """End the examination under way: the visitor has left."""
        self._task.overtake()

    def _ranked(self, share: float) -> Cell:
        matrix = self.matrix()
        distance = matrix.values if self.versus else np.abs(matrix.values - matrix.measure.ideal)
        order = np.argsort(distance, axis=None, kind="stable")  # NaN last
        known = int(np.isfinite(distance).sum())
        place = order[round(share * max(known - 1, 0))]
        row, column = np.unravel_index(place, distance.shape)
        return matrix.shapes[row], matrix.color_maps[column]

    async def examine(self) -> None:
        """Let every method analyze the selected trial again; a newer selection ends it, what fails puts the old back."""
        key, before = self._key(), self.examination
        kept = _kept.pop(key, None)
        if kept is not None:
            _keep(key, kept)
            self._task.overtake()
            self.examination = kept
            return

        def restore() -> None:
            if before is not None:
                self.param.update(examination=before, shape=before.shape, color_map=before.color_map)

        examination = await self._task.run(
            "", lambda report: self._examine(key, report), threads=TURNS.threads, give_up=restore
        )
        if examination is not None:
            self.examination = examination

    def _key(self) -> Key:
        size = min(self.settings.size, EXAMINED_SIZE)
        return (self.shape, self.color_map), self.light_track, self.methods, replace(self.settings, size=size)

    def _examine(self, key: Key, report: TaskReport) -> Examination:
        """Examine in a thread, showing what is answered so far."""

        def partly(examination: Examination) -> None:
            report.put(lambda: self.param.update(examination=examination))

        (shape, color_map), light_track, methods, settings = key
        with TURNS.turn(report) as limited:
            examination = examine(
                shape,
                color_map,
                methods=methods,
                light_track=light_track,
                settings=settings,
                progress=limited,
                partly=partly,
            )
        _keep(key, examination)
        return examination


def _keep(key: Key, examination: Examination) -> None:
    _kept[key] = examination
    while len(_kept) > KEPT_EXAMINATIONS:
        _kept.popitem(last=False)

"""Cells of a study: the trials of one shape and one color map, which a worker measures together."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from toonkit._validation import ToonkitError
from toonkit.estimation.preparation import prepare
from toonkit.methods import METHODS
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.numerics.bands import single_threaded_blas
from toonkit.study.contestants import Contestant
from toonkit.study.plan import StudyPlan
from toonkit.study.provenance import installed_toonkit
from toonkit.study.rendering import RenderedShape
from toonkit.study.subjects import Subject, render
from toonkit.study.trials import Record, StudySettings, Trial, paint, run_trial, unmeasured

Outcome = tuple[Trial, Record]
Truth = RenderedShape | Exception


@dataclass(frozen=True, eq=False)
class Cell:
    """
    Trials of one shape and one color map, with everything that a worker needs except the rendered shape.

    Attributes
    ----------
    trials : tuple of Trial
        What to measure.
    shape_kind : str
        The shape's kind.
    color_map : ColorMap
        M_t.
    methods : dict
        Contestants by name.
    settings : StudySettings
        Size and lights.
    toonkit : str or None
        Version of toonkit that must measure, as from `installed_toonkit`; None if this machine measures.
    subject : Shape or MeshShape, or None
        What is to be rendered first.
    """

    trials: tuple[Trial, ...]
    shape_kind: str
    color_map: ColorMap
    methods: dict[str, Contestant]
    settings: StudySettings
    toonkit: str | None = None
    subject: Subject | None = None

    @classmethod
    def of(cls, trials: Sequence[Trial], plan: StudyPlan) -> Cell:
        """Return the cell of trials that share a shape and a color map of a plan."""
        shape, color_map = trials[0].shape, trials[0].color_map
        subject = plan.subjects[shape]
        methods = {trial.method: plan.methods[trial.method] for trial in trials}
        return cls(
            tuple(trials), subject.kind, plan.color_maps[color_map], methods, plan.settings, subject=subject
        )

    def one_by_one(self) -> list[Cell]:
        """Return one cell per trial."""
        return [
            replace(self, trials=(trial,), methods={trial.method: self.methods[trial.method]})
            for trial in self.trials
        ]

    def failed(self, error: str) -> list[Record]:
        """Return records of all trials with an error."""
        return [unmeasured(trial, self.shape_kind, self.settings, error=error) for trial in self.trials]


def measured_here(cells: Sequence[Cell]) -> Generator[Outcome, None, None]:
    """Measure cells in this process, one trial after the other."""
    rendered: Subject | None = None
    truth: Truth = ToonkitError("nothing was rendered")
    for cell in cells:
        if cell.subject is not rendered:
            rendered, truth = cell.subject, rendered_or_error(cell.subject, cell.settings.size)
        for one in cell.one_by_one():
            yield from zip(one.trials, measure(truth, one), strict=True)


def rendered_or_error(subject: Subject | None, size: int) -> Truth:
    """Render a subject, or return the error, which goes into the records of all its trials."""
    try:
        if subject is None:
            raise ToonkitError("the cell has no subject")
        return render(subject, size)
    except Exception as error:
        return error


def measure(truth: Truth, cell: Cell) -> list[Record]:
    """Run the trials of a cell on any machine; raises `ToonkitError` if it has another version of toonkit."""
    if cell.toonkit is not None and cell.toonkit != installed_toonkit():
        raise ToonkitError(
            f"workers must have toonkit {cell.toonkit}; got {installed_toonkit()}: install it there and restart them"
        )
    if not isinstance(truth, RenderedShape):
        return cell.failed(f"{type(truth).__name__}: {truth}")
    # The order of summation in a matrix product depends on the number of threads. The same trial must give the same
    # numbers in any process.
    with single_threaded_blas():
        _warm_up()
        painting = paint(truth, cell.color_map, cell.settings)
        return [
            run_trial(trial, cell.shape_kind, painting, cell.methods[trial.method]) for trial in cell.trials
        ]


@cache
def _warm_up() -> None:
    """Load the compiled code of toonkit's methods once in each process, so that no trial's time includes it."""
    y, x = np.mgrid[:32, :32] - 15.5
    mask = x**2 + y**2 < 200
    disc = ToonImage(np.where((x > 0)[..., None], 0.9, 0.2) * np.ones(3), mask)
    for method in METHODS.values():
        try:
            method(prepare(disc), light_direction(135, 45))
        except Exception:  # a user's method that fails here may still succeed in the trials
            continue

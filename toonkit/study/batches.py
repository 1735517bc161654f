"""Batches of a study: the trials of one shape and one color map, which a worker measures together."""

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
from toonkit.numerics.parallel import single_threaded_blas
from toonkit.study.estimators import Estimator
from toonkit.study.painting import StudySettings, paint
from toonkit.study.plan import StudyPlan
from toonkit.study.provenance import installed_toonkit
from toonkit.study.records import Record, Trial, blank_record
from toonkit.study.rendering import RenderedShape
from toonkit.study.scenes import Scene, render
from toonkit.study.trials import run_trial

Outcome = tuple[Trial, Record]
Truth = RenderedShape | Exception


@dataclass(frozen=True, eq=False)
class Batch:
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
        Estimators by name.
    settings : StudySettings
        Size and lights.
    toonkit : str or None
        Version of toonkit that must measure, as from `installed_toonkit`; None if this machine measures.
    scene : Shape or MeshShape, or None
        What is to be rendered first.
    """

    trials: tuple[Trial, ...]
    shape_kind: str
    color_map: ColorMap
    methods: dict[str, Estimator]
    settings: StudySettings
    toonkit: str | None = None
    scene: Scene | None = None

    @classmethod
    def of(cls, trials: Sequence[Trial], plan: StudyPlan) -> Batch:
        """Return the batch of trials that share a shape and a color map of a plan."""
        shape, color_map = trials[0].shape, trials[0].color_map
        scene = plan.scenes[shape]
        methods = {trial.method: plan.methods[trial.method] for trial in trials}
        return cls(tuple(trials), scene.kind, plan.color_maps[color_map], methods, plan.settings, scene=scene)

    def split(self) -> list[Batch]:
        """Return one batch per trial."""
        return [
            replace(self, trials=(trial,), methods={trial.method: self.methods[trial.method]})
            for trial in self.trials
        ]

    def fail(self, error: str) -> list[Record]:
        """Return records of all trials with an error."""
        return [blank_record(trial, self.shape_kind, self.settings, error=error) for trial in self.trials]


def measure_here(batches: Sequence[Batch]) -> Generator[Outcome, None, None]:
    """Measure batches in this process, one trial after the other."""
    rendered: Scene | None = None
    truth: Truth = ToonkitError("nothing was rendered")
    for batch in batches:
        if batch.scene is not rendered:
            rendered, truth = batch.scene, try_to_render(batch.scene, batch.settings.size)
        for one in batch.split():
            yield from zip(one.trials, measure(truth, one), strict=True)


def try_to_render(scene: Scene | None, size: int) -> Truth:
    """Render a scene, or return the error, which goes into the records of all its trials."""
    try:
        if scene is None:
            raise ToonkitError("the batch has no scene")
        return render(scene, size)
    except Exception as error:
        return error


def measure(truth: Truth, batch: Batch) -> list[Record]:
    """Run the trials of a batch on any machine; raises `ToonkitError` if it has another version of toonkit."""
    if batch.toonkit is not None and batch.toonkit != installed_toonkit():
        raise ToonkitError(
            f"workers must have toonkit {batch.toonkit}; got {installed_toonkit()}: install it there and restart them"
        )
    if not isinstance(truth, RenderedShape):
        return batch.fail(f"{type(truth).__name__}: {truth}")
    # The order of summation in a matrix product depends on the number of threads. The same trial must give the same
    # numbers in any process.
    with single_threaded_blas():
        _warm_up()
        painting = paint(truth, batch.color_map, batch.settings)
        return [
            run_trial(trial, batch.shape_kind, painting, batch.methods[trial.method])
            for trial in batch.trials
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

"""Run or resume a study: in this process, on a local cluster, or on a running dask cluster."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pandas as pd

from toonkit._validation import ToonkitError, refuse
from toonkit.export.atomic import PathLike
from toonkit.export.folder import make_folder
from toonkit.export.sole_use import sole_use
from toonkit.study.batches import Batch, Outcome, measure_here
from toonkit.study.cluster import measure_on_cluster, worker_count
from toonkit.study.plan import StudyPlan
from toonkit.study.provenance import describe_machine, provenance
from toonkit.study.record_store import RecordStore
from toonkit.study.records import Record
from toonkit.study.study_folder import open_sidecar, write_sidecar
from toonkit.study.table import as_table, write_table

TABLE_SECONDS = 60.0
"""How often the table is written while a study runs. A table that is read in the meantime is at most this old."""


@dataclass(frozen=True)
class StudyProgress:
    """
    Progress of a study.

    Attributes
    ----------
    done, total : int
        Trials on file, and trials planned.
    record : Record or None
        The latest record; None at the start.
    """

    done: int
    total: int
    record: Record | None = None


Report = Callable[[StudyProgress], None]


def run_study(
    plan: StudyPlan,
    folder: PathLike,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    retry_failed: bool = False,
    again: Collection[str] = (),
    progress: Report | None = None,
) -> pd.DataFrame:
    """
    Run every trial of a plan that has no saved record with the same inputs.

    Parameters
    ----------
    plan : StudyPlan
        What to compare.
    folder : path
        Folder of records, table and provenance; created if necessary. Another plan may be run in it, which adds trials.
    workers : int, optional
        Processes of a local cluster; one for each core by default. 0 measures in this process, without dask.
    scheduler : str, optional
        Address of a dask scheduler, such as `tcp://host:8786`, whose workers do the work instead.
    retry_failed : bool, optional
        Rerun trials that failed. Trials whose worker was lost are always rerun.
    again : collection of str, optional
        Methods of the plan whose records are all deleted first, because their code has changed.
    progress : callable, optional
        Called with a `StudyProgress` at the start and after each record.

    Returns
    -------
    pandas.DataFrame
        All records in the folder; also written there as `trials.parquet`, with `study.json` beside it.

    Raises
    ------
    ToonkitError
        If the study cannot be run as asked, or its scheduler is lost. Completed trials are saved.

    Notes
    -----
    A trial is measured again if its inputs change: toonkit's version, the settings, the shape, the color map, the networks
    used, or the method's file. Code is not compared: name methods whose code has changed in `again`.

    Workers import the main program: in a script, call this below `if __name__ == "__main__":`.
    """
    _refuse_bad_workers(workers, scheduler)
    _refuse_unknown_methods(again, plan)
    home = make_folder(folder)
    with sole_use(home):
        sidecar = open_sidecar(provenance(plan), home)
        store = RecordStore(home, sidecar)
        store.forget(again)
        run = _Run(plan, home, store, sidecar, progress or (lambda _: None))
        return run.measure(run.missing_batches(retry_failed=retry_failed), workers, scheduler)


class _Run:
    """One run of a study. It collects outcomes and keeps table and provenance up to date."""

    def __init__(
        self, plan: StudyPlan, home: Path, store: RecordStore, sidecar: dict[str, Any], report: Report
    ) -> None:
        self._plan, self._home, self._store, self._sidecar, self.report = plan, home, store, sidecar, report
        self.total = sum(len(trials) for trials in plan.batches())
        self.done = self.total

    def missing_batches(self, *, retry_failed: bool) -> list[Batch]:
        batches = []
        for trials in self._plan.batches():
            left = [trial for trial in trials if not self._store.is_done(trial, retry_failed=retry_failed)]
            if left:
                batches.append(Batch.of(left, self._plan))
        self.done -= sum(len(batch.trials) for batch in batches)
        return batches

    def measure(self, batches: list[Batch], workers: int | None, scheduler: str | None) -> pd.DataFrame:
        if not batches:
            self.report(StudyProgress(self.done, self.total))
            return self.write_table()
        if workers == 0:
            outcomes = measure_here(batches)
        else:
            outcomes = measure_on_cluster(batches, workers=workers, scheduler=scheduler)
        with closing(outcomes):
            return self.collect(outcomes, "a given scheduler" if scheduler else worker_count(workers))

    def collect(self, outcomes: Iterator[Outcome], workers: int | str) -> pd.DataFrame:
        start = time.perf_counter()
        entry: dict[str, Any] = {"started": _now(), "finished": None, "seconds": None, "trials": None}
        entry |= {"workers": workers, **describe_machine()}
        self._sidecar["runs"].append(entry)
        write_sidecar(self._sidecar, self._home)
        self.report(StudyProgress(self.done, self.total))
        measured, written = 0, start
        try:
            for trial, record in outcomes:
                self._store.save(trial, record)
                measured += 1
                self.done += 1
                self.report(StudyProgress(self.done, self.total, record))
                if time.perf_counter() - written > TABLE_SECONDS:
                    self.write_table()
                    written = time.perf_counter()
        finally:
            # Also of a run that ends in an error or is interrupted; only a killed one cannot tell.
            entry |= {
                "finished": _now(),
                "seconds": round(time.perf_counter() - start, 1),
                "trials": measured,
            }
            write_sidecar(self._sidecar, self._home)
            table = self.write_table()
        return table

    def write_table(self) -> pd.DataFrame:
        table = as_table(self._store.records())
        write_table(table, self._home)
        return table


def _refuse_unknown_methods(again: Collection[str], plan: StudyPlan) -> None:
    for method in again:
        if method not in plan.methods:
            raise refuse("again", f"must be among the plan's {', '.join(plan.methods)}", repr(method))


def _refuse_bad_workers(workers: int | None, scheduler: str | None) -> None:
    if workers is not None and (not isinstance(workers, int) or workers < 0):
        raise refuse("workers", "must be a whole number >= 0", workers)
    if workers is not None and scheduler is not None:
        raise refuse("workers", "must be left out where a scheduler is given", workers)
    # Now, and not when hours of work are to be written.
    needed = ["pyarrow"] if workers == 0 else ["pyarrow", "distributed"]
    missing = [name for name in needed if find_spec(name) is None]
    if missing:
        raise ToonkitError(f'a study needs the package {missing[0]}; got none: pip install "toonkit[study]"')


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")

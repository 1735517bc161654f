"""Run a study: in this process, on a local cluster, or on a dask cluster that is there already; and go on where it ended."""

from __future__ import annotations

import json
import logging
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd

from toonkit._validation import ToonkitError, refuse
from toonkit.export.atomic import PathLike, atomic_write
from toonkit.export.folder import make_folder
from toonkit.model.color_map import ColorMap
from toonkit.study.contestants import Contestant
from toonkit.study.plan import StudyPlan
from toonkit.study.provenance import provenance, source_digest
from toonkit.study.record_store import LOST, RecordStore
from toonkit.study.rendering import RenderedShape
from toonkit.study.subjects import Subject, render
from toonkit.study.table import PROVENANCE_NAME, as_table, load_provenance, settings_from, write_table
from toonkit.study.trials import Record, StudySettings, Trial, paint, run_trial, unmeasured

CONNECT_SECONDS = 20
"""How long to look for a scheduler."""

_KEEP_MEMORY = {
    f"distributed.nanny.pre-spawn-environ.MALLOC_{name}_THRESHOLD_": str(2**30) for name in ("TRIM", "MMAP")
}
# By default dask's workers give every freed array back to the system: half of a trial's time went into page faults.


@dataclass(frozen=True)
class StudyProgress:
    """
    How far a study is.

    Attributes
    ----------
    done, total : int
        Trials on file, and trials planned.
    record : Record or None
        The one that just came; None at the start.
    """

    done: int
    total: int
    record: Record | None = None


Report = Callable[[StudyProgress], None]


@dataclass(frozen=True, eq=False)
class _Cell:
    """Trials of one shape and one color map, with all that a worker needs for them."""

    trials: tuple[Trial, ...]
    subject: Subject
    color_map: ColorMap
    methods: dict[str, Contestant]
    settings: StudySettings


def run_study(
    plan: StudyPlan,
    folder: PathLike,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Report | None = None,
) -> pd.DataFrame:
    """
    Measure every trial of a plan that is not on file yet.

    Parameters
    ----------
    plan : StudyPlan
        What to compare.
    folder : path
        Where records, table and provenance go; created if need be. A study that was interrupted, by whatever, goes on.
        Another plan may be run in the same folder: its trials are added.
    workers : int, optional
        Processes of a local cluster; one for each core by default. 0 measures in this process, without dask.
    scheduler : str, optional
        Address of a dask scheduler, such as `tcp://host:8786`, whose workers do the work instead.
    progress : callable, optional
        Called with a `StudyProgress` at the start and after each record.

    Returns
    -------
    pandas.DataFrame
        All records in the folder; also written there as `trials.parquet`, with `study.json` beside it.

    Raises
    ------
    ToonkitError
        If the folder holds a study of other settings or other code, the scheduler cannot be reached, is lost, or has
        workers with another toonkit. What was measured until then is on file.
    """
    if workers is not None and (not isinstance(workers, int) or workers < 0):
        raise refuse("workers", "must be a whole number >= 0", workers)
    if workers is not None and scheduler is not None:
        raise refuse("workers", "must be left out where a scheduler is given", workers)
    home = make_folder(folder)
    sidecar = _opened_sidecar(plan, home)
    store = RecordStore(home, plan.digests())
    cells = plan.cells()
    missing = [cell for cell in (_missing(cell, plan, store) for cell in cells) if cell is not None]
    total = sum(len(cell) for cell in cells)
    done = total - sum(len(cell.trials) for cell in missing)
    told = progress or (lambda _: None)
    told(StudyProgress(done, total))

    run: dict[str, Any] = {"started": _now(), "finished": None, "seconds": None, "trials": total - done}
    run["workers"] = _worker_count(workers) if scheduler is None else "of a given scheduler"
    if missing:
        _write_sidecar({**sidecar, "runs": [*sidecar["runs"], run]}, home)
    start = time.perf_counter()
    for trial, record in _outcomes(missing, workers, scheduler):
        store.save(trial, record)
        done += 1
        told(StudyProgress(done, total, record))
    if missing:
        run |= {"finished": _now(), "seconds": round(time.perf_counter() - start, 1)}
        sidecar["runs"].append(run)
        _write_sidecar(sidecar, home)
    table = as_table(store.records())
    write_table(table, home)
    return table


def _missing(trials: list[Trial], plan: StudyPlan, store: RecordStore) -> _Cell | None:
    left = tuple(trial for trial in trials if not store.is_current(trial))
    if not left:
        return None
    shape, color_map = left[0].shape, left[0].color_map
    methods = {trial.method: plan.methods[trial.method] for trial in left}
    return _Cell(left, plan.subjects[shape], plan.color_maps[color_map], methods, plan.settings)


def _opened_sidecar(plan: StudyPlan, home: Path) -> dict[str, Any]:
    """Return the folder's provenance, extended by the plan; refuse a folder whose records were made otherwise."""
    fresh = {**provenance(plan), "runs": []}
    if not (home / PROVENANCE_NAME).is_file():
        _write_sidecar(fresh, home)
        return fresh
    known = load_provenance(home)
    if settings_from(known["settings"]) != plan.settings:
        raise refuse("folder", "must hold a study with the same size and lights, or be new", f"{home}")
    if known["source"] != fresh["source"]:
        raise refuse("folder", "must hold a study made by this very code, or be new", f"{home}")
    for group in ("shapes", "digests"):
        fresh[group] = {**known[group], **fresh[group]}
    for group in fresh["digests"]:
        fresh["digests"][group] = {**known["digests"].get(group, {}), **fresh["digests"][group]}
    for group in ("color_maps", "methods", "light_tracks"):
        fresh[group] = list(dict.fromkeys([*known[group], *fresh[group]]))
    return {**fresh, "runs": known["runs"]}


def _write_sidecar(sidecar: dict[str, Any], home: Path) -> None:
    with atomic_write(home / PROVENANCE_NAME) as file:
        file.write((json.dumps(sidecar, indent=2) + "\n").encode())


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _worker_count(workers: int | None) -> int:
    return (os.cpu_count() or 1) if workers is None else workers


def _outcomes(
    cells: list[_Cell], workers: int | None, scheduler: str | None
) -> Iterator[tuple[Trial, Record]]:
    if not cells:
        return
    if workers == 0:
        yield from _measured_here(cells)
        return
    with _cluster(workers, scheduler, len(cells)) as client:
        yield from _measured_there(cells, client)


def _measured_here(cells: list[_Cell]) -> Iterator[tuple[Trial, Record]]:
    truth: RenderedShape | Exception | None = None
    rendered: Subject | None = None
    for cell in cells:
        if cell.subject is not rendered:
            rendered, truth = cell.subject, _render(cell.subject, cell.settings.size)
        for trial in cell.trials:
            one = replace(cell, trials=(trial,))
            yield from zip(one.trials, _measure(truth, one), strict=True)


@contextmanager
def _cluster(workers: int | None, scheduler: str | None, cells: int) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster of processes of one thread each on this machine."""
    import dask  # noqa: PLC0415  # takes a second, with distributed
    from distributed import Client, LocalCluster  # noqa: PLC0415

    if scheduler is None:
        with (
            dask.config.set(_KEEP_MEMORY),
            LocalCluster(
                n_workers=min(_worker_count(workers), cells),
                threads_per_worker=1,  # the solvers use one core each
                dashboard_address=":0",  # any port: another cluster may hold the usual one
                silence_logs=logging.CRITICAL,
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = Client(scheduler, timeout=CONNECT_SECONDS)
    except (OSError, ValueError, TimeoutError) as error:
        raise refuse("scheduler", "must be the address of a running dask scheduler", scheduler) from error
    with client:
        digests = client.run(source_digest)
        if not digests:
            raise refuse(
                "scheduler", "must have workers", f"{scheduler} without any: start `dask worker {scheduler}`"
            )
        strangers = [worker for worker, digest in digests.items() if digest != source_digest()]
        if strangers:
            raise refuse(
                "scheduler", "must have workers with this very toonkit", f"{strangers[0]} with another"
            )
        yield client


def _measured_there(cells: list[_Cell], client: Any) -> Iterator[tuple[Trial, Record]]:
    """Hand the cells to the workers, first shapes first; yield records as they come."""
    from distributed import as_completed  # noqa: PLC0415

    truths: dict[int, Any] = {}
    futures: dict[Any, _Cell] = {}
    for order, cell in enumerate(cells):
        if id(cell.subject) not in truths:
            truths[id(cell.subject)] = client.submit(
                _render, cell.subject, cell.settings.size, pure=False, priority=-order
            )
        truth = truths[id(cell.subject)]
        futures[client.submit(_measure, truth, cell, pure=False, priority=-order)] = cell
    truths.clear()  # a rendered shape is forgotten as soon as its last cell is done
    waiting = as_completed(list(futures))
    for future in waiting:
        cell = futures.pop(future)
        if future.status == "finished":
            records = future.result()
        elif future.status == "error":
            records = _lost(cell, future.exception())
        else:
            raise ToonkitError(
                f"scheduler must stay reachable; got lost with {sum(len(left.trials) for left in futures.values())} "
                "trials to go: run the same command again and it goes on"
            )
        yield from zip(cell.trials, records, strict=True)


def _render(subject: Subject, size: int) -> RenderedShape | Exception:
    """Render a subject; what goes wrong is handed on, for the records of all its trials to tell."""
    try:
        return render(subject, size)
    except Exception as error:
        return error


def _measure(truth: RenderedShape | Exception | None, cell: _Cell) -> list[Record]:
    """Run the trials of a cell, on whatever machine."""
    if not isinstance(truth, RenderedShape):
        return [_failed(cell, trial, f"{type(truth).__name__}: {truth}") for trial in cell.trials]
    painting = paint(truth, cell.color_map, cell.settings)
    return [
        run_trial(trial, cell.subject.kind, painting, cell.methods[trial.method]) for trial in cell.trials
    ]


def _lost(cell: _Cell, error: BaseException) -> list[Record]:
    return [_failed(cell, trial, f"{LOST}{type(error).__name__}: {error}") for trial in cell.trials]


def _failed(cell: _Cell, trial: Trial, error: str) -> Record:
    return unmeasured(trial, cell.subject.kind, cell.settings, error=error)

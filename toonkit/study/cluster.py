"""Cells of a study on a dask cluster: a local one, or one that is there already."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from toonkit._validation import ToonkitError, refuse
from toonkit.study.cells import Cell, Outcome, measure, rendered_or_error
from toonkit.study.digests import CODE
from toonkit.study.record_store import LOST

CONNECT_SECONDS = 20
"""How long to look for a scheduler."""

_KEEP_MEMORY = {
    f"distributed.nanny.pre-spawn-environ.MALLOC_{name}_THRESHOLD_": str(2**30) for name in ("TRIM", "MMAP")
}
# By default dask's workers give every freed array back to the system: half of a trial's time went into page faults.


def worker_count(workers: int | None) -> int:
    """Return the number of processes asked for, or one for each core that this process may use."""
    if workers is not None:
        return workers
    from dask.system import CPU_COUNT  # noqa: PLC0415

    return int(CPU_COUNT)


def measured_there(
    cells: Sequence[Cell], *, workers: int | None, scheduler: str | None
) -> Generator[Outcome, None, None]:
    """
    Measure cells on a cluster; outcomes come in the order in which they are done.

    A cell whose worker died is measured again, one trial at a time and alone: so only a trial that takes its worker with it
    fails, and neither its rivals nor cells that were near.
    """
    with _cluster(workers, scheduler, len(cells)) as client:
        suspects: list[Cell] = []
        yield from _all_at_once(cells, client, suspects)
        for cell in suspects:
            for one in cell.one_by_one():
                yield from _alone(one, client)


@contextmanager
def _cluster(workers: int | None, scheduler: str | None, cells: int) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster of processes of one thread each on this machine."""
    import dask  # noqa: PLC0415  # takes a second, with distributed
    from distributed import Client, LocalCluster  # noqa: PLC0415

    if scheduler is None:
        with dask.config.set(_KEEP_MEMORY), _ignoring_interrupts():
            cluster = LocalCluster(
                n_workers=min(worker_count(workers), cells),
                threads_per_worker=1,  # the solvers use one core each
                memory_limit=None,  # dask would count what a worker keeps for its next array, and stop it
                dashboard_address=":0",  # any port: another cluster may hold the usual one
                silence_logs=logging.CRITICAL,
            )
        with cluster, Client(cluster) as client:
            yield client
        return
    try:
        client = Client(scheduler, timeout=CONNECT_SECONDS)
    except (OSError, ValueError, TimeoutError) as error:
        raise refuse("scheduler", "must be the address of a running dask scheduler", scheduler) from error
    with client:
        _refuse_other_code(client, scheduler)
        yield client


@contextmanager
def _ignoring_interrupts() -> Iterator[None]:
    """Let processes be born deaf to Ctrl-C, which a terminal sends to all: this one ends them, and no stack traces show."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may say what a signal does
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _refuse_other_code(client: Any, scheduler: str) -> None:
    try:
        codes = client.run(_code)
    except Exception as error:  # whatever a worker says that has no toonkit, or another
        raise refuse(
            "scheduler", "must have workers with this very toonkit", f"{scheduler} ({error})"
        ) from error
    if not codes:
        raise refuse(
            "scheduler", "must have workers", f"{scheduler} without any: start `dask worker {scheduler}`"
        )
    strangers = [worker for worker, code in codes.items() if code != CODE]
    if strangers:
        raise refuse("scheduler", "must have workers with this very toonkit", f"{strangers[0]} with another")


def _code() -> str:
    return CODE


def _all_at_once(cells: Sequence[Cell], client: Any, suspects: list[Cell]) -> Iterator[Outcome]:
    """Hand over all cells, first shapes first; put those whose worker died aside."""
    from distributed import as_completed  # noqa: PLC0415

    truths: dict[int, Any] = {}
    futures: dict[Any, Cell] = {}
    for order, cell in enumerate(cells):
        subject = id(cell.subject)
        if subject not in truths:
            truths[subject] = client.submit(
                rendered_or_error, cell.subject, cell.settings.size, pure=False, priority=-order
            )
        future = client.submit(measure, truths[subject], _without_subject(cell), pure=False, priority=-order)
        futures[future] = cell
    truths.clear()  # a rendered shape is forgotten as soon as its last cell is done
    for future in as_completed(list(futures)):
        cell = futures.pop(future)
        if future.status == "finished":
            yield from zip(cell.trials, future.result(), strict=True)
        elif _lost(future):
            suspects.append(cell)
        else:
            left = len(cell.trials) + sum(len(other.trials) for other in futures.values())
            raise _ended(future, left)


def _alone(cell: Cell, client: Any) -> Iterator[Outcome]:
    """Measure a cell while nothing else runs: whoever loses its worker now did it."""
    from distributed import wait  # noqa: PLC0415

    truth = client.submit(rendered_or_error, cell.subject, cell.settings.size, pure=False)
    wait(truth)
    future = client.submit(measure, truth, _without_subject(cell), pure=False)
    wait(future)
    if future.status == "finished":
        records = future.result()
    elif _lost(future):
        records = cell.failed(f"{LOST}it ended each time that this trial ran on it")
    else:
        raise _ended(future, len(cell.trials))
    yield from zip(cell.trials, records, strict=True)


def _without_subject(cell: Cell) -> Cell:
    """Return a cell without its subject, which was rendered by then: a mesh may be large."""
    return replace(cell, subject=None)


def _lost(future: Any) -> bool:
    from distributed import KilledWorker  # noqa: PLC0415

    return future.status == "error" and isinstance(future.exception(), KilledWorker)


def _ended(future: Any, left: int) -> ToonkitError:
    """Return the error for a study that cannot go on now."""
    if future.status != "error":
        return ToonkitError(
            f"scheduler must stay reachable; got lost with {left} trials to go: run the same command again and it goes on"
        )
    error = future.exception()
    if isinstance(error, ToonkitError):
        return error
    return refuse("workers", "must be able to run the trials", f"{type(error).__name__}: {error}")

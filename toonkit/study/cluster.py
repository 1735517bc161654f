"""Measure batches of a study on a dask cluster, either a local one or a running one."""

from __future__ import annotations

import logging
import pickle
import signal
import threading
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import replace
from multiprocessing import get_context
from typing import Any

from toonkit._validation import ToonkitError, refuse
from toonkit.study.batches import Batch, Outcome, measure, try_to_render
from toonkit.study.provenance import installed_toonkit
from toonkit.study.record_store import LOST
from toonkit.study.records import Record

CONNECT_SECONDS = 20
"""How long to look for a scheduler."""

POLL_SECONDS, LOOK_SECONDS = 0.02, 2.0
"""How often to check futures, and workers."""

NO_WORKER_SECONDS = 30.0
"""How long to wait for a worker to join, or to come back."""

_LOCAL = {
    # Tasks of a dead worker are not retried there: each is measured again alone.
    "distributed.scheduler.allowed-failures": 0,
    # By default, dask's workers return freed memory to the system at once. Page faults then take half of a trial's time.
    **{
        f"distributed.nanny.pre-spawn-environ.MALLOC_{name}_THRESHOLD_": str(2**30)
        for name in ("TRIM", "MMAP")
    },
}


def worker_count(workers: int | None) -> int:
    """Return the number of processes asked for, or one for each core that this process may use."""
    if workers is not None:
        return workers
    from dask.system import CPU_COUNT  # noqa: PLC0415

    return int(CPU_COUNT)


def measure_on_cluster(
    batches: Sequence[Batch], *, workers: int | None, scheduler: str | None
) -> Generator[Outcome, None, None]:
    """
    Measure batches on a cluster, and yield outcomes as they are done.

    If its worker died, or there was none, a batch is measured again on this machine, with each trial in a process of its
    own. Only a trial that ends its process then fails, not the other trials of its batch or of others.
    """
    if scheduler is not None:
        # Each batch names the version of toonkit that may measure it, so workers that join later are checked, too.
        batches = [replace(batch, toonkit=installed_toonkit()) for batch in batches]
    with cluster_client(workers, scheduler, len(batches)) as client:
        suspects: list[Batch] = []
        yield from _submit_all(batches, client, suspects)
        for batch in suspects:
            for one in batch.split():
                yield from _measure_alone(one)


@contextmanager
def cluster_client(workers: int | None, scheduler: str | None, tasks: int) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster of processes of one thread each on this machine."""
    import dask  # noqa: PLC0415  # takes a second, with distributed
    from distributed import Client, LocalCluster  # noqa: PLC0415

    if scheduler is None:
        with dask.config.set(_LOCAL), _ignoring_interrupts():
            cluster = LocalCluster(
                n_workers=min(worker_count(workers), tasks),
                threads_per_worker=1,  # a trial keeps one core busy, and its solvers use idle ones
                memory_limit=None,  # dask would count memory that a worker reuses, and stop the worker
                dashboard_address="127.0.0.1:0",  # any port: another cluster may hold the usual one
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
        _refuse_other_toonkit(client, scheduler)
        yield client


@contextmanager
def _ignoring_interrupts() -> Iterator[None]:
    """Start processes with SIGINT ignored: Ctrl-C reaches this process only, which ends them without stack traces."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may say what a signal does
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _refuse_other_toonkit(client: Any, scheduler: str) -> None:
    with suppress(TimeoutError):  # workers that were started a moment ago are still on their way
        client.wait_for_workers(1, timeout=NO_WORKER_SECONDS)
    try:
        found = client.run(installed_toonkit)
    except Exception as error:  # a worker without toonkit, or with another version, can raise anything
        raise refuse(
            "scheduler", f"must have workers with toonkit {installed_toonkit()}", f"{scheduler} ({error})"
        ) from error
    if not found:
        raise refuse(
            "scheduler", "must have workers", f"{scheduler} without any: start `dask worker {scheduler}`"
        )
    for worker, other in found.items():
        if other != installed_toonkit():
            raise refuse(
                "scheduler", f"must have workers with toonkit {installed_toonkit()}", f"{worker} with {other}"
            )


def _submit_all(batches: Sequence[Batch], client: Any, suspects: list[Batch]) -> Iterator[Outcome]:
    """Submit all batches in the order of their shapes; collect those whose worker died."""
    truths: dict[int, Any] = {}
    waiting: dict[Any, Batch] = {}
    for order, batch in enumerate(batches):
        scene = id(batch.scene)
        if scene not in truths:
            truths[scene] = client.submit(
                try_to_render, batch.scene, batch.settings.size, pure=False, priority=-order
            )
        future = client.submit(measure, truths[scene], _without_scene(batch), pure=False, priority=-order)
        waiting[future] = batch
    truths.clear()  # a rendered shape is forgotten as soon as its last batch is done
    for future in yield_done(waiting, client):
        left = sum(len(batch.trials) for batch in waiting.values())
        batch = waiting.pop(future)
        if future.status == "finished":
            try:
                records = future.result()
            except OSError as error:  # the scheduler is lost while the records are on their way
                raise _lost_scheduler(left) from error
            yield from zip(batch.trials, records, strict=True)
        elif _has_lost_worker(future):
            suspects.append(batch)
        else:
            raise _study_error(future, left)
    suspects.extend(waiting.values())


def yield_done(waiting: dict[Any, Any], client: Any) -> Iterator[Any]:
    """Yield futures as they are done; stop if there has been no worker for `NO_WORKER_SECONDS`."""
    looked = deserted = time.monotonic()
    while waiting:
        done = [future for future in waiting if future.done()]
        yield from done
        now = time.monotonic()
        if done:
            deserted = now
        elif now - looked > LOOK_SECONDS:
            looked = now
            # A worker that dies while it starts is not restarted, and its tasks would wait forever.
            if _has_workers(client):
                deserted = now
            elif now - deserted > NO_WORKER_SECONDS:
                return
        time.sleep(POLL_SECONDS)


def _has_workers(client: Any) -> bool:
    try:
        return bool(client.nthreads())
    except Exception:  # the scheduler is gone, and its futures report it
        return True


def _measure_alone(batch: Batch) -> Iterator[Outcome]:
    """Measure a batch in a process of its own on this machine. If the process dies, the batch is to blame."""
    import cloudpickle  # noqa: PLC0415

    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        try:
            records = process.submit(_measure_pickled, cloudpickle.dumps(batch)).result()
        except BrokenProcessPool:
            records = batch.fail(f"{LOST}its process ended each time that this trial ran in it")
    yield from zip(batch.trials, records, strict=True)


def _measure_pickled(content: bytes) -> list[Record]:
    batch: Batch = pickle.loads(content)
    return measure(try_to_render(batch.scene, batch.settings.size), batch)


def _without_scene(batch: Batch) -> Batch:
    """Return a batch without its scene, which may be large and has been rendered."""
    return replace(batch, scene=None)


def _has_lost_worker(future: Any) -> bool:
    from distributed import KilledWorker  # noqa: PLC0415

    return future.status == "error" and isinstance(future.exception(), KilledWorker)


def _lost_scheduler(left: int) -> ToonkitError:
    return ToonkitError(
        f"scheduler must stay reachable; got lost with {left} trials to go: run the same command again and it goes on"
    )


def _study_error(future: Any, left: int) -> ToonkitError:
    """Return the error for a study that cannot go on now."""
    if future.status != "error":
        return _lost_scheduler(left)
    error = future.exception()
    if isinstance(error, ToonkitError):
        return error
    return refuse("workers", "must be able to run the trials", f"{type(error).__name__}: {error}")

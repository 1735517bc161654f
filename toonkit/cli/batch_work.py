"""The drawings of a batch, analyzed in this process, in several ones, or by the workers of a dask cluster."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from typing import Any, TypeVar

from toonkit._validation import ToonkitError, ToonkitWarning
from toonkit.cli.drawing_work import DrawingWork, analyze_drawing

Answer = TypeVar("Answer")

AHEAD = 2
"""Drawings that are sent to each worker of a cluster, so that none waits for the next."""

ENDED = "its process ended while it was analyzed, perhaps for want of memory"


@dataclass(frozen=True)
class BatchItem:
    """A drawing of a batch, and the folder of its analysis."""

    work: DrawingWork
    folder: Path


@dataclass(frozen=True)
class Outcome:
    """An item that is done, why it failed if it did, and what was assumed of its drawing."""

    item: BatchItem
    error: str | None = None
    warnings: tuple[str, ...] = ()


Outcomes = Generator[Outcome, None, None]


def analyzed_here(items: Iterable[BatchItem]) -> Outcomes:
    """Analyze drawings in this process, one after the other."""
    for item in items:
        yield _analyzed(item)


def analyzed_in_processes(items: Sequence[BatchItem], workers: int) -> Outcomes:
    """
    Analyze drawings in processes on this machine; outcomes come in the order in which they are done.

    If a process dies, the drawings that were handed over by then are analyzed again, each in a process of its own, so that
    only a drawing that kills its process fails.
    """
    waiting = deque(items)
    while waiting:
        suspects: list[BatchItem] = []
        yield from _in_one_pool(waiting, min(workers, len(waiting)), suspects)
        for item in suspects:
            alone: list[BatchItem] = []
            yield from _in_one_pool(deque([item]), 1, alone)
            yield from (Outcome(lost, ENDED) for lost in alone)


def _in_one_pool(waiting: deque[BatchItem], workers: int, suspects: list[BatchItem]) -> Iterator[Outcome]:
    """Take what waits until nothing does, or a process has ended; then put aside what was handed over."""
    running: dict[Future[Outcome], BatchItem] = {}
    # Not forked: numba's threads would be missing in the copies.
    with ProcessPoolExecutor(workers, get_context("spawn"), initializer=_follow_parent) as pool:
        try:
            while waiting or running:
                # One is handed over in advance, so that no process waits.
                while waiting and not suspects and len(running) <= workers:
                    running[pool.submit(_analyzed, waiting[0])] = waiting[0]
                    waiting.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    item = running.pop(future)
                    if isinstance(future.exception(), BrokenProcessPool):
                        suspects.append(item)
                    else:
                        yield future.result()
                if suspects and not running:
                    return
        except BrokenProcessPool:  # as the next one was handed over
            suspects.extend(running.values())
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _follow_parent() -> None:
    """Leave Ctrl-C, which a terminal sends to all, to the parent, and end when that does, even if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)


def analyzed_by_cluster(items: Sequence[BatchItem], scheduler: str) -> Outcomes:
    """Have drawings analyzed by the workers of a dask scheduler, which need not see the files: they are sent."""
    from toonkit.study.cluster import cluster_client, yield_done  # noqa: PLC0415
    from toonkit.study.provenance import installed_toonkit  # noqa: PLC0415

    expected = installed_toonkit()
    left = deque(items)
    with cluster_client(None, scheduler, len(items)) as client:
        most = AHEAD * max(sum(client.nthreads().values()), 1)
        running: dict[Any, BatchItem] = {}

        def hand_over() -> list[Outcome]:
            """Keep all workers busy; return what cannot be read."""
            unread: list[Outcome] = []
            while left and len(running) < most:
                item = left.popleft()
                try:
                    content = item.work.file.read_bytes()
                except OSError as error:
                    unread.append(Outcome(item, _told(error)))
                    continue
                running[client.submit(_analyzed_there, item.work, content, expected, pure=False)] = item
            return unread

        yield from hand_over()
        for future in yield_done(running, client):
            item = running.pop(future)
            if future.status == "finished":
                try:
                    answer = future.result()
                except OSError:  # the scheduler is lost while the answer is on its way
                    running[future] = item
                    break
                yield _written(item, *answer)
            elif future.status == "error":
                yield Outcome(item, _told(future.exception()))
            else:
                running[future] = item
                break
            yield from hand_over()
        if running:
            raise ToonkitError(
                f"scheduler must stay reachable and have workers; got lost with {len(running) + len(left)} drawings to go: "
                "run the same command again and it goes on"
            )


def _analyzed(item: BatchItem) -> Outcome:
    """Analyze a drawing into its folder."""
    error, told = _with_warnings(partial(_error_of, item))
    return Outcome(item, error, told)


def _error_of(item: BatchItem) -> str | None:
    try:
        analyze_drawing(item.work, item.folder)
    except Exception as error:  # the other drawings are to be analyzed whatever happens to this one
        return _told(error)
    return None


def _analyzed_there(
    work: DrawingWork, content: bytes, toonkit: str
) -> tuple[dict[str, bytes] | str, tuple[str, ...]]:
    """
    Analyze a drawing on a worker, given the content of its file.

    Returns the content of the files written, or why it failed, and what was assumed of the drawing.
    """
    from toonkit.study.provenance import installed_toonkit  # noqa: PLC0415

    if installed_toonkit() != toonkit:
        return f"its worker must have toonkit {toonkit}; got {installed_toonkit()}", ()
    return _with_warnings(partial(_files_of, work, content))


def _files_of(work: DrawingWork, content: bytes) -> dict[str, bytes] | str:
    with tempfile.TemporaryDirectory() as name:
        file, folder = Path(name) / work.file.name, Path(name) / "analysis"
        file.write_bytes(content)
        try:
            written = analyze_drawing(replace(work, file=file), folder).files
        except Exception as error:
            return _told(error).replace(str(file), str(work.file))
        return {path.name: path.read_bytes() for path in written}


def _written(item: BatchItem, files: dict[str, bytes] | str, told: tuple[str, ...]) -> Outcome:
    """Write the files that a worker returned, unless it returned why it failed."""
    from toonkit.export.folder import fill_folder, make_folder  # noqa: PLC0415

    if isinstance(files, str):
        return Outcome(item, files, told)
    try:
        folder = make_folder(item.folder)
        fill_folder(folder, {name: partial(_write, content) for name, content in files.items()})
    except ToonkitError as error:
        return Outcome(item, _told(error), told)
    return Outcome(item, warnings=told)


def _write(content: bytes, path: Path) -> None:
    from toonkit.export.atomic import atomic_write  # noqa: PLC0415

    with atomic_write(path) as file:
        file.write(content)


def _told(error: BaseException) -> str:
    """Return an error in one line; of one that is no refusal also its type."""
    message = " ".join(str(error).split())
    return message if isinstance(error, ToonkitError) else f"{type(error).__name__}: {message}"


def _with_warnings(work: Callable[[], Answer]) -> tuple[Answer, tuple[str, ...]]:
    """Return what a function returns, and the warnings on the way."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ToonkitWarning)
        answer = work()
    return answer, tuple(str(warning.message) for warning in caught)

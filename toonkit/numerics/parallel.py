"""Loops over the pixels of a grid on all cores, whose results do not depend on how many cores there are."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from toonkit.numerics.compiled import njit

CHUNK_PIXELS = 6_000
"""Pixels of a chunk at least: fewer are done before another thread has started."""

CHUNK_NUMBERS = 16_384
"""Numbers in a chunk: few enough for a core's own cache, so that what is computed on the way is never new memory."""

MOST_CHUNKS = 16
"""Chunks at most. Their number depends on the grid alone, never on the machine: so do the results."""


@dataclass(frozen=True)
class RowChunks:
    """
    The pixels of a grid, in row-major order, cut into chunks of whole rows.

    Attributes
    ----------
    spans : tuple of (int, int)
        First pixel of each chunk and the one after its last. Each chunk starts at an even row, so that no block of 2 x 2
        pixels lies in two.
    separators : tuple of (int, int)
        The first rows of all chunks but the first. What lies between two of them has no neighbor across.
    between : tuple of (int, int)
        The chunks without those rows.
    """

    spans: tuple[tuple[int, int], ...]
    separators: tuple[tuple[int, int], ...]
    between: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, rows: NDArray[np.integer]) -> RowChunks:
        """Cut pixels whose rows (P,) do not fall."""
        size = len(rows)
        count = int(np.clip(size // CHUNK_PIXELS, 1, MOST_CHUNKS))
        wanted = rows[[size * k // count for k in range(1, count)]] // 2 * 2
        cuts = np.unique(np.searchsorted(rows, wanted))
        cuts = cuts[cuts > 0]
        after = np.searchsorted(rows, rows[cuts], side="right")
        starts, ends = [0, *cuts.tolist()], [*cuts.tolist(), size]
        return cls(
            spans=tuple(zip(starts, ends, strict=True)),
            separators=tuple(zip(cuts.tolist(), after.tolist(), strict=True)),
            between=tuple(zip([0, *after.tolist()], ends, strict=True)),
        )

    def run(self, loop: Callable[..., Any], *arguments: Any) -> list[Any]:
        """Call `loop(*arguments, first, last)` for every chunk; return what they return, in order."""
        return _run_parallel(loop, arguments, self.spans)

    def sweep(self, loop: Callable[..., Any], *arguments: Any, backward: bool) -> None:
        """
        Call `loop(*arguments, backward, first, last)` where each pixel's step reads what was written to its neighbors.

        Separators come first, and last on the way back: so it is one order of the pixels and its reverse.
        """
        steps = [
            lambda: [loop(*arguments, backward, *span) for span in self.separators],
            lambda: _run_parallel(loop, (*arguments, backward), self.between),
        ]
        for step in reversed(steps) if backward else steps:
            step()


def inner_product(a: NDArray[Any], b: NDArray[Any]) -> float:
    """
    Return the inner product of two fields of any shape; of complex ones the real part.

    BLAS would leave its threads spinning on the other cores, and would round otherwise on other machines.
    """
    flat = [np.ascontiguousarray(field).view(np.empty(0, field.dtype).real.dtype).ravel() for field in (a, b)]
    cuts = [len(flat[0]) * k // MOST_CHUNKS for k in range(MOST_CHUNKS + 1)]
    if len(flat[0]) < CHUNK_PIXELS:
        return float(_sum_products(*flat, 0, len(flat[0])))
    return float(sum(_run_parallel(_sum_products, tuple(flat), tuple(pairwise(cuts)))))


@njit(cache=True, nogil=True)
def _sum_products(a, b, first, last):  # type: ignore[no-untyped-def]
    total = 0.0
    for k in range(first, last):
        total += a[k] * b[k]
    return total


def run_on_row_chunks(loop: Callable[..., Any], *arguments: Any) -> None:
    """Call `loop(*arguments, first, last)` for chunks of the rows of the first argument, an array (H, ...)."""
    height = len(arguments[0])
    count = int(np.clip(arguments[0].size // CHUNK_PIXELS, 1, MOST_CHUNKS))
    cuts = [height * k // count for k in range(count + 1)]
    _run_parallel(loop, arguments, tuple(pairwise(cuts)))


def run_on_chunks(loop: Callable[..., Any], size: int, *arguments: Any) -> list[Any]:
    """
    Call `loop(*arguments, chunk)` for slices that make up `size` numbers; return what they return, in order.

    For arithmetic on whole arrays, which is done faster chunk by chunk.
    """
    chunks = tuple(
        (slice(first, min(first + CHUNK_NUMBERS, size)),) for first in range(0, size, CHUNK_NUMBERS)
    )
    return _run_parallel(loop, arguments, chunks)


def run_each(works: Sequence[Callable[[], Any]]) -> list[Any]:
    """Call each of some functions; return what they return, in order."""
    with single_threaded_blas():
        return _run_parallel(_call, (), tuple((work,) for work in works))


def _call(work: Callable[[], Any]) -> Any:
    return work()


class _SharedLimit:
    """A limit for the whole process, set when the first thread asks for it and lifted when the last one has left."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._holders = 0
        self._limit = ExitStack()

    def hold(self) -> None:
        with self._lock:
            if self._holders == 0:
                _keeper().submit(self._set).result()
            self._holders += 1

    def release(self) -> None:
        with self._lock:
            self._holders -= 1
            if self._holders == 0:
                _keeper().submit(self._limit.close).result()

    def _set(self) -> None:
        self._limit.enter_context(_libraries().limit(limits=1, user_api="blas"))


_SINGLE_THREADED = _SharedLimit()


@cache
def _keeper() -> ThreadPoolExecutor:
    """Return the thread that sets the limit: threadpoolctl lets no other lift it."""
    return ThreadPoolExecutor(1, "toonkit-blas")


@contextmanager
def single_threaded_blas() -> Iterator[None]:
    """
    Keep BLAS to the core that calls it: threads of its own go on spinning on the others long after they are done.

    The limit holds until all threads that asked for it have left. With more threads BLAS would round otherwise.
    """
    _SINGLE_THREADED.hold()
    try:
        yield
    finally:
        _SINGLE_THREADED.release()


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


def _run_parallel(
    loop: Callable[..., Any], arguments: tuple[Any, ...], spans: tuple[tuple[Any, ...], ...]
) -> list[Any]:
    results: list[Any] = [None] * len(spans)
    waiting = iter(range(len(spans)))

    def work() -> None:
        for k in waiting:
            results[k] = loop(*arguments, *spans[k])

    helping = [_thread_pool().submit(work) for _ in range(min(count_cores(), len(spans)) - 1)]
    work()
    for helper in helping:
        if not helper.cancel():  # one that has not begun finds nothing left to do
            helper.result()
    return results


def count_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _thread_pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(count_cores() - 1, 1), "toonkit-chunk")


if hasattr(os, "register_at_fork"):  # a forked process has none of its parent's threads
    os.register_at_fork(after_in_child=_thread_pool.cache_clear)
    os.register_at_fork(after_in_child=_keeper.cache_clear)

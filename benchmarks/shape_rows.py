"""Rows of a table, measured shape by shape on all cores: what the benchmarks over the study's shapes share."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from toonkit.export.atomic import atomic_write

Row = dict[str, str | float]
Work = Callable[[str], list[Row]]


def measured_rows(work: Work, shapes: Iterable[str], *, workers: int) -> pd.DataFrame:
    """Return the rows of all shapes, in order; measured in this process if there are no workers."""
    shapes = list(shapes)
    parts = tqdm(_parts(work, shapes, workers), total=len(shapes), file=sys.stderr, unit="shape")
    return pd.DataFrame([row for part in parts for row in part])


def _parts(work: Work, shapes: list[str], workers: int) -> Iterator[list[Row]]:
    if workers == 0:
        yield from (_on_one_core(work, shape) for shape in shapes)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(_on_one_core, [work] * len(shapes), shapes)


def _on_one_core(work: Work, shape: str) -> list[Row]:
    with threadpool_limits(1, user_api="blas"):  # workers would wait for each other's threads
        return work(shape)


def write_rows(rows: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV with six digits, whole or not at all."""
    with atomic_write(path) as file:
        rows.to_csv(file, index=False, float_format="%.6g")

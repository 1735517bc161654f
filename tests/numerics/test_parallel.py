import contextlib
import threading
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
import threadpoolctl

from tests.analytic import blob_mask
from toonkit.numerics import parallel
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid
from toonkit.numerics.parallel import run_each, run_on_chunks, run_on_row_chunks, single_threaded_blas


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr(parallel, "CHUNK_PIXELS", 60)


@pytest.fixture(params=[1, 2, 3, 7], ids=lambda cores: f"{cores}-cores", autouse=True)
def cores(request, monkeypatch):
    monkeypatch.setattr(parallel, "count_cores", lambda: request.param)


@pytest.mark.parametrize("seed", range(4))
def test_every_pixel_lies_in_one_band_and_no_block_in_two(seed):
    grid = MaskedGrid(blob_mask(seed, size=40))
    spans = grid.chunks.spans
    assert len(spans) > 3
    assert [place for span in spans for place in range(*span)] == list(range(grid.size))
    for (_, end), (start, _) in pairwise(spans):
        assert end == start
        assert grid.rows[start] % 2 == 0
        assert grid.rows[start] > grid.rows[start - 1]


@pytest.mark.parametrize("seed", range(4))
def test_no_pixel_sees_across_a_separator(seed):
    grid = MaskedGrid(blob_mask(seed, size=40))
    owner = np.full(grid.size, -1)
    for k, span in enumerate(grid.chunks.between):
        owner[slice(*span)] = k
    for here, there in zip(grid.neighbors.T, grid.neighbors.T, strict=True):
        linked = np.flatnonzero(here != OUTSIDE)
        a, b = owner[linked], owner[there[linked]]
        assert ((a == b) | (a == -1) | (b == -1)).all()


def test_results_come_in_the_order_of_the_bands():
    grid = MaskedGrid(blob_mask(1, size=40))
    assert grid.chunks.run(lambda scale, first, last: (scale * first, scale * last), 2) == [
        (2 * first, 2 * last) for first, last in grid.chunks.spans
    ]


def test_a_sweep_visits_every_pixel_once_and_back_in_the_reverse_order(monkeypatch):
    monkeypatch.setattr(parallel, "count_cores", lambda: 1)
    grid = MaskedGrid(blob_mask(2, size=40))
    order = {}
    for backward in (False, True):
        seen = order[backward] = []

        def visit(backward, first, last, seen=seen):
            seen += reversed(range(first, last)) if backward else range(first, last)

        grid.chunks.sweep(visit, backward=backward)
    assert sorted(order[False]) == list(range(grid.size))
    assert set(order[True]) == set(order[False])


def test_what_a_loop_raises_is_raised():
    def fail(first, last):
        if first:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        MaskedGrid(blob_mask(1, size=40)).chunks.run(fail)


def test_the_rows_of_an_array_are_all_run():
    picture, done = np.ones((50, 9)), np.zeros(50, int)

    def count(picture, first, last):
        done[first:last] += 1

    run_on_row_chunks(count, picture)
    assert (done == 1).all()


def test_pieces_make_up_the_whole_in_order(monkeypatch):
    monkeypatch.setattr(parallel, "CHUNK_NUMBERS", 7)
    values = np.arange(40.0)
    doubled = np.zeros(40)

    def double(values, doubled, chunk):
        doubled[chunk] += 2 * values[chunk]
        return chunk.start

    assert run_on_chunks(double, 40, values, doubled) == list(range(0, 40, 7))
    assert np.array_equal(doubled, 2 * values)
    assert run_on_chunks(double, 0, values, doubled) == []


def test_of_several_functions_the_answers_come_in_order():
    assert run_each([lambda k=k: k**2 for k in range(9)]) == [k**2 for k in range(9)]


def blas_threads():
    return {pool["num_threads"] for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"}


@pytest.mark.parametrize("inside", [contextlib.nullcontext, single_threaded_blas])
def test_blas_keeps_to_one_thread_and_has_its_own_back_afterwards(inside):
    before = blas_threads()
    with ThreadPoolExecutor(1) as pool, single_threaded_blas():
        with inside():
            assert blas_threads() == {1}
        assert blas_threads() == pool.submit(blas_threads).result() == {1}
    assert blas_threads() == before


def test_blas_keeps_to_one_thread_until_the_last_of_two_has_left():
    before, entered, leave = blas_threads(), threading.Event(), threading.Event()

    def hold():
        with single_threaded_blas():
            entered.set()
            assert leave.wait(60)
            return blas_threads()

    with ThreadPoolExecutor(1) as pool:
        for last_to_enter_leaves_first in (True, False):
            entered.clear()
            leave.clear()
            other = pool.submit(hold)
            assert entered.wait(60)
            with single_threaded_blas():
                if not last_to_enter_leaves_first:
                    leave.set()
                    assert other.result() == {1}
                assert blas_threads() == {1}
            assert blas_threads() == ({1} if last_to_enter_leaves_first else before)
            leave.set()
            assert other.result() == {1}
    assert blas_threads() == before

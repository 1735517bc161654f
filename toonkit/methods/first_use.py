"""The first analysis on a machine compiles: a second process takes the last loops, while this one sees to the rest."""

from __future__ import annotations

import multiprocessing
import os
import sys
from functools import cache
from pathlib import Path
from subprocess import DEVNULL, Popen
from threading import Thread
from typing import Any

import numpy as np

from toonkit._validation import as_light
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.membrane import uniform_links
from toonkit.numerics.unit_field_kernels import finish_blocks, gather_blocks, relax, slope

LATEST = (relax, slope, finish_blocks, gather_blocks)
"""The loops that are needed last, half of what there is to compile. The two of the blocks in reverse: where the first
process comes too early, it compiles the one while the second compiles the other."""

NO_WINDOW = 0x08000000
"""What keeps Windows from opening one for a new process."""


@cache
def share_compiling() -> None:
    """
    Let a second process compile the last loops, if none has done so on this machine.

    It writes them where this process will look for them when it needs them; if it fails, or is late, this one compiles them
    itself. Nothing is done in one of many workers, on a single core, or where Python is inside of another program.
    """
    if not _is_interpreter() or multiprocessing.parent_process() is not None or _cores() == 1:
        return
    if all(map(_is_compiled, LATEST)):
        return
    # It finds modules where this process does, and nowhere else.
    command = (
        f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import compile_latest; compile_latest()"
    )
    try:
        helper = Popen(
            [sys.executable, "-c", command],
            stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL, creationflags=NO_WINDOW if os.name == "nt" else 0,
        )  # fmt: skip
        Thread(target=helper.wait, name="toonkit-first-use", daemon=True).start()
    except (OSError, RuntimeError):  # no more processes, or no more threads
        return


def compile_latest() -> None:
    """Compile the loops for what an analysis calls them with, by calling them on a few pixels."""
    grid = MaskedGrid(np.ones((2, 2), np.bool_))
    normals, none = np.tile([0.0, 0.0, 1.0], (grid.size, 1)), np.zeros(0)
    bounds = np.zeros(grid.size)
    light = as_light("light", (0.0, 0.0, 1.0))  # which cannot be written to, as every light
    problem = (
        grid.neighbors, normals, light, none, none, bounds, bounds, bounds, uniform_links(grid), bounds, 1.0, 1.0,
        np.zeros((0, 3)),
    )  # fmt: skip
    relax(*problem, normals.copy(), False, 0, grid.size)
    slope(*problem, normals, normals.copy(), 0, grid.size)
    coarse = grid.coarsening.coarse
    means, slopes = np.zeros((2, coarse.size, 3))
    sums = np.zeros((4, coarse.size))
    finish_blocks(light, means, *sums[1:], np.empty(coarse.size), 0, coarse.size)
    gather_blocks(
        grid.coarsening.parent, light, normals, normals, none, bounds, bounds, bounds, means, slopes, *sums, 0, grid.size
    )  # fmt: skip


def _is_interpreter() -> bool:
    """Tell whether this process is Python itself, and can be called again as such."""
    return not getattr(sys, "frozen", False) and Path(sys.executable or "").stem.lower().startswith("python")


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _is_compiled(loop: Any) -> bool:
    """Tell whether numba has an index of a compiled loop on file: of this Python, but perhaps of an older numba."""
    if not hasattr(loop, "stats"):  # numba was told not to compile
        return True
    module, line = loop.__module__.rpartition(".")[2], loop.py_func.__code__.co_firstlineno
    version = "".join(map(str, sys.version_info[:2])) + getattr(sys, "abiflags", "")
    return (Path(loop.stats.cache_path) / f"{module}.{loop.__name__}-{line}.py{version}.nbi").is_file()

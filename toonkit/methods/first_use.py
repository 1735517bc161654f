"""
The first analysis on a machine compiles: a second process takes the two longest loops, while this one sees to the rest.

Neither compiles what the other does: before the refinement, which needs them, this process waits for the second one.
"""

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
from toonkit.estimation.edges import edge_links
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics.bands import cores
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.membrane import uniform_links
from toonkit.numerics.unit_field_kernels import finish_blocks, gather_blocks, relax, retract, slope
from toonkit.numerics.unit_field_problem import UnitFieldProblem
from toonkit.numerics.unit_vectors import moved

LATE = (retract, relax, slope)
"""The loops that the second process compiles, in the order of need: about half of what there is."""

PATIENCE = 60.0
"""Seconds after which this process compiles them itself."""

NO_WINDOW = 0x08000000
"""What keeps Windows from opening one for a new process."""

_waiting: list[Thread] = []
"""What waits for the second process, until the refinement has waited for it."""


@cache
def share_compiling() -> None:
    """
    Let a second process compile some loops, if none has done so on this machine; see `finish_compiling`.

    It writes them where this process will look for them when it needs them; if it fails, this one compiles them itself.
    Nothing is done in one of many workers, on a single core, or where Python is inside of another program.
    """
    if not _is_interpreter() or multiprocessing.parent_process() is not None or cores() == 1:
        return
    if all(map(_is_compiled, LATE)):
        return
    # It finds modules where this process does, and nowhere else. An orderly end would take half a second, for which this
    # process would wait.
    command = f"import os, sys; sys.path[:] = {sys.path!r}; from {__name__} import compile_late; compile_late(); os._exit(0)"
    try:
        helper = Popen(
            [sys.executable, "-c", command],
            stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL, creationflags=NO_WINDOW if os.name == "nt" else 0,
        )  # fmt: skip
        waiting = Thread(target=helper.wait, name="toonkit-first-use", daemon=True)
        waiting.start()
        _waiting.append(waiting)
    except (OSError, RuntimeError):  # no more processes, or no more threads
        return


def finish_compiling() -> None:
    """Wait for the second process, if there is one; compile meanwhile what the refinement needs besides."""
    for waiting in tuple(_waiting):
        _compile_rest()
        waiting.join(PATIENCE)
    _waiting.clear()


def compile_late() -> None:
    """Compile the loops of the second process for what an analysis calls them with, by calling them on a few pixels."""
    problem = _problem_of_a_few_pixels()
    normals = moved(problem.grid, problem.start, problem.start)
    problem.relax(problem.posed, normals, backward=False)
    problem.slope(problem.posed, normals, np.empty_like(normals))


def _compile_rest() -> None:
    """Compile in the same way what else the refinement needs."""
    problem = _problem_of_a_few_pixels()
    step, light, normals, bounds = problem.grid.coarsening, problem.direction, problem.start, problem.lower
    edge_links(problem.grid, normals, IlluminationInterval(bounds, bounds), turn=1.0, jump=1.0)
    means, slopes = np.zeros((2, step.coarse.size, 3))
    sums = np.zeros((4, step.coarse.size))
    gather_blocks(
        step.parent, light, normals, normals, np.zeros(0), bounds, bounds, bounds, means, slopes, *sums, 0, len(normals)
    )  # fmt: skip
    finish_blocks(light, means, *sums[1:], np.empty(step.coarse.size), 0, step.coarse.size)


def _problem_of_a_few_pixels() -> UnitFieldProblem:
    grid = MaskedGrid(np.ones((2, 2), np.bool_))
    ones = np.ones(grid.size)
    return UnitFieldProblem(
        grid=grid,
        start=np.tile([0.0, 0.0, 1.0], (grid.size, 1)),
        direction=as_light("light", (0.0, 0.0, 1.0)),  # which cannot be written to, as every light
        lower=ones,
        upper=ones,
        weight=ones,
        links=uniform_links(grid),
        ties=ones,
        change_weight=1.0,
        integrability_weight=1.0,
    )


def _is_interpreter() -> bool:
    """Tell whether this process is Python itself, and can be called again as such."""
    return not getattr(sys, "frozen", False) and Path(sys.executable or "").stem.lower().startswith("python")


def _is_compiled(loop: Any) -> bool:
    """Tell whether numba has an index of a compiled loop on file: of this Python, but perhaps of an older numba."""
    if not hasattr(loop, "stats"):  # numba was told not to compile
        return True
    module, line = loop.__module__.rpartition(".")[2], loop.py_func.__code__.co_firstlineno
    version = "".join(map(str, sys.version_info[:2])) + getattr(sys, "abiflags", "")
    return (Path(loop.stats.cache_path) / f"{module}.{loop.__name__}-{line}.py{version}.nbi").is_file()

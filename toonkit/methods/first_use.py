"""The first analysis on a machine compiles: a second process takes the longest loops, while this one sees to the rest."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from toonkit._validation import as_light
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.numerics.membrane import uniform_links
from toonkit.numerics.unit_field_kernels import relax, slope

LONGEST = (slope, relax)
"""Loops that take nearly half of the time, in the order in which they are needed, which is late."""

COMMAND = f"from {__name__} import compile_longest; compile_longest()"


@cache
def share_compiling() -> None:
    """
    Let a second process compile the longest loops, if none has done so on this machine.

    It writes them where this process will look for them when it needs them; if it fails, or is late, this one compiles them
    itself. Nothing is done where Python is inside of another program, which is no interpreter to be called.
    """
    callable_python = Path(sys.executable or "").stem.lower().startswith("python")
    if not callable_python or os.cpu_count() == 1 or all(map(_is_compiled, LONGEST)):
        return
    nowhere, windowless = subprocess.DEVNULL, getattr(subprocess, "CREATE_NO_WINDOW", 0)
    try:
        helper = subprocess.Popen(
            [sys.executable, "-c", COMMAND],
            stdin=nowhere, stdout=nowhere, stderr=nowhere, creationflags=windowless,
        )  # fmt: skip
    except OSError:
        return
    threading.Thread(target=helper.wait, name="toonkit-first-use", daemon=True).start()


def _is_compiled(loop: Any) -> bool:
    """Tell whether a compiled loop of this version of Python is on file."""
    if not hasattr(loop, "stats"):  # numba was told not to compile
        return True
    module, version = loop.__module__.rpartition(".")[2], "".join(map(str, sys.version_info[:2]))
    return any(Path(loop.stats.cache_path).glob(f"{module}.{loop.__name__}-*.py{version}.nbi"))


def compile_longest() -> None:
    """Compile the loops for what an analysis calls them with, by calling them on a few pixels."""
    grid = MaskedGrid(np.ones((2, 2), np.bool_))
    normals, none = np.tile([0.0, 0.0, 1.0], (grid.size, 1)), np.zeros(0)
    bounds, light = np.zeros(grid.size), as_light("light", (0.0, 0.0, 1.0))
    problem = (
        grid.neighbors, normals, light, none, none, bounds, bounds, bounds, uniform_links(grid), bounds, 1.0, 1.0,
        np.zeros((0, 3)),
    )  # fmt: skip
    slope(*problem, normals, normals.copy(), 0, grid.size)
    relax(*problem, normals.copy(), False, 0, grid.size)

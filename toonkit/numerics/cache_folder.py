"""ensure_cache_folder: a place for compiled loops where neither the package nor the user's cache can be written to."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile

from numba import config, njit


def ensure_cache_folder() -> None:
    """
    Give Numba a temporary folder for compiled code if it finds no other; call it before any loop is declared.

    Numba refuses to declare a cached loop without one, as for a user without a home whose packages belong to another.
    The folder is removed when this process ends; child processes share it. Without one, nothing is cached.
    """
    if _can_cache():
        return
    try:
        folder = tempfile.mkdtemp(prefix="toonkit-")
    except OSError:
        return
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = (
        folder  # for child processes, and because Numba reads it again before it compiles
    )
    config.reload_config()


def _can_cache() -> bool:
    try:
        njit(cache=True)(_can_cache)
    except (OSError, RuntimeError):
        return False
    return True

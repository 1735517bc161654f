"""njit: Numba's, quicker to compile, with a cache on disk that may be damaged, full or missing without any other harm."""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numba
from numba.core.caching import FunctionCache
from numba.core.compiler import Compiler
from numba.core.runtime import rtsys

_told: list[str] = []


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles or loads a function on its first call; options are those of `numba.njit`."""
    cached = options.pop("cache", False)

    def declare(function: Callable[..., Any]) -> Any:
        # Loops over scalars have no array expressions to rewrite, and nothing written in C calls them through a wrapper.
        quick = {"pipeline_class": _Compiler, "no_rewrites": True, "no_cfunc_wrapper": True}
        dispatcher = numba.njit(**quick, **options)(function)
        if cached and dispatcher is not function:  # as it is where Numba is switched off
            try:
                dispatcher._cache = _ForgivingCache(function)
            except (OSError, RuntimeError) as error:  # no folder can be written to
                _tell_once(str(error))
        return dispatcher

    return declare


class _Compiler(Compiler):
    """Numba's, without collecting garbage meanwhile: of the many objects that it makes nearly all are in use."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function."""
        collecting = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            if collecting:
                gc.enable()


class _ForgivingCache(FunctionCache):
    """Numba's cache of one function, which raises whatever is wrong with its files."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return compiled code; None if there is none, or a damaged one, which is dropped."""
        try:
            # As Numba does, but without registering all that compiling needs, which takes a quarter of a second.
            rtsys.initialize(target_context)
            return self._load_overload(sig, target_context)
        except Exception as error:  # unpickling raises any type for a damaged file
            _tell_once(f"{self.cache_path}: {type(error).__name__}: {error}")
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save compiled code, if it can be saved."""
        try:
            super().save_overload(sig, data)
        except Exception as error:  # as above; and disks are full
            _tell_once(f"{self.cache_path}: {type(error).__name__}: {error}")


@njit(inline="always")
def larger(a: float, b: float) -> float:
    """Return the larger of two numbers. Numba compiles `max` anew for each pair of types, which takes longer."""
    return a if a > b else b


@njit(inline="always")
def smaller(a: float, b: float) -> float:
    """Return the smaller of two numbers."""
    return a if a < b else b


def _tell_once(reason: str) -> None:
    """Log one line in each process, which goes to stderr unless the program has its own handlers."""
    if not _told:
        _told.append(reason)
        logging.getLogger("toonkit").warning(
            "toonkit compiles anew, which takes seconds: its cache cannot be used (%s)",
            " ".join(reason.split()),
        )

"""Standard streams that are closed, full, or read by nobody."""

from __future__ import annotations

import io
import os
import sys
from typing import TextIO


def prepare_streams() -> None:
    """Replace closed streams by ones that swallow all, and let a terminal that lacks a sign show another."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # as Python leaves a stream that was closed when it started
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - open until the end
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # such as the sign for degrees


def discard_output() -> None:
    """Send what is left for stdout nowhere, or Python would complain of it once more as it ends."""
    _discard(sys.stdout)


def complain(message: str) -> None:
    """Say in one line on stderr what went wrong, if anything can be said there."""
    try:
        print(f"toonkit: {' '.join(message.split())}", file=sys.stderr, flush=True)
    except OSError:
        _discard(sys.stderr)  # or Python would end with a status of its own


def _discard(stream: TextIO) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)

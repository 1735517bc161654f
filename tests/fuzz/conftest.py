"""What every fuzz test has to keep to besides its answers: nothing on stderr, and little memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.fuzz.profiles import MOST_MEMORY

PROCESS = Path("/proc/self")
RESET_THE_PEAK = "5"


@pytest.fixture(autouse=True)
def nothing_on_stderr(capfd: pytest.CaptureFixture[str]) -> Iterator[None]:
    """Fail a test during which a library, Python or C, wrote to stderr."""
    yield
    assert capfd.readouterr().err == ""


@pytest.fixture(autouse=True)
def little_memory() -> Iterator[None]:
    """Fail a test during which the process took more than `MOST_MEMORY`, where Linux knows it."""
    reset = PROCESS / "clear_refs"
    if not reset.exists():
        yield
        return
    reset.write_text(RESET_THE_PEAK)
    yield
    (peak,) = (line for line in (PROCESS / "status").read_text().splitlines() if line.startswith("VmHWM"))
    assert int(peak.split()[1]) * 1024 < MOST_MEMORY

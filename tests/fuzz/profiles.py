"""How long the fuzz tests look: half a minute by default, for hours if `TOONKIT_FUZZ_FACTOR` says so."""

from __future__ import annotations

import os
from datetime import timedelta

from hypothesis import HealthCheck, settings

FUZZ_FACTOR = int(os.environ.get("TOONKIT_FUZZ_FACTOR", "1"))
"""How many times as many examples each test tries as it does in the suite."""

LONGEST_EXAMPLE = timedelta(seconds=20)
"""Time for one example of a long search; not for the suite's, whose first ones may have to compile the library."""

MOST_MEMORY = 2 * 2**30
"""Bytes that the whole process may take during a test."""


def fuzz(few: int) -> settings:
    """Return settings for a test that tries a few examples in the suite, always the same ones, and many others if asked."""
    long = FUZZ_FACTOR > 1
    return settings(
        max_examples=few * FUZZ_FACTOR,
        derandomize=not long,
        database=None,
        deadline=LONGEST_EXAMPLE if long else None,
        suppress_health_check=list(HealthCheck),
    )

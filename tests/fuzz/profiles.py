"""How long the fuzz tests look: a few seconds each by default, for hours if `TOONKIT_FUZZ_EXAMPLES` says so."""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

FUZZ_EXAMPLES = int(os.environ.get("TOONKIT_FUZZ_EXAMPLES", "0"))
"""Examples of each test; 0 for the few of each test's own."""


def fuzz(few: int) -> settings:
    """Return settings for a test that tries a few examples in the suite, always the same ones, and many others if asked."""
    return settings(
        max_examples=FUZZ_EXAMPLES or few,
        derandomize=not FUZZ_EXAMPLES,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )

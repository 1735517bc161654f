"""Arrays to pictures: HoloViews elements, PyVista scenes, and the relight view. Estimates nothing."""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    """Import Panel only for what needs it."""
    if name == "relight_view":
        from toonkit.viz.light_view import relight_view  # noqa: PLC0415

        return relight_view
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

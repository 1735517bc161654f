"""The JavaScript of the relight views: files put together to one module, which imports nothing."""

from __future__ import annotations

from pathlib import Path

_PAINTING = (
    "shader.js",
    "tone_ramp.js",
    "picture_frame.js",
    "gestures.js",
    "light_card.js",
    "split_slider.js",
)

EDITOR = (
    *_PAINTING, "light_path.js", "label_map.js", "ramp_editor.js", "materials_editor.js", "shape_map.js", "tilt_ball.js",
    "shape_editor.js", "shortcuts.js", "view_style.js", "shape_style.js", "view.js",
)  # fmt: skip
"""What the relight page needs, in order: a module that imports others would have to be served from somewhere."""

VIEW = (*_PAINTING, "view_style.js", "light_view.js")
"""What the relit picture with its light needs alone."""


def joined(names: tuple[str, ...]) -> str:
    """Return some of the files as one module."""
    return "\n".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in names)

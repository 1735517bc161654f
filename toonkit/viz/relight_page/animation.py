"""The animation that a visitor of the relight page downloads: the light along its path, or once around the object."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import panel as pn
import panel_material_ui as pmui

from toonkit._validation import refuse
from toonkit.export.animation import write_light_path, write_orbit
from toonkit.viz.page_style import WIDE
from toonkit.viz.relight_page.busy_line import BusyLine
from toonkit.viz.relight_page.settings import ANIMATION_SUFFIXES
from toonkit.viz.relight_page.state import RelightState
from toonkit.viz.turns import TURNS, Progress

ORBIT_FRAMES = 36
"""Number of frames of an animation without a path."""

MOST_PIXELS = 210_000_000
"""Largest number of pixels in all frames of an animation together: 50 frames of 2048 x 2048."""


def animation_maker(state: RelightState) -> Callable[[Progress], bytes]:
    """
    Return a function that writes the animation of what is on screen now, to be called in a thread.

    Raises
    ------
    ToonkitError
        If the animation is too large for a page.
    """
    analysis, options, suffix = state.recolored, state.relight_options, state.animation_suffix
    travels, loops, elevation = state.travels, state.path_loops, state.new_light[1]
    lights = [tuple(light) for light in state.key_lights]
    frames = state.path_frames if travels else ORBIT_FRAMES
    pixels = frames * analysis.image.mask.size
    if pixels > MOST_PIXELS:
        rule = (
            f"must have at most {MOST_PIXELS // 10**6} million pixels in all frames: choose a shorter path, "
            "or use `toonkit relight --orbit`"
        )
        raise refuse("animation", rule, f"{pixels / 10**6:.0f} million")

    def make(progress: Progress) -> bytes:
        with TURNS.turn(progress) as limited, TemporaryDirectory() as folder:
            path = Path(folder) / f"animation{suffix}"

            def report(fraction: float) -> None:
                limited("painting frames", fraction)

            if travels:
                write_light_path(
                    analysis, path, lights, frames=frames, loop=loops, progress=report, **options
                )
            else:
                write_orbit(analysis, path, frames=frames, elevation=elevation, progress=report, **options)
            return path.read_bytes()

    return make


def animation_download(state: RelightState, busy: BusyLine) -> pn.Column:
    """Return the button that makes an animation, as a task of `busy`, and downloads it, beside a choice of formats."""
    made = BytesIO()
    formats = {suffix[1:].upper().replace("WEBP", "WebP"): suffix for suffix in ANIMATION_SUFFIXES}
    button = pmui.Button(
        label="Animation",
        variant="outlined",
        margin=(4, 6, 4, 12),
        disabled=state.param.analysis.rx.is_(None),
        **WIDE,
    )
    choice = pmui.Select.from_param(
        state.param.animation_suffix, label="", options=formats, size="small", width=96, margin=(4, 12, 4, 0)
    )
    hand_over = pmui.FileDownload(callback=lambda: made, filename="relit.gif", visible=False)

    async def pressed(_: object) -> None:
        hand_over.param.update(data=None, filename=f"relit{state.animation_suffix}")
        content = await busy.run("painting frames", animation_maker(state))
        if content is not None:
            made.seek(0)
            made.truncate()
            made.write(content)
            hand_over.transfer(download=True)

    button.on_click(pressed)
    row = pn.Row(button, choice, **WIDE)
    return pn.Column(row, pn.Column(busy, margin=(0, 12), **WIDE), hand_over, **WIDE)

"""What is on screen, as Python and as commands: both paint the same picture from the visitor's file. Knows no panel."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from toonkit.model.luminance import color_of_hex
from toonkit.model.tone_ramp import ToneRamp
from toonkit.samples import PREFIX
from toonkit.viz.relight_page.state import RelightState

SAVE_FIRST = "{name} is this drawing as you left it: save the session first."
KEEP_BESIDE = "Run it in the folder of {name}."

WHITE = "#ffffff"


@dataclass(frozen=True)
class Snippet:
    """
    Something to be copied.

    Attributes
    ----------
    text : str
        The code.
    note : str
        Which file it needs, in a sentence.
    """

    text: str
    note: str


@dataclass(frozen=True)
class Recipe:
    """
    How the picture on screen is made.

    Attributes
    ----------
    source : str
        The file to begin with, as a path that no program takes for something else.
    is_saved : bool
        Whether it holds an analysis.
    note : str
        Which file that is, in a sentence.
    light : tuple of float or None
        Azimuth and elevation of the drawing's light; None where it is estimated, or is in the file.
    method : str
        Name in `toonkit.METHODS`.
    ramps : dict of int to ToneRamp, or None
        Other ramps for its materials; None if they are as in the file.
    output : str
        The picture to write.
    animation : str
        The animation to write, if the light travels.
    """

    source: str
    is_saved: bool
    note: str
    light: tuple[float, ...] | None
    method: str
    ramps: dict[int, ToneRamp] | None
    output: str
    animation: str


def python_snippet(state: RelightState) -> Snippet:
    """Return Python that paints the picture on screen; there must be one."""
    recipe = _recipe(state, with_ramps=True)
    options = {
        "flat_shading": (state.flat_shading, 1.0),
        "keep_detail": (state.keep_detail, True),
        "light_color": (
            tuple(float(f"{part:.6f}") for part in color_of_hex(state.light_color)),
            (1.0, 1.0, 1.0),
        ),
        "ambient": (state.ambient, 0.0),
    }
    told = "".join(f", {name}={value!r}" for name, (value, usual) in options.items() if value != usual)
    if recipe.is_saved:
        analysis = f"toonkit.load_analysis({recipe.source!r})"
    else:
        light = "" if recipe.light is None else f", ({_angles(recipe.light, ', ')})"
        analysis = f"toonkit.analyze({recipe.source!r}{light}, method={recipe.method!r})"
    lines = ["import toonkit"]
    if state.travels:
        lines.append("from toonkit.export.animation import write_light_path")
    lines += ["", f"analysis = {analysis}"]
    if recipe.ramps is not None:
        ramps = "".join(f"\n    {place}: toonkit.{ramp!r}," for place, ramp in recipe.ramps.items())
        lines.append(f"analysis = analysis.recolored({{{ramps}{ramps and chr(10)}}})")
    lines.append(f"relit = toonkit.relight(analysis, ({_angles(state.new_light, ', ')}){told})")
    lines.append(f"relit.save({recipe.output!r})")
    if state.travels:
        lights = ", ".join(f"({_angles(light, ', ')})" for light in state.key_lights)
        way = f"frames={state.path_frames}" + ("" if state.path_loops else ", loop=False")
        lines.append(f"write_light_path(analysis, {recipe.animation!r}, [{lights}], {way}{told})")
    return Snippet("\n".join(lines) + "\n", recipe.note)


def command_snippet(state: RelightState) -> Snippet:
    """Return shell commands that paint the picture on screen; there must be one."""
    recipe = _recipe(state, with_ramps=False)
    analysis, commands = recipe.source, []
    if not recipe.is_saved:
        analysis = recipe.output.removesuffix("_relit.png") + "_analysis"
        given = [] if recipe.light is None else [f"--light={_angles(recipe.light, ',')}"]
        commands.append(
            ["toonkit", "analyze", recipe.source, *given, "--method", recipe.method, "-o", analysis]
        )
    options = {
        "--flat-shading": (f"{state.flat_shading:g}", "1"),
        "--light-color": (state.light_color, WHITE),
        "--ambient": (f"{state.ambient:g}", "0"),
    }
    told = [part for name, (value, usual) in options.items() if value != usual for part in (name, value)]
    model_only = [] if state.keep_detail else ["--model-only"]
    light = f"--light={_angles(state.new_light, ',')}"
    commands.append(["toonkit", "relight", analysis, light, *told, *model_only, "-o", recipe.output])
    if state.travels:
        lights = [_angles(light, ",") for light in state.key_lights]
        way = ["--frames", str(state.path_frames), *([] if state.path_loops else ["--once"])]
        orbit = ["--orbit", recipe.animation, "--through", *lights, *way]
        commands.append(["toonkit", "relight", analysis, *orbit, *told, *model_only])
    return Snippet(" &&\n".join(map(shlex.join, commands)) + "\n", recipe.note)


def _recipe(state: RelightState, *, with_ramps: bool) -> Recipe:
    shown = state.on_screen
    opened, question, analysis = shown.opened, shown.question, shown.answer.analysis
    name, ramps = opened.name, state.placed_ramps
    saved = opened.saved
    is_saved = saved is not None and saved.analysis is analysis
    recolored: dict[int, ToneRamp] | None = ramps or None
    if is_saved and saved is not None:
        recolored = None if state.ramps == saved.ramps else ramps
    is_plain = shown.answer.is_plain and saved is None
    if not (is_saved or is_plain) or (recolored is not None and not with_ramps):
        name, is_saved, recolored = opened.session_name, True, None
        note = SAVE_FIRST.format(name=name)
    else:
        note = "" if opened.sample else KEEP_BESIDE.format(name=name)
    stem = opened.sample or PurePosixPath(name).stem
    return Recipe(
        source=name if opened.sample and not is_saved else _safe(name),
        is_saved=is_saved,
        note=note,
        light=None if analysis.light_estimate is not None else question.angles,
        method=analysis.method,
        ramps=recolored,
        output=_safe(f"{stem}_relit.png"),
        animation=_safe(f"{stem}_relit{state.animation_suffix}"),
    )


def _safe(name: str) -> str:
    """Return a path of a file that is not taken for an option, a home folder or a sample."""
    return f"./{name}" if name.startswith(("-", "~", PREFIX)) else name


def _angles(angles: Sequence[float], separator: str) -> str:
    return separator.join(f"{angle:.7g}" for angle in angles)

"""`toonkit relight`: paint an analyzed drawing under other lights."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from toonkit._validation import refuse
from toonkit.cli.folders import holds_frames, read_analysis
from toonkit.cli.frames import relight_frames
from toonkit.cli.lights import parse_angles, parse_color, parse_light
from toonkit.cli.progress import StepBar

if TYPE_CHECKING:
    from toonkit.analysis import ToonAnalysis


def add_relight_command(commands: Any) -> None:
    """Add `relight` to the parser's commands."""
    relight = commands.add_parser("relight", help="paint an analyzed drawing under another light")
    relight.add_argument("analysis", help="the folder that `toonkit analyze` wrote, or its analysis.npz")
    relight.add_argument(
        "--light",
        metavar="AZ,EL",
        help="the new light, in degrees; an elevation below 0 is behind the picture",
    )
    relight.add_argument("-o", "--out", metavar="FILE", help="picture to write, .png or .webp")
    relight.add_argument(
        "--layers",
        metavar="PATH",
        help="write the picture as layers (base color, shadow, light, highlight, ink): a file that ends in .psd or .ora, "
        "or a folder of PNGs",
    )
    relight.add_argument(
        "--profiles",
        metavar="FOLDER",
        help="write the drawing lit from the left, right, top, bottom and front, gray and relit, for sprite-lighting tools",
    )
    _add_animation_options(relight)
    relight.add_argument(
        "--model-only",
        action="store_true",
        help="paint with the color maps alone, without the drawing's own detail",
    )
    relight.add_argument(
        "--flat-shading",
        type=float,
        default=1.0,
        metavar="S",
        help="how much materials painted in one tone answer to the light: 0 leaves them as drawn, 1 (default) shades "
        "them as the drawing shades the others",
    )
    relight.add_argument(
        "--light-color", default="#ffffff", metavar="#RRGGBB", help="color of the new light (default: white)"
    )
    relight.add_argument(
        "--ambient",
        type=float,
        default=0.0,
        metavar="A",
        help="how much light comes from all sides: 0 (default) leaves shadows as the drawing paints them, 1 leaves none",
    )
    relight.add_argument(
        "--palette",
        action=argparse.BooleanOptionalAction,
        help="paint with the drawing's own colors only, or with any; by default, pixel art keeps its palette",
    )
    relight.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    relight.set_defaults(run=_relight)


def _add_animation_options(relight: argparse.ArgumentParser) -> None:
    relight.add_argument(
        "--orbit", metavar="FILE", help="animation to write, .gif, .webp or .apng: the light circles"
    )
    relight.add_argument(
        "--through",
        nargs="+",
        metavar="AZ,EL",
        help="two or more lights; the light of the animation moves through them and back to the first, instead of circling",
    )
    relight.add_argument(
        "--once",
        action="store_true",
        help="with --through: stop at the last light, and show the animation once",
    )
    relight.add_argument(
        "--frames", type=int, default=36, metavar="N", help="frames of the animation, 2 to 720 (default: 36)"
    )
    relight.add_argument(
        "--elevation", type=float, metavar="EL", help="elevation of the circling light, in degrees, -90 to 90"
    )


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Refuse lights without a place for their pictures, and places without a light."""
    if (arguments.light is None) == (arguments.orbit is None) and (arguments.light or not arguments.profiles):
        raise refuse(
            "relight", "needs one of --light AZ,EL and --orbit FILE", "both" if arguments.light else "neither"
        )
    if arguments.light is not None and arguments.out is None and arguments.layers is None:
        raise refuse("relight", "needs -o FILE or --layers PATH beside --light", "neither")
    if arguments.light is None and arguments.layers is not None:
        raise refuse("relight", "needs --light AZ,EL beside --layers", "none")
    if arguments.light is None and arguments.out is not None:
        named = "--profiles" if arguments.orbit is None else "--orbit"
        what = "folder" if arguments.orbit is None else "animation"
        raise refuse("relight", f"takes the {what}'s name from {named} alone", f"-o {arguments.out} too")
    if arguments.through is not None and arguments.orbit is None:
        raise refuse("relight", "needs --orbit FILE beside --through", "none")
    if arguments.through is not None and arguments.elevation is not None:
        raise refuse(
            "relight", "takes the elevations from --through", f"--elevation {arguments.elevation:g} too"
        )
    if arguments.once and arguments.through is None:
        raise refuse("relight", "needs --through AZ,EL AZ,EL beside --once", "none")


def _relight(arguments: argparse.Namespace) -> int:
    _check_outputs(arguments)
    light = None if arguments.light is None else parse_light(arguments.light, behind=True)

    from toonkit.export.layer_files import write_layers  # noqa: PLC0415
    from toonkit.export.layers import split_layers  # noqa: PLC0415
    from toonkit.export.light_profiles import write_light_profiles  # noqa: PLC0415
    from toonkit.export.picture import write_picture  # noqa: PLC0415
    from toonkit.relighting import relight  # noqa: PLC0415

    options: dict[str, Any] = {
        "keep_detail": not arguments.model_only,
        "flat_shading": arguments.flat_shading,
        "palette": arguments.palette,
        "light_color": parse_color(arguments.light_color),
        "ambient": arguments.ambient,
    }
    if holds_frames(arguments.analysis):
        relight_frames(arguments.analysis, arguments, options)
        if not arguments.quiet:
            print(f"written to {arguments.out}")
        return 0
    analysis = read_analysis(arguments.analysis)
    if light is not None and arguments.out is not None:
        write_picture(relight(analysis, light, **options), arguments.out)
    if light is not None and arguments.layers is not None:
        write_layers(split_layers(analysis, light, **options), arguments.layers)
    if arguments.profiles is not None:
        write_light_profiles(analysis, arguments.profiles, **options)
    if arguments.orbit is not None:
        with StepBar(visible=not arguments.quiet) as progress:
            _write_animation(
                analysis,
                arguments,
                progress=lambda fraction: progress("painting frames", fraction),
                **options,
            )
    if not arguments.quiet:
        for target in (arguments.out, arguments.layers, arguments.profiles, arguments.orbit):
            if target is not None:
                print(f"written to {target}")
    return 0


def _write_animation(analysis: ToonAnalysis, arguments: argparse.Namespace, **options: Any) -> None:
    from toonkit.export.animation import write_light_path, write_orbit  # noqa: PLC0415

    if arguments.through is None:
        write_orbit(
            analysis, arguments.orbit, frames=arguments.frames, elevation=arguments.elevation, **options
        )
        return
    lights = [parse_angles(text, "--through") for text in arguments.through]
    write_light_path(
        analysis, arguments.orbit, lights, frames=arguments.frames, loop=not arguments.once, **options
    )

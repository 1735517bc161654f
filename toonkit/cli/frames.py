"""`toonkit frames`: take the frames of a sprite sheet or an animation apart together."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from toonkit._validation import expand_home, refuse
from toonkit.cli.drawing_work import ENGINE_NAMES, ESTIMATED, METHOD_NAMES
from toonkit.cli.folders import print_files
from toonkit.cli.lights import parse_light
from toonkit.cli.progress import StepBar


def add_frames_command(commands: Any) -> None:
    """Add `frames` to the parser's commands."""
    frames = commands.add_parser("frames", help="take the frames of a sprite sheet or an animation apart")
    frames.add_argument("file", help="sprite sheet, or animated .gif, .webp, .png or .apng")
    frames.add_argument(
        "-o", "--out", required=True, metavar="FOLDER", help="where to write; created if need be"
    )
    layout = frames.add_mutually_exclusive_group()
    layout.add_argument(
        "--atlas",
        metavar="FILE",
        help="JSON atlas of the sheet, of TexturePacker or Aseprite (default: the .json file beside it, if there is one)",
    )
    layout.add_argument("--grid", metavar="COLUMNSxROWS", help="equal cells, such as 4x3")
    layout.add_argument(
        "--islands",
        action="store_true",
        help="each part that touches no other is a frame; default without an atlas",
    )
    frames.add_argument(
        "--light",
        default=ESTIMATED,
        metavar="AZ,EL",
        help='the light that all frames were painted under, in degrees; "auto" (default) estimates it',
    )
    frames.add_argument(
        "--method", choices=METHOD_NAMES, default="toonkit", help="estimator (default: toonkit)"
    )
    frames.add_argument(
        "--engine",
        choices=ENGINE_NAMES,
        help="write a normal map for this engine, too, beside base_color.png: with its green axis and bits",
    )
    frames.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    frames.set_defaults(run=_frames)


def _frames(arguments: argparse.Namespace) -> int:
    import toonkit  # noqa: PLC0415
    from toonkit.export.folder import make_folder  # noqa: PLC0415
    from toonkit.export.frame_files import write_frame_folder  # noqa: PLC0415

    light = None if arguments.light == ESTIMATED else parse_light(arguments.light)
    frames = toonkit.read_frames(
        arguments.file, atlas=arguments.atlas, grid=_grid(arguments.grid), islands=arguments.islands
    )
    make_folder(arguments.out)  # before the long work, so that a bad name costs no time
    with StepBar(visible=not arguments.quiet) as progress:
        result = toonkit.analyze_frames(frames.pictures, light, method=arguments.method, progress=progress)
        written = write_frame_folder(
            result, frames, arguments.out, suffix=_suffix(arguments.file, frames), engine=arguments.engine
        )
    if not arguments.quiet:
        count, materials = len(frames.pictures), result.analysis.materials.count
        print(f"{arguments.file}: {count} frame{'' if count == 1 else 's'} analyzed as one drawing")
        print(f"light: {result.analysis.describe_light()}")
        print(f"materials: {materials}, the same in all frames")
        print_files(written)
    return 0


def _grid(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text, re.ASCII)
    if found is None:
        raise refuse("--grid", "must be COLUMNSxROWS, such as 4x3", repr(text))
    return int(found[1]), int(found[2])


def _suffix(file: str, frames: Any) -> str:
    """Return the suffix of the base color's file: that of the animation it belongs to, or .png."""
    own = Path(file).suffix.lower()
    return own if frames.timing is not None and own in (".gif", ".webp", ".apng") else ".png"


def relight_frames(source: str, arguments: argparse.Namespace, options: dict[str, Any]) -> None:
    """Write the frames of an analysis in a folder under another light, in their own layout."""
    from toonkit.export.frame_files import read_frame_folder, write_frames  # noqa: PLC0415

    for name in ("layers", "profiles", "orbit"):
        if getattr(arguments, name) is not None:
            raise refuse("relight", f"takes --light and -o for frames, without --{name}", f"{source}")
    result, frames = read_frame_folder(source)
    pictures = result.relight(parse_light(arguments.light, behind=True), **options)
    write_frames(pictures, frames, expand_home(arguments.out))

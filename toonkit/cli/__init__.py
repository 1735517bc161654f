"""The command line: `toonkit analyze`, `relight`, `frames`, `mesh`, `batch`, `samples`, `dashboard` and `study`.

Everything heavy is imported inside the commands, so that `toonkit --version` and `--help` answer at once.
"""

from __future__ import annotations

import argparse
import re
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from toonkit._validation import ToonkitError, ToonkitWarning
from toonkit.cli.batch import add_batch_command
from toonkit.cli.dashboard import add_dashboard_command
from toonkit.cli.drawing_work import DrawingWork, add_work_options, analyze_drawing, layer_options
from toonkit.cli.folders import print_files
from toonkit.cli.frames import add_frames_command
from toonkit.cli.mesh import add_mesh_command
from toonkit.cli.progress import StepBar, show_warning
from toonkit.cli.relight import add_relight_command
from toonkit.cli.streams import complain, discard_output, prepare_streams
from toonkit.cli.study import add_study_commands
from toonkit.samples import PREFIX, drawing_path, sample_names, sample_path

if TYPE_CHECKING:
    from toonkit.cli.drawing_work import AnalyzedDrawing

UNSURE = 0.5
"""Confidence in an estimated light below which the summary says that it is a guess."""

_EXIT_FAILED = 1
_EXIT_REFUSED = 2
_EXIT_INTERRUPTED = 130
_EXIT_UNREAD = 141  # as a shell tells that whoever read the output went away


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process by default.

    Returns
    -------
    int
        0 if all went well, 1 if a drawing of a batch or a trial of a study failed, or the system did, such as a full disk
        under the summary, 2 if the input was refused (one line on stderr says why), 130 if interrupted, 141 if nobody read
        the summary to its end.
    """
    prepare_streams()
    try:
        status = _run(sys.argv[1:] if argv is None else argv)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        discard_output()
        return _EXIT_UNREAD
    except OSError as error:
        discard_output()
        complain(f"error: {error.filename or 'standard output'}: {error.strerror or error}")
        return _EXIT_FAILED


def _run(argv: Sequence[str]) -> int:
    try:
        arguments = _parser().parse_args(_joined_lights(argv))
        with warnings.catch_warnings():
            warnings.simplefilter("always", ToonkitWarning)
            warnings.showwarning = show_warning
            return int(arguments.run(arguments))
    except ToonkitError as error:
        complain(f"error: {error}")
        return _EXIT_REFUSED
    except KeyboardInterrupt:
        complain("interrupted")
        return _EXIT_INTERRUPTED
    except SystemExit as stop:  # argparse, after --help or a usage error
        return stop.code if isinstance(stop.code, int) else _EXIT_REFUSED


class _Parser(argparse.ArgumentParser):
    def print_help(self, file: Any = None) -> None:
        """Print the help; argparse by itself hides that it could not be written."""
        print(self.format_help(), end="", file=file)

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one line, without the usage."""
        self.exit(_EXIT_REFUSED, f"toonkit: error: {message} (see {self.prog} --help)\n")


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        import toonkit  # noqa: PLC0415

        print(f"toonkit {toonkit.__version__}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="toonkit",
        description="Recover the shape and the colors behind a cartoon-shaded drawing, and relight it.",
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and stop")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", title="commands")

    analyze = commands.add_parser("analyze", help="take a drawing apart into light, shape and colors")
    analyze.add_argument(
        "drawing",
        help=f"picture, .psd, .ora or .kra file, folder of layers, or {PREFIX}NAME for a drawing that toonkit ships",
    )
    analyze.add_argument(
        "-o", "--out", required=True, metavar="FOLDER", help="where to write; created if need be"
    )
    analyze.add_argument(
        "--light",
        default="auto",
        metavar="AZ,EL",
        help="the light it was painted under, in degrees: azimuth counter-clockwise from the right, "
        'elevation from the paper toward you; "auto" (default) estimates it',
    )
    analyze.add_argument(
        "--mask", metavar="FILE", help="picture that is white (or opaque) where the object is"
    )
    analyze.add_argument(
        "--materials",
        metavar="FILE",
        help="label picture of the drawing's size, .png or .webp: each color is one material, transparent pixels are "
        "unknown; by default the materials are found",
    )
    add_work_options(analyze)
    analyze.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    analyze.set_defaults(run=_analyze)

    add_relight_command(commands)
    add_frames_command(commands)
    add_mesh_command(commands)
    add_batch_command(commands)
    samples = commands.add_parser("samples", help="list the drawings that toonkit ships")
    samples.set_defaults(run=_samples)
    add_dashboard_command(commands)
    add_study_commands(commands)
    return parser


def _joined_lights(argv: Sequence[str]) -> list[str]:
    """Keep argparse from taking `-30,50` for an option: join it to `--light=-30,50`, or put a space before it in a list."""
    joined: list[str] = []
    for argument in argv:
        if joined and joined[-1] in ("--light", "--view") and re.match(r"-[\d.]", argument):
            joined[-1] += f"={argument}"
        else:
            joined.append(f" {argument}" if re.match(r"-[\d.][^,]*,", argument) else argument)
    return joined


def _analyze(arguments: argparse.Namespace) -> int:
    work = DrawingWork(
        arguments.drawing,
        Path(drawing_path(arguments.drawing)),
        arguments.light,
        arguments.method,
        arguments.engine,
        arguments.bleed,
        mask=None if arguments.mask is None else Path(arguments.mask),
        materials=None if arguments.materials is None else Path(arguments.materials),
        **layer_options(arguments),
    )
    with StepBar(visible=not arguments.quiet) as progress:
        analyzed = analyze_drawing(work, arguments.out, progress=progress, seconds=progress.seconds)
        seconds = sum(progress.seconds().values())
    if not arguments.quiet:
        _summarize(analyzed, arguments.drawing, seconds)
        print_files(analyzed.files)
    return 0


def _summarize(analyzed: AnalyzedDrawing, drawing: str, seconds: float) -> None:
    from toonkit.export.report import ink_share  # noqa: PLC0415
    from toonkit.relighting import Paint  # noqa: PLC0415

    analysis = analyzed.analysis
    estimate, materials = analysis.light_estimate, analysis.materials
    print(f"{drawing}: {int(analysis.image.mask.sum()):,} pixels analyzed in {seconds:.1f} s")
    print(f"light: {analysis.describe_light()}")
    if analysis.light_source == "assumed":
        print("       the drawing does not say where its light is; if you know, say so with --light AZ,EL")
    elif estimate is not None and estimate.confidence < UNSURE:
        print("       this light is a guess; if you know where it was, say so with --light AZ,EL")
    flat = int(materials.flat.sum())
    if materials.count == 1:
        print("materials: 1, flat" if flat else "materials: 1")
    else:
        print(f"materials: {materials.count}, {flat or 'none'} of them flat")
    if (share := ink_share(analysis.drawing)) > 0:
        print(f"line art: {100 * share:.1f} % of the drawing, which stays as drawn")
    if analyzed.drawing.ink_layers:
        print(f"line art from the layers: {', '.join(analyzed.drawing.ink_layers)}")
    if analyzed.drawing.flats_layers:
        print(f"materials from the layers: {', '.join(analyzed.drawing.flats_layers)}")
    if Paint.of(analysis, None, keep_detail=True).palette is not None:
        print("pixel art: relight keeps to its colors, unless you add --no-palette")


def _samples(_: argparse.Namespace) -> int:
    names = sample_names()
    width = max(len(name) for name in names)
    for name in names:
        print(f"{name:<{width}}  {sample_path(name)}")
    print(f"\ntry: toonkit analyze {PREFIX}{names[0]} -o out/")
    return 0

"""The command line of the study: `toonkit study run`, `toonkit study report`, `toonkit study list`."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from toonkit._validation import ToonkitError, expand_home, refuse
from toonkit.cli.extensions import load_extension
from toonkit.cli.lights import parse_angles
from toonkit.cli.progress import StepBar, TrialBar

if TYPE_CHECKING:
    from toonkit.study.plan import StudyPlan
    from toonkit.study.registry import View

REPORT_FOLDER = "report"

ERROR_CHARACTERS, MOST_ERRORS = 100, 3
"""How much of an error, and how many different ones, the summary of a run shows."""

_EXIT_FAILED = 1


def add_study_commands(commands: Any) -> None:
    """Add `study` and what it can do to the parser's commands."""
    study = commands.add_parser("study", help="measure every method on shapes whose normals are known")
    actions = study.add_subparsers(required=True, metavar="ACTION", title="actions")
    _add_run(actions.add_parser("run", help="run the trials that are not on file with the same inputs"))

    report = actions.add_parser("report", help="print the tables of a study and write its figures")
    report.add_argument(
        "study", help="the folder of `toonkit study run`, or its trials.parquet or trials.csv"
    )
    report.add_argument(
        "-o", "--out", metavar="FOLDER", help="where to write; report/ in the study's folder by default"
    )
    report.add_argument("--quiet", action="store_true", help="write without printing")
    report.set_defaults(run=_report)

    listing = actions.add_parser("list", help="list the shapes, color maps and methods")
    listing.set_defaults(run=_list)


def _add_run(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "-o",
        "--out",
        required=True,
        metavar="FOLDER",
        help="the study's folder; where one was interrupted, it goes on",
    )
    run.add_argument(
        "--shapes", nargs="+", metavar="NAME", help="shapes; all by default, or none if there is a --mesh"
    )
    run.add_argument("--maps", nargs="+", metavar="NAME", help="color maps (default: all)")
    run.add_argument("--methods", nargs="+", metavar="NAME", help="methods (default: all, and flat)")
    run.add_argument(
        "--mesh",
        action="append",
        default=[],
        metavar="FILE",
        help="a mesh as a further shape, or pyvista:NAME for one that PyVista downloads; may be repeated",
    )
    run.add_argument(
        "--view",
        action=_ViewOfLastMesh,
        dest="views",
        default={},
        metavar="YAW,PITCH,ROLL",
        help="from where the mesh named before it is seen, in degrees",
    )
    run.add_argument(
        "--size", type=int, metavar="PIXELS", help="width and height of the pictures (default: 512)"
    )
    run.add_argument("--light", metavar="AZ,EL", help="the light the shapes are painted under, in degrees")
    run.add_argument(
        "--tracks",
        nargs="+",
        default=["given"],
        metavar="TRACK",
        help="given: the methods are told the true light (default); estimated: they are not",
    )
    run.add_argument(
        "--with",
        action="append",
        default=[],
        dest="extensions",
        metavar="FILE.py",
        help="Python file that registers further methods (toonkit.METHODS) or shapes (@shape); may be repeated",
    )
    run.add_argument(
        "--retry-failed", action="store_true", help="measure trials again that are on file with an error"
    )
    run.add_argument(
        "--again",
        nargs="+",
        default=[],
        metavar="METHOD",
        help="delete all records of these methods and measure them again: needed after a change of toonkit's own code, which"
        " is not detected; a changed --with FILE.py is",
    )
    where = run.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes (default: one for each core); 0 runs in this one",
    )
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="dask scheduler whose workers do the work, tcp://HOST:PORT"
    )
    run.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    run.set_defaults(run=_run)


class _ViewOfLastMesh(argparse.Action):
    """Keep a view under the number of the mesh that was named before it."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        if not namespace.mesh:
            parser.error(f"{option_string} must come after the --mesh that it is the view of")
        views = dict(getattr(namespace, self.dest))
        views[len(namespace.mesh) - 1] = values
        setattr(namespace, self.dest, views)


def _run(arguments: argparse.Namespace) -> int:
    refuse_without_extra()
    from toonkit.study.runner import run_study  # noqa: PLC0415
    from toonkit.study.table import TABLE_NAME  # noqa: PLC0415

    method_files = {method: file for file in arguments.extensions for method in load_extension(file)}
    plan = _plan(arguments, method_files)
    # A lost scheduler is told in one line: dask's own stack traces say no more.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        with TrialBar(visible=not arguments.quiet) as bar:
            table = run_study(
                plan,
                arguments.out,
                workers=arguments.workers,
                scheduler=arguments.scheduler,
                retry_failed=arguments.retry_failed,
                again=arguments.again,
                progress=bar,
            )
    except KeyboardInterrupt:
        command = "the same command without --again" if arguments.again else "the same command"
        print(f"what was measured is on file: {command} goes on from there", file=sys.stderr)
        raise
    errors = table.loc[table["error"] != "", "error"]
    if not arguments.quiet:
        print(
            f"{len(table):,} trials on file, {len(errors):,} of them failed: {Path(arguments.out) / TABLE_NAME}"
        )
        for error, count in errors.str.slice(0, ERROR_CHARACTERS).value_counts().head(MOST_ERRORS).items():
            print(f"  {count:,} x {error}")
        if len(errors):
            print("to try them anew: the same command with --retry-failed")
        print(f"tables and figures: toonkit study report {arguments.out}")
    return _EXIT_FAILED if len(errors) else 0


def _plan(arguments: argparse.Namespace, method_files: dict[str, str]) -> StudyPlan:
    from toonkit.study.painting import StudySettings  # noqa: PLC0415
    from toonkit.study.plan import plan_study  # noqa: PLC0415
    from toonkit.study.scenes import load_mesh  # noqa: PLC0415

    settings = StudySettings()
    if arguments.size is not None:
        settings = replace(settings, size=arguments.size)
    if arguments.light is not None:
        settings = replace(settings, light=parse_angles(arguments.light))
    meshes = [
        load_mesh(source, _parse_view(arguments.views.get(number)))
        for number, source in enumerate(arguments.mesh)
    ]
    return plan_study(
        shapes=arguments.shapes,
        meshes=meshes,
        color_maps=arguments.maps,
        methods=arguments.methods,
        light_tracks=arguments.tracks,
        settings=settings,
        method_files=method_files,
    )


def _parse_view(text: str | None) -> View | None:
    if text is None:
        return None
    from toonkit.study.registry import View  # noqa: PLC0415

    try:
        yaw, pitch, roll = (float(part) for part in text.split(","))
    except ValueError:
        raise refuse("--view", "must be YAW,PITCH,ROLL in degrees, such as 35,10,0", repr(text)) from None
    return View(yaw, pitch, roll)


def _report(arguments: argparse.Namespace) -> int:
    refuse_without_extra()
    from toonkit.export.folder import make_folder  # noqa: PLC0415
    from toonkit.study.reporting.measure_table import on_track, tracks  # noqa: PLC0415
    from toonkit.study.reporting.report import REPORT_NAME, write_report  # noqa: PLC0415
    from toonkit.study.table import load_provenance, load_trials  # noqa: PLC0415
    from toonkit.viz.figures.study import write_figures  # noqa: PLC0415

    source = expand_home(arguments.study)
    trials, provenance = load_trials(source), load_provenance(source)
    home = source if source.is_dir() else source.parent
    folder = make_folder(arguments.out or home / REPORT_FOLDER)
    with StepBar(visible=not arguments.quiet) as progress:
        progress("drawing the figures", 0.0)
        figures = write_figures(on_track(trials, tracks(trials)[0]), folder)
        progress("comparing the methods", 0.6)
        written = write_report(trials, provenance, folder, figures=figures)
    if not arguments.quiet:
        print((folder / REPORT_NAME).read_text(encoding="utf-8"))
        print(f"{len(written) + len(figures)} files written to {folder}")
    return 0


def _list(_: argparse.Namespace) -> int:
    from toonkit.study.color_maps import load_ramps  # noqa: PLC0415
    from toonkit.study.estimators import list_estimators  # noqa: PLC0415
    from toonkit.study.shapes import SHAPES  # noqa: PLC0415

    print("shapes")
    for shape in SHAPES.values():
        print(f"  {shape.name:<14}{shape.kind}")
    print("color maps")
    for ramp in load_ramps().values():
        print(f"  {ramp.name:<18}{len(ramp.tones)} tones  {', '.join(ramp.tags)}")
    print("methods")
    for name in list_estimators():
        print(f"  {name}")
    return 0


def refuse_without_extra() -> None:
    """Refuse to go on where the packages of the extra "study" are not installed."""
    try:
        import pandas  # noqa: F401, PLC0415
    except ImportError as error:
        raise ToonkitError(
            f'study needs its extra packages; got no {error.name}: pip install "toonkit[study]"'
        ) from error

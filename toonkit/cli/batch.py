"""`toonkit batch`: analyze all drawings of a folder, and go on where that was stopped."""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from toonkit._validation import ToonkitError, expand_home, refuse
from toonkit.cli.drawing_work import ESTIMATED, DrawingWork, add_work_options, layer_options
from toonkit.cli.progress import DrawingBar, show_warning
from toonkit.cli.streams import complain

if TYPE_CHECKING:
    from toonkit.cli.batch_work import BatchItem

LAYERED_SUFFIXES = (".psd", ".psb", ".ora", ".kra")

SUFFIXES = (
    ".png", ".apng", ".webp", ".jpg", ".jpeg", ".jpe", ".jfif", ".tif", ".tiff", ".gif", ".bmp", *LAYERED_SUFFIXES
)  # fmt: skip
"""Ends of the names that are taken for drawings: those of the formats that `toonkit.load_layers` reads."""

_EXIT_FAILED = 1


def add_batch_command(commands: Any) -> None:
    """Add `batch` to the parser's commands."""
    batch = commands.add_parser("batch", help="take all drawings of a folder apart")
    batch.add_argument(
        "folder", help=f"folder of pictures, {', '.join(SUFFIXES)}; those in folders below it are left out"
    )
    batch.add_argument(
        "-o",
        "--out",
        required=True,
        metavar="FOLDER",
        help="where to write a folder for each drawing, named like it; where a batch was stopped, it goes on",
    )
    batch.add_argument(
        "--light",
        default=ESTIMATED,
        metavar="AZ,EL",
        help='the light that all of them were painted under, in degrees; "auto" (default) estimates each',
    )
    add_work_options(batch)
    batch.add_argument(
        "--again", action="store_true", help="analyze also what was analyzed before, with the same options"
    )
    where = batch.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes (default: one for each core); 0 works in this one",
    )
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="dask scheduler whose workers do the work, tcp://HOST:PORT"
    )
    batch.add_argument("--quiet", action="store_true", help="no progress bar, and no summary but of failures")
    batch.set_defaults(run=_batch)


def _batch(arguments: argparse.Namespace) -> int:
    from toonkit.cli.batch_work import BatchItem  # noqa: PLC0415
    from toonkit.export.folder import make_folder  # noqa: PLC0415
    from toonkit.export.sole_use import sole_use  # noqa: PLC0415

    if arguments.workers is not None and arguments.workers < 0:
        raise refuse("--workers", "must be a whole number >= 0", arguments.workers)
    files = _drawings(arguments.folder)
    options = arguments.light, arguments.method, arguments.engine, arguments.bleed
    layers = layer_options(arguments)
    works = [DrawingWork(str(file), file, *options, **layers) for file in files]
    start = time.perf_counter()
    out = make_folder(arguments.out)
    with sole_use(out):
        items = [BatchItem(work, out / name) for work, name in zip(works, _folder_names(files), strict=True)]
        left = [item for item in items if arguments.again or not _is_done(item)]
        failed = _analyze_all(left, len(items), arguments)
    for name, error in sorted(failed.items()):
        complain(f"error: {name}: {error}")
    if not arguments.quiet:
        seconds = time.perf_counter() - start
        print(f"{len(items):,} drawings: {len(left) - len(failed):,} analyzed in {seconds:.1f} s, ", end="")
        print(f"{len(items) - len(left):,} analyzed before, {len(failed):,} failed")
        print(f"written to {out}")
    return _EXIT_FAILED if failed else 0


def _is_done(item: BatchItem) -> bool:
    from toonkit.export.folder import holds_analysis  # noqa: PLC0415

    try:
        return holds_analysis(item.folder, item.work.inputs())
    except OSError:  # its analysis will say why the drawing cannot be read
        return False


def _analyze_all(left: Sequence[BatchItem], total: int, arguments: argparse.Namespace) -> dict[str, str]:
    """Analyze what is left of a batch; return the errors by the names of the drawings."""
    from toonkit.cli.batch_work import (  # noqa: PLC0415
        analyzed_by_cluster,
        analyzed_here,
        analyzed_in_processes,
    )
    from toonkit.numerics.parallel import count_cores  # noqa: PLC0415

    workers = count_cores() if arguments.workers is None else arguments.workers
    if arguments.scheduler is not None and left:
        _refuse_without_dask()
        # A lost scheduler is told in one line: dask's own stack traces say no more.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        outcomes = analyzed_by_cluster(left, arguments.scheduler)
    else:
        outcomes = analyzed_in_processes(left, workers) if workers else analyzed_here(left)
    failed: dict[str, str] = {}
    try:
        with DrawingBar(total, total - len(left), visible=not arguments.quiet) as bar, closing(outcomes):
            for outcome in outcomes:
                work = outcome.item.work
                for message in outcome.warnings:
                    show_warning(f"{work.drawing}: {message}")
                if outcome.error is not None:
                    failed[work.drawing] = outcome.error
                bar.count(work.file.name, failed=len(failed))
    except KeyboardInterrupt:
        print("what was analyzed is on file: the same command goes on from there", file=sys.stderr)
        raise
    return failed


def _drawings(folder: str) -> list[Path]:
    """Return the picture files of a folder by name; refuse one that has none."""
    home = expand_home(folder)
    if not home.is_dir():
        raise refuse("folder", "must be an existing folder", f"{folder}")
    files = sorted(
        path
        for path in home.iterdir()
        if path.suffix.lower() in SUFFIXES and not path.name.startswith(".") and path.is_file()
    )
    if not files:
        raise refuse("folder", f"must hold pictures, {', '.join(SUFFIXES)}", f"{folder} without any")
    return files


def _folder_names(files: Sequence[Path]) -> list[str]:
    """Return a name for the output of each file: without its suffix, unless another one has the same name then."""
    taken = Counter(name for file in files for name in {file.stem, file.name})
    return [file.stem if taken[file.stem] == 1 else file.name for file in files]


def _refuse_without_dask() -> None:
    try:
        import distributed  # noqa: F401, PLC0415
        import pandas  # noqa: F401, PLC0415
    except ImportError as error:
        raise ToonkitError(
            f'--scheduler needs the packages of the study; got no {error.name}: pip install "toonkit[study]"'
        ) from error

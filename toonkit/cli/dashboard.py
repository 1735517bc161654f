"""The command line of the dashboards: `toonkit dashboard relight`, `toonkit dashboard study`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from toonkit._validation import expand_home, refuse
from toonkit.cli.study import refuse_without_extra

if TYPE_CHECKING:
    import panel_material_ui as pmui

PAGES = ("relight", "study")

PUBLISHED = Path("notebooks", "study")
"""The published study, where the command is given in a checkout of the repository."""

PORT = 5006


def add_dashboard_command(commands: Any) -> None:
    """Add `dashboard` to the parser's commands."""
    dashboard = commands.add_parser(
        "dashboard", help="open a page in the browser: relight a drawing, or look into a study"
    )
    dashboard.add_argument(
        "page", nargs="?", choices=PAGES, default=PAGES[0], help="which page (default: relight)"
    )
    dashboard.add_argument(
        "folder",
        nargs="?",
        metavar="FOLDER",
        help=f"with study: the folder of `toonkit study run`; {PUBLISHED} by default, if there is one here",
    )
    dashboard.add_argument(
        "--port", type=int, default=PORT, metavar="N", help=f"port on localhost (default: {PORT})"
    )
    dashboard.add_argument("--no-show", action="store_true", help="do not open a browser")
    dashboard.set_defaults(run=_dashboard)


def _dashboard(arguments: argparse.Namespace) -> int:
    app = _study_app(arguments.folder) if arguments.page == "study" else _relight_app(arguments.folder)
    from toonkit.viz.server import serve_page  # noqa: PLC0415

    serve_page(
        arguments.page,
        app,
        port=arguments.port,
        show=not arguments.no_show,
        started=lambda address: print(f"{address}\nCtrl-C stops it", flush=True),
    )
    return 0


def _relight_app(folder: str | None) -> Callable[[], pmui.Page]:
    if folder is not None:
        raise refuse("dashboard", "takes a FOLDER only for study", folder)
    _say_that_it_starts()
    from toonkit.viz.relight_page.page import relight_app  # noqa: PLC0415

    return relight_app


def _study_app(folder: str | None) -> Callable[[], pmui.Page]:
    study = PUBLISHED if folder is None else expand_home(folder)
    if not study.exists():
        found = f"{study}, which does not exist" if folder else "none"
        raise refuse("dashboard study", "needs the FOLDER of a study (toonkit study run -o FOLDER)", found)
    refuse_without_extra()
    _say_that_it_starts()
    from toonkit.viz.study_page.page import study_app  # noqa: PLC0415

    return partial(study_app, study)


def _say_that_it_starts() -> None:
    """Say so before what draws is imported, which takes seconds."""
    print("starting the dashboard", flush=True)

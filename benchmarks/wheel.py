"""Whether the wheel is complete: its commands and both dashboards, in an environment that holds nothing else.

    python -m benchmarks.wheel

Builds an sdist and a wheel with `python -m build`, installs the wheel with its `study` extra into a new environment, and
runs it from an empty folder. Opens each dashboard in Chromium until it shows its first result. Needs the package index,
Chromium and a few minutes. The first failure ends it with an error.
"""

from __future__ import annotations

import argparse
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parent.parent
SECONDS = 180
"""How long a dashboard may take to show something on a busy machine: its first page also compiles."""

COMMANDS = (
    "--version",
    "analyze sample:pear --light 135,45 -o pear",
    "relight pear --light 30,50 -o relit.png",
    "study run -o study --shapes sphere cone --maps terracotta ocean --methods toonkit todo lumo --size 64 --workers 0",
)
WRITTEN = ("pear/analysis.npz", "pear/relit_contact_sheet.png", "relit.png", "study/trials.parquet")
SHOWN = {"relight": ".card.relit canvas", "study study": ".sheet .tile img"}
"""Dashboard -> what its page shows once it works."""


def build(folder: Path) -> Path:
    """Build sdist and wheel into a folder, and return the wheel."""
    subprocess.run([sys.executable, "-m", "build", "--outdir", str(folder), str(ROOT)], check=True)
    (wheel,) = folder.glob("*.whl")
    assert len(list(folder.glob("*.tar.gz"))) == 1
    return wheel


def install(wheel: Path, folder: Path, environment: dict[str, str]) -> Path:
    """Install a wheel into a new virtual environment, and return its `toonkit` command."""
    venv.create(folder, with_pip=True)
    pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "-q", "-c", str(ROOT / "constraints.txt")]
    subprocess.run([*pip, f"{wheel}[study]"], env=environment, check=True)
    return folder / "bin" / "toonkit"


def open_dashboard(
    toonkit: Path, arguments: str, shown: str, folder: Path, environment: dict[str, str]
) -> None:
    """Serve a dashboard and wait until its page shows a result; an error of the page is one of ours."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [str(toonkit), "dashboard", *arguments.split(), "--no-show", "--port", str(port)]
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            address = next(line.strip() for line in server.stdout if line.startswith("http"))
            with sync_playwright() as driver:
                browser = driver.chromium.launch(
                    executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
                )
                page = browser.new_page()
                errors: list[str] = []
                page.on("pageerror", lambda error: errors.append(str(error)))
                page.goto(address)
                page.locator(shown).first.wait_for(timeout=SECONDS * 1000)
                browser.close()
            assert not errors, errors
        finally:
            server.terminate()


def main(arguments: Sequence[str] | None = None) -> None:
    """Build, install, run."""
    argparse.ArgumentParser(description=__doc__).parse_args(arguments)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary)
        toonkit = install(build(place / "dist"), place / "environment", environment)
        (place / "empty").mkdir()
        for command in COMMANDS:
            subprocess.run([str(toonkit), *command.split()], cwd=place / "empty", env=environment, check=True)
        assert all((place / "empty" / name).stat().st_size > 0 for name in WRITTEN)
        for dashboard, shown in SHOWN.items():
            open_dashboard(toonkit, dashboard, shown, place / "empty", environment)
            print(f"toonkit dashboard {dashboard}: works")


if __name__ == "__main__":
    main()

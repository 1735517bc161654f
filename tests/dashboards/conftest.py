"""A dashboard served on a free port, and a page in headless Chromium that tolerates no complaint."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import numpy as np
import pytest
from playwright.sync_api import expect

from toonkit.study.color_maps import load_color_maps
from toonkit.study.contestants import contestants
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES
from toonkit.study.table import CSV_NAME, PROVENANCE_NAME, as_table, write_csv
from toonkit.study.trials import StudySettings, Trial, paint, run_trial

ROOT = Path(__file__).parents[2]
START_SECONDS = 180  # the first page of a busy machine also compiles
PATIENCE_SECONDS = 90  # for what a page answers once it stands
LEAVE_SECONDS = 60
STUDY_SIZE = 48
STUDY_SHAPES = ("sphere", "cone")
STUDY_COLOR_MAPS = ("terracotta", "ocean")

LOCAL = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def served(name, log, *arguments):
    """The address of a dashboard, served until the end of the block."""
    port = free_port()
    command = [sys.executable, "-m", "panel", "serve", str(ROOT / "dashboards" / f"{name}.py")]
    command += [
        "--port",
        str(port),
        "--address",
        "127.0.0.1",
        "--allow-websocket-origin",
        f"127.0.0.1:{port}",
        "--check-unused-sessions",
        "1000",
        "--plugins",
        "tests.dashboards.census",
    ]
    command += ["--args", *map(str, arguments)] if arguments else []
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    with (
        log.open("w") as output,
        subprocess.Popen(
            command, env={**os.environ, "PYTHONPATH": path}, stdout=output, stderr=subprocess.STDOUT
        ) as server,
    ):
        url = f"http://127.0.0.1:{port}/{name}"
        try:
            wait_until_served(url, server, log)
            yield url
        finally:
            server.terminate()


@pytest.fixture(scope="session")
def relight_url(tmp_path_factory):
    with served("relight", tmp_path_factory.mktemp("serve") / "log") as url:
        yield url


@pytest.fixture(scope="session")
def study_folder(tmp_path_factory):
    """A study of two shapes and two color maps, small enough to be run here; one trial of it has failed."""
    folder = tmp_path_factory.mktemp("study")
    settings = StudySettings(size=STUDY_SIZE)
    methods, records = contestants(), []
    for shape in STUDY_SHAPES:
        truth = render_shape(SHAPES[shape], STUDY_SIZE)
        for name in STUDY_COLOR_MAPS:
            painting = paint(truth, load_color_maps()[name], settings)
            for method, contestant in methods.items():
                trial = Trial(shape, name, method, "given")
                records.append(run_trial(trial, SHAPES[shape].kind, painting, contestant))
    records[-1] = replace(records[-1], angular_error=np.nan, error="ToonkitError: no shape")
    records += [replace(record, light_track="estimated") for record in records]
    write_csv(as_table(records), folder / CSV_NAME)
    (folder / PROVENANCE_NAME).write_text(json.dumps({"settings": asdict(settings)}))
    return folder


@pytest.fixture(scope="session")
def study_url(tmp_path_factory, study_folder):
    with served("study", tmp_path_factory.mktemp("serve") / "log", study_folder) as url:
        yield url


def census(url):
    """What the server of a page still holds: how many of its objects, and the longest sides of its analyses."""
    with urlopen(url.rsplit("/", 1)[0] + "/census", timeout=START_SECONDS) as answer:
        return json.load(answer)


def wait_until_all_have_left(url):
    """The census once no session is left, or after a minute."""
    end = time.monotonic() + LEAVE_SECONDS
    while census(url)["counts"].get("ServerSession") and time.monotonic() < end:
        time.sleep(1)
    return census(url)


def wait_until_served(url, server, log):
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end:
        if server.poll() is not None:
            pytest.fail(f"the dashboard's server ended: {log.read_text()}")
        try:
            with urlopen(url, timeout=START_SECONDS):
                return
        except (URLError, ConnectionError):
            time.sleep(0.2)
    pytest.fail(f"the dashboard did not start in {START_SECONDS} s: {log.read_text()}")


@pytest.fixture
def complaints(page):
    """What the page complained about: errors, and requests that left this machine. Checked after the test."""
    page.set_default_timeout(PATIENCE_SECONDS * 1000)
    expect.set_options(timeout=PATIENCE_SECONDS * 1000)
    heard: list[str] = []
    page.on("pageerror", lambda error: heard.append(f"page error: {error}"))
    page.on("console", lambda message: heard.append(message.text) if message.type == "error" else None)
    page.on("request", lambda request: None if request.url.startswith(LOCAL) else heard.append(request.url))
    yield heard
    assert heard == []


@pytest.fixture
def relight_page(page, relight_url, complaints):
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(relight_url)
    page.wait_for_selector(".relight:not(.empty)", timeout=START_SECONDS * 1000)
    page.wait_for_selector(".busy:not(.on)", state="attached")
    return page


@pytest.fixture
def study_page(page, study_url, complaints):
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(study_url)
    page.wait_for_selector(".bk-Figure", timeout=START_SECONDS * 1000)
    page.locator(".sheet img[alt='normal map']").nth(len(contestants())).wait_for(
        timeout=START_SECONDS * 1000
    )
    return page

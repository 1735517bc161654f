"""Dashboards served on free ports, and pages in headless Chromium that tolerate no complaint."""

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
from urllib.request import urlopen

import numpy as np
import pytest

from tests.dashboards.driving import (
    START_SECONDS,
    WINDOW,
    Tab,
    listen,
    show_badged_ball,
    show_first_choices,
    show_first_sample,
    wait_until_examined,
    wait_until_relit,
)
from toonkit.study.color_maps import load_color_maps
from toonkit.study.estimators import list_estimators
from toonkit.study.painting import StudySettings, paint
from toonkit.study.records import Trial
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES
from toonkit.study.table import CSV_NAME, PROVENANCE_NAME, as_table, write_csv
from toonkit.study.trials import run_trial

ROOT = Path(__file__).parents[2]
LEAVE_SECONDS = 60
STUDY_SIZE = 48
STUDY_SHAPES = ("sphere", "cone")
STUDY_COLOR_MAPS = ("terracotta", "ocean")


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
    methods, records = list_estimators(), []
    for shape in STUDY_SHAPES:
        truth = render_shape(SHAPES[shape], STUDY_SIZE)
        for name in STUDY_COLOR_MAPS:
            painting = paint(truth, load_color_maps()[name], settings)
            for method, estimator in methods.items():
                trial = Trial(shape, name, method, "given")
                records.append(run_trial(trial, SHAPES[shape].kind, painting, estimator))
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
    address = "127.0.0.1", int(url.split(":")[2].partition("/")[0])
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end:
        if server.poll() is not None:
            pytest.fail(f"the dashboard's server ended: {log.read_text()}")
        try:
            with socket.create_connection(address, START_SECONDS):
                return
        except ConnectionError:
            time.sleep(0.2)
    pytest.fail(f"the dashboard did not start in {START_SECONDS} s: {log.read_text()}")


@pytest.fixture
def complaints(page):
    """What the page complained about. Checked after the test."""
    heard = listen(page)
    yield heard
    assert heard == []


@pytest.fixture(scope="session")
def relight_tab(browser, relight_url):
    page = browser.new_page(viewport=WINDOW)
    yield Tab(page, relight_url, wait_until_relit)
    page.close()


@pytest.fixture
def opened_relight_page(relight_tab, request):
    """The relight page that nobody has touched."""
    with relight_tab.lent(request.session.testsfailed, fresh=True) as page:
        yield page


@pytest.fixture
def relight_page(relight_tab, request):
    """The relight page with its first sample."""
    with relight_tab.lent(request.session.testsfailed, show_first_sample) as page:
        yield page


@pytest.fixture
def materials_page(relight_tab, request):
    """A gray ball with a red badge on the relight page, its two materials shown."""
    with relight_tab.lent(request.session.testsfailed, show_badged_ball) as page:
        yield page


@pytest.fixture(scope="session")
def study_tab(browser, study_url):
    page = browser.new_page(viewport=WINDOW)
    yield Tab(page, study_url, wait_until_examined)
    page.close()


@pytest.fixture
def opened_study_page(study_tab, request):
    """The study page that nobody has touched."""
    with study_tab.lent(request.session.testsfailed, fresh=True) as page:
        yield page


@pytest.fixture
def study_page(study_tab, request):
    """The study page with the choices that it opens with."""
    with study_tab.lent(request.session.testsfailed, show_first_choices) as page:
        yield page

"""A dashboard served on a free port, and a page in headless Chromium that tolerates no complaint."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import pytest

ROOT = Path(__file__).parents[2]
START_SECONDS = 60
LOCAL = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="session")
def relight_url(tmp_path_factory):
    port = free_port()
    log = tmp_path_factory.mktemp("serve") / "log"
    command = [
        sys.executable,
        "-m",
        "panel",
        "serve",
        str(ROOT / "dashboards" / "relight.py"),
        "--port",
        str(port),
    ]
    command += ["--address", "127.0.0.1", "--allow-websocket-origin", f"127.0.0.1:{port}"]
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    with (
        log.open("w") as output,
        subprocess.Popen(
            command, env={**os.environ, "PYTHONPATH": path}, stdout=output, stderr=subprocess.STDOUT
        ) as server,
    ):
        url = f"http://127.0.0.1:{port}/relight"
        try:
            _wait_for(url, server, log)
            yield url
        finally:
            server.terminate()


def _wait_for(url, server, log):
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

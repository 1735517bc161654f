"""`toonkit dashboard` serves the pages to this machine, and says where."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager

import pytest

from tests.dashboards.conftest import ROOT, free_port, wait_until_served
from tests.dashboards.driving import START_SECONDS
from toonkit.cli import main

STOP_SECONDS = 30


@contextmanager
def commanded(folder, *arguments):
    """The address of a page that the command serves from another folder than the checkout, and its process."""
    port, log = free_port(), folder / "log"
    opened = folder / "opened"
    browser = folder / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > "{opened}"\n')
    browser.chmod(0o755)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "BROWSER": str(browser)}
    command = [sys.executable, "-m", "toonkit", "dashboard", *map(str, arguments), "--port", str(port)]
    with (
        log.open("w") as output,
        subprocess.Popen(
            command, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT
        ) as server,
    ):
        url = f"http://127.0.0.1:{port}/{arguments[0]}"
        try:
            wait_until_served(url, server, log)
            yield url, server
        finally:
            server.terminate()


def handshake(url, origin):
    """The status with which the server of a page answers a page of another address that wants to connect to it."""
    host = url.split("/")[2]
    lines = [
        f"GET /{url.rsplit('/', 1)[1]}/ws HTTP/1.1",
        f"Host: {host}",
        f"Origin: {origin}",
        "Connection: Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==",
    ]
    with socket.create_connection(tuple(host.split(":")), STOP_SECONDS) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        return int(connection.recv(64).split()[1])


@pytest.mark.browser
def test_relight_is_served_to_its_own_page_alone_and_opened_until_it_is_interrupted(
    tmp_path, page, complaints
):
    with commanded(tmp_path, "relight") as (url, server):
        assert handshake(url, url.rsplit("/", 1)[0]) == 101
        assert handshake(url, "http://example.com") == 403
        page.goto(url)
        page.wait_for_selector(".relight:not(.empty)", timeout=START_SECONDS * 1000)
        assert page.title() == "toonkit · relight a drawing"
        page.goto("about:blank")
        with socket.socket() as other:  # whoever listens on all addresses has this one, too
            other.bind(("127.0.0.2", int(url.split(":")[2].partition("/")[0])))
        server.send_signal(signal.SIGINT)
        assert server.wait(STOP_SECONDS) == 0
    address = url.replace("127.0.0.1", "localhost")
    assert (tmp_path / "opened").read_text().strip() == address
    assert address in (tmp_path / "log").read_text().splitlines()


@pytest.mark.browser
def test_study_is_served_from_its_folder_without_a_browser(tmp_path, study_folder, page, complaints):
    with commanded(tmp_path, "study", study_folder, "--no-show") as (url, _):
        page.goto(url)
        page.wait_for_selector(".bk-Figure", timeout=START_SECONDS * 1000)
        assert page.title() == "toonkit · look into the study"
    assert not (tmp_path / "opened").exists()


def test_a_port_in_use_is_refused():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        command = [sys.executable, "-m", "toonkit", "dashboard", "--no-show", "--port", port]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert f"port must be one that nothing else uses; try another; got {port} (in use)" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sketch"], "argument page: invalid choice: 'sketch'"),
        (["relight", "study/"], "dashboard takes a FOLDER only for study; got study/"),
        (["study"], "dashboard study needs the FOLDER of a study (toonkit study run -o FOLDER); got none"),
        (["study", "absent"], "got absent, which does not exist"),
        (["--port", "70000"], "port must be a number from 1 to 65535; got 70000"),
    ],
)
def test_what_cannot_be_shown_is_refused(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["dashboard", *arguments, "--no-show"]) == 2
    assert message in capsys.readouterr().err

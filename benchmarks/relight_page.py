"""The relight dashboard, served for a benchmark, and what is dropped on it."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).parents[1]
CHROMIUM_FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"]
START_SECONDS = 60


def four_tone_ball(size: int, radius: float) -> bytes:
    """Return a four-tone ball with an antialiased outline, in the middle of a square picture, as a PNG file."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    away = np.hypot(x, y)
    height = np.sqrt(np.maximum(0, 1 - (away / radius) ** 2))
    light = -0.5 * (x + y) / radius + 0.7071 * height
    ramp = np.array([[58, 38, 84], [122, 62, 108], [214, 108, 96], [250, 190, 120]])
    color = ramp[np.digitize(light, [-0.2, 0.3, 0.7])]
    alpha = np.clip(radius + 0.5 - away, 0, 1) * 255
    file = BytesIO()
    Image.fromarray(np.dstack([color, alpha]).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


@contextmanager
def served_page() -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Serve the dashboard on a free port, nothing of it warm yet; yield its address and the server's process."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "panel", "serve", str(ROOT / "dashboards" / "relight.py")]
    command += ["--port", str(port), "--address", "127.0.0.1"]
    command += ["--allow-websocket-origin", f"127.0.0.1:{port}"]
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    with subprocess.Popen(
        command, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as server:
        try:
            _wait_for(port)
            yield f"http://127.0.0.1:{port}/relight", server
        finally:
            server.terminate()


def _wait_for(port: int) -> None:
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=5).close()
        except ConnectionError:
            time.sleep(0.1)
        else:
            return
    raise SystemExit("the dashboard did not start")


@contextmanager
def system_chromium() -> Iterator[Browser]:
    """Yield the system's Chromium, without a window."""
    names = ("chromium", "chromium-browser", "google-chrome")
    executable = next((path for path in map(shutil.which, names) if path), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=CHROMIUM_FLAGS)
        try:
            yield browser
        finally:
            browser.close()


def drop_file(page: Page, content: bytes) -> None:
    """Drop a PNG file on the page."""
    page.locator("input[type=file]").set_input_files(
        {"name": "drawing.png", "mimeType": "image/png", "buffer": content}
    )

"""Memory of the relight page's server before, during and after visits.

Sixteen visitors, one after another, each drop a 1300 x 1300 drawing on the page, wait for it, and leave. Written are the
resident memory before the first of them (after one visit that only loads the page), the most while they are there, and what
is left a minute after the last has gone. Run from the repository's root:

    python -m benchmarks.sessions -o benchmarks/results
"""

from __future__ import annotations

import argparse
import csv
import shutil
import socket
import threading
import time
from io import BytesIO
from pathlib import Path

import numpy as np
import psutil
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from benchmarks.drag_rate import CHROMIUM_FLAGS, serve

VISITS = 16
SIZE = 1300
AFTER_SECONDS = 60
WANTED_SHARE = 0.15
"""Of the memory before: what may be left of the visits."""

CSV_NAME = "sessions.csv"


class MemoryWatch:
    """The most resident memory of a process, sampled from a thread."""

    def __init__(self, process: int) -> None:
        self._process = psutil.Process(process)
        self._ended = threading.Event()
        self.peak = 0.0
        threading.Thread(target=self._watch, daemon=True).start()

    def now(self) -> float:
        """Return the resident memory, MB."""
        return self._process.memory_info().rss / 1e6

    def end(self) -> None:
        """Stop sampling."""
        self._ended.set()

    def _watch(self) -> None:
        while not self._ended.wait(0.1):
            self.peak = max(self.peak, self.now())


def drawing(visit: int, size: int) -> bytes:
    """Return a four-tone ball as a PNG file, another for each visit."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    radius = 0.48 * size - visit
    distance = np.hypot(x, y) / radius
    light = -0.5 * (x + y) / radius + 0.7071 * np.sqrt(np.maximum(0, 1 - distance**2))
    ramp = np.array([[58, 38, 84], [122, 62, 108], [214, 108, 96], [250, 190, 120]])
    color = ramp[np.digitize(light, [-0.2, 0.3, 0.7])]
    alpha = np.where(distance <= 1, 255, 0)
    file = BytesIO()
    Image.fromarray(np.dstack([color, alpha]).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


def visit(browser: Browser, url: str, content: bytes | None, size: int) -> None:
    """Open the page, drop a drawing if there is one, and leave once it is relit."""
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.goto(url, timeout=120_000)
    page.wait_for_selector(".relight:not(.empty)", timeout=120_000)
    page.wait_for_selector(".busy:not(.on)", state="attached", timeout=120_000)
    if content is not None:
        drop(page, content, size)
    page.close()


def drop(page: Page, content: bytes, size: int) -> None:
    page.locator("input[type=file]").set_input_files(
        {"name": "drawing.png", "mimeType": "image/png", "buffer": content}
    )
    page.wait_for_function(
        f"[...document.querySelectorAll('*')].flatMap(function all(node) {{"
        f"  return [node, ...[...(node.shadowRoot?.querySelectorAll('*') ?? [])].flatMap(all)] }})"
        f".some((node) => node.matches('.card.relit canvas.picture') && node.width === {size})",
        timeout=300_000,
    )
    page.wait_for_selector(".busy:not(.on)", state="attached", timeout=120_000)
    page.wait_for_timeout(2000)  # the tab below the pictures is filled, too


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, help=f"folder to write {CSV_NAME} into")
    parser.add_argument("--visits", type=int, default=VISITS, help=f"visitors (default {VISITS})")
    parser.add_argument("--size", type=int, default=SIZE, help=f"pixels of a side (default {SIZE})")
    options = parser.parse_args()
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    url = f"http://127.0.0.1:{port}/relight"
    server = serve(port)
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=chromium, args=CHROMIUM_FLAGS)
            visit(browser, url, None, options.size)
            time.sleep(AFTER_SECONDS)
            memory = MemoryWatch(server.pid)
            before = memory.now()
            for number in range(options.visits):
                visit(browser, url, drawing(number, options.size), options.size)
            browser.close()
        time.sleep(AFTER_SECONDS)
        memory.end()
        after = memory.now()
    finally:
        server.terminate()
        server.wait()
    row = {
        "visits": options.visits,
        "size": options.size,
        "before_mb": round(before),
        "peak_mb": round(memory.peak),
        "after_60_s_mb": round(after),
        "left_share": round(after / before - 1, 3),
        "wanted_share": WANTED_SHARE,
    }
    for name, value in row.items():
        print(f"{name:16} {value}")
    if options.output:
        options.output.mkdir(parents=True, exist_ok=True)
        with (options.output / CSV_NAME).open("w", newline="") as file:
            writer = csv.DictWriter(file, row, lineterminator="\n")
            writer.writeheader()
            writer.writerow(row)


if __name__ == "__main__":
    main()

"""Memory of the relight page's server before, during and after visits.

Sixteen visitors, one after another, each drop a 1300 x 1300 drawing on the page, wait for it, and leave. Written are the
resident memory before the first of them (after one visit that only loads the page), the most while they are there, and what
is left a minute after the last has gone. Run from the repository's root:

    python -m benchmarks.sessions -o benchmarks/results
"""

from __future__ import annotations

import argparse
import csv
import threading
import time
from pathlib import Path

import psutil
from playwright.sync_api import Browser, Page

from benchmarks.relight_page import drop_file, four_tone_ball, served_page, system_chromium

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
        self.peak = self.before = 0.0
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
    """Drop a drawing and wait until it is relit."""
    drop_file(page, content)
    page.wait_for_function(
        f"[...document.querySelectorAll('*')].flatMap(function all(node) {{"
        f"  return [node, ...[...(node.shadowRoot?.querySelectorAll('*') ?? [])].flatMap(all)] }})"
        f".some((node) => node.matches('.card.relit canvas.picture') && node.width === {size})",
        timeout=300_000,
    )
    page.wait_for_selector(".busy:not(.on)", state="attached", timeout=120_000)
    page.wait_for_timeout(2000)  # the tab below the pictures is filled, too


def report(row: dict[str, float], path: Path | None) -> None:
    """Print what was measured, and write it as a table of one row if there is a path."""
    for name, value in row.items():
        print(f"{name:16} {value}")
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, row, lineterminator="\n")
            writer.writeheader()
            writer.writerow(row)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, help=f"folder to write {CSV_NAME} into")
    parser.add_argument("--visits", type=int, default=VISITS, help=f"visitors (default {VISITS})")
    parser.add_argument("--size", type=int, default=SIZE, help=f"pixels of a side (default {SIZE})")
    options = parser.parse_args()
    with served_page() as (url, server):
        with system_chromium() as browser:
            visit(browser, url, None, options.size)
            time.sleep(AFTER_SECONDS)
            memory = MemoryWatch(server.pid)
            before = memory.now()
            for number in range(options.visits):
                ball = four_tone_ball(options.size, 0.48 * options.size - number)  # another for each visit
                visit(browser, url, ball, options.size)
        time.sleep(AFTER_SECONDS)
        memory.end()
        after = memory.now()
    row = {
        "visits": options.visits,
        "size": options.size,
        "before_mb": round(before),
        "peak_mb": round(memory.peak),
        "after_60_s_mb": round(after),
        "left_share": round(after / before - 1, 3),
        "wanted_share": WANTED_SHARE,
    }
    report(row, options.output and options.output / CSV_NAME)


if __name__ == "__main__":
    main()

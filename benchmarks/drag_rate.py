"""Pictures a second while the light is dragged in the relight page, and seconds to its first picture.

Serves the dashboard, opens it in headless Chromium, drops a 512 x 512 drawing, and drags on the light ball.
A picture counts once the graphics card has finished it: after each draw one pixel is read back. Run from the
repository's root:

    python -m benchmarks.drag_rate -o drag_rate.json
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Page

from benchmarks.relight_page import drop_file, four_tone_ball, served_page, system_chromium

SIZE = 512
WANTED_RATE = 20
WANTED_SECONDS = 10

COUNT_FINISHED_PICTURES = """
window.finished = [];
const draw = WebGL2RenderingContext.prototype.drawArrays;
WebGL2RenderingContext.prototype.drawArrays = function (...call) {
  draw.apply(this, call);
  if (!this.canvas.classList.contains("picture")) return;
  this.readPixels(this.canvas.width >> 1, this.canvas.height >> 1, 1, 1, this.RGBA, this.UNSIGNED_BYTE, new Uint8Array(4));
  window.finished.push([performance.now(), this.canvas.width, this.canvas.height]);
}
"""


def seconds_to_first_picture(page: Page, url: str) -> float:
    start = time.perf_counter()
    page.goto(url)
    page.wait_for_function("window.finished.length > 0", timeout=120_000)
    return time.perf_counter() - start


def drop(page: Page) -> None:
    drop_file(page, four_tone_ball(SIZE, 250))
    page.wait_for_function(f"window.finished.at(-1)[1] === {SIZE}", timeout=120_000)
    page.wait_for_selector(".busy:not(.on)", state="attached")
    page.wait_for_timeout(3000)  # the plots below the pictures are drawn too


def drag(page: Page, seconds: float) -> list[float]:
    """Circle on the ball; return the time at which each picture was finished, in ms."""
    box = page.locator(".card.relit .ball-box").bounding_box()
    assert box is not None
    center = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*center)
    page.mouse.down()
    page.evaluate("window.finished = []")
    start = time.perf_counter()
    while (passed := time.perf_counter() - start) < seconds:
        turn = 2 * math.pi * passed / 2
        reach = box["width"] * 0.35
        page.mouse.move(center[0] + reach * math.cos(turn), center[1] + reach * math.sin(turn))
    times = page.evaluate("window.finished.map(([time]) => time)")
    page.mouse.up()
    return times


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, help="write the figures here, as JSON")
    parser.add_argument("--seconds", type=float, default=5, help="how long to drag (default 5)")
    parser.add_argument(
        "--screenshot", type=Path, help="write a picture of the page with its sample here, as PNG"
    )
    options = parser.parse_args()
    with served_page() as (url, _), system_chromium() as browser:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.add_init_script(COUNT_FINISHED_PICTURES)
        first = seconds_to_first_picture(page, url)
        page.wait_for_timeout(4000)
        again = seconds_to_first_picture(page, url)
        page.wait_for_timeout(6000)  # the plots below the pictures are drawn too
        if options.screenshot:
            page.screenshot(path=options.screenshot)
        drop(page)
        times = drag(page, options.seconds)
    gaps = np.diff(times)
    figures = {
        "picture": [SIZE, SIZE],
        "first_picture_cold_s": round(first, 2),
        "first_picture_warm_s": round(again, 2),
        "pictures": len(times),
        "pictures_per_second": round(1000 * len(gaps) / (times[-1] - times[0]), 1),
        "median_ms": round(statistics.median(gaps), 1),
        "p95_ms": round(float(np.percentile(gaps, 95)), 1),
        "wanted_pictures_per_second": WANTED_RATE,
        "wanted_first_picture_s": WANTED_SECONDS,
    }
    for name, value in figures.items():
        print(f"{name:28} {value}")
    if options.output:
        options.output.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()

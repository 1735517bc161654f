"""Many visitors of the relight page at once: how long their drawings take, and what is left of them.

Each brings a drawing, drags the light, merges two materials, takes that back, and begins again with another drawing, for
two minutes, looking at each result for five seconds. Measured are the seconds from a dropped file to the relit picture,
and the resident memory of the server before, meanwhile and a minute after the last visitor has left. It fails if a page
has an error or asks anything of another machine; a page that showed another visitor's drawing would wait for its own,
which is of another size, until the time is up. Run from the repository's root:

    python -m benchmarks.crowd -o benchmarks/results
"""

from __future__ import annotations

import argparse
import asyncio
import shutil
import time
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.async_api import Browser, Page, async_playwright

from benchmarks.relight_page import CHROMIUM_FLAGS, served_page
from benchmarks.sessions import AFTER_SECONDS, WANTED_SHARE, MemoryWatch, report

VISITORS, SECONDS, SIZE = 8, 120, 512
WANTED_SECONDS = 4.0
"""From a dropped file to the relit picture, median."""

LOOK_SECONDS = 5
"""For which somebody looks at a result before doing the next thing."""

PATIENCE = 120_000
"""Milliseconds until a page is given up."""

LOCAL = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")
CSV_NAME = "crowd.csv"

SHOWN = """size => [...document.querySelectorAll('*')].flatMap(function all(node) {
  return [node, ...[...(node.shadowRoot?.querySelectorAll('*') ?? [])].flatMap(all)]
}).some((node) => node.matches('.card.relit canvas.picture') && node.width === size)"""


def badged_ball(size: int, hue: int) -> bytes:
    """Return a ball in two tones with a badge, as a PNG file; each hue is another drawing."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    color = np.where((x + y < 0)[..., None], (230, 210, 120 + hue), (120, 100, 60 + hue))
    color[np.hypot(x - 0.1 * size, y - 0.1 * size) < 0.15 * size] = (200, 30, 40)
    alpha = np.clip(0.42 * size - np.hypot(x, y), 0, 1) * 255
    file = BytesIO()
    Image.fromarray(np.dstack([color, alpha]).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


class Visitor:
    """Somebody at the page, whose drawings are of a size of their own."""

    def __init__(self, page: Page, number: int, size: int) -> None:
        self.page, self.number, self.size = page, number, size + number
        self.seconds: list[float] = []
        self.corrections = 0
        self.complaints: list[str] = []
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: self.complaints.append(f"page error: {error}"))
        page.on("request", lambda asked: self._hear(asked.url))

    def _hear(self, url: str) -> None:
        if not url.startswith(LOCAL):
            self.complaints.append(f"asked for {url}")

    async def stay(self, url: str, until: float) -> None:
        """Work until a moment, and leave."""
        await self.page.goto(url)
        await self.page.wait_for_selector(".relight:not(.empty)")
        while time.monotonic() < until:
            for act in (self._bring, self._drag_light, self._merge, self._undo):
                await asyncio.sleep(LOOK_SECONDS)
                await act()
        await self.page.close()

    async def _bring(self) -> None:
        """Drop a drawing that nobody has dropped, and wait until it is relit."""
        content = badged_ball(self.size, 10 * self.number + len(self.seconds) % 10)
        began = time.monotonic()
        await self.page.locator("input[type=file]").set_input_files(
            {"name": "ball.png", "mimeType": "image/png", "buffer": content}
        )
        await self.page.wait_for_selector(".busy.on", state="attached")
        await self._rest()
        await self.page.wait_for_function(SHOWN, arg=self.size)
        self.seconds.append(time.monotonic() - began)

    async def _drag_light(self) -> None:
        """Drag the light across the relit picture."""
        await self.page.get_by_role("button", name="Light", exact=True).click()
        box = await self.page.locator(".card.relit .stage").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        await self.page.mouse.move(x, y)
        await self.page.mouse.down()
        for step in range(10):
            await self.page.mouse.move(x + 6 * step, y - 4 * step)
            await asyncio.sleep(0.1)
        await self.page.mouse.up()

    async def _merge(self) -> None:
        """Merge the badge into the ball."""
        await self.page.get_by_role("button", name="Materials", exact=True).click()
        swatches = self.page.locator(".swatch:not(.new):not(.ghost):not(.mark)")
        await swatches.nth(1).click()
        await self.page.locator(".tools").get_by_role("button", name="Merge into").click()
        await swatches.nth(0).click()
        await self._rest()

    async def _undo(self) -> None:
        """Take the merge back."""
        await self.page.keyboard.press("Control+z")
        await self._rest()
        self.corrections += 1

    async def _rest(self) -> None:
        """Wait until the page has an answer."""
        await asyncio.sleep(0.3)
        await self.page.wait_for_selector(".busy:not(.on)", state="attached")


async def crowd(url: str, options: argparse.Namespace, memory: MemoryWatch) -> list[Visitor]:
    """Let everybody visit at once; start with one who only looks, after whom the memory counts."""
    names = ("chromium", "chromium-browser", "google-chrome")
    executable = next((path for path in map(shutil.which, names) if path), None)
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=executable, args=CHROMIUM_FLAGS)
        await Visitor(await _page(browser), 0, options.size).stay(url, 0.0)
        await asyncio.sleep(AFTER_SECONDS)
        memory.before = memory.now()
        visitors = [Visitor(await _page(browser), k, options.size) for k in range(options.visitors)]
        until = time.monotonic() + options.seconds
        await asyncio.gather(*(visitor.stay(url, until) for visitor in visitors))
        await browser.close()
    return visitors


async def _page(browser: Browser) -> Page:
    return await browser.new_page(viewport={"width": 1280, "height": 720})


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, help=f"folder to write {CSV_NAME} into")
    parser.add_argument("--visitors", type=int, default=VISITORS, help=f"how many (default {VISITORS})")
    parser.add_argument("--seconds", type=int, default=SECONDS, help=f"how long (default {SECONDS})")
    parser.add_argument("--size", type=int, default=SIZE, help=f"pixels of a side (default {SIZE})")
    options = parser.parse_args()
    with served_page() as (url, server):
        memory = MemoryWatch(server.pid)
        visitors = asyncio.run(crowd(url, options, memory))
        time.sleep(AFTER_SECONDS)
        memory.end()
        after = memory.now()
    complaints = [complaint for visitor in visitors for complaint in visitor.complaints]
    if complaints:
        raise SystemExit("\n".join(complaints))
    seconds = [each for visitor in visitors for each in visitor.seconds]
    row = {
        "visitors": options.visitors,
        "size": options.size,
        "drawings": len(seconds),
        "corrections": sum(visitor.corrections for visitor in visitors),
        "median_seconds": round(float(np.median(seconds)), 2),
        "worst_seconds": round(max(seconds), 2),
        "wanted_seconds": WANTED_SECONDS,
        "before_mb": round(memory.before),
        "peak_mb": round(memory.peak),
        "after_60_s_mb": round(after),
        "left_share": round(after / memory.before - 1, 3),
        "wanted_share": WANTED_SHARE,
    }
    report(row, options.output and options.output / CSV_NAME)


if __name__ == "__main__":
    main()

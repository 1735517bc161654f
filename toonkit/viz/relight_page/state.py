"""What the relight page knows: the drawing, the method, two lights. Knows no panel."""

from __future__ import annotations

import asyncio
import hashlib
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from io import BytesIO
from typing import TypeVar

import numpy as np
import param
from numpy.typing import NDArray
from PIL import Image

import toonkit
from toonkit import ToonAnalysis, ToonImage
from toonkit._validation import collect_warnings, refuse
from toonkit.model.normals import encode_normal_map
from toonkit.samples import sample_light, sample_path
from toonkit.viz.turns import TURNS, Progress

METHOD_DESCRIPTIONS = {
    "toonkit": ("toonkit", "Recommended: knows shapes, keeps the colors"),
    "classical": ("classical", "The same without what it has learned"),
    "todo": ("Todo et al.", "The published method, step by step"),
    "lumo": ("Lumo", "Puffs up the outline, ignores the shading"),
    "lambert": ("Lambert", "Reads the tones as plain, even shading"),
}
"""Name for people and one line of advice for each method."""

DEFAULT_METHOD = "toonkit"

KEPT_ANALYSES = 6
"""Analyses kept for going back to a method or a sample without waiting: of the samples, and of a visitor's own."""

KEPT_PIXELS = 1_500_000
"""Pictures larger than this are not kept: an analysis of one takes some 200 bytes a pixel."""


MOST_FILE_BYTES = 60 * 10**6
"""Largest picture file that a visitor may open."""

PROGRESS_SECONDS = 0.08
"""Pause between two progress reports: faster ones only fill the connection."""

Key = tuple[str, str, tuple[float, ...]]
Result = TypeVar("Result")


Kept = OrderedDict[Key, ToonAnalysis]

_samples: Kept = (
    OrderedDict()
)  # of the samples, for all visitors; pictures of their own are kept with their state


class CancelledError(Exception):
    """Raised inside a computation to end it."""


class RelightState(param.Parameterized):
    """
    A drawing, its analysis on screen, and the light it is shown under.

    `method` and `original_light` are wishes: `analyze` makes them true, or, when it fails or is
    cancelled, puts them back to what the analysis on screen was made with.

    Examples
    --------
    >>> state = RelightState()
    >>> asyncio.run(state.open_sample("duck"))  # doctest: +SKIP
    >>> state.relit_png()  # doctest: +SKIP
    """

    sample = param.String("", doc='Name of the sample on screen; "" for a picture of the user\'s own.')
    method = param.String(DEFAULT_METHOD, doc="Name of the estimator in METHODS.")
    original_light = param.List(
        [135.0, 45.0], bounds=(2, 2), doc="Azimuth and elevation of the artist's light, degrees."
    )
    new_light = param.List(
        [35.0, 40.0], bounds=(2, 2), doc="Azimuth and elevation of the new light, degrees."
    )
    keep_detail = param.Boolean(True, doc="Keep what the artist painted on top of the color map.")
    flat_shading = param.Number(1.0, bounds=(0, 1), doc="How much materials in one tone answer to the light.")
    analysis = param.Parameter(None, doc="The ToonAnalysis on screen.")
    step = param.String("", doc='What is being computed; "" when idle.')
    fraction = param.Number(0.0, bounds=(0, 1), doc="How much of it is done.")

    def __init__(self, **params: object) -> None:
        super().__init__(**params)
        self._stop = threading.Event()
        self._turn = asyncio.Lock()
        self._own: Kept = OrderedDict()

    async def open_sample(self, name: str) -> None:
        """Open a drawing that ships with toonkit, under its own light."""
        image = await self._work("opening the drawing", lambda _: toonkit.load_image(sample_path(name)))
        if image is not None:
            await self._analyze(image, list(sample_light(name)), sample=name)

    async def open_file(self, content: bytes) -> list[str]:
        """
        Open a picture of the user's own; its light is estimated.

        Returns
        -------
        list of str
            What of the file is ignored or only assumed, a line each.

        Raises
        ------
        ToonkitError
            If it is no picture, or too large.
        """
        if not isinstance(content, bytes):
            raise refuse("source", "must be a picture file", "a text")
        if len(content) > MOST_FILE_BYTES:
            rule = f"must have at most {MOST_FILE_BYTES // 10**6} MB"
            raise refuse("source", rule, f"{len(content) / 10**6:.0f} MB")
        opened = await self._work("opening the drawing", lambda _: _read(content))
        if opened is None:
            return []
        image, warned = opened
        await self._analyze(image, None, sample="")
        return warned

    async def analyze(self) -> None:
        """Analyze the drawing on screen with the method and the original light now wished for."""
        shown = self.analysis
        if shown is None or (shown.method, _angles(shown)) == (self.method, self.original_light):
            return
        await self._analyze(shown.image, list(self.original_light), sample=self.sample)

    async def estimate_light(self) -> None:
        """Let toonkit find the artist's light, and analyze the drawing under it."""
        if self.analysis is not None:
            await self._analyze(self.analysis.image, None, sample=self.sample)

    def cancel(self) -> None:
        """End the computation under way, if there is one."""
        self._stop.set()

    def close(self) -> None:
        """End what is under way, and let go of everything large: the visitor has left."""
        self.cancel()
        self._own.clear()
        with param.parameterized.discard_events(self):
            self.analysis = None

    def relit(self) -> ToonImage:
        """Return the picture on screen under the new light."""
        light = toonkit.light_direction(*self.new_light)
        return toonkit.relight(
            self.analysis, light, keep_detail=self.keep_detail, flat_shading=self.flat_shading
        )

    def relit_png(self) -> BytesIO:
        """Return the relit picture as an RGBA PNG file."""
        return _png_file(self.relit().to_rgba())

    def normal_map_png(self) -> BytesIO:
        """Return the normals as an OpenGL normal map, transparent outside the object."""
        normals = self.analysis.normals
        coverage = np.where(normals.mask, 255, 0).astype(np.uint8)
        return _png_file(np.dstack([encode_normal_map(normals), coverage]))

    async def _analyze(self, image: ToonImage, angles: list[float] | None, *, sample: str) -> None:
        method = self.method
        key = (_digest(image), method, tuple(angles or ()))
        kept = _samples if sample else self._own
        analysis = kept.get(key)
        if analysis is None:
            shown = self.analysis
            previous = shown if shown is not None and shown.image is image else None
            analysis = await self._work(
                "reading the drawing",
                lambda progress: _analyze_once(key, image, progress, previous, kept),
                waits=True,
            )
        else:
            self.cancel()
        if analysis is not None:
            self.param.update(sample=sample, analysis=analysis, original_light=_angles(analysis))

    async def _work(
        self, step: str, task: Callable[[Progress], Result], *, waits: bool = False
    ) -> Result | None:
        """
        Run a task in a thread; None if it was cancelled or overtaken. What it raises is raised here.

        A task that waits for its turn does so in a thread for that, and keeps none from those that do not.
        """
        self._stop.set()  # a newer wish ends the computation of an older one
        stop = self._stop = threading.Event()
        async with self._turn:
            if stop.is_set():
                return None
            self.param.update(step=step, fraction=0.0)
            try:
                loop = asyncio.get_running_loop()
                result = await loop.run_in_executor(
                    TURNS.threads if waits else None, task, self._progress(stop)
                )
            except CancelledError:
                result = None
            except BaseException:
                self._restore()
                raise
            finally:
                self.param.update(step="", fraction=0.0)
            if not stop.is_set():
                return result
            if stop is self._stop:
                self._restore()
            return None

    def _progress(self, stop: threading.Event) -> Progress:
        """Return the callback that a computing thread reports to, and is cancelled through."""
        loop = asyncio.get_running_loop()
        shown_at = 0.0

        def report(step: str, fraction: float) -> None:
            nonlocal shown_at
            if stop.is_set():
                raise CancelledError
            now = time.monotonic()
            if now - shown_at > PROGRESS_SECONDS:
                shown_at = now
                fraction = min(max(float(fraction), 0.0), 1.0)
                loop.call_soon_threadsafe(self._show_progress, stop, step, fraction)

        return report

    def _show_progress(self, stop: threading.Event, step: str, fraction: float) -> None:
        # A report may arrive after its computation has ended, or after another one has begun.
        if self.step and stop is self._stop:
            self.param.update(step=step, fraction=fraction)

    def _restore(self) -> None:
        """Take back wishes that were not fulfilled."""
        if self.analysis is not None:
            self.param.update(method=self.analysis.method, original_light=_angles(self.analysis))


def prepare_sample(name: str) -> None:
    """Analyze a sample ahead of time, so that the next page to open it need not wait."""
    image = toonkit.load_image(sample_path(name))
    key = (_digest(image), DEFAULT_METHOD, sample_light(name))
    _analyze_once(key, image, lambda _step, _fraction: None, None, _samples)


def _read(content: bytes) -> tuple[ToonImage, list[str]]:
    with collect_warnings() as warned:
        return toonkit.load_image(BytesIO(content)), warned


def _analyze_once(
    key: Key, image: ToonImage, progress: Progress, previous: ToonAnalysis | None, kept: Kept
) -> ToonAnalysis:
    """Analyze a picture once its turn has come, from an earlier answer if there is one, unless somebody has done so."""
    with TURNS.turn(progress) as limited:
        if key not in kept:
            _, method, angles = key
            light = toonkit.light_direction(*angles) if angles else None
            analysis = toonkit.analyze(image, light, method=method, previous=previous, progress=limited)
            if image.mask.size > KEPT_PIXELS:
                return analysis
            kept[key] = analysis
            while len(kept) > KEPT_ANALYSES:
                kept.popitem(last=False)
        return kept[key]


def _angles(analysis: ToonAnalysis) -> list[float]:
    """Azimuth and elevation of the light of an analysis, rounded to what a slider can tell apart."""
    return [round(angle, 3) for angle in toonkit.light_angles(analysis.light)]


def _digest(image: ToonImage) -> str:
    content = hashlib.blake2b(np.ascontiguousarray(image.color).tobytes(), digest_size=16)
    content.update(np.ascontiguousarray(image.alpha).tobytes())
    return content.hexdigest()


def _png_file(pixels: NDArray[np.unsignedinteger]) -> BytesIO:
    file = BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    file.seek(0)
    return file

"""What the relight page knows: the drawing, its materials, the method, two lights. Knows no panel."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import param

import toonkit
from toonkit import ToonAnalysis, ToonImage
from toonkit.model.tone_ramp import ToneRamp
from toonkit.samples import sample_light, sample_path
from toonkit.viz.latest_task import LatestTask, TaskReport
from toonkit.viz.relight_page.analyses import (
    SAMPLES,
    Evidence,
    Kept,
    Question,
    answer,
    base_of,
    digest_of,
)
from toonkit.viz.relight_page.corrections import (
    LabelVersion,
    MaterialCorrections,
    Numbers,
    materials_of,
    numbers_in,
)
from toonkit.viz.relight_page.opening import check_size, read_picture
from toonkit.viz.relight_page.settings import SETTINGS, RelightSettings
from toonkit.viz.turns import TURNS

KEPT_CORRECTIONS = 12
"""Drawings of which a visitor's corrections are kept, for coming back to them."""

STEP_SECONDS = 0.8
"""Pause after which a change of the same setting is a step of its own: a drag is undone as a whole."""

Result = TypeVar("Result")


class RelightState(RelightSettings):
    """
    A drawing, its analysis on screen, and the light it is shown under.

    `method`, `original_light` and the corrected materials are wishes: `analyze` makes them true, or, when it fails or is
    cancelled, puts them back to what the analysis on screen was made with.

    Examples
    --------
    >>> state = RelightState()
    >>> asyncio.run(state.open_sample("duck"))  # doctest: +SKIP
    >>> state.relit()  # doctest: +SKIP
    """

    sample = param.String("", doc='Name of the sample on screen; "" for a picture of the user\'s own.')
    analysis = param.Parameter(None, doc="The ToonAnalysis on screen.")
    selected = param.Integer(-1, doc="Number of the material being looked at, as in `labels`; -1 for none.")
    can_undo = param.Boolean(False, doc="Whether a correction of the materials can be undone.")
    can_redo = param.Boolean(False, doc="Whether one can be done again.")
    corrected = param.Boolean(False, doc="Whether the materials wished for are others than those found.")
    ramps = param.Dict({}, doc="Edited ramps, a `ToneRamp` for each number of a material that has one.")
    settled = param.Integer(
        0, doc="How many corrections are done with: analyzed, refused, or overtaken by others."
    )
    step = param.String("", doc='What is being computed; "" when idle.')
    fraction = param.Number(0.0, bounds=(0, 1), doc="How much of it is done.")

    def __init__(self, **params: object) -> None:
        super().__init__(**params)
        self._task = LatestTask(lambda step, fraction: self.param.update(step=step, fraction=fraction))
        self._own: Kept = OrderedDict()
        self._corrections: OrderedDict[str, MaterialCorrections] = OrderedDict()
        self._digest = ""
        self._version: LabelVersion | None = None  # of the materials on screen; None as found
        self._under_way: tuple[object, ...] | None = None
        self._recalling = False
        self._changing: tuple[set[str], float] = set(), 0.0  # settings, and when they were last changed

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
        picture = check_size(content)
        opened = await self._work("opening the drawing", lambda _: read_picture(picture))
        if opened is None:
            return []
        image, warned = opened
        await self._analyze(image, None, sample="")
        return warned

    async def analyze(self) -> None:
        """Analyze the drawing on screen with the method, the original light and the materials now wished for."""
        wish = () if self.analysis is None else self._wish
        if self.analysis is None or wish in (self._fulfilled, self._under_way):
            return
        self._under_way = wish
        try:
            await self._analyze(self.analysis.image, list(self.original_light), sample=self.sample)
        finally:
            if self._under_way is wish:
                self._under_way = None

    @property
    def corrections(self) -> MaterialCorrections:
        """The materials of the drawing on screen, and what was corrected in them."""
        return self._corrections[self._digest]

    @property
    def codes(self) -> Numbers:
        """Number of each pixel's material on screen plus its mark, shape (H, W): in `corrections`, not in the analysis."""
        return self.corrections.codes_of(self._version)

    @property
    def labels(self) -> Numbers:
        """Number of each pixel's material on screen, shape (H, W), -1 where the analysis has found it."""
        return materials_of(self.codes)

    @property
    def numbers(self) -> list[int]:
        """Numbers of the materials on screen, in the order in which the analysis has them."""
        return [] if self.analysis is None else numbers_in(self.labels)

    @property
    def selected_place(self) -> str:
        """Place of the selected material in the analysis on screen, as a text; empty if none of its materials is."""
        numbers = self.numbers
        return str(numbers.index(self.selected)) if self.selected in numbers else ""

    def select_place(self, place: int) -> None:
        """Select a material by its place in the analysis on screen."""
        numbers = self.numbers
        if place < len(numbers):
            self.selected = numbers[place]

    async def merge(self, material: int, into: int) -> None:
        """Give all of a material to another one, and analyze the drawing with it."""
        await self._correct(lambda corrections: corrections.merge(material, into))

    async def paint(self, path: Sequence[Sequence[float]], radius: float, material: int) -> None:
        """Give what a brush covers to a material, and analyze the drawing with it: see `MaterialCorrections.paint`."""
        await self._correct(lambda corrections: corrections.paint(path, radius, material))

    async def fill(self, place: Sequence[float], material: int) -> None:
        """Give a connected region to a material, and analyze the drawing with it: see `MaterialCorrections.fill`."""
        await self._correct(lambda corrections: corrections.fill(place, material))

    async def split(self, path: Sequence[Sequence[float]], material: int) -> None:
        """Make what a loop encloses a new material, and analyze the drawing with it: see `MaterialCorrections.split`."""
        await self._correct(lambda corrections: corrections.split(path, material))

    async def recolor(self, material: int, ramp: Mapping[str, Any] | None) -> None:
        """Give a material the tones of a `ToneRamp` with these arguments; None gives it back those it is drawn with."""
        await self._correct(
            lambda corrections: corrections.recolor(material, None if ramp is None else ToneRamp(**ramp))
        )

    async def undo(self) -> None:
        """Take the last correction back."""
        await self._correct(MaterialCorrections.undo)

    async def redo(self) -> None:
        """Do again what was taken back last."""
        await self._correct(MaterialCorrections.redo)

    async def reset_materials(self) -> None:
        """Return to the materials that were found."""
        await self._correct(MaterialCorrections.reset)

    async def estimate_light(self) -> None:
        """Let toonkit find the artist's light, and analyze the drawing under it."""
        if self.analysis is not None:
            await self._analyze(self.analysis.image, None, sample=self.sample)

    def cancel(self) -> None:
        """End the computation under way, if there is one."""
        self._task.cancel()

    def close(self) -> None:
        """End what is under way, and let go of everything large: the visitor has left."""
        self._task.overtake()
        self._own.clear()
        self._corrections.clear()
        with param.parameterized.discard_events(self):
            self.analysis = None

    @property
    def recolored(self) -> ToonAnalysis:
        """The analysis on screen, with the edited ramps."""
        analysis: ToonAnalysis = self.analysis
        if not self.ramps:
            return analysis
        places = {number: place for place, number in enumerate(self.numbers)}
        ramps = {places[number]: ramp for number, ramp in self.ramps.items() if number in places}
        return analysis.recolored(ramps)

    def relit(self) -> ToonImage:
        """Return the picture on screen under the new light."""
        return self.relight(self.recolored)

    @property
    def _wish(self) -> tuple[object, ...]:
        return self.method, self.original_light, self.corrections.labels_version

    @property
    def _fulfilled(self) -> tuple[object, ...]:
        return self.analysis.method, _angles(self.analysis), self._version

    async def _correct(self, change: Callable[[MaterialCorrections], None]) -> None:
        if self.analysis is None:
            return
        try:
            change(self.corrections)
            self._changing = set(), 0.0
            self._recall()
            self._show_corrections()
            if self._wish == self._fulfilled:
                self.cancel()  # back at what is on screen, while something else was on its way
            await self.analyze()
        finally:
            self.settled += 1

    @param.depends(*SETTINGS, watch=True)
    def _remember(self) -> None:
        """Make a step of what the visitor has changed."""
        if self._recalling or self._digest not in self._corrections:
            return
        look = self.look
        changed = {name for name, _ in set(look) - set(self.corrections.look)}
        if not changed:
            return
        (before, then), now = self._changing, time.monotonic()
        self.corrections.change_look(look, again=changed == before and now - then < STEP_SECONDS)
        self._changing = changed, now
        self._show_corrections()

    def _recall(self) -> None:
        """Return to the settings of the step that the corrections are at."""
        with self._silently():
            self.take(self.corrections.look)

    @contextmanager
    def _silently(self) -> Iterator[None]:
        """Change settings without making a step of it."""
        self._recalling = True
        try:
            yield
        finally:
            self._recalling = False

    def _show_corrections(self) -> None:
        corrections = self.corrections
        self.param.update(
            can_undo=corrections.can_undo,
            can_redo=corrections.can_redo,
            corrected=corrections.is_corrected,
            ramps=corrections.ramps,
        )

    async def _analyze(self, image: ToonImage, angles: list[float] | None, *, sample: str) -> None:
        shown = self.analysis if self.analysis is not None and self.analysis.image is image else None
        digest = digest_of(image) if shown is None else self._digest
        corrections = self._corrections.get(digest)
        version = None if corrections is None else corrections.labels_version
        question = Question(digest, self.method, tuple(angles or ()), version)
        kept = SAMPLES if sample and version is None else self._own
        analysis = kept.get(question)
        if analysis is not None:
            self.cancel()
        else:
            evidence = Evidence(image)
            if shown is not None and version == self._version:
                evidence = Evidence(image, previous=shown)
            elif corrections is not None and version is not None:
                marks = corrections.ink, corrections.highlights
                evidence = Evidence(base_of(image, shown, marks), corrections.labels, *marks)
            analysis = await self._work(
                "reading the drawing", lambda progress: answer(question, evidence, progress, kept), waits=True
            )
        if analysis is not None:
            self._put_on_screen(question, analysis, sample)

    def _put_on_screen(self, question: Question, analysis: ToonAnalysis, sample: str) -> None:
        digest = question.digest
        if digest not in self._corrections:
            drawing = analysis.drawing
            highlit = np.zeros(drawing.shape, np.bool_)
            highlit[drawing.places(drawing.mixed.pixels[drawing.mixed.highlit])] = True
            self._corrections[digest] = MaterialCorrections(
                analysis.materials.labels, drawing.ink_coverage >= 0.5, highlit
            )
            while len(self._corrections) > KEPT_CORRECTIONS:
                self._corrections.popitem(last=False)
        another = digest != self._digest
        selected = -1 if another else self.selected
        self._digest, self._version = digest, question.version
        self._show_corrections()
        angles = _angles(analysis)
        if question in self._own:  # a light that was estimated is one that is given from now on
            self._own.setdefault(replace(question, angles=tuple(angles)), analysis)
        if another:
            with self._silently():
                self.param.update(original_light=angles)
            self.corrections.change_look(self.look, again=True)
        self.param.update(sample=sample, analysis=analysis, original_light=angles, selected=selected)

    async def _work(
        self, step: str, task: Callable[[TaskReport], Result], *, waits: bool = False
    ) -> Result | None:
        """Run a task in a thread: see `LatestTask.run`. One that waits for its turn does so in a thread for that."""
        threads = TURNS.threads if waits else None
        return await self._task.run(step, task, threads=threads, give_up=self._restore)

    def _restore(self) -> None:
        """Take back wishes that were not fulfilled."""
        if self.analysis is not None:
            with self._silently():
                self.param.update(method=self.analysis.method, original_light=_angles(self.analysis))
            self.corrections.restore(self._version)
            self.corrections.change_look(self.look, again=True)
            self._show_corrections()


def _angles(analysis: ToonAnalysis) -> list[float]:
    """Azimuth and elevation of the light of an analysis, rounded to what a slider can tell apart."""
    return [round(angle, 3) for angle in toonkit.light_angles(analysis.light)]

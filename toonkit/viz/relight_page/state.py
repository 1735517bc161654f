"""What the relight page knows: the drawing, its materials, the method, two lights. Knows no panel."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

import param

import toonkit
from toonkit import ToonAnalysis, ToonImage
from toonkit.model.tone_ramp import ToneRamp
from toonkit.samples import sample_light
from toonkit.viz.latest_task import LatestTask, TaskReport
from toonkit.viz.relight_page.analyses import SAMPLES, Answer, Kept, Question, answer
from toonkit.viz.relight_page.codes import Numbers, materials_of, numbers_in
from toonkit.viz.relight_page.corrections import MaterialCorrections
from toonkit.viz.relight_page.material_actions import MaterialActions
from toonkit.viz.relight_page.opening import OnScreen, Opened, check_file, open_file, open_sample
from toonkit.viz.relight_page.session_file import SavedWork, is_saved_work
from toonkit.viz.relight_page.settings import PATH_SETTINGS, SETTINGS, RelightSettings
from toonkit.viz.relight_page.shape_actions import ShapeActions
from toonkit.viz.relight_page.shape_marks import ShapeMarks
from toonkit.viz.turns import TURNS

KEPT_CORRECTIONS = 12
"""Drawings of which a visitor's corrections are kept, for coming back to them."""

STEP_SECONDS = 0.8
"""Pause after which a change of the same setting is a step of its own: a drag is undone as a whole. What changes the path of
the light is always one, for it is no drag."""

Result = TypeVar("Result")


class RelightState(RelightSettings, MaterialActions, ShapeActions):
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
        self._on_screen: OnScreen | None = None
        self._under_way: tuple[object, ...] | None = None
        self._recalling = False
        self._changing: tuple[set[str], float] = set(), 0.0  # settings, and when they were last changed

    async def open_sample(self, name: str) -> None:
        """Open a drawing that ships with toonkit, under its own light."""
        opened = await self._work("opening the drawing", lambda _: open_sample(name))
        if opened is not None:
            await self._analyze(opened, sample_light(name))

    async def open_file(self, name: str, content: bytes, *, again: bool = False) -> list[str]:
        """
        Open a file of the user's own: a picture, whose light is estimated, or a session, which comes back as it was.

        Parameters
        ----------
        name : str
            Of the file.
        content : bytes
            Of the file.
        again : bool
            Whether to go on where its drawing was left, if it was on screen before.

        Returns
        -------
        list of str
            What of the file is ignored or only assumed, a line each.

        Raises
        ------
        ToonkitError
            If it is neither, or too large.
        """
        check_file(name, content)
        opened = await self._work(
            "opening the drawing",
            lambda report: open_file(name, content, report),
            waits=is_saved_work(content),
        )
        if opened is None:
            return []
        known = self._corrections.get(opened.digest) if again else None
        if known is not None:
            light: Any = dict(known.look).get("original_light", ())
            await self._analyze(opened, light)
        elif opened.saved is None:
            await self._analyze(opened, ())
        else:
            self._resume(opened, opened.saved)
        return list(opened.remarks)

    async def analyze(self) -> None:
        """Analyze the drawing on screen with the method, the original light and the materials now wished for."""
        shown = self._on_screen
        wish = () if shown is None else self._wish
        if shown is None or wish in (self._fulfilled, self._under_way):
            return
        self._under_way = wish
        try:
            await self._analyze(shown.opened, tuple(self.original_light))
        finally:
            if self._under_way is wish:
                self._under_way = None

    @property
    def on_screen(self) -> OnScreen:
        """The drawing on screen with its analysis, as `analysis` is not None."""
        assert self._on_screen is not None
        return self._on_screen

    @property
    def corrections(self) -> MaterialCorrections:
        """The materials of the drawing on screen, and what was corrected in them."""
        return self._corrections[self.on_screen.question.digest]

    @property
    def codes(self) -> Numbers:
        """Number of each pixel's material on screen plus its mark, shape (H, W): in `corrections`, not in the analysis."""
        return self.corrections.codes_of(self.on_screen.question.version)

    @property
    def labels(self) -> Numbers:
        """Number of each pixel's material on screen, shape (H, W), -1 where the analysis has found it."""
        return materials_of(self.codes)

    @property
    def shape_marks(self) -> ShapeMarks:
        """What is said about the shape on screen: in `corrections`, there may be more already."""
        return self.on_screen.question.shape

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

    async def estimate_light(self) -> None:
        """Let toonkit find the artist's light, and analyze the drawing under it."""
        if self._on_screen is not None:
            await self._analyze(self.on_screen.opened, ())

    def cancel(self) -> None:
        """End the computation under way, if there is one."""
        self._task.cancel()

    def close(self) -> None:
        """End what is under way, and let go of everything large: the visitor has left."""
        self._task.overtake()
        self._own.clear()
        self._corrections.clear()
        self._on_screen = None
        with param.parameterized.discard_events(self):
            self.analysis = None

    @property
    def placed_ramps(self) -> dict[int, ToneRamp]:
        """The edited ramps, by the place of their material in the analysis on screen."""
        places = {number: place for place, number in enumerate(self.numbers)}
        return {places[number]: ramp for number, ramp in self.ramps.items() if number in places}

    @property
    def recolored(self) -> ToonAnalysis:
        """The analysis on screen, with the edited ramps."""
        analysis: ToonAnalysis = self.analysis
        return analysis.recolored(self.placed_ramps) if self.ramps else analysis

    def relit(self) -> ToonImage:
        """Return the picture on screen under the new light."""
        return self.relight(self.recolored)

    @property
    def _wish(self) -> tuple[object, ...]:
        return self.method, self.original_light, *self.corrections.told

    @property
    def _fulfilled(self) -> tuple[object, ...]:
        question = self.on_screen.question
        return self.analysis.method, _angles(self.analysis), question.version, question.shape

    async def _correct(self, change: Callable[[MaterialCorrections], None]) -> None:
        if self._on_screen is None:
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
        if self._recalling or self._on_screen is None:
            return
        look = self.look
        changed = {name for name, _ in set(look) - set(self.corrections.look)}
        if not changed:
            return
        (before, then), now = self._changing, time.monotonic()
        dragged = changed == before and now - then < STEP_SECONDS and changed.isdisjoint(PATH_SETTINGS)
        self.corrections.change_look(look, again=dragged)
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

    async def _analyze(self, opened: Opened, angles: tuple[float, ...]) -> None:
        shown = self._on_screen if self._on_screen is not None and self._on_screen.opened is opened else None
        corrections = self._corrections.get(opened.digest)
        question = Question(opened.digest, self.method, angles, *(corrections.told if corrections else ()))
        kept = SAMPLES if opened.sample and question.is_of_drawing_alone else self._own
        found = kept.get(question)
        if found is not None:
            self.cancel()
        else:
            evidence = opened.evidence(question, corrections, shown)
            found = await self._work(
                "reading the drawing", lambda report: answer(question, evidence, report, kept), waits=True
            )
        if found is not None:
            self._put_on_screen(opened, question, found)

    def _resume(self, opened: Opened, saved: SavedWork) -> None:
        """Put what was saved back on screen."""
        analysis = saved.analysis
        angles = tuple(_angles(analysis))
        question = Question(opened.digest, analysis.method, angles, *saved.corrections.told)
        self._corrections[opened.digest] = saved.corrections
        self._on_screen = None  # so that it counts as another drawing, even if it is the same
        self._own[question] = found = Answer(analysis)
        self._put_on_screen(opened, question, found, settings=saved.settings, selected=saved.selected)

    def _put_on_screen(
        self,
        opened: Opened,
        question: Question,
        found: Answer,
        *,
        settings: Mapping[str, Any] = MappingProxyType({}),
        selected: int = -1,
    ) -> None:
        digest, analysis = question.digest, found.analysis
        if digest not in self._corrections:
            self._corrections[digest] = MaterialCorrections.of(analysis)
            while len(self._corrections) > KEPT_CORRECTIONS:
                self._corrections.popitem(last=False)
        another = self._on_screen is None or digest != self._on_screen.question.digest
        self._on_screen = OnScreen(opened, question, found)
        angles = _angles(analysis)
        if question in self._own:  # a light that was estimated is one that is given from now on
            self._own.setdefault(replace(question, angles=tuple(angles)), found)
        values = {"sample": opened.sample, "analysis": analysis, "original_light": angles}
        if not another:
            self._show_corrections()
            self.param.update(**values)
            return
        with self._silently():
            self._show_corrections()
            self.param.update(**{**settings, **values, "method": analysis.method, "selected": selected})
        self.corrections.change_look(self.look, again=True)

    async def _work(
        self, step: str, task: Callable[[TaskReport], Result], *, waits: bool = False
    ) -> Result | None:
        """Run a task in a thread: see `LatestTask.run`. One that waits for its turn does so in a thread for that."""
        threads = TURNS.threads if waits else None
        return await self._task.run(step, task, threads=threads, give_up=self._restore)

    def _restore(self) -> None:
        """Take back wishes that were not fulfilled."""
        if self._on_screen is not None:
            with self._silently():
                self.param.update(method=self.analysis.method, original_light=_angles(self.analysis))
            question = self.on_screen.question
            self.corrections.restore(question.version, question.shape)
            self.corrections.change_look(self.look, again=True)
            self._show_corrections()


def _angles(analysis: ToonAnalysis) -> list[float]:
    """Azimuth and elevation of the light of an analysis, rounded to what a slider can tell apart."""
    return [round(angle, 3) for angle in toonkit.light_angles(analysis.light)]

"""The tab of linked views: what was found at each step, under one crosshair, beside another method's results."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import panel as pn
import panel_material_ui as pmui
import param

from toonkit.analysis import ToonAnalysis
from toonkit.methods import METHODS
from toonkit.model.light import light_angles, light_direction
from toonkit.viz.page_style import WIDE, note
from toonkit.viz.relight_page.analyses import SAMPLES, Evidence, Kept, answer
from toonkit.viz.relight_page.busy_line import BusyLine
from toonkit.viz.relight_page.linked_pictures import ZOOM_STEP, LinkedPictures
from toonkit.viz.relight_page.settings import METHOD_DESCRIPTIONS, SETTINGS
from toonkit.viz.relight_page.state import RelightState
from toonkit.viz.relight_page.view_pictures import (
    Picture,
    PixelReading,
    pictures_of_drawing,
    pictures_of_method,
    read_pixel,
    relit_picture,
)
from toonkit.viz.turns import Progress

VIEWS_NOTE = (
    "Every step from the drawing to the relit picture. Drag to pan, zoom with Ctrl and the wheel or a pinch, double-click "
    "to fit: all pictures follow. Each curve joins pixels of equal illumination."
)
READ_NOTE = "Point at a picture, or enter a column and a row, to read a pixel."

REST_SECONDS = 0.15
"""Seconds without a move after which the light counts as resting."""

KEPT_COMPARISONS = 2
"""Number of analyses by other methods that are kept for a visitor's own drawings."""

RELIT, OTHERS = "relit", "other "
"""Name of the relit picture, and the prefix of the names of another method's pictures."""

ORDER = ["drawing", "base", "regions", "initial", "relit", "normals", "refined"]
COMPARED = [
    "drawing",
    "regions",
    "initial",
    "base",
    RELIT,
    OTHERS + RELIT,
    "normals",
    OTHERS + "normals",
    "refined",
    OTHERS + "refined",
]
"""The pictures in the order shown, without and with another method."""

READING_STYLE = """
.reading { font-size: 13px; line-height: 1.6; font-variant-numeric: tabular-nums;
  color: var(--panel-on-surface-color); }
.reading i { display: inline-block; width: 13px; height: 13px; border-radius: 3px; vertical-align: -2px; margin-right: 5px;
  box-shadow: 0 0 0 1px color-mix(in srgb, var(--panel-on-surface-color) 35%, transparent); }
.reading span { display: inline-block; margin-right: 18px; }
.reading b { font-weight: 600; }
"""


class LinkedViews(pn.viewable.Viewer):
    """
    The linked views of the drawing on screen.

    Parameters
    ----------
    state : RelightState
        What is on screen.
    """

    other = param.String("", doc='Name of the method to compare with; "" for none.')
    active = param.Boolean(False, doc="Whether the tab of the views is open; otherwise they are not updated.")

    def __init__(self, state: RelightState, **params: Any) -> None:
        super().__init__(**params)
        self._state, self._busy = state, BusyLine()
        self._kept: Kept = OrderedDict()
        self._shown: ToonAnalysis | None = None
        self._compared: ToonAnalysis | None = None
        self._looks, self._reads = 0, False
        self._pictures: dict[str, Picture] = {}
        self._linked: LinkedPictures | None = None
        waiting = pmui.LinearProgress(variant="indeterminate", margin=(16, 10), **WIDE)
        self._place = pn.Column(note("Making the pictures"), waiting, margin=0, **WIDE)
        self._reading = pn.pane.HTML(
            _reading_html(READ_NOTE, 1), stylesheets=[READING_STYLE], margin=(0, 10), **WIDE
        )
        self._column, self._row = (
            pmui.IntInput(
                label=label,
                value=0,
                start=0,
                format="0",
                size="small",
                width=116,
                margin=(4, 4),
                disabled=True,
            )
            for label in ("Column", "Row")
        )
        self._choice = pmui.Select.from_param(
            self.param.other,
            label="Compare with",
            options=_others(""),
            description=None,
            size="small",
            width=190,
            margin=(4, 4, 4, 10),
        )
        for field in (self._column, self._row):
            field.param.watch(self._go_to, "value")
        state.param.watch(self._note_look, [*SETTINGS, "ramps"])

    def prepare(self, analysis: ToonAnalysis) -> Callable[[], None]:
        """Make the pictures of an analysis, in a thread; return a function that shows them."""
        pictures = {
            **pictures_of_drawing(analysis),
            **pictures_of_method(analysis),
            RELIT: self._relit(analysis),
        }

        def show() -> None:
            self._shown, self._compared, self._pictures = analysis, None, pictures
            if self.other == analysis.method:
                self.other = ""
            self._choice.options = _others(analysis.method)
            self.param.trigger("other")  # shows them, and analyzes with the other method

        return show

    def close(self) -> None:
        """Cancel what is under way, and free everything large: the visitor has left."""
        self._busy.close()
        self._kept.clear()
        self._pictures.clear()
        self._shown = self._compared = None
        if self._linked is not None:
            self._linked.close()

    def __panel__(self) -> pn.viewable.Viewable:
        zooms = [
            pmui.Button(
                label=label, description=tip, size="small", variant="outlined", margin=(4, 2), width=width, height=40,
                sx={"minWidth": "0"},
                on_click=press,
            )
            for label, tip, width, press in (
                ("−", "Show more of the pictures", 44, lambda _: self._zoom(1 / ZOOM_STEP)),
                ("+", "Magnify all pictures", 44, lambda _: self._zoom(ZOOM_STEP)),
                ("Fit", "Fit all pictures", 56, lambda _: self._zoom(0.0)),
            )
        ]  # fmt: skip
        bar = pn.FlexBox(
            self._choice, *zooms, self._column, self._row, align_items="center", gap="4px", **WIDE
        )
        return pn.Column(
            note(VIEWS_NOTE),
            bar,
            pn.Column(self._busy, margin=(0, 10), **WIDE),
            self._reading,
            self._place,
            **WIDE,
        )

    def _zoom(self, factor: float) -> None:
        """Magnify all pictures, or fit them for 0."""
        if self._linked is not None and factor:
            self._linked.zoom(factor)
        elif self._linked is not None:
            self._linked.fit()

    async def _put(self) -> None:
        """Show the pictures made so far; a drawing of another size gets another grid."""
        if self._shown is None:
            return
        shape = self._shown.image.shape
        if self._linked is None or self._linked.shape != shape:
            self._linked = LinkedPictures(shape)
            self._linked.param.watch(lambda event: self._read(event.new), "pixel")
            self._column.param.update(end=shape[1] - 1, disabled=False)
            self._row.param.update(end=shape[0] - 1, disabled=False)
            self._place[:] = [self._linked]
        order = ORDER if self._compared is None else COMPARED
        await self._linked.show({name: self._pictures[name] for name in order}, order)
        if self._linked.pixel is not None:
            self._read(self._linked.pixel)

    @param.depends("other", watch=True)
    async def _compare(self) -> None:
        """Analyze the drawing with the other method, under the same light, and show what it has found."""
        shown, method = self._shown, self.other
        if shown is None:
            return
        self._compared = None
        await self._put()
        if method in ("", shown.method):
            self._busy.cancel()
            return
        on_screen = self._state.on_screen
        angles = tuple(round(angle, 3) for angle in light_angles(shown.light))
        question = replace(on_screen.question, method=method, angles=angles)
        kept = SAMPLES if on_screen.opened.sample and question.version is None else self._kept
        while len(self._kept) >= KEPT_COMPARISONS:
            self._kept.popitem(last=False)
        name = _title(method)

        def work(progress: Progress) -> tuple[ToonAnalysis, dict[str, Picture]]:
            found = answer(question, Evidence(shown.drawing), progress, kept).analysis
            return found, {**pictures_of_method(found, name), RELIT: self._relit(found, name)}

        try:
            result = await self._busy.run(f"analyzing with {name}", work)
        except Exception:
            self.other = ""
            raise
        if result is None:
            if self._shown is shown and self.other == method:
                self.other = ""  # canceled
        elif self._shown is shown and self.other == method:
            self._compared, found = result
            self._pictures.update({OTHERS + part: picture for part, picture in found.items()})
            await self._put()

    def _relit(self, analysis: ToonAnalysis, name: str = "") -> Picture:
        """Relight an analysis as the page does, with the edited ramps if it has as many materials as the one on screen."""
        state = self._state
        ramps = state.placed_ramps if state.analysis.materials.count == analysis.materials.count else {}
        return relit_picture(state.relight(analysis.recolored(ramps) if ramps else analysis), name)

    def _note_look(self, *_: object) -> None:
        if self.active:
            self.param.trigger("active")

    @param.depends("active", watch=True)
    async def _relight(self) -> None:
        """Paint the relit pictures again once the light rests."""
        self._looks = looks = self._looks + 1
        await asyncio.sleep(REST_SECONDS)
        shown, compared = self._shown, self._compared
        if looks != self._looks or not self.active or shown is None:
            return

        def paint() -> dict[str, Picture]:
            painted = {RELIT: self._relit(shown)}
            if compared is not None:
                painted[OTHERS + RELIT] = self._relit(compared, _title(compared.method))
            return painted

        painted = await asyncio.to_thread(paint)
        if looks == self._looks and (shown, compared) == (self._shown, self._compared):
            self._pictures.update(painted)
            await self._put()

    def _go_to(self, _: object) -> None:
        if (
            self._linked is not None
            and not self._reads
            and self._linked.pixel != (self._row.value, self._column.value)
        ):
            self._linked.point_at(self._row.value, self._column.value)

    def _read(self, pixel: tuple[int, int]) -> None:
        """Say what is known of a pixel."""
        shown = self._shown
        if shown is None:
            return
        row, column = pixel
        self._reads = True
        self._row.value, self._column.value = row, column
        self._reads = False
        analyses = {_title(found.method): found for found in (shown, self._compared) if found is not None}
        reading = read_pixel(analyses, row, column, light_direction(*self._state.new_light))
        words = "Outside the object." if reading is None else _words(reading)
        self._reading.object = _reading_html(words, len(analyses))


def _others(method: str) -> dict[str, str]:
    """Return the names of the methods to compare with `method`, by title."""
    return {"no other method": "", **{_title(name): name for name in METHODS if name != method}}


def _title(method: str) -> str:
    """Return the title of a method, as the page shows it."""
    return METHOD_DESCRIPTIONS.get(method, (method, ""))[0]


def _words(reading: PixelReading) -> str:
    """Write a reading as HTML: numbers, and names of methods."""
    lines = [
        f'<span><i style="background: {reading.paint}"></i>{reading.paint}</span><span>Material {reading.material}</span>'
    ]
    for name, (x, y, z) in reading.normals.items():
        before, after = reading.illuminations[name]
        lines.append(
            f"<span><b>{name}</b></span><span>Normal ({x:.2f}, {y:.2f}, {z:.2f})</span>"
            f"<span>L · N {before:.2f} as drawn</span><span>{after:.2f} relit</span>"
        )
    return "<br>".join(lines)


def _reading_html(words: str, methods: int) -> str:
    """Return a reading of fixed height: what is below it must not move as the pointer does."""
    room = f"min-height: {1.6 * (1 + methods):.1f}em"
    return f'<div class="reading" role="status" aria-label="Pixel" style="{room}">{words}</div>'

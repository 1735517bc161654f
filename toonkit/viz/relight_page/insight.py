"""The tabs below the pictures: what was recovered, each filled when it is opened."""

from __future__ import annotations

import asyncio
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import panel as pn
import panel_material_ui as pmui

from toonkit.analysis import ToonAnalysis
from toonkit.viz.choice_cards import ChoiceCards
from toonkit.viz.page_style import WIDE, note
from toonkit.viz.relight_page.height_view import HeightView, encode_surface
from toonkit.viz.relight_page.state import RelightState

if TYPE_CHECKING:
    from toonkit.viz.relight_page.views import LinkedViews

PICTURE_FIRST_SECONDS = 0.4
TabMaker = Callable[[ToonAnalysis], Any]

TAB_SIZE = {"height": 380, **WIDE}

NORMAL_MAP_NOTE = (
    "Which way the surface faces: red to the right, green up, blue toward you (OpenGL convention)."
)
SHAPE_NOTE = "The recovered surface with its normals. Drag to turn it, scroll to come closer."


# HoloViews takes seconds to import, and the first picture does not need it: each tab imports its own, once the page
# stands. Not in a thread, where Panel would meet modules that are only half imported.
def _color_map_tab(box: pn.Column, state: RelightState) -> TabMaker:
    from toonkit.viz.relight_page.color_maps import ColorMapsView  # noqa: PLC0415

    def make(shown: ToonAnalysis) -> Callable[[], None]:
        view = ColorMapsView(shown, height=TAB_SIZE["height"], chosen=state.selected_place)

        def show() -> None:
            box[:] = [view]
            view.chosen = state.selected_place or view.chosen  # another may be selected by now
            for cards in box.select(ChoiceCards):
                cards.param.watch(lambda event: state.select_place(int(event.new)), "value")

        return show

    return make


def _normal_map_tab(box: pn.Column, _: RelightState) -> TabMaker:
    from toonkit.viz.elements import normal_map  # noqa: PLC0415

    def make(shown: ToonAnalysis) -> Callable[[], None]:
        rows, columns = shown.normals.shape
        height = TAB_SIZE["height"]
        # As wide as its shape asks for: stretched over the page, pixels would not be square.
        element = normal_map(shown.normals).opts(
            responsive=False, height=height, width=height * columns // rows
        )
        return lambda: _fill(box, NORMAL_MAP_NOTE, pn.pane.HoloViews(element, sizing_mode="fixed"))

    return make


def _shape_tab(box: pn.Column, _: RelightState) -> TabMaker:
    def make(shown: ToonAnalysis) -> Callable[[], None]:
        surface = encode_surface(shown.normals, shown.image)

        def show() -> None:
            # One view for all surfaces: it keeps its graphics context, and the visitor's point of view.
            if not box:
                _fill(box, SHAPE_NOTE, HeightView(**TAB_SIZE))
            box[-1].param.update(**surface)

        return show

    return make


def _fill(box: pn.Column, text: str, pane: pn.viewable.Viewable) -> None:
    box[:] = [note(text), pane]


class ViewsTab:
    """The tab of linked views, which keeps its pictures, and a comparison, from one analysis to the next."""

    def __init__(self) -> None:
        self._views: LinkedViews | None = None

    def __call__(self, box: pn.Column, state: RelightState) -> TabMaker:
        """Return what fills the tab, as of the others."""
        from toonkit.viz.relight_page.views import LinkedViews  # noqa: PLC0415

        if self._views is None:
            self._views = LinkedViews(state, active=True)
            box[:] = [self._views]
        return self._views.prepare

    def look(self, *, active: bool) -> None:
        """Let the views follow the light only while their tab is open."""
        if self._views is not None:
            self._views.active = active

    def close(self) -> None:
        """Free everything large: the visitor has left."""
        if self._views is not None:
            self._views.close()


def insight(state: RelightState, views: ViewsTab) -> pmui.Tabs:
    """Return the tabs that show what was recovered; a tab is filled when it is opened."""
    makers: dict[str, Callable[[pn.Column, RelightState], TabMaker]] = {
        "Color map": _color_map_tab,
        "Views": views,
        "Normal map": _normal_map_tab,
        "Shape in 3-D": _shape_tab,
    }
    boxes = [pn.Column(min_height=TAB_SIZE["height"], **WIDE) for _ in makers]
    tabs = pmui.Tabs(*zip(makers, boxes, strict=True), **WIDE)
    on_screen = pn.rx(False)
    filled: dict[int, weakref.ref[ToonAnalysis]] = {}

    async def show(active: int, shown: ToonAnalysis | None, ready: bool) -> None:
        views.look(active=list(makers)[active] == "Views")
        if shown is None or not ready or (active in filled and filled[active]() is shown):
            return
        filled[active] = weakref.ref(shown)
        await asyncio.sleep(PICTURE_FIRST_SECONDS)
        make = list(makers.values())[active](boxes[active], state)
        put = await asyncio.to_thread(make, shown)
        if filled[active]() is shown:
            put()

    async def follow(selected: int) -> None:
        await asyncio.sleep(PICTURE_FIRST_SECONDS)
        if selected == state.selected and not state.step:
            for cards in boxes[0].select(ChoiceCards):
                cards.value = state.selected_place or cards.value

    def loaded() -> None:
        on_screen.rx.value = True

    pn.bind(show, tabs.param.active, state.param.analysis, on_screen, watch=True)
    pn.bind(follow, state.param.selected, watch=True)
    pn.state.onload(loaded)
    return tabs

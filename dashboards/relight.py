"""Relight a drawing: drop a picture, drag the light. Start it with `panel serve dashboards/relight.py`."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

import panel as pn
import panel_material_ui as pmui
from panel.models.esm import DataEvent

from toonkit import METHODS, ToonAnalysis
from toonkit.samples import sample_names, sample_path, sample_title
from toonkit.viz.choice_cards import ChoiceCards, picture_choices, text_choices
from toonkit.viz.page_style import THEME, WIDE, error_reporter, heading
from toonkit.viz.relight_page.state import METHOD_DESCRIPTIONS, RelightState, prepare_sample
from toonkit.viz.relight_page.view import RelightView

PICTURE_TYPES = ["image/png", "image/jpeg", "image/webp", "image/tiff", ".tif", ".tiff"]
LARGEST_FILE = "60MB"

PICTURE_FIRST_SECONDS = 0.4
TabMaker = Callable[[ToonAnalysis], pn.Column]

TAB_SIZE = {"height": 380, **WIDE}

COLOR_MAP_NOTE = (
    "Each dot is a pixel in its own color, placed by the light it would get if the drawing were just puffed up; dark "
    "outlines and lines are left out, for they stay as drawn. "
    "The curve is the color map of the shape that was recovered, and a bar is the range of light that one color stands for."
)
NORMAL_MAP_NOTE = (
    "Which way the surface faces: red to the right, green up, blue toward you (OpenGL convention)."
)
SHAPE_NOTE = "The recovered surface with its normals. Drag to turn it, scroll to come closer."
DROP_ZONE = """
.filepond--root { min-height: 64px; font-family: inherit; margin: 0; border-radius: 8px; background: transparent !important;
  border: 1.5px dashed color-mix(in srgb, var(--panel-on-surface-color) 35%, transparent) !important; }
.filepond--panel-root { background: transparent !important; border: none !important; }
.filepond--drop-label { min-height: 64px; color: inherit; }
.filepond--drop-label label { font-size: 13px; }
.filepond--list-scroller { mask: none !important; -webkit-mask: none !important; }
.filepond--credits { display: none; }
"""


def stage(state: RelightState) -> RelightView:
    """Return both pictures with their lights, in step with the state."""
    view = RelightView(
        new_light=state.new_light,
        original_light=state.original_light,
        step=state.param.step,
        fraction=state.param.fraction,
        keep_detail=state.param.keep_detail,
        min_height=400,
    )
    view.link(state, bidirectional=True, new_light="new_light", original_light="original_light")

    async def asked(message: DataEvent) -> None:
        if message.data["action"] == "estimate":
            await state.estimate_light()
        else:
            state.cancel()

    view.on_msg(asked)
    state.param.watch(lambda event: view.show(event.new), "analysis")
    return view


def drawing_picker(state: RelightState) -> pn.Column:
    """Return the thumbnails of the samples and the place to drop a picture."""
    cards = ChoiceCards(
        choices=picture_choices({name: (sample_title(name), sample_path(name)) for name in sample_names()}),
        value=state.param.sample,
        columns=3,
        label="Sample drawing",
        margin=(2, 12, 8, 12),
        **WIDE,
    )
    dropper = pn.widgets.FileDropper(
        accepted_filetypes=PICTURE_TYPES,
        max_file_size=LARGEST_FILE,
        multiple=False,
        previews=[],
        height=104,
        margin=(0, 12),
        stylesheets=[DROP_ZONE],
        **WIDE,
    )

    async def choose(name: str) -> None:
        if name and name != state.sample:
            try:
                await state.open_sample(name)
            finally:
                cards.value = state.sample

    async def dropped(files: dict[str, bytes]) -> None:
        # The widget changes this dictionary when the next file is dropped, which may be before this one is analyzed.
        for content in tuple(files.values()):
            await state.open_file(content)

    pn.bind(choose, cards, watch=True)
    pn.bind(dropped, dropper, watch=True)
    return pn.Column(heading("Drawing"), cards, dropper, **WIDE)


def method_picker(state: RelightState) -> pn.Column:
    """Return one card for each method, and the switch for brushwork."""
    described = {name: METHOD_DESCRIPTIONS.get(name, (name, "")) for name in METHODS}
    cards = ChoiceCards(
        choices=text_choices(described), value=state.method, label="Method", margin=(2, 12, 6, 12), **WIDE
    )
    cards.link(state, bidirectional=True, value="method")
    brushwork = pmui.Switch.from_param(state.param.keep_detail, label="Keep brushwork", margin=(4, 12))

    async def changed(_: str) -> None:
        await state.analyze()

    pn.bind(changed, state.param.method, watch=True)
    pn.bind(changed, state.param.original_light, watch=True)
    return pn.Column(heading("Method"), cards, brushwork, **WIDE)


def downloads(state: RelightState) -> pn.Column:
    """Return the two download buttons."""
    buttons = [
        pmui.FileDownload(
            callback=make,
            filename=filename,
            label=label,
            variant="outlined",
            margin=(4, 12),
            **WIDE,
            disabled=state.param.analysis.rx.is_(None),
        )
        for label, filename, make in (
            ("Relit picture", "relit.png", state.relit_png),
            ("Normal map", "normal_map.png", state.normal_map_png),
        )
    ]
    return pn.Column(heading("Download"), *buttons, **WIDE)


# HoloViews and PyVista take seconds to import, and the first picture needs neither: each tab imports its own, once
# the page stands. Not in a thread, where Panel would meet modules that are only half imported.
def color_map_tab() -> TabMaker:
    from toonkit.viz.elements import color_map_fit  # noqa: PLC0415

    return lambda shown: tab_content(COLOR_MAP_NOTE, pn.pane.HoloViews(color_map_fit(shown), **TAB_SIZE))


def normal_map_tab() -> TabMaker:
    from toonkit.viz.elements import normal_map  # noqa: PLC0415

    def make(shown: ToonAnalysis) -> pn.Column:
        rows, columns = shown.normals.shape
        height = TAB_SIZE["height"]
        # As wide as its shape asks for: stretched over the page, pixels would not be square.
        element = normal_map(shown.normals).opts(
            responsive=False, height=height, width=height * columns // rows
        )
        return tab_content(NORMAL_MAP_NOTE, pn.pane.HoloViews(element, sizing_mode="fixed"))

    return make


def shape_tab() -> TabMaker:
    from toonkit.viz.relight_page.height_pane import HeightPane  # noqa: PLC0415
    from toonkit.viz.scene import height_scene  # noqa: PLC0415

    def make(shown: ToonAnalysis) -> pn.Column:
        plotter = height_scene(shown.normals, shown.image).plotter()
        return tab_content(SHAPE_NOTE, HeightPane(plotter.render_window, **TAB_SIZE))

    return make


TABS = {"Color map": color_map_tab, "Normal map": normal_map_tab, "Shape in 3-D": shape_tab}


def insight(state: RelightState) -> pmui.Tabs:
    """Return the tabs that show what was recovered; a tab is filled when it is opened."""
    boxes = [pn.Column(min_height=TAB_SIZE["height"], **WIDE) for _ in TABS]
    tabs = pmui.Tabs(*zip(TABS, boxes, strict=True), **WIDE)
    on_screen = pn.rx(False)
    filled: dict[int, ToonAnalysis] = {}

    async def fill(active: int, shown: ToonAnalysis | None, ready: bool) -> None:
        if shown is None or not ready or filled.get(active) is shown:
            return
        filled[active] = shown
        await asyncio.sleep(PICTURE_FIRST_SECONDS)
        make = list(TABS.values())[active]()
        content = await asyncio.to_thread(make, shown)
        if filled[active] is shown:
            boxes[active][:] = [content]

    def loaded() -> None:
        on_screen.rx.value = True

    pn.bind(fill, tabs.param.active, state.param.analysis, on_screen, watch=True)
    pn.state.onload(loaded)
    return tabs


def tab_content(text: str, pane: pn.viewable.Viewable) -> pn.Column:
    return pn.Column(note(text), pane, **WIDE)


def note(text: str) -> pmui.Typography:
    return pmui.Typography(text, variant="body2", color="text.secondary", margin=(8, 10, 4, 10))


def relight_page() -> pmui.Page:
    """Return the page for one visitor, with the first sample on its way."""
    state = RelightState()
    page = pmui.Page(
        title="toonkit · relight a drawing",
        main=[pn.Column(stage(state), insight(state), margin=16, **WIDE)],
        sidebar=[drawing_picker(state), method_picker(state), downloads(state)],
        sidebar_width=300,
        sidebar_resizable=False,
        theme="dark",
        theme_config=THEME,
    )

    async def first_picture() -> None:
        await state.open_sample(sample_names()[0])

    pn.state.onload(first_picture)
    return page


def start_with(name: str) -> threading.Thread:
    """Analyze the first picture while the first visitor's browser still loads the page."""
    thread = threading.Thread(target=prepare_sample, args=(name,), daemon=True)
    thread.start()
    return thread


pn.extension("vtk", "filedropper", notifications=True, exception_handler=error_reporter("relight page"))

if pn.state.served:
    pn.state.as_cached("first sample", start_with, name=sample_names()[0])
    relight_page().servable()

"""The relight page: drop a picture, drag the light."""

from __future__ import annotations

import threading
from collections.abc import Awaitable, Callable
from dataclasses import astuple
from functools import partial

import panel as pn
import panel_material_ui as pmui
from panel.models.esm import DataEvent

from toonkit.analysis import ToonAnalysis
from toonkit.methods import METHODS
from toonkit.samples import sample_names
from toonkit.viz.choice_cards import ChoiceCards, text_choices
from toonkit.viz.copy_buttons import CopyButtons
from toonkit.viz.page_style import THEME, WIDE, after_updates, error_reporter, heading
from toonkit.viz.relight_page.analyses import prepare_sample
from toonkit.viz.relight_page.animation import animation_download
from toonkit.viz.relight_page.busy_line import BusyLine
from toonkit.viz.relight_page.downloads import analysis_file, normal_map_png, relit_png, session_file
from toonkit.viz.relight_page.drawing_picker import drawing_picker, tell_light
from toonkit.viz.relight_page.insight import ViewsTab, insight
from toonkit.viz.relight_page.settings import METHOD_DESCRIPTIONS, PATH_SETTINGS
from toonkit.viz.relight_page.snippets import command_snippet, python_snippet
from toonkit.viz.relight_page.state import RelightState
from toonkit.viz.relight_page.upload import FileDropper
from toonkit.viz.relight_page.view import RelightView
from toonkit.viz.session_end import free_when_left

AS_HIGH_AS_NEEDED = {"max-height": "none"}
"""Style of what would be cut to the height of a narrow window, where the pictures stand one below the other."""


def stage(state: RelightState) -> RelightView:
    """Return both pictures with their lights, in step with the state."""
    view = RelightView(
        new_light=state.new_light,
        original_light=state.original_light,
        step=state.param.step,
        fraction=state.param.fraction,
        keep_detail=state.param.keep_detail,
        flat_shading=state.param.flat_shading,
        light_color=state.param.light_color,
        ambient=state.param.ambient,
        can_undo=state.param.can_undo,
        can_redo=state.param.can_redo,
        corrected=state.param.corrected,
        settled=state.param.settled,
        styles=AS_HIGH_AS_NEEDED,
    )
    linked = ("new_light", "original_light", "selected", *PATH_SETTINGS)
    view.link(state, bidirectional=True, **{name: name for name in linked})
    view.on_msg(_answer(state))

    async def arrive(step: str, *_: object) -> None:
        if not step:
            await after_updates(lambda: view.param.update(idle=view.idle + (not state.step)))

    told = (state.param[name] for name in ("step", "settled", "can_undo", "can_redo"))
    pn.bind(arrive, *told, watch=True)
    state.param.watch(lambda event: view.show(event.new, state.codes, state.shape_marks), "analysis")
    state.param.watch(lambda event: view.recolor(event.new), "ramps")
    return view


def _answer(state: RelightState) -> Callable[[DataEvent], Awaitable[None]]:
    """Return what does what the view's user asks for."""

    async def estimate() -> None:
        await state.estimate_light()
        tell_light(state.analysis)

    async def cancel() -> None:
        state.cancel()

    actions: dict[str, Callable[..., Awaitable[None]]] = {
        "estimate": estimate,
        "cancel": cancel,
        "merge": state.merge,
        "paint": state.paint,
        "fill": state.fill,
        "split": state.split,
        "recolor": state.recolor,
        "undo": state.undo,
        "redo": state.redo,
        "reset": state.reset_materials,
        "shape_paint": state.shape_paint,
        "shape_fill": state.shape_fill,
        "shape_tilt": state.shape_tilt,
        "shape_reset": state.shape_reset,
    }

    async def asked(message: DataEvent) -> None:
        details = dict(message.data)
        await actions[details.pop("action")](**details)

    return asked


def method_picker(state: RelightState) -> pn.Column:
    """Return one card for each method, the switch for brushwork, and the slider for what is painted in one tone."""
    described = {name: METHOD_DESCRIPTIONS.get(name, (name, "")) for name in METHODS}
    cards = ChoiceCards(
        choices=text_choices(described), value=state.method, label="Method", margin=(2, 12, 6, 12), **WIDE
    )
    cards.link(state, bidirectional=True, value="method")
    brushwork = pmui.Switch.from_param(state.param.keep_detail, label="Keep brushwork", margin=(4, 12))
    flat = pmui.FloatSlider.from_param(
        state.param.flat_shading,
        label="Flat shading",
        step=0.05,
        visible=pn.bind(_has_flat_materials, state.param.analysis),
        margin=(4, 20, 4, 16),
        **WIDE,
    )

    async def changed(_: str) -> None:
        await state.analyze()

    pn.bind(changed, state.param.method, watch=True)
    pn.bind(changed, state.param.original_light, watch=True)
    return pn.Column(heading("Method"), cards, brushwork, flat, **WIDE)


def light_controls(state: RelightState) -> pn.Column:
    """Return the color of the new light, and the slider for light from all sides."""
    color = pmui.ColorPicker.from_param(state.param.light_color, label="Color", margin=(4, 12), **WIDE)
    ambient = pmui.FloatSlider.from_param(
        state.param.ambient, label="Ambient light", step=0.05, margin=(4, 20, 4, 16), **WIDE
    )
    return pn.Column(heading("New light"), color, ambient, **WIDE)


def _has_flat_materials(analysis: ToonAnalysis | None) -> bool:
    return analysis is not None and bool(analysis.materials.flat.any())


def downloads(state: RelightState, busy: BusyLine) -> pn.Column:
    """Return the download buttons, the slow ones as tasks of `busy`, and those that copy how the picture is made."""
    none = state.param.analysis.rx.is_(None)

    def session_name(shown: ToonAnalysis | None) -> str:
        return "session.toonkit" if shown is None else state.on_screen.opened.session_name

    files = (
        ("Relit picture", "relit.png", relit_png),
        ("Normal map", "normal_map.png", normal_map_png),
        ("Whole analysis", "analysis.npz", analysis_file),
        ("Save session", pn.bind(session_name, state.param.analysis), session_file),
    )
    buttons = [
        pmui.FileDownload(
            callback=partial(make, state),
            filename=filename,
            label=label,
            variant="outlined",
            margin=(4, 12),
            **WIDE,
            disabled=none,
        )
        for label, filename, make in files
    ]
    copy = CopyButtons(
        {
            "Copy as Python": lambda: astuple(python_snippet(state)),
            "Copy as command line": lambda: astuple(command_snippet(state)),
        },
        disabled=none,
        margin=(4, 12, 16, 12),
        **WIDE,
    )
    buttons.insert(1, animation_download(state, busy))
    return pn.Column(heading("Download"), *buttons, heading("Do it again in code"), copy, **WIDE)


def relight_page() -> pmui.Page:
    """Return the page for one visitor, with the first sample on its way."""
    state = RelightState()
    view, picker, views, painting = stage(state), drawing_picker(state), ViewsTab(), BusyLine()
    page = pmui.Page(
        title="toonkit · relight a drawing",
        main=[pn.Column(view, insight(state, views), margin=16, styles=AS_HIGH_AS_NEEDED, **WIDE)],
        sidebar=[picker, method_picker(state), light_controls(state), downloads(state, painting)],
        sidebar_width=300,
        sidebar_resizable=False,
        theme="dark",
        theme_config=THEME,
    )
    # In the browser alone: a drawer that closes once the server has answered would be seen to. Panel keeps the arguments of
    # a `jscallback` for ever, unlike the target of a link.
    view.jslink(page, code={"narrow": "target.data.sidebar_open = !cb_obj.narrow"})

    async def first_picture() -> None:
        await state.open_sample(sample_names()[0])

    pn.state.onload(first_picture)
    droppers = picker.select(FileDropper)
    free_when_left(
        page, state.close, view.close, views.close, painting.close, *(dropper.close for dropper in droppers)
    )
    return page


def start_with(name: str) -> threading.Thread:
    """Analyze the first picture while the first visitor's browser still loads the page."""
    thread = threading.Thread(target=prepare_sample, args=(name,), daemon=True)
    thread.start()
    return thread


def relight_app() -> pmui.Page:
    """Set up the session of one visitor, and return their page."""
    pn.extension("filedropper", notifications=True, exception_handler=error_reporter("relight page"))
    pn.state.as_cached("first sample", start_with, name=sample_names()[0])
    return relight_page()

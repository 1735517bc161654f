"""Which drawing is on screen: samples to choose from, a place to drop files, and the files dropped so far."""

from __future__ import annotations

import panel as pn

from toonkit._validation import ToonkitError
from toonkit.analysis import ToonAnalysis
from toonkit.model.light import describe_light
from toonkit.samples import sample_names, sample_path, sample_title
from toonkit.viz.choice_cards import ChoiceCards, picture_choices, text_choices
from toonkit.viz.page_style import WIDE, heading, note, tell_remarks
from toonkit.viz.relight_page.opening import MOST_FILE_BYTES
from toonkit.viz.relight_page.state import RelightState
from toonkit.viz.relight_page.upload import FileDropper

LIGHT_NOTE_MILLISECONDS = 8000

FILES_NOTE = (
    "PNG, JPEG, WebP, TIFF, GIF, BMP; PSD, ORA or KRA with their layers; or a saved session or analysis. "
    f"Up to {MOST_FILE_BYTES // 10**6} MB."
)

DROP_ZONE = """
.filepond--root { min-height: 64px; font-family: inherit; margin: 0; border-radius: 8px; background: transparent !important;
  border: 1.5px dashed color-mix(in srgb, var(--panel-on-surface-color) 35%, transparent) !important; }
.filepond--panel-root { background: transparent !important; border: none !important; }
.filepond--drop-label { min-height: 64px; color: inherit; background: transparent !important; }
.filepond--drop-label label { font-size: 13px; }
.filepond--list-scroller { mask: none !important; -webkit-mask: none !important; }
.filepond--credits { display: none; }
.filepond--item[data-filepond-item-state="processing-complete"] { visibility: hidden; }
"""


def tell_light(analysis: ToonAnalysis | None) -> None:
    """Tell the user where an estimated light stands and how sure that is, or that it is only assumed."""
    estimate = None if analysis is None else analysis.light_estimate
    if estimate is None or pn.state.notifications is None:
        return
    if estimate.is_guess:
        text = "This drawing does not say where its light is. Upper left is assumed: drag the sun on it if you know better."
    else:
        sure = f"{100 * estimate.confidence:.0f} % sure"
        text = f"Estimated light: {describe_light(estimate.light)}, {sure}. Drag the sun on the drawing to correct it."
    pn.state.notifications.info(text, duration=LIGHT_NOTE_MILLISECONDS)


def drawing_picker(state: RelightState) -> pn.Column:
    """Return the thumbnails of the samples and the place to drop a picture."""
    cards = ChoiceCards(
        choices=picture_choices({name: (sample_title(name), sample_path(name)) for name in sample_names()}),
        value=state.sample,
        columns=3,
        label="Sample drawing",
        margin=(2, 12, 8, 12),
        **WIDE,
    )
    dropper = FileDropper(
        previews=[],
        height=124,
        margin=(0, 12),
        stylesheets=[DROP_ZONE],
        **WIDE,
    )

    async def choose(name: str) -> None:
        if name == state.sample:
            state.cancel()  # back on the card of what is on screen, while another drawing is being opened
        elif name:
            try:
                await state.open_sample(name)
            finally:
                if cards.value == name:  # not when another card was chosen meanwhile
                    cards.value = state.sample

    async def show(name: str, content: bytes, *, again: bool) -> None:
        shown = state.analysis
        remarks = await state.open_file(name, content, again=again)
        if state.analysis is not shown:  # as it is if this was canceled, or overtaken by another drawing
            tell_remarks(remarks)
            tell_light(state.analysis)

    async def arrived(file: tuple[str, bytes]) -> None:
        try:
            await show(*file, again=False)
        except ToonkitError:
            dropper.let_go(file[0])  # of what cannot be shown
            raise

    def on_screen() -> str:
        return "" if state.analysis is None else state.on_screen.opened.file_name

    async def go_back(name: str) -> None:
        if name in dropper.value and name != on_screen():
            try:
                await show(name, dropper.value[name], again=True)
            finally:
                list_own()

    own = ChoiceCards(label="Your files", margin=(2, 12, 8, 12), visible=False, **WIDE)

    def list_own(*_: object) -> None:
        names = list(dropper.value)
        own.param.update(
            choices=text_choices({name: (name, "") for name in names}),
            value=on_screen() if on_screen() in names else "",
            visible=len(names) > 1,
        )

    state.param.watch(lambda event: cards.param.update(value=event.new), "sample")
    pn.bind(choose, cards.param.value, watch=True)
    pn.bind(list_own, dropper.param.value, state.param.analysis, watch=True)
    pn.bind(arrived, dropper.param.arrived, watch=True)
    pn.bind(go_back, own.param.value, watch=True)
    accepted = note(FILES_NOTE, margin=(6, 12, 8, 12), sx={"fontSize": "12px"})
    return pn.Column(heading("Drawing"), cards, dropper, accepted, own, **WIDE)

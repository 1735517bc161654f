"""The study page: a heat map of any measure, and every trial behind it."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

import panel as pn
import panel_material_ui as pmui
import param

from toonkit._validation import ToonkitError
from toonkit.study.table import load_trials, settings_of
from toonkit.viz.choice_cards import ChoiceCards, text_choices
from toonkit.viz.figures.study_style import format_name
from toonkit.viz.page_style import THEME, WIDE, after_updates, error_reporter, heading, plain
from toonkit.viz.session_end import free_when_left
from toonkit.viz.study_page.elements import live_heat_map
from toonkit.viz.study_page.examination import Examination
from toonkit.viz.study_page.sheet import SHEET_STYLE, sheet_note, trial_sheet
from toonkit.viz.study_page.state import StudyState

LINE = "1px solid color-mix(in srgb, var(--panel-on-surface-color) 16%, transparent)"
FRAME = {"border": LINE, "border-radius": "10px"}


def heat_map_card(state: StudyState) -> pn.Column:
    """Return the heat map; a click on a cell selects its trial."""
    shown = [state.param[name] for name in ("measure", "method", "versus", "light_track")]
    title = pn.bind(lambda *_: plain(state.matrix().title), *shown)
    summary = pn.bind(lambda *_: plain(state.matrix().summary), *shown)
    chart = pn.pane.HoloViews(live_heat_map(state), margin=(0, 8), **WIDE)
    return card(title, summary, chart)


def trial_card(state: StudyState) -> pn.Column:
    """Return the pictures of the selected trial, for all methods side by side."""
    kept = state.examination
    content = trial_sheet(kept, state.records(kept), measure=state.measure) if kept is not None else ""
    sheet = pn.pane.HTML(content, stylesheets=[SHEET_STYLE], min_height=400, margin=0, **WIDE)
    progress = pmui.LinearProgress(
        value=state.param.fraction.rx() * 100,
        variant="determinate",
        margin=0,
        visible=state.param.step.rx.bool(),
        **WIDE,
    )

    async def fill(examination: Examination | None, measure: str) -> None:
        if examination is not None:
            records = state.records(examination)
            content = await asyncio.to_thread(trial_sheet, examination, records, measure=measure)
            if state.examination is examination:
                sheet.object = content
                await after_updates(lambda: sheet.param.update(tags=[time.monotonic()]))

    async def examine(*_: object) -> None:
        await state.examine()

    pn.bind(fill, state.param.examination, state.param.measure, watch=True)
    pn.bind(examine, state.param.shape, state.param.color_map, state.param.light_track, watch=True)
    title = pn.bind(
        lambda shape, color_map: plain(f"{format_name(shape).capitalize()} in {format_name(color_map)}"),
        state.param.shape,
        state.param.color_map,
    )
    hint = pn.bind(
        lambda found, step: (
            plain(f"{step} …") if step else sheet_note(found, state.settings.size) if found else ""
        ),
        state.param.examination,
        state.param.step,
    )
    return card(title, hint, progress, sheet)


def card(title: object, hint: object, *content: pn.viewable.Viewable) -> pn.Column:
    """Return a framed part of the page: a title, a line about it, and what it holds."""
    head = pn.FlexBox(
        pmui.Typography(
            title, margin=(10, 10, 8, 16), sx={"fontSize": "16px", "fontWeight": 600, "whiteSpace": "nowrap"}
        ),
        pmui.Typography(
            hint, margin=(12, 8, 8, 0), sx={"fontSize": "13px", "opacity": 0.65}, sizing_mode="stretch_width"
        ),
        flex_wrap="nowrap",
        align_items="center",
        styles={"border-bottom": LINE, "padding-right": "12px"},
        **WIDE,
    )
    return pn.Column(head, *content, styles=FRAME, margin=(0, 0, 16, 0), **WIDE)


def method_picker(state: StudyState) -> ChoiceCards:
    """Return one card for each method, with its mean of the measure."""
    cards = ChoiceCards(value=state.method, label="Method", margin=(2, 12, 6, 12), **WIDE)
    cards.link(state, bidirectional=True, value="method")

    def describe(*_: object) -> None:
        means = state.means().items()
        cards.choices = text_choices({name: (format_name(name), mean) for name, mean in means})

    pn.bind(describe, state.param.measure, state.param.light_track, watch=True)
    describe()
    return cards


def trial_picker(state: StudyState) -> pn.Column:
    """Return the selected trial by name, and buttons that select a telling one."""
    buttons = []
    for label, find in (("Best", state.best), ("Typical", state.typical), ("Worst", state.worst)):
        button = pmui.Button(label=label, variant="outlined", size="small", margin=0, **WIDE)
        button.on_click(lambda _, find=find: state.select(*find()))
        buttons.append(button)
    row = pn.FlexBox(*buttons, flex_wrap="nowrap", gap="8px", margin=(4, 12, 6, 12), **WIDE)
    names = [_select(state.param.shape, "Shape"), _select(state.param.color_map, "Color map")]
    return pn.Column(heading("Trial"), *names, row, **WIDE)


def sidebar(state: StudyState) -> list[pn.viewable.Viewable]:
    """Return what can be chosen: a measure, a method, another one, a trial, and the light track if there are two."""
    parts = [heading("Heat map"), _select(state.param.measure, "Measure"), method_picker(state)]
    parts.append(_select(state.param.versus, "Compared with"))
    if len(state.param.light_track.objects) > 1:
        parts.append(_select(state.param.light_track, "Light"))
    return [*parts, trial_picker(state), heading("Study"), _note(state.about)]


def _select(parameter: param.Parameter, label: str) -> pmui.Select:
    return pmui.Select.from_param(
        parameter, label=label, description=None, size="small", margin=(8, 12), **WIDE
    )


def _note(text: str) -> pmui.Typography:
    return pmui.Typography(text, margin=(2, 12, 12, 12), sx={"fontSize": "13px", "opacity": 0.65})


def study_page(folder: Path) -> pmui.Page:
    """Return the page for one visitor, with a typical trial on its way; without a study, what to run."""
    try:
        state = StudyState(load_trials(folder), settings_of(folder))
    except ToonkitError as error:
        return _page([_no_study(folder, error)], [])
    pn.state.onload(state.examine)
    shown = _page([heat_map_card(state), trial_card(state)], sidebar(state))
    free_when_left(shown, state.close)
    return shown


def _no_study(folder: Path, error: ToonkitError) -> pmui.Alert:
    return pmui.Alert(
        f"**There is no study to show in `{folder}`.** Run one and show it:\n\n"
        "```\ntoonkit study run -o study/\ntoonkit dashboard study study/\n```\n\n"
        f"What is wrong: {plain(str(error))}",
        severity="info",
        **WIDE,
    )


def _page(main: list[pn.viewable.Viewable], choices: list[pn.viewable.Viewable]) -> pmui.Page:
    return pmui.Page(
        title="toonkit · look into the study",
        # Panel caps a column at the height of the window, and frames would end there.
        main=[pn.Column(*main, margin=16, styles={"max-height": "none"}, **WIDE)],
        sidebar=choices,
        sidebar_width=300,
        sidebar_resizable=False,
        theme="dark",
        theme_config=THEME,
    )


def study_app(folder: Path) -> pmui.Page:
    """Set up the session of one visitor, and return their page."""
    pn.extension(notifications=True, exception_handler=error_reporter("study page"))
    return study_page(folder)

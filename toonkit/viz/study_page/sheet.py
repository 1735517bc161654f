"""An examination as a page of pictures: one column for the truth and one for each method (HTML, no script)."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from html import escape
from io import BytesIO

import numpy as np
from bokeh.palettes import Inferno256
from PIL import Image

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.light import light_direction
from toonkit.study.measures import MEASURES, Measure
from toonkit.study.painting import Angles
from toonkit.viz.elements import NEUTRAL
from toonkit.viz.figures.study_style import format_name
from toonkit.viz.study_page.examination import Answer, Examination, Pixels
from toonkit.viz.study_page.matrix import REFERENCE

ANGLE_LIMIT = 45.0
"""Degrees at the end of the error maps' scale: one for all trials, so that they can be compared."""

LISTED = (
    "angular_error",
    "illumination_error",
    "color_map_rmse",
    "input_rmse",
    "relight_rmse",
    "relight_response",
    "seconds",
)
"""Measures below the pictures."""

KEPT_COLUMNS = 64
STRIP_SAMPLES = 256

SHEET_STYLE = f"""
.sheet {{ --ink: var(--panel-on-surface-color, #1c1c1e); --accent: var(--panel-primary-color, #d9772b);
  --quiet: color-mix(in srgb, var(--ink) 65%, transparent); --line: color-mix(in srgb, var(--ink) 12%, transparent);
  color: var(--ink); font-size: 13px; line-height: 1.35; display: grid; gap: 8px 10px; align-items: center;
  padding: 0 16px 16px; }}
.sheet > .label {{ color: var(--quiet); font-size: 12px; }}
.sheet > .label b {{ color: var(--ink); font-size: 13px; font-weight: 600; display: block; }}
.sheet > .name {{ position: sticky; top: var(--sheet-top, 0px); z-index: 1; padding: 8px 0 6px; align-self: stretch;
  background: var(--panel-background-color, transparent); }}
.sheet > .name b {{ font-weight: 600; font-size: 14px; display: block; }}
.sheet > .name span {{ color: var(--quiet); font-size: 12px; font-variant-numeric: tabular-nums; }}
.sheet .tile {{ background: {NEUTRAL}; border-radius: 6px; overflow: hidden; display: flex; align-items: center;
  justify-content: center; aspect-ratio: var(--shape); }}
.sheet .tile img {{ width: 94%; height: 94%; object-fit: contain; display: block; }}
.sheet .tile.empty {{ background: color-mix(in srgb, var(--ink) 5%, transparent); }}
.sheet .tile.failed {{ background: none; border: 1px dashed var(--quiet); box-sizing: border-box; font-size: 12px;
  padding: 8px; overflow: auto; overflow-wrap: anywhere; align-items: flex-start; }}
.sheet .scale {{ font-size: 12px; color: var(--quiet); align-self: center; }}
.sheet .scale i {{ display: block; height: 10px; border-radius: 3px; margin: 6px 0 3px;
  background: linear-gradient(to right, {", ".join(Inferno256[::15])}); }}
.sheet .scale div {{ display: flex; justify-content: space-between; font-variant-numeric: tabular-nums; }}
.sheet .strips {{ border-radius: 4px; overflow: hidden; display: grid; gap: 1px; }}
.sheet .strips img {{ display: block; width: 100%; height: 15px; }}
.sheet .strips.true img {{ height: 31px; }}
.sheet .light {{ display: flex; gap: 8px; align-items: center; }}
.sheet .light svg {{ width: 34px; flex: none; }}
.sheet .number {{ font-variant-numeric: tabular-nums; }}
.sheet .number.best {{ color: var(--accent); font-weight: 600; }}
.sheet .number.ideal {{ color: var(--quiet); }}
.sheet .rule {{ grid-column: 1 / -1; border-top: 1px solid var(--line); margin: 4px 0 0; }}
.sheet-message {{ padding: 20px 16px; font-size: 14px; }}
"""
"""For `stylesheets` of the pane that shows a sheet."""

Record = Mapping[str, object]


def trial_sheet(examination: Examination, records: Mapping[str, Record], *, measure: str) -> str:
    """
    Show what every method made of one picture, beside the truth, as HTML to be styled by `SHEET_STYLE`.

    Rows are pictures, normal maps, angles between normals in one scale, color maps over illumination -1 to 1, relit
    pictures, and the table's numbers with the best of each set off. The measure stands below each method's name.
    """
    numbers = _numbers(records, measure)
    if examination.unavailable:
        message = f'<div class="sheet-message">{escape(examination.unavailable)} Its numbers are those of the study.</div>'
        return message + _grid(_names(examination, records, measure) + numbers, examination, 1.0)
    answers = {answer.name: answer for answer in examination.answers}
    order = ["truth", *examination.methods]
    frame = _frame(answers["truth"])
    columns = {name: _column(answer, frame) for name, answer in answers.items() if not answer.failure}

    def row(label: str, tile: Callable[[_Column], str]) -> str:
        cells = [tile(columns[name]) if name in columns else _EMPTY for name in order]
        return _label(label) + "".join(cells)

    pictures = "".join(
        _failure(answers[name]) if name in answers and answers[name].failure
        else _tile(columns[name].picture, f"{format_name(name)}: picture") if name in columns else _EMPTY
        for name in order
    )  # fmt: skip
    rows = [
        _names(examination, records, measure),
        _label("<b>Picture</b>input, and as explained"),
        pictures,
        row("<b>Normals</b>right red, up green", lambda column: _tile(column.normal_map, "normal map")),
        row(
            "<b>Error</b>angle to the true normals",
            lambda column: _tile(column.angle, "angular error") if column.angle else _SCALE,
        ),
        row("<b>Color map</b>true above, estimated below", lambda column: _strips(columns["truth"], column)),
    ]
    for index, angles in enumerate(examination.new_lights):
        rows.append(row(_light(angles), partial(_relit, index=index)))
    top, bottom, left, right = frame
    shape = max((right - left) / (bottom - top), 1.0)
    return _grid("".join(rows) + numbers, examination, shape)


def sheet_note(examination: Examination, study_size: int) -> str:
    """Say at which size the pictures of an examination were made, and whose its numbers are."""
    size = examination.size
    if examination.unavailable:
        return ""
    if size == study_size:
        return f"Painted and analyzed again at the study's {size} × {size} pixels; the numbers are the study's own."
    return (
        f"Painted and analyzed again at {size} × {size} pixels; the numbers are the study's own, at "
        f"{study_size} × {study_size}."
    )


@dataclass(frozen=True)
class _Column:
    """The pictures of an answer as data addresses."""

    picture: str
    normal_map: str
    angle: str
    color_map: str
    relit: tuple[str, ...]


Frame = tuple[int, int, int, int]

_EMPTY = '<div class="tile empty"></div>'
_SCALE = f'<div class="scale"><i></i><div><span>0°</span><span>{ANGLE_LIMIT:g}° and more</span></div></div>'


@lru_cache(maxsize=KEPT_COLUMNS)
def _column(answer: Answer, frame: Frame) -> _Column:
    assert answer.color_map is not None  # only failures have none
    return _Column(
        picture=_address(answer.picture, frame),
        normal_map=_address(answer.normal_map, frame),
        angle="" if answer.name == "truth" else _address(_heat(answer.angle, answer.picture), frame),
        color_map=_ramp_address(answer.color_map),
        relit=tuple(_address(picture, frame) for picture in answer.relit),
    )


def _heat(angle: FloatArray, picture: Pixels) -> Pixels:
    """Return angles as RGBA, with the outline of the picture."""
    palette = np.array(
        [[int(color[i : i + 2], 16) for i in (1, 3, 5)] for color in Inferno256], dtype=np.uint8
    )
    place = np.round(np.clip(np.nan_to_num(angle) / ANGLE_LIMIT, 0.0, 1.0) * 255).astype(np.intp)
    coverage = np.where(np.isfinite(angle), picture[..., 3], 0).astype(np.uint8)
    return np.dstack([palette[place], coverage])


def _frame(truth: Answer) -> Frame:
    """Return top, bottom, left and right of the object: what is cut out of every picture."""
    rows, columns = np.nonzero(truth.picture[..., 3])
    return int(rows.min()), int(rows.max()) + 1, int(columns.min()), int(columns.max()) + 1


def _address(pixels: Pixels, frame: Frame) -> str:
    top, bottom, left, right = frame
    return _png(pixels[top:bottom, left:right])


def _ramp_address(color_map: ColorMap) -> str:
    samples = color_map(np.linspace(-1.0, 1.0, STRIP_SAMPLES))[None]
    return _png(np.round(samples * 255).astype(np.uint8))


def _png(pixels: Pixels) -> str:
    buffer = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(buffer, "PNG", compress_level=4)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def _grid(content: str, examination: Examination, shape: float) -> str:
    columns = f"132px repeat({len(examination.methods) + 1}, minmax(104px, 1fr))"
    name = escape(f"{format_name(examination.shape)} in {format_name(examination.color_map)}")
    style = f"grid-template-columns: {columns}; --shape: {shape:.3f}"
    return f'<div class="sheet" role="group" aria-label="{name}" style="{style}">{content}</div>'


def _names(examination: Examination, records: Mapping[str, Record], measure: str) -> str:
    meaning = MEASURES[measure]
    azimuth, elevation = examination.light
    cells = [
        "<div></div>",
        f'<div class="name"><b>Truth</b><span>light from {azimuth:g}°, {elevation:g}° up</span></div>',
    ]
    for method, record in records.items():
        value = _value(record, meaning)
        error = str(record.get("error") or "")
        shown = "failed" if error else meaning.shown(value) if np.isfinite(value) else "—"
        name = f'<b>{escape(format_name(method))}</b><span title="{escape(error)}">{shown}</span>'
        cells.append(f'<div class="name">{name}</div>')
    return "".join(cells)


def _numbers(records: Mapping[str, Record], measure: str) -> str:
    """Return the table's numbers, a row a measure; the best method is set off, leaving out the trivial one."""
    listed = LISTED if measure in LISTED else (measure, *LISTED)
    rows = ['<div class="rule"></div>']
    for name in listed:
        meaning = MEASURES[name]
        values = {method: _value(record, meaning) for method, record in records.items()}
        shown = {
            method: meaning.shown(value) if np.isfinite(value) else "—" for method, value in values.items()
        }
        rivals = [method for method, value in values.items() if method != REFERENCE and np.isfinite(value)]
        best = min(rivals, key=lambda method: abs(values[method] - meaning.ideal), default=None)
        ideal = f"ideal {meaning.ideal:g}" if name != "seconds" else ""
        rows += [_label(escape(meaning.axis)), f'<div class="number ideal">{ideal}</div>']
        for method, text in shown.items():
            marked = " best" if best is not None and method in rivals and text == shown[best] else ""
            rows.append(f'<div class="number{marked}">{text}</div>')
    return "".join(rows)


def _value(record: Record, measure: Measure) -> float:
    return float(record.get(measure.column, np.nan))  # type: ignore[arg-type]  # a column of numbers


def _label(content: str) -> str:
    return f'<div class="label">{content}</div>'


def _tile(address: str, name: str) -> str:
    return f'<div class="tile"><img src="{address}" alt="{escape(name)}"></div>'


def _relit(column: _Column, *, index: int) -> str:
    return _tile(column.relit[index], "relit")


def _failure(answer: Answer) -> str:
    return f'<div class="tile failed">{escape(answer.failure)}</div>'


def _strips(truth: _Column, column: _Column) -> str:
    if column is truth:
        return f'<div class="strips true"><img src="{truth.color_map}" alt="true color map"></div>'
    pair = ((truth.color_map, "true color map"), (column.color_map, "estimated color map"))
    return '<div class="strips">' + "".join(f'<img src="{src}" alt="{alt}">' for src, alt in pair) + "</div>"


def _light(angles: Angles) -> str:
    """Return a label with a ball that shows where the light comes from."""
    x, y, _ = light_direction(*angles) * 13
    ball = (
        '<svg viewBox="-16 -16 32 32"><circle r="15" fill="none" stroke="currentColor" opacity=".5"/>'
        f'<circle cx="{x:.1f}" cy="{-y:.1f}" r="3.4" fill="#ffd640" stroke="#141416"/></svg>'
    )
    return f'<div class="light">{ball}<span><b>Relit</b>{angles[0]:g}°, {angles[1]:g}° up</span></div>'

"""The study's heat map as HoloViews elements: shapes down, color maps across, means in the margins."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import holoviews as hv
import holoviews.plotting.bokeh
import numpy as np
from bokeh.models import ColorBar
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.model.luminance import tone
from toonkit.study.color_maps import load_color_maps
from toonkit.viz.figures.study_style import format_name
from toonkit.viz.study_page.matrix import TrialMatrix
from toonkit.viz.study_page.state import StudyState

BACKEND = "bokeh"  # the import of its module above registers it, without a notebook's hv.extension

ROW_HEIGHT = 16
"""Pixels of a shape's row."""

FURNITURE = 146
"""Pixels above and below the rows: names, color strips, color bar."""

GAP = 0.45
"""Of a cell: between kinds of shapes, and before the means."""

SIZE = 0.94
"""Of a cell: its filled part."""

STRIP = (0.62, 1.0)
"""Above the first row, in cells: where a color map's strip begins and ends."""

STRIP_SAMPLES = 100

ONE_SIDED = "inferno"
BETTER, EVEN, WORSE = "#58b4f0", "#26282c", "#f08a3c"
"""Colors of a difference: blue where the method is better, dark where it is the same, orange where it is worse."""

MARK = (("#141416", 5.0), ("#ffffff", 2.5))
"""Colors and widths of the lines around the selected cell."""

WIDEST_CELL = 120
"""Pixels: a study of few color maps does not fill the page."""

Place = tuple[float, float]


class MatrixLayout:
    """
    Where the cells of a matrix lie: x to the right, one unit a column; y upward, one unit a row, the first at 0.

    Parameters
    ----------
    matrix : TrialMatrix
        Its shapes, kinds and color maps count, its values do not.
    """

    def __init__(self, matrix: TrialMatrix) -> None:
        breaks = [0, *(int(a != b) for a, b in zip(matrix.kinds, matrix.kinds[1:], strict=False))]
        self.columns = np.arange(len(matrix.color_maps), dtype=np.float64)
        self.rows = -np.arange(len(matrix.shapes)) - GAP * np.cumsum(breaks)
        self.mean_column = self.columns[-1] + 1 + GAP
        self.mean_row = self.rows[-1] - 1 - GAP

    def cell_at(self, x: float, y: float) -> tuple[int, int] | None:
        """Return row and column of the cell at a place; None between and outside them."""
        row, column = np.abs(self.rows - y).argmin(), np.abs(self.columns - x).argmin()
        if abs(self.rows[row] - y) > 0.5 or abs(self.columns[column] - x) > 0.5:
            return None
        return int(row), int(column)

    @property
    def frame(self) -> tuple[Place, Place]:
        """Limits of x and of y."""
        return (-0.6, self.mean_column + 0.6), (self.mean_row - 0.6, STRIP[1] + 0.15)

    @property
    def height(self) -> int:
        """Height of the plot in pixels, at which its rows can be read."""
        low, high = self.frame[1]
        return FURNITURE + round(ROW_HEIGHT * (high - low))


def heat_map(matrix: TrialMatrix) -> hv.Overlay:
    """
    Show a measure, or the difference of two methods, over shapes and color maps.

    Cells are colored by value, with a cross where a trial has none and the means in the margins. They are rectangles
    rather than a `holoviews.HeatMap`, because kinds of shapes stand apart, and so do the means.
    """
    layout = MatrixLayout(matrix)
    low, high = matrix.limits
    colors = difference_colors() if matrix.center is not None else ONE_SIDED
    cells = _cells(matrix, layout).opts(
        color="value",
        cmap=colors,
        clim=(low, high),
        colorbar=True,
        colorbar_position="bottom",
        colorbar_opts={"height": 9, "padding": 4, "title_standoff": 5, "major_tick_line_color": None},
        hooks=[_name_color_bar],
        line_color=None,
        tools=["hover"],
        hover_tooltips=[("", "@shape in @color_map"), ("", "@text")],
        backend=BACKEND,
    )
    overlay = cells * _crosses(matrix, layout) * _mean_labels(matrix, layout)
    return overlay.opts(**_page(matrix, layout), backend=BACKEND)


def color_strips(color_maps: Sequence[str], layout: MatrixLayout) -> hv.RGB:
    """Return the color maps as strips above their columns, dark to bright; one that does not ship stays empty."""
    known = load_color_maps()
    strips = np.zeros((len(color_maps), STRIP_SAMPLES, 4))
    free = round(STRIP_SAMPLES * (1 - SIZE) / 2)
    for strip, name in zip(strips, color_maps, strict=True):
        if name in known:
            strip[free:-free, :3] = known[name](np.linspace(-1.0, 1.0, STRIP_SAMPLES - 2 * free))
            strip[free:-free, 3] = 1.0
    bounds = (layout.columns[0] - 0.5, STRIP[0], layout.columns[-1] + 0.5, STRIP[1])
    return hv.RGB(strips.reshape(1, -1, 4), bounds=bounds, vdims=["R", "G", "B", "A"])


def live_heat_map(state: StudyState) -> hv.DynamicMap:
    """
    Return the heat map that follows a state, and selects the trial whose cell is clicked.

    Only values and colors are sent when the measure or a method changes, only the mark when a cell is selected.
    """
    first = state.matrix()
    layout = MatrixLayout(first)
    shown = hv.streams.Params(state, ["measure", "method", "versus", "light_track"])
    selected = hv.streams.Params(state, ["shape", "color_map"])
    cells = hv.DynamicMap(lambda **_: heat_map(state.matrix()), streams=[shown])
    mark = hv.DynamicMap(partial(_mark, first, layout), streams=[selected])

    def tapped(x: float | None, y: float | None) -> None:
        cell = None if x is None or y is None else layout.cell_at(x, y)
        if cell is not None:
            state.select(first.shapes[cell[0]], first.color_maps[cell[1]])

    hv.streams.Tap(source=mark).add_subscriber(tapped)
    # Options of a page are those of its outermost overlay.
    return (cells * color_strips(first.color_maps, layout) * mark).opts(
        **_page(first, layout), backend=BACKEND
    )


def difference_colors() -> list[str]:
    """Return the colors of a difference, from better over even to worse."""
    steps = np.linspace(0.0, 1.0, 128)[:, None]
    better, even, worse = (_rgb(color) for color in (BETTER, EVEN, WORSE))
    sides = [better + steps * (even - better), even + steps * (worse - even)]
    return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in np.round(np.concatenate(sides)).astype(int)]


def _page(matrix: TrialMatrix, layout: MatrixLayout) -> dict[str, Any]:
    """Return the options of the plot: names for axes, and nothing else around the cells."""
    return {
        "xticks": [*_ticks(layout.columns, matrix.color_maps), (layout.mean_column, matrix.center_name)],
        "yticks": [*_ticks(layout.rows, matrix.shapes), (layout.mean_row, matrix.center_name)],
        "xlim": layout.frame[0],
        "ylim": layout.frame[1],
        "xaxis": "top",
        "xrotation": 40,
        "xlabel": "",
        "ylabel": "",
        "show_frame": False,
        "show_legend": False,
        "responsive": True,
        "height": layout.height,
        "max_width": WIDEST_CELL * (len(layout.columns) + 2),
        "toolbar": None,
        "default_tools": [],
        "fontsize": {"ticks": "9pt"},
        "hooks": [_bare_axes],
    }


def _cells(matrix: TrialMatrix, layout: MatrixLayout) -> hv.Rectangles:
    """Return cells and means as rectangles that know what they stand for."""
    rows = []
    for i, shape in enumerate(matrix.shapes):
        for j, color_map in enumerate(matrix.color_maps):
            text = matrix.cell_text(i, j)
            rows.append(
                (
                    layout.columns[j],
                    layout.rows[i],
                    matrix.values[i, j],
                    format_name(shape),
                    format_name(color_map),
                    text,
                )
            )
    for y, value, name in zip(layout.rows, matrix.row_means, matrix.shapes, strict=True):
        rows.append(
            (
                layout.mean_column,
                y,
                value,
                format_name(name),
                "all color maps",
                f"{matrix.center_name} {matrix.shown(value)}",
            )
        )
    for x, value, name in zip(layout.columns, matrix.column_means, matrix.color_maps, strict=True):
        rows.append(
            (
                x,
                layout.mean_row,
                value,
                "all shapes",
                format_name(name),
                f"{matrix.center_name} {matrix.shown(value)}",
            )
        )
    rows.append(
        (layout.mean_column, layout.mean_row, matrix.mean, "all shapes", "all color maps", matrix.summary)
    )
    half = SIZE / 2
    boxes = [(x - half, y - half, x + half, y + half, *rest) for x, y, *rest in rows]
    value = hv.Dimension("value", label=matrix.label)
    return hv.Rectangles(boxes, kdims=["x0", "y0", "x1", "y1"], vdims=[value, "shape", "color_map", "text"])


def _crosses(matrix: TrialMatrix, layout: MatrixLayout) -> hv.Scatter:
    """Mark the cells that have no value."""
    i, j = np.nonzero(~np.isfinite(matrix.values))
    places = (layout.columns[j], layout.rows[i])
    return hv.Scatter(places, "x", "y").opts(
        marker="x", size=8, color="#f4f2ee", line_width=2, backend=BACKEND
    )


def _mean_labels(matrix: TrialMatrix, layout: MatrixLayout) -> hv.Labels:
    """Write the means into their cells."""
    x = np.concatenate([np.full(len(layout.rows), layout.mean_column), layout.columns, [layout.mean_column]])
    y = np.concatenate([layout.rows, np.full(len(layout.columns), layout.mean_row), [layout.mean_row]])
    values = np.concatenate([matrix.row_means, matrix.column_means, [matrix.mean]])
    known = np.isfinite(values)
    texts = [matrix.shown(value).rstrip("°").removesuffix(" s") for value in values[known]]
    inks = np.where(_is_bright(values[known], matrix), "#141416", "#f4f2ee")
    labels = hv.Labels((x[known], y[known], texts, inks), kdims=["x", "y"], vdims=["text", "ink"])
    return labels.opts(text_color="ink", text_font_size="8pt", backend=BACKEND)


def _is_bright(values: FloatArray, matrix: TrialMatrix) -> NDArray[np.bool_]:
    """Tell which values are painted so brightly that only dark text can be read on them."""
    low, high = matrix.limits
    palette: Sequence[str] = (
        difference_colors() if matrix.center is not None else hv.plotting.util.process_cmap(ONE_SIDED, 256)
    )
    place = np.clip((values - low) / (high - low), 0.0, 1.0) * (len(palette) - 1)
    paints = np.array([_rgb(palette[index]) for index in np.round(place).astype(int)]).reshape(-1, 3) / 255
    return np.asarray(tone(paints) > 0.5)


def _mark(matrix: TrialMatrix, layout: MatrixLayout, shape: str, color_map: str) -> hv.Rectangles:
    """Frame the selected cell."""
    x = layout.columns[matrix.color_maps.index(color_map)]
    y = layout.rows[matrix.shapes.index(shape)]
    box = (x - 0.5, y - 0.5, x + 0.5, y + 0.5)
    # Light on dark: one of them can be seen on any cell and on either theme.
    lines = hv.Rectangles([(*box, *line) for line in MARK], vdims=["ink", "width"])
    return lines.opts(fill_color=None, line_color="ink", line_width="width", tools=["tap"], backend=BACKEND)


def _ticks(places: FloatArray, names: Sequence[str]) -> list[tuple[float, str]]:
    return [(float(place), format_name(name)) for place, name in zip(places, names, strict=True)]


def _name_color_bar(plot: Any, element: hv.Rectangles) -> None:
    """Write the label of the values over the color bar: HoloViews writes it once, and the measure changes."""
    for bar in plot.state.select(ColorBar):
        bar.title = element.vdims[0].label


def _bare_axes(plot: Any, _: Any) -> None:
    """Leave of the axes only the names."""
    for axis in (*plot.state.above, *plot.state.left):
        axis.update(axis_line_color=None, major_tick_line_color=None, minor_tick_line_color=None)
        axis.update(major_label_standoff=2)
    plot.state.outline_line_color = None
    plot.state.stylesheets = [
        ":host(:focus:not(:focus-visible)) { outline: none; }"
    ]  # no frame after a click


def _rgb(color: str) -> FloatArray:
    return np.array([int(color[start : start + 2], 16) for start in (1, 3, 5)], dtype=np.float64)

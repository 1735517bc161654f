"""Pictures of one size in a grid, panned and zoomed together, with one crosshair over all of them."""

from __future__ import annotations

import asyncio
import weakref
from collections.abc import Callable, Mapping
from typing import Any

import holoviews as hv
import holoviews.plotting.bokeh
import numpy as np
import panel as pn
import param
from bokeh.models import CrosshairTool, PanTool, Range1d, Span, WheelZoomTool

from toonkit.viz.page_style import ACCENT, WIDE, Insistence
from toonkit.viz.relight_page.view_pictures import Picture, Window, isophotes, reduced

BACKEND = "bokeh"  # the import of its module above registers it

GRID = {
    "display": "grid",
    "grid-template-columns": "repeat(auto-fill, minmax(max(140px, 23%), 1fr))",
    "gap": "10px",
}
"""Up to four pictures side by side, two on a phone."""

NO_SCROLLING = ".scroll-button { display: none; }"
"""Hides the scroll button of a Panel column, which would take a place in the grid."""

DARK_ON_WHITE = ".bk-Panel { color: #222; font-size: 13px; }"
"""Makes Bokeh's zoom hint readable: its background is white, and it would take the text color of the page."""

ASPECTS = (0.7, 1.6)
"""Least and greatest ratio of a frame's width to its height; pictures of other shapes are shown with margins."""

CLOSEST = 6.0
"""Least number of picture pixels along the shorter side of a frame: it limits the zoom."""

ZOOM_STEP = 2**0.5
FIRST_WIDTH = 224
"""Assumed width of a frame in pixels, until the browser reports the real one."""

REST_SECONDS = 0.15
"""Seconds without panning or zooming after which the visible parts are sent in full detail."""

READ_SECONDS = 0.05
"""Seconds between two readings of the pixel under the crosshair."""


class LinkedPictures(pn.viewable.Viewer):
    """
    A grid of pictures of one drawing.

    Ctrl with the wheel zooms, as everywhere on the page; dragging pans; a double click fits. The browser does this without
    Python, which sends no more pixels than the frames have on screen: the whole picture, and over it the visible part.

    Parameters
    ----------
    shape : tuple of int
        Height and width of all pictures, pixels.
    """

    pixel = param.Tuple(
        None, length=2, doc="Row and column of the pixel under the crosshair; None before there is one."
    )
    moved = param.Integer(0, doc="Grows whenever the pictures are panned or zoomed.")
    pointed = param.Integer(0, doc="Grows whenever the crosshair is moved.")

    def __init__(self, shape: tuple[int, int], **params: Any) -> None:
        super().__init__(**params)
        height, width = self.shape = shape
        self._aspect = float(np.clip(width / height, *ASPECTS))
        wide = max(width, height * self._aspect)
        self._extent = (wide, wide / self._aspect)
        least = CLOSEST / min(self._extent)
        self._ranges = tuple(
            Range1d(min_interval=least * side, max_interval=2 * side) for side in self._extent
        )
        self.fit()
        self._spans = tuple(
            Span(dimension=dimension, location=np.nan, line_color="white", line_alpha=0.9, line_width=1)
            for dimension in ("width", "height")
        )
        for scale in self._ranges:
            for end in ("start", "end"):
                scale.on_change(end, self._note_move)
        for span in self._spans:
            span.on_change("location", self._note_pointer)
        self._hook = _weakly(self._link)
        self._reading = False
        self._sharpness = float(getattr(pn.state.browser_info, "device_pixel_ratio", None) or 1.0)
        self._frame_width = FIRST_WIDTH
        self._wholes: dict[str, hv.RGB] = {}
        self._pictures: dict[str, Picture] = {}
        self._pipes: dict[str, hv.streams.Pipe] = {}
        self._cells: dict[str, pn.Column] = {}
        self._showing = asyncio.Lock()
        self._grid = pn.Column(styles=GRID, stylesheets=[NO_SCROLLING], margin=(0, 10), **WIDE)

        self._insist = Insistence(self._grid)

    async def show(self, pictures: Mapping[str, Picture], order: list[str]) -> None:
        """
        Show these pictures and no others. They are sent one at a time, so that the page stays responsive.

        Parameters
        ----------
        pictures : mapping of str to Picture
            All pictures that are shown; those that are the same object as before are not sent again.
        order : list of str
            Their names, in the order shown.
        """
        async with self._showing:
            before, self._pictures = self._pictures, dict(pictures)
            for name in list(self._cells):
                if pictures.get(name) is not before[name]:
                    self._wholes.pop(name, None)
                if name not in pictures:
                    del self._cells[name], self._pipes[name]
            self._grid[:] = [self._cells[name] for name in order if name in self._cells]
            for place, name in enumerate(order):
                if name not in self._cells:
                    self._add(name)
                    self._grid.insert(place, self._cells[name])
                    await asyncio.sleep(0)
                elif before[name] is not pictures[name]:
                    self._cells[name][0].object = _title(pictures[name].title)
                    self._pipes[name].send(self._element(name))
                    await asyncio.sleep(0)
        self._insist()

    def point_at(self, row: int, column: int) -> None:
        """Put the crosshair on a pixel."""
        across, down = self._spans
        across.location, down.location = self.shape[0] - row - 0.5, column + 0.5

    def fit(self) -> None:
        """Show the whole pictures."""
        self._look(self.shape[1] / 2, self.shape[0] / 2, 1.0)

    def zoom(self, factor: float) -> None:
        """Magnify the pictures by a factor about the middle of the view."""
        x, y = ((scale.start + scale.end) / 2 for scale in self._ranges)
        shown = (self._ranges[0].end - self._ranges[0].start) / self._extent[0]
        self._look(x, y, float(np.clip(shown / factor, CLOSEST / min(self._extent), 1.0)))

    def close(self) -> None:
        """Free the pictures: the visitor has left."""
        self._insist.end()
        for kept in (self._pictures, self._wholes, self._pipes, self._cells):
            kept.clear()

    def __panel__(self) -> pn.viewable.Viewable:
        return self._grid

    def _look(self, x: float, y: float, share: float) -> None:
        for scale, middle, side in zip(self._ranges, (x, y), self._extent, strict=True):
            scale.update(start=middle - share * side / 2, end=middle + share * side / 2)

    def _add(self, name: str) -> None:
        self._pipes[name] = hv.streams.Pipe(data=self._element(name))
        pane = pn.pane.HoloViews(
            hv.DynamicMap(_passed, streams=[self._pipes[name]]),
            styles={"aspect-ratio": f"{self._aspect:.4f}", "flex": "none", "height": "auto"},
            margin=0,
            **WIDE,
            linked_axes=False,
        )
        title = pn.pane.HTML(_title(self._pictures[name].title), margin=(0, 0, 3, 0), **WIDE)
        self._cells[name] = pn.Column(title, pane, margin=0, **WIDE)

    def _note_move(self, attr: str, old: object, new: object) -> None:  # noqa: ARG002  # as Bokeh calls it
        self.moved += 1

    def _note_width(self, attr: str, old: object, new: int) -> None:  # noqa: ARG002
        if new > 0 and new != self._frame_width:  # all frames are alike
            self._frame_width = new
            self._wholes.clear()
            self.moved += 1

    def _note_pointer(self, attr: str, old: object, new: object) -> None:  # noqa: ARG002
        self.pointed += 1

    @property
    def _window(self) -> Window:
        """The visible part."""
        columns, upward = ((scale.start, scale.end) for scale in self._ranges)
        rows = self.shape[0] - upward[1], self.shape[0] - upward[0]
        return Window.around(columns, rows, self.shape, self._sharpness * self._frame_width)

    def _element(self, name: str) -> hv.Overlay:
        """Return a picture, its visible part over it, and its isophotes if it has any."""
        picture, window = self._pictures[name], self._window
        if name not in self._wholes:
            everywhere = (0.0, self._extent[0]), (0.0, self._extent[1])
            whole = Window.around(*everywhere, self.shape, self._sharpness * self._frame_width)
            self._wholes[name] = self._part(picture, whole)
        layers: list[hv.Element] = [self._wholes[name], self._part(picture, window)]
        if picture.illumination is not None:
            places = isophotes(picture.illumination, window)
            curve = hv.Curve((places[:, 0], self.shape[0] - places[:, 1]), "column", "height")
            layers.append(curve.opts(color=ACCENT, line_width=1.2, backend=BACKEND))
        return hv.Overlay(layers).opts(
            responsive=True,
            xaxis=None,
            yaxis=None,
            toolbar=None,
            default_tools=[],
            show_legend=False,
            border=0,
            apply_ranges=False,
            hooks=[self._hook],
            backend=BACKEND,
        )

    def _part(self, picture: Picture, window: Window) -> hv.RGB:
        height = self.shape[0]
        bounds = (window.left, height - window.bottom, window.right, height - window.top)
        element = hv.RGB(reduced(picture.pixels, window), bounds=bounds, kdims=["column", "height"])
        return element.opts(apply_ranges=False, backend=BACKEND)

    def _link(self, plot: Any, _: hv.Element) -> None:
        """Give a figure the ranges and the crosshair that all pictures share."""
        figure = plot.state
        if figure.x_range is self._ranges[0]:
            return
        figure.x_range, figure.y_range = self._ranges
        plot.handles["x_range"], plot.handles["y_range"] = self._ranges
        wheel = WheelZoomTool(modifiers={"ctrl": True})
        figure.add_tools(PanTool(), wheel, CrosshairTool(overlay=self._spans))
        figure.toolbar.active_scroll = wheel
        figure.on_event("doubletap", lambda _: self.fit())
        figure.stylesheets = [*figure.stylesheets, DARK_ON_WHITE]
        figure.outline_line_color = None
        figure.on_change("inner_width", self._note_width)

    @param.depends("moved", watch=True)
    async def _sharpen(self) -> None:
        moved = self.moved
        await asyncio.sleep(REST_SECONDS)
        if moved != self.moved:
            return
        elements = await asyncio.to_thread(lambda: {name: self._element(name) for name in self._pipes})
        if moved == self.moved:
            for name, element in elements.items():
                if name in self._pipes:
                    self._pipes[name].send(element)
            self._insist()

    @param.depends("pointed", watch=True)
    async def _read(self) -> None:
        if self._reading:
            return
        self._reading = True
        await asyncio.sleep(READ_SECONDS)
        self._reading = False
        across, down = (span.location for span in self._spans)
        if across is None or down is None or not np.isfinite([across, down]).all():
            return
        row, column = int(np.floor(self.shape[0] - across)), int(np.floor(down))
        if 0 <= row < self.shape[0] and 0 <= column < self.shape[1]:
            self.pixel = (row, column)
            self._insist()


def _weakly(link: Callable[[Any, hv.Element], None]) -> Callable[[Any, hv.Element], None]:
    """Return a hook that does not keep the pictures alive: HoloViews keeps it as long as their elements."""
    reference = weakref.WeakMethod(link)

    def hook(plot: Any, element: hv.Element) -> None:
        method = reference()
        if method is not None:
            method(plot, element)

    return hook


def _title(words: str) -> str:
    return f'<span style="color: var(--panel-on-surface-color); font-size: 12px">{words}</span>'


def _passed(data: Any) -> Any:
    """Show the element that a stream sends."""
    return data

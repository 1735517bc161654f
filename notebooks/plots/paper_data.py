"""Figures 1 and 6: what color maps do to a shape, and the shapes and color maps of the study (Section 4.1)."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.gridspec import GridSpec
from numpy.typing import ArrayLike

from toonkit._validation import refuse
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.shading import shade
from toonkit.study.color_maps import Ramp
from toonkit.study.rendering import RenderedShape
from toonkit.viz.figures.ramp import draw_ramp
from toonkit.viz.figures.study_style import format_name
from toonkit.viz.figures.style import INK, PAGE_WIDTH, QUIET, SMALL, figure_style, new_figure

from .panels import caption, draw_picture, fill, part_title, proportion

SHAPES_ACROSS = 7
RAMPS_ACROSS = 3

STRIP_GAP = 0.05
"""Room between columns, as a share of their width: two strips side by side must not read as one."""

MARK_ROOM = 8.0
"""Points between a strip and its name, for the marks of its steps."""


def stylized_shading(
    shape: RenderedShape, color_maps: Mapping[str, ColorMap], light: ArrayLike, *, across: int = 4
) -> Figure:
    """
    Draw Figure 1: one shape under one light, painted with several color maps.

    Parameters
    ----------
    shape : RenderedShape
        The shape.
    color_maps : mapping of str to ColorMap
        Name -> ramp; each is shown below the picture it paints.
    light : array_like, shape (3,)
        Direction from the surface to the light.
    across : int, optional
        Pictures side by side.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page.

    Raises
    ------
    ToonkitError
        If there is no color map, or the light is refused.
    """
    if not color_maps:
        raise refuse("color_maps", "must hold at least one color map", "none")
    rows = -(-len(color_maps) // across)
    tall = proportion(shape.normals) * PAGE_WIDTH / across
    with figure_style():
        figure = new_figure(rows * (tall + 0.42), gap=STRIP_GAP)
        grid = GridSpec(2 * rows, across, figure, height_ratios=[tall, 0.12] * rows)
        for index, (name, color_map) in enumerate(color_maps.items()):
            row, column = divmod(index, across)
            above = figure.add_subplot(grid[2 * row, column])
            draw_picture(above, _painted(shape, color_map, light))
            above.set_title(format_name(name))
            below = figure.add_subplot(grid[2 * row + 1, column])
            draw_ramp(below, color_map)
            if index + across >= len(color_maps):
                below.set_xlabel("illumination  L · N")
            else:
                below.set_xticklabels([])
    return figure


def data_sets(
    shapes: Mapping[str, RenderedShape], ramps: Mapping[str, Ramp], light: ArrayLike, paint: ColorMap
) -> Figure:
    """
    Draw Figure 6: all shapes in one paint, and all color maps with their transitions.

    Parameters
    ----------
    shapes : mapping of str to RenderedShape
        Name -> shape, in the order of showing.
    ramps : mapping of str to Ramp
        Name -> ramp. A mark above its strip stands at each step between two tones, and a bar there is as wide as the step.
    light : array_like, shape (3,)
        Direction from the shapes to their light.
    paint : ColorMap
        What the shapes are painted with.

    Returns
    -------
    matplotlib.figure.Figure
        A full page.

    Raises
    ------
    ToonkitError
        If there is no shape or no ramp, or the light is refused.
    """
    if not shapes or not ramps:
        raise refuse("shapes and ramps", "must hold at least one each", f"{len(shapes)} and {len(ramps)}")
    shape_rows, ramp_rows = -(-len(shapes) // SHAPES_ACROSS), -(-len(ramps) // RAMPS_ACROSS)
    heights = [0.1 + shape_rows * (PAGE_WIDTH / SHAPES_ACROSS + 0.14), 0.6 + ramp_rows * 0.47]
    with figure_style():
        figure = new_figure(sum(heights), gap=STRIP_GAP)
        (above,), (below,) = figure.subfigures(2, 1, squeeze=False, height_ratios=heights, hspace=0.02)
        part_title(above, f"(a) {len(shapes)} shapes")
        for axes, (name, shape) in zip(
            above.subplots(shape_rows, SHAPES_ACROSS, squeeze=False).flat, shapes.items(), strict=False
        ):
            draw_picture(axes, _painted(shape, paint, light))
            fill(axes, 1.0)
            caption(axes, format_name(name))
        part_title(below, f"(b) {len(ramps)} color maps over illumination  L · N")
        _draw_ramps(below, ramps, ramp_rows)
        for axes in figure.axes:
            if not axes.images:
                axes.remove()
    return figure


def _draw_ramps(figure: SubFigure, ramps: Mapping[str, Ramp], rows: int) -> None:
    """Down each column, then the next."""
    # The first row stays empty, so that the names of the first strips keep off the title.
    grid = figure.add_gridspec(rows + 1, RAMPS_ACROSS, height_ratios=[0.15] + [1.0] * rows)
    for index, ramp in enumerate(ramps.values()):
        column, row = divmod(index, rows)
        axes = figure.add_subplot(grid[row + 1, column])
        draw_ramp(axes, ramp.color_map())
        _mark_steps(axes, ramp)
        axes.set_title(format_name(ramp.name), loc="left", fontsize=SMALL, pad=MARK_ROOM)
        axes.set_title(", ".join(ramp.tags), loc="right", fontsize=SMALL - 1, color=QUIET, pad=MARK_ROOM)
        if row == rows - 1 or index == len(ramps) - 1:
            axes.set_xlabel("illumination  L · N")
        else:
            axes.set_xticklabels([])


def _mark_steps(axes: Axes, ramp: Ramp) -> None:
    """Mark where tones meet, just above the strip."""
    for at, softness in ramp.steps:
        low, high = max(at - softness / 2, -1.0), min(at + softness / 2, 1.0)
        axes.plot([low, high], [1.22, 1.22], color=QUIET, linewidth=1.0, clip_on=False, solid_capstyle="butt")
        axes.plot(at, 1.22, marker="v", markersize=2.6, color=INK, markeredgewidth=0, clip_on=False)
    axes.set(xlim=(-1.0, 1.0), ylim=(0.0, 1.0))


def _painted(shape: RenderedShape, color_map: ColorMap, light: ArrayLike) -> ToonImage:
    return ToonImage(shade(shape.normals, light, color_map).color, shape.mask, alpha=shape.coverage)

"""Figures 2 to 5: the method, step by step (Sections 3.1 to 3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_light, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.islands import islands_of
from toonkit.heightfield import height_map
from toonkit.metrics import angular_error
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField, encode_normal_map
from toonkit.model.shading import illumination
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.relighting import relight
from toonkit.study.rendering import RenderedShape
from toonkit.viz.figures.ramp import draw_ramp
from toonkit.viz.figures.style import GROUND, INK, PAGE_WIDTH, QUIET, SMALL, figure_style, new_figure

from .panels import (
    angles_text,
    bare,
    caption,
    draw_light,
    draw_normal_map,
    draw_picture,
    draw_values,
    error_scale,
    fill,
    ground_color,
    heading,
    illumination_scale,
    part_title,
    proportion,
)

SILHOUETTE_ARROWS = 60
PROFILES = 44
"""Cuts through a height."""

LEAN = 0.55
"""How far a cut moves up the page for each pixel of height."""


def method_overview(analysis: ToonAnalysis, lights: Sequence[ArrayLike]) -> Figure:
    """
    Draw Figure 2: the four steps from a picture to the same picture under new lights.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    lights : sequence of array_like, shape (3,)
        Lights to relight with.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page; one ground for each of the steps (a) to (d).

    Raises
    ------
    ToonkitError
        If there is no light, or one is zero, not finite or from behind.
    """
    if not lights:
        raise refuse("lights", "must hold at least one light", "none")
    tall = proportion(analysis.image)
    heights = [0.5 + 1.12 * tall, 0.95 + (PAGE_WIDTH - 0.3) / len(lights) * tall * 0.92]
    with figure_style():
        figure = new_figure(sum(heights))
        (steps,), (below,) = figure.subfigures(2, 1, squeeze=False, height_ratios=heights, hspace=0.02)
        ((inflating, fitting, refining),) = steps.subfigures(
            1, 3, squeeze=False, width_ratios=[2.3, 1.6, 2.3], wspace=0.02
        )
        for part, title in (
            (inflating, "(a) Initial normals"),
            (fitting, "(b) Reflectance"),
            (refining, "(c) Refinement"),
            (below, "(d) Relighting"),
        ):
            part.set_facecolor(GROUND)
            part_title(part, title)
        _draw_pair(inflating, analysis, ("input  c", "initial normals N₀"), refined=False)
        _draw_reflectance(fitting, analysis)
        _draw_pair(refining, analysis, ("refined normals  N", "model  M(L · N)"), refined=True)
        _draw_relit(below, analysis, [as_light("lights", light) for light in lights], tall)
    return figure


def inflation(normals: NormalField, truth: RenderedShape, light: ArrayLike, *, limit: float = 60.0) -> Figure:
    """
    Draw Figure 3: the initial normals, what surface they bound, and how far they are from the truth.

    Parameters
    ----------
    normals : NormalField
        Initial normals N0 over the mask of the truth.
    truth : RenderedShape
        The shape whose silhouette was inflated.
    light : array_like, shape (3,)
        Direction from the surface to the light of the shading.
    limit : float, optional
        Degrees at the end of the error's color bar.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page.
    """
    gray, error = illumination_scale(), error_scale(limit)
    difference = angular_error(normals, truth.normals)
    with figure_style():
        figure = new_figure(2 * (proportion(normals) * 2.0 + 0.35))
        axes = figure.subplots(2, 3)
        outline, field, true_field, shaded, surface, wrong = axes.flat
        _draw_silhouette(outline, truth)
        draw_normal_map(field, normals, alpha=truth.coverage)
        draw_normal_map(true_field, truth.normals, alpha=truth.coverage)
        draw_values(shaded, illumination(normals, light), gray, alpha=truth.coverage)
        _draw_profiles(surface, normals)
        draw_values(wrong, difference.map, error, alpha=truth.coverage)
        for panel in axes.flat:
            fill(panel, proportion(normals))
        caption(wrong, f"mean {difference.mean:.1f}°")
        figure.colorbar(gray, ax=shaded, label="illumination  L · N₀", ticks=[-1, 0, 1], **_BAR)
        figure.colorbar(error, ax=wrong, label="angle to the truth (degrees)", extend="max", **_BAR)
        for panel, title in zip(
            axes.flat,
            (
                "(a) silhouette and its normals",
                "(b) inflated normals N₀",
                "(c) true normals",
                "(d) shading of N₀",
                "(e) height of N₀, in cuts",
                "(f) error of N₀",
            ),
            strict=True,
        ):
            heading(panel, title)
    return figure


_BAR: dict[str, Any] = {"shrink": 0.8, "aspect": 22, "pad": 0.02}
"""Proportions of a color bar beside a panel."""


def _draw_pair(
    figure: SubFigure, analysis: ToonAnalysis, captions: tuple[str, str], *, refined: bool
) -> None:
    first, arrow, second = figure.subplots(1, 3, width_ratios=[1, 0.14, 1])
    alpha = analysis.image.alpha
    if refined:
        draw_normal_map(first, analysis.normals, alpha=alpha)
        draw_picture(second, analysis.picture)
    else:
        draw_picture(first, analysis.image)
        draw_normal_map(second, analysis.initial_normals, alpha=alpha)
    _draw_arrow(arrow)
    caption(first, captions[0])
    caption(second, captions[1])


def _draw_arrow(axes: Axes) -> None:
    axes.set_axis_off()
    axes.annotate(
        "",
        xy=(1.4, 0.5),
        xytext=(-0.4, 0.5),
        arrowprops={"arrowstyle": "-|>", "color": QUIET, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0},
        annotation_clip=False,
    )


def _draw_reflectance(figure: SubFigure, analysis: ToonAnalysis) -> None:
    above, below = figure.subplots(2, 1, height_ratios=[1, 0.17])
    draw_light(above, analysis.light, analysis.color_map)
    caption(above, f"light  L,  {angles_text(analysis.light)}")
    draw_ramp(below, analysis.color_map)
    below.set_xlabel("color map  M(L · N)", fontsize=SMALL)


def _draw_relit(figure: SubFigure, analysis: ToonAnalysis, lights: list[FloatArray], tall: float) -> None:
    grid = figure.subplots(2, len(lights), squeeze=False, height_ratios=[0.32, tall])
    for (ball, panel), light in zip(grid.T, lights, strict=True):
        draw_light(ball, light, analysis.color_map)
        draw_picture(panel, relight(analysis, light))
        caption(panel, angles_text(light))


def _draw_silhouette(axes: Axes, shape: RenderedShape) -> None:
    """Show the mask, and arrows along the silhouette's own normals in the colors of a normal map."""
    gray = ToonImage(np.full((*shape.mask.shape, 3), 0.88), shape.mask, alpha=shape.coverage)
    draw_picture(axes, gray, free=0.09)
    grid = MaskedGrid(shape.mask)
    islands = islands_of(shape.mask, shape.coverage)
    everyone = np.arange(grid.size)
    pixels = np.concatenate([everyone[island.pixels][island.silhouette.pixels] for island in islands])
    rows, columns = grid.rows[pixels], grid.columns[pixels]
    middle = rows.mean(), columns.mean()
    around = np.argsort(np.arctan2(rows - middle[0], columns - middle[1]), kind="stable")
    chosen = around[np.linspace(0, len(around) - 1, SILHOUETTE_ARROWS).astype(np.intp)]
    outward = np.concatenate([island.silhouette.outward for island in islands])[chosen]
    vectors = np.concatenate([outward, np.zeros((len(chosen), 1))], axis=1)[None]
    colors = encode_normal_map(NormalField(vectors, np.ones(vectors.shape[:2], dtype=np.bool_)))[0] / 255.0
    arrows = axes.quiver(
        columns[chosen],
        rows[chosen],
        outward[:, 0],
        outward[:, 1],
        color=colors,
        pivot="tail",
        units="width",
        width=0.012,
        scale=15.0,
        headwidth=3.6,
        headlength=4.0,
        headaxislength=3.6,
        clip_on=False,
    )
    arrows.set_in_layout(False)  # or the layout would make room for arrows of their length before scaling


def _draw_profiles(axes: Axes, normals: NormalField) -> None:
    """Show a height as cuts through it, one behind the other, seen from above at a slant."""
    height = height_map(normals).height
    rows = np.flatnonzero(normals.mask.any(axis=1))
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, PROFILES).astype(np.intp))]
    ground = tuple(ground_color(axes))
    columns = np.arange(height.shape[1])
    for row in chosen:
        there = normals.mask[row]
        # Each cut hides what lies behind it.
        axes.fill_between(columns, row - LEAN * height[row], row, where=there, facecolor=ground, linewidth=0)
        axes.plot(columns, np.where(there, row - LEAN * height[row], np.nan), color=INK, linewidth=0.55)
    axes.set_aspect("equal")
    axes.margins(0.03)
    axes.invert_yaxis()
    bare(axes)

"""Figures of what an analysis finds in a drawing: its ink, its materials and their color maps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from toonkit._validation import refuse
from toonkit.analysis import ToonAnalysis
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.viz.figures.ramp import draw_ramp
from toonkit.viz.figures.style import PAGE_WIDTH, QUIET, figure_style, new_figure

from .panels import bare, draw_normal_map, draw_picture, heading, proportion

MAP_ROW = 0.62
"""Inches that a material takes in the figure of all color maps."""

MOST_TONES = 12
"""Tones of a material that are shown; a gradient has more."""

FAINT = 0.12
"""Share of their color that pixels of other materials keep."""


def panels(pictures: Mapping[str, ToonImage | NormalField], *, across: int = 4) -> Figure:
    """
    Draw pictures side by side, each under its title.

    Parameters
    ----------
    pictures : mapping of str to ToonImage or NormalField
        Title -> what to show; normals are drawn as an OpenGL normal map.
    across : int, optional
        Panels in a row.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page.

    Raises
    ------
    ToonkitError
        If there is no picture.
    """
    if not pictures:
        raise refuse("pictures", "must hold at least one", "none")
    rows = -(-len(pictures) // across)
    tall = max(proportion(shown) for shown in pictures.values()) * PAGE_WIDTH / across
    with figure_style():
        figure = new_figure(rows * (tall + 0.25))
        grid = figure.subplots(rows, across, squeeze=False)
        for axes in grid.flat:
            bare(axes)
        for axes, (title, shown) in zip(grid.flat, pictures.items(), strict=False):
            if isinstance(shown, NormalField):
                draw_normal_map(axes, shown)
            else:
                draw_picture(axes, shown)
            heading(axes, title)
    return figure


def ink_layer(analysis: ToonAnalysis) -> ToonImage:
    """Return the ink alone, black on light gray, as a picture of the drawing's object."""
    gray = np.repeat(0.94 * (1.0 - analysis.drawing.ink_coverage[..., None]), 3, axis=-1)
    return ToonImage(gray, analysis.image.mask, alpha=analysis.image.alpha)


def region_colors(analysis: ToonAnalysis) -> ToonImage:
    """Return a picture in which each material has one color, the mean of its tones."""
    materials = analysis.materials
    color = materials.base_tones[np.maximum(materials.labels, 0)]
    return ToonImage(color, analysis.image.mask, alpha=analysis.image.alpha)


def color_maps(analysis: ToonAnalysis) -> Figure:
    """
    Draw the materials of a drawing: where each is, its tones, and its color map.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.

    Returns
    -------
    matplotlib.figure.Figure
        A row for each material, the largest first.
    """
    materials = analysis.materials
    tall = proportion(analysis.image)
    with figure_style():
        figure = new_figure(materials.count * MAP_ROW + 0.35)
        grid = figure.add_gridspec(materials.count, 3, width_ratios=[MAP_ROW / tall, 1.7, 4.0])
        for number in range(materials.count):
            where, tones, ramp = (figure.add_subplot(grid[number, column]) for column in range(3))
            draw_picture(where, _only(analysis, number))
            _draw_tones(tones, analysis, number)
            draw_ramp(ramp, materials.color_maps[number])
            if number == materials.count - 1:
                ramp.set_xlabel("illumination  L · N")
            else:
                ramp.set_xticklabels([])
    return figure


def _only(analysis: ToonAnalysis, number: int) -> ToonImage:
    """Return the drawing with all but one material faint."""
    image = analysis.image
    share = np.where(analysis.materials.labels == number, 1.0, FAINT)[..., None]
    return ToonImage(share * image.color + (1.0 - share) * 0.92, image.mask, alpha=image.alpha)


def _draw_tones(axes: Axes, analysis: ToonAnalysis, number: int) -> None:
    """Show a material's tones as squares, and what part of the object it is."""
    materials, tones = analysis.materials, analysis.materials.tones[number]
    shown = tones[np.unique(np.linspace(0, len(tones) - 1, MOST_TONES).round().astype(int))]
    for place, color in enumerate(shown):
        axes.add_patch(Rectangle((place, 0.0), 0.9, 1.0, facecolor=color, edgecolor=QUIET, linewidth=0.4))
    axes.set(xlim=(0.0, MOST_TONES), ylim=(0.0, 1.0))
    bare(axes)
    share = np.mean(materials.labels[analysis.image.mask] == number)
    kind = "flat" if materials.flat[number] else "shaded"
    axes.set_xlabel(f"{kind}, {share:.1%} of the object", loc="left", color=QUIET)

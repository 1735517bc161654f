"""Figures 7 and 8: the methods beside the truth, under the input's light and under new ones (Sections 4.2 and 4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_light, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.metrics import angular_error, color_rmse
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.shading import illumination, shade
from toonkit.relighting import relight
from toonkit.study.rendering import RenderedShape
from toonkit.viz.figures.ramp import draw_ramp
from toonkit.viz.figures.style import (
    METHOD_COLORS,
    METHOD_LABELS,
    PAGE_WIDTH,
    SMALL,
    figure_style,
    new_figure,
)

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
    illumination_scale,
    proportion,
)

STRIP_WIDTH = 0.12
"""Of a color map, in widths of a picture."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """
    A shape of known normals, and what methods made of one picture of it.

    Attributes
    ----------
    truth : RenderedShape
        The shape.
    color_map : ColorMap
        What it was painted with.
    analyses : sequence of ToonAnalysis
        At least one, all of the same picture and light, in the order of showing.

    Raises
    ------
    ToonkitError
        If there is no analysis, or two are of different pictures.
    """

    truth: RenderedShape
    color_map: ColorMap
    analyses: Sequence[ToonAnalysis]

    def __post_init__(self) -> None:
        if not self.analyses:
            raise refuse("analyses", "must hold at least one analysis", "none")
        if any(analysis.image is not self.image for analysis in self.analyses):
            raise refuse("analyses", "must all be of the same picture", "several pictures")

    @property
    def image(self) -> ToonImage:
        """The painted picture."""
        return self.analyses[0].image

    @property
    def light(self) -> FloatArray:
        """Its light, shape (3,)."""
        return self.analyses[0].light

    def relit_truth(self, light: ArrayLike) -> ToonImage:
        """Return the picture that is right under a light."""
        color = shade(self.truth.normals, light, self.color_map).color
        return ToonImage(color, self.image.mask, alpha=self.image.alpha)


def shading_analysis(comparisons: Sequence[Comparison], *, limit: float = 60.0) -> Figure:
    """
    Draw Figure 7: what each method makes of a picture, next to the truth.

    Parameters
    ----------
    comparisons : sequence of Comparison
        One block of columns each; all with the same methods in the same order.
    limit : float, optional
        Degrees at the end of the one color bar that all error maps share.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page: a row for the truth and one for each method.

    Raises
    ------
    ToonkitError
        If there is no comparison, or their methods differ.
    """
    if not comparisons:
        raise refuse("comparisons", "must hold at least one comparison", "none")
    methods = [analysis.method for analysis in comparisons[0].analyses]
    if any([analysis.method for analysis in other.analyses] != methods for other in comparisons):
        raise refuse("comparisons", "must show the same methods in the same order", "others")
    gray, error = illumination_scale(), error_scale(limit)
    rows = len(methods) + 1
    ratio = max(proportion(comparison.image) for comparison in comparisons)
    wide = (PAGE_WIDTH - 0.85) / (len(comparisons) * 4.4)
    with figure_style():
        figure = new_figure(rows * (wide * ratio + 0.2) + 0.2)
        widths = [STRIP_WIDTH, 1, 1, 1, 1, STRIP_WIDTH] * len(comparisons)  # the sixth keeps blocks apart
        grid = GridSpec(rows, len(widths) - 1, figure, width_ratios=widths[:-1])
        for block, comparison in enumerate(comparisons):
            columns = range(6 * block, 6 * block + 5)
            cells = np.array(
                [[figure.add_subplot(grid[row, column]) for column in columns] for row in range(rows)]
            )
            _draw_truth(cells[0], comparison, gray)
            for row, analysis in zip(cells[1:], comparison.analyses, strict=True):
                _draw_analysis(row, analysis, comparison, gray, error)
            for axes, title in zip(
                cells[0], ("M", "M(L · N)", "normals N", "L · N", "error of N"), strict=True
            ):
                axes.set_title(title)
            for row, method in zip(cells, ["truth", *methods], strict=True):
                fill(row[0], ratio / STRIP_WIDTH)
                for axes in row[1:]:
                    fill(axes, ratio)
                if block == 0:
                    _name_row(row[0], method)
        figure.colorbar(
            error,
            ax=figure.axes,
            label="angular error of the normals (degrees)",
            extend="max",
            shrink=0.5,
            aspect=30,
            pad=0.01,
        )
    return figure


def relighting(comparison: Comparison, lights: Sequence[ArrayLike]) -> Figure:
    """
    Draw Figure 8: the picture of each method as the light moves, next to the truth.

    Parameters
    ----------
    comparison : Comparison
        The shape and the methods.
    lights : sequence of array_like, shape (3,)
        New lights, shown after the input's own.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page: a row for the truth and one for each method, a column for each light.

    Raises
    ------
    ToonkitError
        If a light is zero, not finite or from behind.

    Notes
    -----
    Shows the model alone, M(L' · N) of Eq. 7: with the painted detail kept, every method would repeat its input exactly.
    """
    shown = [comparison.light, *(as_light("lights", light) for light in lights)]
    rows = len(comparison.analyses) + 1
    wide = (PAGE_WIDTH - 0.35) / len(shown)
    tall = wide * proportion(comparison.image) + 0.17
    truths = [comparison.relit_truth(light) for light in shown]
    relit = [
        [relight(analysis, light, keep_detail=False) for light in shown] for analysis in comparison.analyses
    ]
    errors = [[color_rmse(ours, true) for ours, true in zip(row, truths, strict=True)] for row in relit]
    with figure_style():
        figure = new_figure(rows * tall + 0.75)
        cells = figure.subplots(rows + 1, len(shown), squeeze=False, height_ratios=[0.42] + [tall] * rows)
        for column, (axes, light) in enumerate(zip(cells[0], shown, strict=True)):
            draw_light(axes, light, comparison.color_map)
            axes.set_title(("input light\n" if column == 0 else "\n") + angles_text(light), fontsize=SMALL)
            draw_picture(cells[1, column], truths[column])
            best = min(row[column] for row in errors)
            for index, row in enumerate(relit):
                draw_picture(cells[index + 2, column], row[column])
                error = errors[index][column]
                caption(cells[index + 2, column], f"{error:.3f}", strong=f"{error:.3f}" == f"{best:.3f}")
        for axes, method in zip(
            cells[1:, 0], ["truth", *(a.method for a in comparison.analyses)], strict=True
        ):
            _name_row(axes, method)
    return figure


def _draw_truth(row: Sequence[Axes], comparison: Comparison, gray: ScalarMappable) -> None:
    strip, picture, normals, light, error = row
    alpha = comparison.image.alpha
    _draw_strip(strip, comparison.color_map)
    draw_picture(picture, comparison.image)
    draw_normal_map(normals, comparison.truth.normals, alpha=alpha)
    draw_values(light, illumination(comparison.truth.normals, comparison.light), gray, alpha=alpha)
    bare(error)
    caption(picture, "input")


def _draw_analysis(
    row: Sequence[Axes],
    analysis: ToonAnalysis,
    comparison: Comparison,
    gray: ScalarMappable,
    error: ScalarMappable,
) -> None:
    strip, picture, normals, light, wrong = row
    alpha = comparison.image.alpha
    difference = angular_error(analysis.normals, comparison.truth.normals)
    _draw_strip(strip, analysis.color_map)
    draw_picture(picture, analysis.picture)
    draw_normal_map(normals, analysis.normals, alpha=alpha)
    draw_values(light, analysis.illumination, gray, alpha=alpha)
    draw_values(wrong, difference.map, error, alpha=alpha)
    caption(picture, f"RMSE {color_rmse(analysis.picture, comparison.image):.3f}")
    caption(wrong, f"mean {difference.mean:.1f}°")


def _draw_strip(axes: Axes, color_map: ColorMap) -> None:
    draw_ramp(axes, color_map, upright=True)
    axes.set(yticks=[])


def _name_row(axes: Axes, method: str) -> None:
    axes.set_ylabel(
        METHOD_LABELS.get(method, method),
        color=METHOD_COLORS.get(method, "black"),
        fontweight="bold",
        labelpad=4.0,
    )

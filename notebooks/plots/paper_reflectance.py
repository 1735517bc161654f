"""Figures 4 and 5: how the color map is estimated, and how it constrains the illumination (Sections 3.2 and 3.3)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec, GridSpecFromSubplotSpec, SubplotSpec
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import BoolArray, FloatArray, is_number, refuse
from toonkit.estimation.preparation import prepare
from toonkit.metrics import color_rmse
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.luminance import tone
from toonkit.viz.figures.ramp import draw_ramp
from toonkit.viz.figures.style import INK, METHOD_COLORS, PAGE_WIDTH, QUIET, SMALL, figure_style, new_figure

from .panels import caption, draw_picture, draw_values, heading, illumination_scale, proportion

SCATTER_POINTS = 4000
"""Points in a scatter: enough to show its shape, few enough for a small file."""

RANKS_SHOWN = 600
BREAK = 0.03
"""Step in tone between neighbors of the shown ranks that borders two bands; a soft transition takes many small ones."""

HALO = [withStroke(linewidth=2.6, foreground="white")]
"""Around lines that cross paint of any color."""

FITTED = METHOD_COLORS["toonkit"]
SLACK = 1e-9
"""A bound is met up to rounding."""


def color_map_estimation(
    image: ToonImage, illumination: FloatArray, fitted: ColorMap, truth: ColorMap, *, seed: int = 0
) -> Figure:
    """
    Draw Figure 4: a color map from the orders of painted tones and of illumination.

    Parameters
    ----------
    image : ToonImage
        The picture c.
    illumination : ndarray, shape (H, W)
        I0 = L · N0, NaN outside the mask.
    fitted : ColorMap
        M, estimated from the two.
    truth : ColorMap
        What the picture was painted with.
    seed : int, optional
        Which pixels the scatter shows of a picture that has more than `SCATTER_POINTS`.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page.
    """
    scale = illumination_scale()
    model = ToonImage(fitted(illumination), image.mask, alpha=image.alpha)
    with figure_style():
        tall = 2.0 * proportion(image)
        figure = new_figure(2 * tall + 0.7, gap=0.05)
        grid = GridSpec(2, 3, figure)
        painted, smooth, points = (figure.add_subplot(grid[0, column]) for column in range(3))
        ranks, repeated = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 2])
        draw_picture(painted, image)
        draw_values(smooth, illumination, scale, alpha=image.alpha)
        draw_picture(repeated, model)
        caption(repeated, f"RMSE to c: {color_rmse(model, image):.3f} (sRGB, 0 to 1)")
        figure.colorbar(scale, ax=smooth, label="illumination  I₀", ticks=[-1, 0, 1], shrink=0.8, aspect=22)
        _draw_scatter(points, image, illumination, seed)
        _draw_ranks(ranks, image, illumination)
        curves = _draw_maps(figure, grid[1, 1], fitted, truth)
        for axes in (painted, smooth, repeated):
            axes.set_anchor("N")  # titles of a row on one line
        for axes, title in (
            (painted, "(a) input c"),
            (smooth, "(b) initial illumination I₀ = L · N₀"),
            (points, "(c) tone against illumination"),
            (ranks, "(d) both sorted, rank by rank"),
            (curves, "(e) color map M"),
            (repeated, "(f) model M(I₀)"),
        ):
            heading(axes, title)
    return figure


def illumination_constraints(
    image: ToonImage,
    interval: IlluminationInterval,
    initial: FloatArray,
    refined: FloatArray,
    *,
    cut: float = 0.5,
) -> Figure:
    """
    Draw Figure 5: the interval that each pixel's color allows, and the illumination before and after refinement.

    Parameters
    ----------
    image : ToonImage
        The picture.
    interval : IlluminationInterval
        Bounds of shape (H, W), NaN outside the mask.
    initial, refined : ndarray, shape (H, W)
        L · N0 and L · N, NaN outside the mask.
    cut : float, optional
        How far down the object the cut runs: 0 is its top row, 1 its bottom row.

    Returns
    -------
    matplotlib.figure.Figure
        As wide as a page.

    Raises
    ------
    ToonkitError
        If the cut does not lie in 0 to 1.
    """
    if not (is_number(cut) and 0.0 <= cut <= 1.0):
        raise refuse("cut", "must lie in 0 (the object's top) to 1 (its bottom)", cut)
    rows = np.flatnonzero(image.mask.any(axis=1))
    row = int(rows[round(cut * (len(rows) - 1))])
    scale = illumination_scale()
    tall = proportion(image) * PAGE_WIDTH / 5.4
    with figure_style():
        figure = new_figure(tall + 3.2)
        grid = GridSpec(2, 5, figure, height_ratios=[tall, 2.5])
        panels = [figure.add_subplot(grid[0, column]) for column in range(5)]
        draw_picture(panels[0], image)
        maps = (interval.lower, interval.upper, initial, refined)
        for axes, values in zip(panels[1:], maps, strict=True):
            draw_values(axes, values, scale, alpha=image.alpha)
        for axes in panels:
            axes.axhline(row, color=FITTED, linewidth=0.8)
        caption(panels[3], _share_outside(interval, initial, image.mask))
        caption(panels[4], _share_outside(interval, refined, image.mask))
        titles = (
            "(a) input c",
            "(b) lower bound Iᵢ",
            "(c) upper bound Iᵢ₊₁",
            "(d) initial L · N₀",
            "(e) refined L · N",
        )
        for axes, title in zip(panels, titles, strict=True):
            heading(axes, title)
        figure.colorbar(
            scale, ax=panels, label="illumination", ticks=[-1, 0, 1], shrink=0.8, aspect=22, pad=0.01
        )
        section = figure.add_subplot(grid[1, :])
        _draw_cut(section, image, interval, initial, refined, row)
        heading(section, "(f) along the blue line")
    return figure


def _draw_scatter(axes: Axes, image: ToonImage, illumination: FloatArray, seed: int) -> None:
    colors, values = prepare(image).paint, illumination[image.mask]
    random = np.random.default_rng(seed)
    chosen = random.choice(len(colors), min(SCATTER_POINTS, len(colors)), replace=False)
    axes.scatter(
        values[chosen],
        tone(colors[chosen]),
        c=colors[chosen],
        s=5.0,
        linewidths=0.15,
        edgecolors=[(0.2, 0.2, 0.2, 0.25)],
        rasterized=True,
    )
    axes.set(xlim=(-1, 1), ylim=(-0.02, 1.02), xlabel="illumination  I₀", ylabel="tone of c (sRGB, 0 to 1)")


def _draw_ranks(axes: Axes, image: ToonImage, illumination: FloatArray) -> None:
    """Show the sorted colors behind the sorted illumination; a band's borders on it are the bounds of its interval."""
    colors = prepare(image).paint
    tones = tone(colors)
    order = np.argsort(tones, kind="stable")
    values = np.sort(illumination[image.mask])
    share = (np.arange(len(values)) + 0.5) / len(values)
    shown = np.linspace(0, len(values) - 1, RANKS_SHOWN).astype(np.intp)
    sorted_colors = colors[order][shown]
    axes.imshow(sorted_colors[None], extent=(0.0, 1.0, -1.0, 1.0), aspect="auto", interpolation="nearest")
    for border in shown[_band_borders(tones[order][shown])]:
        at, level = share[border], values[border]
        _draw_dashes(axes, [0.0, at, at], [level, level, -1.0], linewidth=0.7)
    axes.plot(share[shown], values[shown], color=INK, linewidth=1.4, path_effects=HALO)
    axes.set(xlim=(0, 1), ylim=(-1, 1), xticks=[0, 0.5, 1], yticks=[-1, -0.5, 0, 0.5, 1])
    axes.set(xlabel="rank, dark to bright (share of pixels)", ylabel="sorted illumination  I₀")


def _band_borders(tones: FloatArray) -> NDArray[np.intp]:
    """Return the indices of sorted tones after which a band ends; the few tones between two bands are one border."""
    steps = np.flatnonzero(np.diff(tones) > BREAK)
    runs = np.split(steps, np.flatnonzero(np.diff(steps) > 2) + 1)
    return np.array([run[len(run) // 2] for run in runs if len(run)], dtype=np.intp)


def _draw_maps(figure: Figure, place: SubplotSpec, fitted: ColorMap, truth: ColorMap) -> Axes:
    """Show two maps as curves of tone, with their strips below; returns the curves' panel."""
    inner = GridSpecFromSubplotSpec(3, 1, place, height_ratios=[1.0, 0.1, 0.1], hspace=0.03)
    curves = figure.add_subplot(inner[0])
    where = np.linspace(-1.0, 1.0, 1025)
    curves.plot(where, tone(truth(where)), color=INK, linewidth=1.0, linestyle=(0, (3, 1.5)), label="true")
    curves.plot(where, tone(fitted(where)), color=FITTED, linewidth=1.5, label="estimated")
    curves.set(xlim=(-1, 1), ylim=(-0.02, 1.02), xticks=[-1, 0, 1], ylabel="tone of M (sRGB, 0 to 1)")
    curves.tick_params(labelbottom=False)
    curves.legend(loc="upper left")
    for index, (name, color_map) in enumerate((("true", truth), ("est.", fitted)), start=1):
        strip = figure.add_subplot(inner[index])
        draw_ramp(strip, color_map)
        strip.set_ylabel(name, rotation=0, ha="right", va="center", fontsize=SMALL)
        if index == 1:
            strip.tick_params(labelbottom=False)
        else:
            strip.set_xlabel("illumination  L · N")
    return curves


def _draw_cut(
    axes: Axes,
    image: ToonImage,
    interval: IlluminationInterval,
    initial: FloatArray,
    refined: FloatArray,
    row: int,
) -> None:
    columns = np.flatnonzero(image.mask[row])
    lower, upper = interval.lower[row], interval.upper[row]
    corners = [
        [
            (column - 0.5, lower[column]),
            (column + 0.5, lower[column]),
            (column + 0.5, upper[column]),
            (column - 0.5, upper[column]),
        ]
        for column in columns
    ]
    axes.add_collection(
        PolyCollection(corners, facecolors=image.color[row, columns], linewidths=0, antialiaseds=False)
    )
    for bound in (lower, upper):
        axes.step(np.arange(len(bound)), bound, where="mid", color=QUIET, linewidth=0.5)
    _draw_dashes(axes, np.arange(len(lower)), initial[row], linewidth=1.0, label="initial  L · N₀")
    axes.plot(refined[row], color=FITTED, linewidth=1.6, path_effects=HALO, label="refined  L · N")
    axes.fill_between(
        [], [], [], facecolor="0.8", edgecolor=QUIET, linewidth=0.5, label="interval of the painted color"
    )
    lowest = min(float(np.nanmin(values[row])) for values in (initial, refined))
    axes.set(
        xlim=(columns[0] - 0.5, columns[-1] + 0.5),
        ylim=(lowest - 0.15, 1.02),
        xlabel="column (pixels)",
        ylabel="illumination  L · N",
    )
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)


def _draw_dashes(axes: Axes, across: ArrayLike, up: ArrayLike, *, linewidth: float, label: str = "") -> None:
    """Draw a dashed line on a white one; as a halo of the dashes, it would have dashes of another length."""
    axes.plot(across, up, color="white", linewidth=linewidth + 1.2)
    axes.plot(across, up, color=INK, linewidth=linewidth, linestyle=(0, (4, 2)), label=label)


def _share_outside(interval: IlluminationInterval, values: FloatArray, mask: BoolArray) -> str:
    return f"{_is_outside(interval, values)[mask].mean():.0%} outside their interval"


def _is_outside(interval: IlluminationInterval, values: FloatArray) -> BoolArray:
    outside: BoolArray = (values < interval.lower - SLACK) | (values > interval.upper + SLACK)
    return outside

"""The panels of printed figures: pictures, normal maps, scalar maps, ramps, and the ball that shows a light."""

from __future__ import annotations

from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba
from matplotlib.figure import SubFigure
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import light_angles
from toonkit.model.normals import NormalField, encode_normal_map
from toonkit.model.shading import shade
from toonkit.viz.figures.style import INK, QUIET, SMALL

FREE_SHARE = 0.02
"""Of the object's longer side: what stays free around it in a panel."""

BALL_PIXELS = 160

TITLE_INDENT = 0.06
"""Inches from the left edge of a part of the page to its title."""

_ILLUMINATION_COLORS = LinearSegmentedColormap.from_list("illumination", ["#17171c", "#73737b", "#fdfdf8"])


def illumination_scale() -> ScalarMappable:
    """Return the gray scale of illumination, -1 to 1, for `draw_values` and its color bar."""
    return ScalarMappable(Normalize(-1.0, 1.0), _ILLUMINATION_COLORS)


def error_scale(limit: float) -> ScalarMappable:
    """Return a scale from 0, paper white, to a limit, dark: errors are what is printed."""
    return ScalarMappable(Normalize(0.0, limit), "magma_r")


def proportion(image: ToonImage | NormalField) -> float:
    """Return height over width of the panel that shows an object."""
    left, right, low, high = _extent(image)
    return (low - high) / (right - left)


def draw_picture(axes: Axes, image: ToonImage, *, outlined: bool = False, free: float = FREE_SHARE) -> None:
    """
    Show a picture on its figure's ground, cut to its object, without axes.

    Parameters
    ----------
    axes : Axes
        Where.
    image : ToonImage
        What.
    outlined : bool, optional
        Whether a thin line sets its object off from the page.
    free : float, optional
        What stays free around the object, as a share of its longer side.
    """
    rgba = image.to_rgba() / 255.0
    # Laid on it here and not by matplotlib, which would mix the black of transparent pixels into the outline.
    axes.imshow(rgba[..., :3] * rgba[..., 3:] + ground_color(axes) * (1.0 - rgba[..., 3:]))
    if outlined:
        axes.contour(image.alpha, levels=[0.5], colors=[QUIET], linewidths=0.4)
    left, right, low, high = _extent(image, free)
    axes.set(xlim=(left, right), ylim=(low, high))
    bare(axes)


def draw_normal_map(axes: Axes, normals: NormalField, *, alpha: ArrayLike | None = None) -> None:
    """Show normals as an OpenGL normal map; `alpha` is the coverage of shape (H, W), the mask by default."""
    draw_picture(
        axes, ToonImage(encode_normal_map(normals) / 255.0, normals.mask, alpha=cast(FloatArray, alpha))
    )


def draw_values(
    axes: Axes, values: FloatArray, scale: ScalarMappable, *, alpha: ArrayLike | None = None
) -> None:
    """
    Show a scalar per pixel.

    Parameters
    ----------
    axes : Axes
        Where.
    values : ndarray, shape (H, W)
        Values, NaN outside the object.
    scale : ScalarMappable
        Their colors, from this module; also what `Figure.colorbar` takes.
    alpha : array_like, shape (H, W), optional
        Coverage in [0, 1].
    """
    colors = np.asarray(scale.to_rgba(values))[..., :3]
    draw_picture(axes, ToonImage(colors, np.isfinite(values), alpha=cast(FloatArray, alpha)), outlined=True)


def draw_light(axes: Axes, light: FloatArray, color_map: ColorMap) -> None:
    """Show a light by a ball in its paint, and a dot where the light stands above it; the ring is the horizon."""
    normals, coverage = ball(BALL_PIXELS)
    draw_picture(axes, ToonImage(shade(normals, light, color_map).color, normals.mask, alpha=coverage))
    middle, radius = (BALL_PIXELS - 1) / 2, BALL_PIXELS / 2 - 1
    angle = np.linspace(0.0, 2 * np.pi, 181)
    axes.plot(middle + radius * np.cos(angle), middle + radius * np.sin(angle), color=INK, linewidth=0.6)
    # Rows count downward.
    axes.plot(
        middle + radius * light[0],
        middle - radius * light[1],
        marker="o",
        markersize=4.0,
        markerfacecolor="#ffd640",
        markeredgecolor=INK,
        markeredgewidth=0.6,
    )


def ball(size: int) -> tuple[NormalField, FloatArray]:
    """Return the normals of a ball that fills a picture of `size` pixels but for one, and its coverage."""
    row, column = np.indices((size, size))
    middle, radius = (size - 1) / 2, size / 2 - 1
    x, y = (column - middle) / radius, (middle - row) / radius
    distance = np.hypot(x, y)
    vectors = np.stack([x, y, np.sqrt(np.maximum(1.0 - distance**2, 0.0))], axis=-1)
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    coverage = np.clip((1.0 - distance) * radius + 0.5, 0.0, 1.0)
    return NormalField(vectors, coverage >= 0.5), coverage


def ground_color(axes: Axes) -> FloatArray:
    """Return the color of the page, or of the part of it, that a panel stands on: sRGB, shape (3,)."""
    part, page = axes.figure, axes.figure.figure
    red, green, blue, alpha = to_rgba(part.get_facecolor())
    return np.array([red, green, blue] if alpha > 0 else to_rgba(page.get_facecolor())[:3])


def bare(axes: Axes) -> None:
    """Take everything from around a panel but its title and the labels that serve as captions."""
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.patch.set_visible(False)


def fill(axes: Axes, ratio: float) -> None:
    """Give a panel a height of `ratio` times its width, whatever it shows, so that it lines up with its neighbors."""
    axes.set_box_aspect(ratio)
    if axes.get_aspect() == "auto":
        return
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    wide, tall = right - left, low - high
    across, down = max(tall / ratio - wide, 0.0) / 2, max(wide * ratio - tall, 0.0) / 2
    axes.set(xlim=(left - across, right + across), ylim=(low + down, high - down))


def caption(axes: Axes, text: str, *, strong: bool = False) -> None:
    """Write a line below a panel."""
    axes.set_xlabel(text, fontsize=SMALL, fontweight="bold" if strong else "normal", labelpad=2.0)


def heading(axes: Axes, text: str) -> None:
    """Write a panel's letter and title above it, from its left edge."""
    axes.set_title(text, loc="left")


def part_title(part: SubFigure, text: str) -> None:
    """Write the letter and the title of a part of the page, from the same distance of its left edge whatever its width."""
    inches = part.bbox.width / part.dpi
    part.suptitle(text, x=TITLE_INDENT / inches, ha="left", fontsize="medium")


def angles_text(light: FloatArray) -> str:
    """Return a light as its azimuth and elevation in whole degrees."""
    azimuth, elevation = light_angles(light)
    return f"{round(azimuth) % 360}°, {round(elevation)}°"


def _extent(image: ToonImage | NormalField, share: float = FREE_SHARE) -> tuple[float, float, float, float]:
    """Left, right, lower and upper edge of the object's panel, in pixels; rows count downward, so lower > upper."""
    rows, columns = np.nonzero(image.mask)
    free = 0.5 + share * max(np.ptp(rows) + 1, np.ptp(columns) + 1)
    return columns.min() - free, columns.max() + free, rows.max() + free, rows.min() - free

"""Arrays to HoloViews elements: pictures, normal maps, materials and the fits of their color maps, errors."""

from __future__ import annotations

from typing import Any

import holoviews as hv
import holoviews.plotting.bokeh
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from toonkit._validation import FloatArray, as_array, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.color_map_fit import allowed_interval
from toonkit.estimation.shading_ratio import PaintedMaterial
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.luminance import hex_color, tone
from toonkit.model.normals import NormalField, encode_normal_map

BACKEND = "bokeh"  # the import of its module above registers it, without a notebook's hv.extension

SCATTER_PIXELS = 2500
"""Points in the scatter of a fit: enough to show its shape, few enough to send in a moment."""

INTERVAL_BARS = 28
"""Colors whose interval of illumination is drawn."""

DIMMED = 0.15
"""How much is left, beside `NEUTRAL`, of the colors that are not of the material that is shown."""

LONGEST_SIDE = 480
"""Pixels of a material's picture: no more than it has on screen."""

NEUTRAL = "#7b7c81"
"""Background on which both the darkest and the brightest paint can be seen, whatever the page's theme."""

FRAME = (-1.03, -0.15, 1.03, 1.03)
"""Illumination and tone at the lower left and the upper right of a fit's plot."""

STRIP = (-0.13, -0.03)
"""Tones between which the color-map strip lies: below the plot's content."""


def picture(image: ToonImage) -> hv.RGB:
    """
    Return a cartoon picture, transparent outside the object.

    Parameters
    ----------
    image : ToonImage
        The picture, (H, W).

    Returns
    -------
    holoviews.RGB
        Square pixels, no axes; coordinates are columns from the left and rows from the bottom.
    """
    return _rgb(image.to_rgba())


def normal_map(normals: NormalField) -> hv.RGB:
    """
    Return the OpenGL normal map (red right, green up, blue toward the viewer), transparent outside the object.

    Parameters
    ----------
    normals : NormalField
        The normals, (H, W).

    Returns
    -------
    holoviews.RGB
        Square pixels, no axes.
    """
    coverage = np.where(normals.mask, 255, 0).astype(np.uint8)
    return _rgb(np.dstack([encode_normal_map(normals), coverage]))


def material_place(analysis: ToonAnalysis, material: int) -> hv.RGB:
    """
    Show where a material is: the drawing, all but gray except there.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    material : int
        Its number in `analysis.materials`.

    Returns
    -------
    holoviews.RGB
        Square pixels, no axes; a large drawing is reduced to at most `LONGEST_SIDE` pixels.

    Raises
    ------
    ToonkitError
        If there is no such material.
    """
    _check_material(analysis, material)
    pixels = analysis.image.to_rgba()
    elsewhere = analysis.materials.labels != material
    gray = np.array([int(NEUTRAL[k : k + 2], 16) for k in (1, 3, 5)])
    pixels[elsewhere, :3] = np.round(DIMMED * pixels[elsewhere, :3] + (1 - DIMMED) * gray)
    small = Image.fromarray(pixels).reduce(-(-max(pixels.shape) // LONGEST_SIDE))
    return _rgb(np.asarray(small))


def color_map_fit(analysis: ToonAnalysis, *, material: int = 0, seed: int = 0) -> hv.Overlay:
    """
    Show how painted tones became a color map.

    Each point is a pixel of the material in the color of its paint, at the illumination of the *initial* normals. The curve
    is the fitted map M; a bar spans the illumination that M allows one painted color; the strip below is M itself. A flat
    material has no bars, for its colors allow any illumination.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    material : int, optional
        Number of a material in `analysis.materials`.
    seed : int, optional
        Which pixels are shown of a material that has more than `SCATTER_PIXELS`.

    Returns
    -------
    holoviews.Overlay
        Tone (0 to 1) over illumination (-1 to 1).

    Raises
    ------
    ToonkitError
        If there is no such material.
    """
    _check_material(analysis, material)
    painted = analysis.drawing.painted_materials[material]
    color_map = analysis.materials.color_maps[material]
    color = analysis.drawing.paint[painted.pixels]
    chosen = _sample(len(color), SCATTER_PIXELS, seed)
    points = hv.Points(
        (
            (analysis.initial_normals.compact[painted.pixels] @ analysis.light)[chosen],
            tone(color[chosen]),
            _hex(color[chosen]),
        ),
        kdims=["illumination", "tone"],
        vdims=["color"],
    ).opts(color="color", size=4, alpha=0.75, line_color=None, backend=BACKEND)
    bars = _bars(painted, color, color_map)
    overlay = _backdrop() * _strip(color_map) * points * bars * _curve(color_map)
    return overlay.opts(
        xlabel="illumination  L · N",
        ylabel="tone  (black 0, white 1)",
        xlim=FRAME[::2],
        ylim=FRAME[1::2],
        show_legend=False,
        responsive=True,
        toolbar=None,
        default_tools=[],
        backend=BACKEND,
    )


def error_map(error: ArrayLike, *, label: str, unit: str, limit: float | None = None) -> hv.Image:
    """
    Return a map of per-pixel errors with a color bar.

    Parameters
    ----------
    error : array_like, shape (H, W)
        Errors >= 0; NaN outside the object.
    label : str
        What the error is of, for instance "normals".
    unit : str
        Its unit, for instance "degrees".
    limit : float, optional
        Error at the end of the color bar; the largest one if not given.

    Returns
    -------
    holoviews.Image
        Square pixels, no axes.

    Raises
    ------
    ToonkitError
        If the error is not a (H, W) array with at least one number, or the limit is not positive.
    """
    values = as_array("error", error, (None, None))
    if not np.isfinite(values).any():
        raise refuse("error", "must hold at least one number", "NaN only")
    if limit is not None and not limit > 0:
        raise refuse("limit", "must be positive", limit)
    height, width = values.shape
    top = limit if limit is not None else max(float(np.nanmax(values)), np.finfo(float).tiny)
    dimension = hv.Dimension("error", label=f"{label} error", unit=unit)
    element = hv.Image(values, bounds=(0, 0, width, height), vdims=[dimension])
    return element.opts(
        **_PICTURE, cmap="inferno", clim=(0.0, top), colorbar=True, tools=["hover"], backend=BACKEND
    )


def _unframe(plot: Any, _: hv.Element) -> None:
    """Leave no frame for a page's theme to bring back: it sees the color alone."""
    plot.state.outline_line_color = None


_PICTURE: dict[str, Any] = {
    "xaxis": None,
    "yaxis": None,
    "data_aspect": 1,
    "responsive": True,
    "toolbar": None,
    "default_tools": [],
    "hooks": [_unframe],
}
"""How a picture looks: square pixels and nothing around it. (`data_aspect`: `aspect="equal"` stretches.)"""


def _rgb(pixels: NDArray[np.uint8]) -> hv.RGB:
    height, width = pixels.shape[:2]
    element = hv.RGB(pixels, bounds=(0, 0, width, height), vdims=["R", "G", "B", "A"])
    return element.opts(**_PICTURE, backend=BACKEND)


def _backdrop() -> hv.Rectangles:
    """Neutral ground as an element: a page's theme repaints a plot's own background."""
    ground = hv.Rectangles([FRAME], kdims=["illumination", "tone", "illumination_end", "tone_end"])
    return ground.opts(color=NEUTRAL, line_color=None, backend=BACKEND)


def _strip(color_map: ColorMap) -> hv.RGB:
    samples = color_map(np.linspace(-1.0, 1.0, 512))[None]
    return hv.RGB(samples, bounds=(-1.0, STRIP[0], 1.0, STRIP[1]), kdims=["illumination", "tone"])


def _curve(color_map: ColorMap) -> hv.Overlay:
    """Return the ramp as a line, lighter around than inside, to be seen on any color."""
    where = np.linspace(-1.0, 1.0, 513)
    curve = hv.Curve((where, tone(color_map(where))), "illumination", "tone")
    halo = curve.opts(color="white", line_width=5, alpha=0.9, backend=BACKEND)
    return halo * curve.clone().opts(color="#1d1d1f", line_width=2.2, backend=BACKEND)


def _bars(painted: PaintedMaterial, color: FloatArray, color_map: ColorMap) -> hv.Segments:
    """Return intervals of illumination of some painted colors (p, 3), evenly spread over the tones."""
    chosen, lower, upper = np.zeros(0, np.intp), np.zeros(0), np.zeros(0)
    tones = tone(color)
    if painted.tones is not None:
        order = np.argsort(tones, kind="stable")
        chosen = order[np.linspace(0, len(order) - 1, INTERVAL_BARS).astype(np.intp)]
        _, first, count = np.unique(np.round(tones[chosen], 2), return_index=True, return_counts=True)
        chosen = chosen[first + count // 2]  # the middle pixel of each tone, not one at the edge of its band
        allowed = allowed_interval(painted.tones, color_map)
        lower, upper = allowed.lower[chosen], allowed.upper[chosen]
    bars = hv.Segments(
        (lower, tones[chosen], upper, tones[chosen], _hex(color[chosen])),
        kdims=["illumination", "tone", "illumination_end", "tone_end"],
        vdims=["color"],
    )
    return bars.opts(color="color", line_width=16, alpha=0.65, backend=BACKEND)


def _check_material(analysis: ToonAnalysis, material: int) -> None:
    count = analysis.materials.count
    if not 0 <= material < count:
        raise refuse("material", f"must be the number of one of {count} materials", material)


def _sample(count: int, wanted: int, seed: int) -> NDArray[np.intp]:
    if count <= wanted:
        return np.arange(count)
    return np.sort(np.random.default_rng(seed).choice(count, wanted, replace=False))


def _hex(color: FloatArray) -> list[str]:
    return [hex_color(one) for one in color]

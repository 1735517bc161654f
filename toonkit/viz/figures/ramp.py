"""A color map as a strip beside a chart."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from toonkit.model.color_map import ColorMap


def draw_ramp(axes: Axes, color_map: ColorMap, *, upright: bool = False) -> None:
    """Show a color map as a strip over illumination -1 to 1; upright, it goes from dark below to bright above."""
    samples = color_map(np.linspace(-1.0, 1.0, 512))
    if upright:
        axes.imshow(samples[:, None], extent=(0.0, 1.0, -1.0, 1.0), aspect="auto", origin="lower")
        axes.set(xticks=[], yticks=[-1, 0, 1])
    else:
        axes.imshow(samples[None], extent=(-1.0, 1.0, 0.0, 1.0), aspect="auto")
        axes.set(xticks=[-1, 0, 1], yticks=[])
        first, _, last = axes.get_xticklabels()
        first.set_horizontalalignment("left")  # within the strip's own width: strips stand close
        last.set_horizontalalignment("right")
    axes.spines[:].set_visible(True)
    axes.spines[:].set_linewidth(0.4)

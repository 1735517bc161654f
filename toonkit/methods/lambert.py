"""Baseline: luminance taken for illumination (the Lambert assumption, Sections 3.3 and 4.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.refinement import refine_as_printed
from toonkit.methods.steps import StepProgress, inflate_drawing
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.luminance import luminance

SMOOTHNESS = 1.0
"""The paper's small lambda for this baseline (Section 4.2)."""


def lambert(
    drawing: ToonImage | PreparedDrawing,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Analyze a picture as if its luminance were the illumination.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing.
    light : array_like, shape (3,) or (2,)
        Direction from the surface to the light, or its azimuth and elevation in degrees.
    previous : ToonAnalysis, optional
        Not used: this method starts from N0.
    progress : callable, optional
        Called with (step, fraction done).

    Returns
    -------
    ToonAnalysis
        Normals of Eq. 3 with lambda = 1, from N0; the color map is estimated on them.

    Raises
    ------
    ToonkitError
        If the light is refused.

    Notes
    -----
    The target of Eq. 3 is the picture's own luminance, stretched linearly to the range of illumination of N0.

    References
    ----------
    T.-P. Wu, J. Sun, C.-K. Tang, H.-Y. Shum, "Interactive normal reconstruction from a single image", ACM Trans. Graph.
    27(5), 2008.
    """
    del previous
    steps = inflate_drawing(drawing, light, progress)
    target = _stretched_luminance(luminance(steps.drawing.paint), steps.initial_illumination)
    energy = steps.printed_energy(IlluminationInterval(target, target), rho=1.0, smoothness=SMOOTHNESS)
    refinement = refine_as_printed(energy, steps.drawing.mask, progress=steps.refining)
    return steps.finish("lambert", refinement)


def _stretched_luminance(shades: FloatArray, illumination: FloatArray) -> FloatArray:
    """Map luminances (P,) linearly so that their extremes meet those of the illumination."""
    dark, bright = shades.min(), shades.max()
    low, high = illumination.min(), illumination.max()
    if bright - dark < 1e-9:
        return np.full(shades.shape, (low + high) / 2)
    stretched: FloatArray = low + (shades - dark) * ((high - low) / (bright - dark))
    return stretched

"""Baseline: luminance taken for illumination (the Lambert assumption, Sections 3.3 and 4.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.reading import reading
from toonkit.estimation.refinement import refine_as_printed
from toonkit.methods.steps import StepProgress, inflated
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.luminance import luminance

SMOOTHNESS = 1.0
"""The paper's small lambda for this baseline (Section 4.2)."""


def lambert(image: ToonImage, light: ArrayLike, *, progress: StepProgress | None = None) -> ToonAnalysis:
    """
    Analyze a picture as if its luminance were the illumination.

    Parameters
    ----------
    image : ToonImage
        The picture.
    light : array_like, shape (3,)
        Direction from the surface to the light.
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
    steps = inflated(image, light, progress)
    target = reading(image).grid.scatter(_stretched_luminance(image, steps.initial_illumination[image.mask]))
    refinement = refine_as_printed(
        steps.initial_normals,
        steps.light,
        IlluminationInterval(target, target),
        rho=1.0,
        smoothness=SMOOTHNESS,
        progress=steps.refining,
    )
    return steps.finished("lambert", refinement)


def _stretched_luminance(image: ToonImage, illumination: FloatArray) -> FloatArray:
    """Luminance (P,) of the paint, mapped so that its extremes meet those of the illumination."""
    shades = luminance(reading(image).paint)
    dark, bright = shades.min(), shades.max()
    low, high = illumination.min(), illumination.max()
    if bright - dark < 1e-9:
        return np.full(shades.shape, (low + high) / 2)
    stretched: FloatArray = low + (shades - dark) * ((high - low) / (bright - dark))
    return stretched

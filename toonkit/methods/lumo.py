"""Baseline: the inflated normals as they are (Lumo, Sections 3.1 and 4.2)."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit.analysis import ToonAnalysis
from toonkit.estimation.refinement import Refinement
from toonkit.methods.steps import StepProgress, inflated
from toonkit.model.image import ToonImage
from toonkit.numerics.report import NOT_REFINED


def lumo(image: ToonImage, light: ArrayLike, *, progress: StepProgress | None = None) -> ToonAnalysis:
    """
    Analyze a picture with the inflated normals alone; the color map is estimated on them.

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
        Its normals are the initial normals.

    Raises
    ------
    ToonkitError
        If the light is refused.

    References
    ----------
    S. F. Johnston, "Lumo: illumination for cel animation", NPAR 2002, doi:10.1145/508530.508538
    """
    steps = inflated(image, light, progress)
    return steps.finished("lumo", Refinement(steps.initial_normals, NOT_REFINED))

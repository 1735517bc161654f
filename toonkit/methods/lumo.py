"""Baseline: the inflated normals as they are (Lumo, Sections 3.1 and 4.2)."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit.analysis import ToonAnalysis
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.refinement import Refinement
from toonkit.methods.steps import StepProgress, inflate_drawing
from toonkit.model.image import ToonImage
from toonkit.numerics.report import NOT_REFINED


def lumo(
    drawing: ToonImage | PreparedDrawing,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Analyze a picture with the inflated normals alone; the color map is estimated on them.

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
        Its normals are the initial normals.

    Raises
    ------
    ToonkitError
        If the light is refused.

    References
    ----------
    S. F. Johnston, "Lumo: illumination for cel animation", NPAR 2002, doi:10.1145/508530.508538
    """
    del previous
    steps = inflate_drawing(drawing, light, progress)
    return steps.finish("lumo", Refinement(steps.initial_normals, NOT_REFINED))

"""The paper, step by step (Sections 3.1 to 3.3), kept faithful for ever."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit.analysis import ToonAnalysis
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.refinement import refine_as_printed
from toonkit.methods.steps import StepProgress, inflate_drawing
from toonkit.model.image import ToonImage

RHO, LAMBDA = 20.0, 30.0
"""The paper's weights of Eq. 5, per pixel."""


def todo(
    drawing: ToonImage | PreparedDrawing,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Analyze a picture by the method of Todo and Yamaguchi.

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
        Normals that minimize Eq. 5 from N0; the color map is estimated on them.

    Raises
    ------
    ToonkitError
        If the light is refused.

    References
    ----------
    H. Todo, Y. Yamaguchi, "Reflectance and Shape Estimation for Cartoon Shaded Objects", Pacific Graphics
    Short Papers, 2016.
    """
    del previous
    steps = inflate_drawing(drawing, light, progress)
    allowed, _ = steps.fit_intervals(steps.initial_normals)
    energy = steps.printed_energy(allowed, rho=RHO, smoothness=LAMBDA)
    refinement = refine_as_printed(energy, steps.drawing.mask, progress=steps.refining)
    return steps.finish("todo", refinement)

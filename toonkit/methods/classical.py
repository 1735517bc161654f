"""Our method without what was learned: the paper's steps with a smooth change of the normals and an integrable result."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit.analysis import ToonAnalysis
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.methods.steps import StepProgress, inflate_drawing
from toonkit.model.image import ToonImage


def classical(
    drawing: ToonImage | PreparedDrawing,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Analyze a picture: inflate, fit the color map, refine the change of the normals coarse to fine.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing.
    light : array_like, shape (3,) or (2,)
        Direction from the surface to the light, or its azimuth and elevation in degrees.
    previous : ToonAnalysis, optional
        An analysis of the same drawing under a nearby light: the refinement starts from its normals.
    progress : callable, optional
        Called with (step, fraction done).

    Returns
    -------
    ToonAnalysis
        Refined normals and the color map estimated on them.

    Raises
    ------
    ToonkitError
        If the light is refused.

    Notes
    -----
    Where the paper smooths the normals (Eq. 5), which pulls a round shape flat, this smooths their change from N0, and adds
    the integrability that normals of a surface have; see `toonkit.estimation.energy.ChangeEnergy`.
    """
    steps = inflate_drawing(drawing, light, progress)
    return steps.finish("classical", steps.refine(steps.drawing.inflated_normals, previous))

"""Our method, the default: `classical`, started from a shape that was learned."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit.analysis import ToonAnalysis
from toonkit.estimation.energy import RefinementOptions
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.shape_prior import correct_shape
from toonkit.methods.steps import INFLATED, StepProgress, inflate_drawing
from toonkit.model.image import ToonImage

OPTIONS = RefinementOptions(change_reach=0.05, tolerance=0.1)
"""A learned shape is right in more places than an inflated one, so a change stays nearer to the colors that ask for it; and
further cycles change normals far less than their error."""


def toonkit(
    drawing: ToonImage | PreparedDrawing,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Analyze a picture: inflate, correct the shape as learned, fit the color map, refine the change coarse to fine.

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
    The network of `toonkit.estimation.shape_prior` brings the shape, the energy of `toonkit.estimation.energy` brings the
    picture back: neither does as well alone.
    """
    steps = inflate_drawing(drawing, light, progress)
    if progress is not None:
        progress("correcting the shape", INFLATED / 2)
    refinement = steps.refine(
        correct_shape(steps.drawing, steps.light, steps.drawing.inflated_normals), previous, OPTIONS
    )
    return steps.finish("toonkit", refinement)

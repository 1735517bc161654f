"""Our method, the default: `classical`, started from a shape that was learned."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit.analysis import ToonAnalysis
from toonkit.estimation.refinement import RefinementOptions
from toonkit.estimation.shape_prior import correct_shape
from toonkit.methods.steps import INFLATED, StepProgress, inflated
from toonkit.model.image import ToonImage

OPTIONS = RefinementOptions(change_reach=0.05, tolerance=0.1)
"""A learned shape is right in more places than an inflated one: what the colors ask of it stays nearer to where they do, and
the last hundredths of the energy turn no normal by anything near what it errs."""


def toonkit(
    image: ToonImage,
    light: ArrayLike,
    *,
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Analyze a picture: inflate, correct the shape as learned, fit the color map, refine the change coarse to fine.

    Parameters
    ----------
    image : ToonImage
        The picture.
    light : array_like, shape (3,)
        Direction from the surface to the light.
    previous : ToonAnalysis, optional
        An analysis of the same picture, under a light nearby: its normals are where the refinement starts.
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
    steps = inflated(image, light, progress)
    if progress is not None:
        progress("correcting the shape", INFLATED / 2)
    corrected = correct_shape(image, steps.light, steps.initial_normals)
    return steps.finished("toonkit", steps.refined(corrected, previous, OPTIONS))

"""Whole estimators: one call signature, one registry."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Protocol

from numpy.typing import ArrayLike

from toonkit._validation import of_type, refuse, same_mask
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.light_fit import estimate_light
from toonkit.methods.classical import classical
from toonkit.methods.first_use import share_compiling
from toonkit.methods.lambert import lambert
from toonkit.methods.lumo import lumo
from toonkit.methods.steps import StepProgress
from toonkit.methods.todo import todo
from toonkit.methods.toonkit import toonkit
from toonkit.model.image import ToonImage
from toonkit.numerics.bands import single_threaded_blas


class Method(Protocol):
    """An estimator: a picture and its light to an analysis."""

    def __call__(
        self, image: ToonImage, light: ArrayLike, *, progress: StepProgress | None = None
    ) -> ToonAnalysis:
        """
        Analyze `image` lit from `light`, telling `progress` the step and the fraction done.

        One that can start from an earlier analysis takes it as another keyword, `previous`.
        """
        ...


METHODS: dict[str, Method] = {
    "toonkit": toonkit,
    "classical": classical,
    "todo": todo,
    "lumo": lumo,
    "lambert": lambert,
}
"""Name -> estimator. Adding one is `METHODS["name"] = function`."""

REFINING = (toonkit, classical)
"""Estimators that run the loops which a second process compiles ahead."""


def compile_ahead(method: str) -> None:
    """Have a second process compile what a method needs last, on a machine that has not: the earlier, the better."""
    if METHODS[method] in REFINING:
        share_compiling()


def analyze(
    image: ToonImage,
    light: ArrayLike | None = None,
    *,
    method: str = "toonkit",
    previous: ToonAnalysis | None = None,
    progress: StepProgress | None = None,
) -> ToonAnalysis:
    """
    Take a cartoon-shaded picture apart into normals and a color map.

    Parameters
    ----------
    image : ToonImage
        The picture.
    light : array_like, shape (3,), optional
        Direction from the surface to the light that the artist had in mind; estimated if not given.
    method : str, optional
        Name of an estimator in `METHODS`.
    previous : ToonAnalysis, optional
        An analysis of the same mask, under a light nearby: methods that start from it, `toonkit` and `classical`, answer
        sooner.
    progress : callable, optional
        Called with the name of the running step and the fraction of the whole done, 0 to 1. What it raises cancels.

    Returns
    -------
    ToonAnalysis
        Normals, color map, light and how the refinement went.

    Raises
    ------
    ToonkitError
        If the method is unknown, the image is not a `ToonImage`, the light is refused, or the previous analysis is of
        another mask.

    Examples
    --------
    >>> import numpy as np
    >>> import toonkit
    >>> y, x = np.mgrid[:64, :64] - 32.0
    >>> mask = x**2 + y**2 < 900
    >>> color = np.where((x - y)[..., None] > 0, [0.9, 0.8, 0.6], [0.4, 0.2, 0.5])
    >>> analysis = toonkit.analyze(toonkit.ToonImage(color, mask), toonkit.light_direction(45, 40))
    >>> analysis.color_map([-0.5, 0.9]).round(2).tolist()
    [[0.4, 0.2, 0.5], [0.9, 0.8, 0.6]]
    """
    if method not in METHODS:
        raise refuse("method", f"must be one of {', '.join(METHODS)}", repr(method))
    of_type("image", image, ToonImage)
    estimator: Callable[..., ToonAnalysis] = METHODS[method]
    if previous is not None:
        of_type("previous", previous, ToonAnalysis)
        same_mask("previous", previous.image.mask, image.mask, "the picture")
        if "previous" in inspect.signature(estimator).parameters:
            estimator = functools.partial(estimator, previous=previous)
    compile_ahead(method)
    with single_threaded_blas():
        direction = estimate_light(image).light if light is None else light
        return estimator(image, direction, progress=progress)

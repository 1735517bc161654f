"""What all methods share: the first step, and the last, which re-estimates the color map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_light, of_type
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.color_map_fit import allowed_interval, painted_interval, rank_matched
from toonkit.estimation.energy import ShadingTerm
from toonkit.estimation.reading import reading
from toonkit.estimation.refinement import Refinement, RefinementOptions, refine_traced
from toonkit.methods.first_use import finish_compiling
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.model.shading import illumination

StepProgress = Callable[[str, float], None]
"""Called with the name of the running step and the fraction of the whole done, 0 to 1; what it raises cancels."""

INFLATED, FITTED = 0.2, 0.3
"""Fractions of the whole done once the shape is inflated and the color map fitted, for the progress bar."""


@dataclass(frozen=True, eq=False)
class Inflated:
    """
    Section 3.1 carried out, whatever follows.

    Attributes
    ----------
    image : ToonImage
        The picture.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    initial_normals : NormalField
        N0.
    progress : callable or None
        Called as work goes on.
    """

    image: ToonImage
    light: FloatArray
    initial_normals: NormalField
    progress: StepProgress | None

    @property
    def initial_illumination(self) -> FloatArray:
        """I0 = L · N0, shape (H, W)."""
        return illumination(self.initial_normals, self.light)

    def fitted_interval(self, normals: NormalField | None = None) -> IlluminationInterval:
        """Fit the color map to N0, or to better normals (Section 3.2); return the illumination it allows, (H, W)."""
        allowed, _ = self._allowed(self.initial_normals if normals is None else normals)
        grid = reading(self.image).grid
        return IlluminationInterval(grid.scatter(allowed.lower), grid.scatter(allowed.upper))

    def refined(
        self, normals: NormalField, previous: ToonAnalysis | None, options: RefinementOptions | None = None
    ) -> Refinement:
        """Fit the color map to normals and refine them (Sections 3.2 and 3.3), from an earlier answer if there is one."""
        finish_compiling()
        read = reading(self.image)
        allowed, painted = self._allowed(normals)
        return refine_traced(
            read.silhouette,
            normals,
            ShadingTerm(self.light, allowed.lower, allowed.upper),
            grid=read.grid,
            painted=painted,
            options=options,
            guess=None if previous is None else previous.normals,
            progress=self.refining,
        )

    def _allowed(self, normals: NormalField) -> tuple[IlluminationInterval, IlluminationInterval]:
        """Return what the color map fitted to normals allows each pixel (P,), and what it would if none were mixed."""
        if self.progress is not None:
            self.progress("fitting the color map", INFLATED)
        tones, color_map = reading(self.image).tones, self._fitted(normals)
        allowed = allowed_interval(tones, color_map)
        return allowed, painted_interval(tones, color_map, allowed)

    def _fitted(self, normals: NormalField) -> ColorMap:
        lit = np.clip(normals.compact @ self.light, -1.0, 1.0)
        return rank_matched(reading(self.image).tones, lit)

    def refining(self, fraction: float) -> None:
        """Report how far the refinement is, 0 to 1."""
        if self.progress is not None:
            self.progress("refining the normals", FITTED + (1 - FITTED) * fraction)

    def finished(self, method: str, refinement: Refinement) -> ToonAnalysis:
        """Re-estimate the color map on the refined normals (every method does) and hand everything over."""
        color_map = self._fitted(refinement.normals)
        if self.progress is not None:
            self.progress("done", 1.0)
        return ToonAnalysis(
            image=self.image,
            method=method,
            light=self.light,
            normals=refinement.normals,
            initial_normals=self.initial_normals,
            color_map=color_map,
            report=refinement.report,
        )


def inflated(image: ToonImage, light: ArrayLike, progress: StepProgress | None) -> Inflated:
    """Inflate the silhouette (Section 3.1) for a picture and its light."""
    of_type("image", image, ToonImage)
    direction = as_light("light", light)
    if progress is not None:
        progress("inflating the silhouette", 0.0)
    return Inflated(image, direction, reading(image).initial_normals, progress)

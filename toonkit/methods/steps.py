"""What all methods share: the first step, and the last, which re-estimates the color map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.color_map_fit import allowed_intervals, fit_materials, painted_intervals
from toonkit.estimation.energy import RefinementOptions, printed_energy
from toonkit.estimation.packing import round_normals
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.refinement import Refinement, build_energies, refine_islands
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.light import direction_of
from toonkit.model.normals import NormalField
from toonkit.numerics.smoothness_energy import SmoothnessEnergy

StepProgress = Callable[[str, float], None]
"""Called with the name of the running step and the fraction of the whole done, 0 to 1; what it raises cancels."""

INFLATED, FITTED = 0.2, 0.3
"""Fractions of the whole done once the shape is inflated and the color map fitted, for the progress bar."""


@dataclass(frozen=True, eq=False)
class Steps:
    """
    Section 3.1 carried out, whatever follows.

    Attributes
    ----------
    drawing : PreparedDrawing
        The drawing.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    initial_normals : NormalField
        N0.
    progress : callable or None
        Called as work goes on.
    """

    drawing: PreparedDrawing
    light: FloatArray
    initial_normals: NormalField
    progress: StepProgress | None

    @property
    def initial_illumination(self) -> FloatArray:
        """I0 = L · N0 of the object's pixels, shape (P,)."""
        return self._illumination(self.initial_normals)

    def fit_intervals(self, normals: NormalField) -> tuple[IlluminationInterval, IlluminationInterval]:
        """Fit the color maps to normals; return the intervals (P,) they allow, and those without mixed pixels' own range."""
        if self.progress is not None:
            self.progress("fitting the color maps", INFLATED)
        color_maps = self._fit(normals)
        allowed = allowed_intervals(self.drawing, color_maps)
        return allowed, painted_intervals(self.drawing, color_maps, allowed)

    def printed_energy(
        self, allowed: IlluminationInterval, *, rho: float, smoothness: float
    ) -> SmoothnessEnergy:
        """Build Eq. 5 from N0 for intervals (P,) of illumination; see `toonkit.estimation.energy.printed_energy`."""
        return printed_energy(
            self.drawing.grid,
            self.initial_normals.compact,
            self.light,
            allowed,
            rho=rho,
            smoothness=smoothness,
        )

    def refine(
        self, normals: NormalField, previous: ToonAnalysis | None, options: RefinementOptions | None = None
    ) -> Refinement:
        """
        Fit the color maps to normals and refine the normals (Sections 3.2 and 3.3), from an earlier result if there is one.

        A person's corrections of the shape are applied to the normals first.
        """
        weights = RefinementOptions() if options is None else options
        corrected, hold = self.drawing.corrected(normals), None
        if corrected is not None:
            normals, hold = NormalField.of_pixels(corrected.vectors, normals.mask), corrected.hold
        islands = self.drawing.posed(self.light).islands
        allowed, painted = self.fit_intervals(normals)
        energies = build_energies(islands, normals, self.light, allowed, weights, painted=painted, hold=hold)
        del allowed, painted, normals, corrected, hold  # the solver needs the memory
        return refine_islands(
            islands,
            energies,
            self.drawing.mask,
            weights,
            guess=None if previous is None else previous.normals,
            progress=self.refining,
        )

    def refining(self, fraction: float) -> None:
        """Report how far the refinement is, 0 to 1."""
        if self.progress is not None:
            self.progress("refining the normals", FITTED + (1 - FITTED) * fraction)

    def finish(self, method: str, refinement: Refinement) -> ToonAnalysis:
        """
        Re-estimate the color maps on the refined normals (every method does) and hand everything over.

        The normals are rounded as archives hold them, so that a saved analysis relights to the same picture.
        """
        normals = NormalField.of_pixels(round_normals(refinement.normals.compact), self.drawing.mask)
        materials = replace(self.drawing.materials, color_maps=self._fit(normals))
        if self.progress is not None:
            self.progress("done", 1.0)
        return ToonAnalysis(
            image=self.drawing.image,
            method=method,
            light=self.light,
            normals=normals,
            initial_normals=self.initial_normals,
            materials=materials,
            report=refinement.report,
            drawing=self.drawing,
        )

    def _fit(self, normals: NormalField) -> tuple[ColorMap, ...]:
        return fit_materials(self.drawing, self._illumination(normals))

    def _illumination(self, normals: NormalField) -> FloatArray:
        return np.clip(normals.compact @ self.light, -1.0, 1.0)


def inflate_drawing(
    drawing: ToonImage | PreparedDrawing, light: ArrayLike, progress: StepProgress | None
) -> Steps:
    """Inflate the silhouette (Section 3.1) of a drawing, for its light."""
    prepared = prepare(drawing)
    direction = direction_of("light", light)
    if progress is not None:
        progress("inflating the silhouette", 0.0)
    return Steps(prepared, direction, prepared.initial_normals, progress)

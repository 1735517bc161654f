"""ToonAnalysis: what every method returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import Literal

import numpy as np

from toonkit._validation import FloatArray, check_unit_light, of_type, refuse, same_mask
from toonkit.estimation.color_map_fit import allowed_intervals
from toonkit.estimation.light_fit import LightEstimate
from toonkit.estimation.preparation import PreparedDrawing, prepare
from toonkit.illustration.palette import Palette, find_palette
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.description import describe_object
from toonkit.model.image import ToonImage
from toonkit.model.light import describe_light
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.model.shading import illumination
from toonkit.numerics.masked_grid import IndexArray
from toonkit.numerics.report import NOT_REFINED, SolverReport

LightSource = Literal["given", "estimated", "assumed"]

TEXTURE = 0.15
"""Color difference, in sRGB, up to which what the model leaves unexplained is texture, which base colors keep."""

SHINE = 0.1
"""Share of a material's pixels that are brighter than its base color: a rim or a shine, and not what it is painted with."""


@dataclass(frozen=True, eq=False)
class ToonAnalysis:
    """
    A picture taken apart into a light, normals, and materials with a color map each: c = M(L · N), under its ink.

    Attributes
    ----------
    image : ToonImage
        The picture; given as one that is prepared, it stands for `drawing` as well.
    method : str
        Name of the estimator in `toonkit.METHODS`.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    normals : NormalField
        Refined normals N.
    initial_normals : NormalField
        Inflated normals N0.
    materials : Materials
        Which pixels are painted with which color map M, re-estimated on the refined normals (`toonkit.fit_color_maps`);
        given as a `ColorMap`, the whole object is painted with it.
    report : SolverReport
        How the refinement went; by default, that there was none.
    light_estimate : LightEstimate or None
        The light with the confidence of its estimate, if it was estimated; None if it was given. A light of low
        confidence is the customary one: see `toonkit.estimation.light_fit.assume_light`.
    drawing : PreparedDrawing
        The picture with what is derived from it alone, for relighting and further analyses; prepared anew by default.

    Raises
    ------
    ToonkitError
        If a part is of another type or covers another mask, or a material has no color map.
    """

    image: ToonImage
    method: str
    light: FloatArray
    normals: NormalField
    initial_normals: NormalField
    materials: Materials
    report: SolverReport = NOT_REFINED
    light_estimate: LightEstimate | None = None
    drawing: PreparedDrawing = field(kw_only=True, default=None)  # type: ignore[assignment]  # None until __post_init__

    def __post_init__(self) -> None:
        if not isinstance(self.image, PreparedDrawing):
            of_type("image", self.image, ToonImage)
        if isinstance(self.materials, ColorMap):
            object.__setattr__(self, "materials", Materials.single(self.image.mask, self.materials))
        of_type("method", self.method, str)
        check_unit_light("light", self.light)
        for name, normals in (("normals", self.normals), ("initial_normals", self.initial_normals)):
            of_type(name, normals, NormalField)
            same_mask(name, normals.mask, self.image.mask, "the picture")
        of_type("materials", self.materials, Materials)
        same_mask("materials.labels", self.materials.labels >= 0, self.image.mask, "the picture")
        if not self.materials.color_maps:
            raise refuse("materials", "must have a color map each", "none")
        area = np.bincount(self.materials.labels[self.image.mask], minlength=self.materials.count)
        if not area.all():
            raise refuse(
                "materials", "must all occur on the object", f"none of number {int(np.argmin(area))}"
            )
        of_type("report", self.report, SolverReport)
        if self.light_estimate is not None:
            of_type("light_estimate", self.light_estimate, LightEstimate)
        if self.drawing is None or self.drawing.image is not self.image:
            object.__setattr__(self, "drawing", prepare(self.image, materials=self.materials.labels))
            object.__setattr__(self, "image", self.drawing.image)

    @property
    def light_source(self) -> LightSource:
        """Where the light is from: given, estimated, or assumed because the drawing does not say where it is."""
        if self.light_estimate is None:
            return "given"
        return "assumed" if self.light_estimate.is_guess else "estimated"

    def describe_light(self) -> str:
        """Say in words where the light stands, where it is from, and how sure that is."""
        estimate = self.light_estimate
        confidence = "" if estimate is None else f", confidence {estimate.confidence:.2f}"
        return f"{describe_light(self.light)} ({self.light_source}{confidence})"

    def __repr__(self) -> str:
        count = self.materials.count
        parts = (
            f"method {self.method!r}",
            describe_object(self.image.mask),
            "1 material" if count == 1 else f"{count} materials",
            f"light at {self.describe_light()}",
        )
        return f"ToonAnalysis({', '.join(parts)})"

    @property
    def illumination(self) -> FloatArray:
        """L · N, shape (H, W), NaN outside the mask."""
        return illumination(self.normals, self.light)

    @property
    def color_map(self) -> ColorMap:
        """The only color map; a drawing in several materials has none, and raises ToonkitError."""
        if self.materials.count > 1:
            raise refuse(
                "analysis.color_map",
                "is that of a drawing in one material; take analysis.materials.color_maps",
                f"{self.materials.count} materials",
            )
        return self.materials.color_maps[0]

    @property
    def picture(self) -> ToonImage:
        """The input as the model paints it: M(L · N), flat materials in their one tone, ink on top."""
        paint = self.drawing.paint.copy()
        for own, _, shown in self._shaded():
            paint[own] = shown
        return self._painted(self._composed(paint))

    @property
    def base_color(self) -> ToonImage:
        """The drawing without its painted shading: each material in its lit tone, with its texture, ink and alpha."""
        return self._painted(self.base_colors())

    def base_colors(self) -> FloatArray:
        """Return the base color of the object's pixels alone, sRGB, shape (P, 3)."""
        paint = self.drawing.paint.copy()
        for own, lit, shown in self._shaded():
            detail = paint[own] - shown
            size = np.einsum("pc,pc->p", detail, detail) / TEXTURE**2
            paint[own] = lit + np.maximum(1.0 - size, 0.0)[:, None] * detail
        return self._composed(np.clip(paint, 0.0, 1.0, out=paint), highlights=0.0)

    @cached_property
    def palette(self) -> Palette | None:
        """The drawing's own colors, as a ramp for each material; None if there are too many for a palette."""
        return find_palette(self.image, self.materials)

    def intervals(self) -> IlluminationInterval:
        """Range of illumination that each pixel's painted color allows, (H, W) bounds, NaN outside the mask."""
        return self.drawing.interval(allowed_intervals(self.drawing, self.materials.color_maps))

    def save(self, path: str | PathLike[str]) -> None:
        """
        Write the analysis to one file, which `toonkit.load_analysis` reads.

        Parameters
        ----------
        path : path
            Ends in .npz. An older file is replaced once the new one is complete.

        Raises
        ------
        ToonkitError
            If the suffix is another or the file cannot be written.
        """
        from toonkit.export.archive import save_analysis  # noqa: PLC0415 - archives stand above analyses

        save_analysis(self, path)

    def _shaded(self) -> Iterator[tuple[IndexArray | slice, FloatArray, FloatArray]]:
        """Yield of each shaded material its pixels, its lit tone (3,), and the colors that its map gives them (p, 3)."""
        value = self.normals.compact @ self.light
        for material, color_map in zip(
            self.drawing.painted_materials, self.materials.color_maps, strict=True
        ):
            if material.tones is not None:
                own = value[material.pixels]
                yield material.pixels, color_map(np.quantile(own, 1.0 - SHINE)), color_map(own)

    def _composed(self, paint: FloatArray, *, highlights: float = 1.0) -> FloatArray:
        """Put other paint (P, 3) under the drawing's ink and highlights, and mix it where the drawing does."""
        mixed = self.drawing.mixed
        before, after = self.drawing.paint[mixed.sources], paint[mixed.sources]
        paint[mixed.pixels] = mixed.over(before, after, highlights)
        return paint

    def _painted(self, paint: FloatArray) -> ToonImage:
        """Return the picture of which the object's pixels have these colors (P, 3)."""
        return ToonImage.like(self.image, paint, paint[self.image.fringe_pixels])

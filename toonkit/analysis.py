"""ToonAnalysis: what every method returns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import BoolArray, FloatArray, check_unit_light, of_type, refuse, same_mask
from toonkit.estimation.color_map_fit import allowed_intervals
from toonkit.estimation.light_fit import LightEstimate
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.shading_ratio import PaintedMaterial
from toonkit.illustration.palette import Palette, find_palette
from toonkit.illustration.recoloring import recolor, recolor_materials, texture_share
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.description import describe_object
from toonkit.model.image import ToonImage
from toonkit.model.light import OPENING_LIGHT, describe_light
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.model.shading import illumination
from toonkit.model.tone_ramp import ToneRamp
from toonkit.numerics.masked_grid import IndexArray
from toonkit.numerics.parallel import run_on_chunks
from toonkit.numerics.report import NOT_REFINED, SolverReport

LightSource = Literal["given", "estimated", "assumed"]

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
    drawn_materials : Materials or None
        The materials with the color maps that the picture is drawn with, if `materials` has others: see `recolored`.

    Raises
    ------
    ToonkitError
        If a part has the wrong type or a different mask, or a material has no color map.
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
    drawn_materials: Materials | None = field(kw_only=True, default=None)

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
        if self.drawn_materials is not None:
            of_type("drawn_materials", self.drawn_materials, Materials)
            if len(self.drawn_materials.color_maps) != self.materials.count:
                raise refuse(
                    "drawn_materials",
                    f"must have {self.materials.count} color maps, as many as the materials",
                    len(self.drawn_materials.color_maps),
                )
        of_type("report", self.report, SolverReport)
        if self.light_estimate is not None:
            of_type("light_estimate", self.light_estimate, LightEstimate)
        if self.drawing is None or self.drawing.image is not self.image:
            object.__setattr__(self, "drawing", prepare(self.image, materials=self.materials.labels))
            object.__setattr__(self, "image", self.drawing.image)

    @property
    def light_source(self) -> LightSource:
        """How the light was obtained: given, estimated, or assumed because the drawing gives no cue."""
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
        """The input as the model renders it: M(L · N) for shaded materials, the base tone for flat ones, with ink on top."""
        paint = self.recolor(self.drawing.paint, slice(None))
        value = self.normals.compact @ self.light
        for material, flat, color_map in self._each_material():
            if not flat:
                paint[material.pixels] = color_map(value[material.pixels])
        return self._painted(self._composed(paint))

    @property
    def base_color(self) -> ToonImage:
        """The drawing without its painted shading: each material in its lit tone, with its texture, ink and alpha."""
        return self._painted(self.base_colors())

    def base_colors(self) -> FloatArray:
        """Return the base color of the object's pixels alone, sRGB, shape (P, 3)."""
        paint = self.recolor(self.drawing.paint, slice(None))
        value = self.normals.compact @ self.light
        for material, flat, color_map in self._each_material():
            if not flat:
                lit = color_map(np.quantile(value[material.pixels], 1.0 - SHINE))
                pixels = np.arange(len(value)) if isinstance(material.pixels, slice) else material.pixels
                run_on_chunks(_unshade, len(pixels), pixels, value, color_map, lit, paint)
        return self._composed(np.clip(paint, 0.0, 1.0, out=paint), highlights=0.0)

    @cached_property
    def palette(self) -> Palette | None:
        """
        The drawing's own colors, as a ramp for each material; None if there are too many for a palette.

        The ramps of recolored materials are empty.
        """
        palette = find_palette(self.image, self.drawn_materials or self.materials)
        if palette is None or self.drawn_materials is None:
            return palette
        return palette.without(self.is_recolored, self.materials)

    def intervals(self) -> IlluminationInterval:
        """Range of illumination that each pixel's painted color allows, (H, W) bounds, NaN outside the mask."""
        drawn = self.drawn_materials or self.materials
        return self.drawing.interval(allowed_intervals(self.drawing, drawn.color_maps))

    @cached_property
    def is_recolored(self) -> BoolArray:
        """Which materials have another color map than they are drawn with, shape (count,)."""
        drawn = self.drawn_materials
        if drawn is None:
            return np.zeros(self.materials.count, np.bool_)
        return np.array(
            [
                is_flat != was_flat or not _same(one, other)
                for one, is_flat, other, was_flat in zip(
                    self.materials.color_maps, self.materials.flat, drawn.color_maps, drawn.flat, strict=True
                )
            ]
        )

    def recolored(self, ramps: Mapping[int, ToneRamp]) -> ToonAnalysis:
        """
        Return the analysis with other tones for some materials: relit, the drawing looks as if painted in them.

        Parameters
        ----------
        ramps : mapping of int to ToneRamp
            The tones of each of these materials; the others are as they are drawn.

        Returns
        -------
        ToonAnalysis
            The same drawing and shape; its `materials` have those color maps.

        Raises
        ------
        ToonkitError
            If there is no such material, or a ramp is not a `ToneRamp`.

        Examples
        --------
        >>> import toonkit
        >>> analysis = toonkit.analyze("sample:pear", (135, 45))
        >>> blue = toonkit.ToneRamp(["#224488", "#88bbff"], [0.2])
        >>> toonkit.relight(analysis.recolored({0: blue}), (30, 40)).save("blue_pear.png")  # doctest: +SKIP
        """
        drawn = self.drawn_materials or self.materials
        if not ramps:
            return replace(self, materials=drawn, drawn_materials=None)
        for number, ramp in ramps.items():
            of_type("ramps", ramp, ToneRamp)
            if number not in range(drawn.count):
                raise refuse("ramps", f"must be of materials 0 to {drawn.count - 1}", number)
        return replace(self, materials=recolor_materials(drawn, ramps), drawn_materials=drawn)

    def recolor(self, paint: FloatArray, pixels: IndexArray | slice) -> FloatArray:
        """
        Return what the drawing would be painted in, under its own light, with the color maps of `materials`.

        Parameters
        ----------
        paint : ndarray, shape (n, 3)
            Colors that some of the object's pixels are painted in, sRGB.
        pixels : ndarray of int, shape (n,), or slice
            Which ones, counted in row-major order.

        Returns
        -------
        ndarray, shape (n, 3)
            Always a new array.
        """
        if self.drawn_materials is None or not self.is_recolored.any():
            return paint.copy()
        labels = self.materials.labels[self.image.mask][pixels]
        value = self.normals.compact[pixels] @ self.light
        return recolor(paint, labels, value, self.drawn_materials, self.materials, self.is_recolored)

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

    def save_html(self, path: str | PathLike[str], light: ArrayLike = OPENING_LIGHT) -> None:
        """
        Write one HTML file that shows the picture under a light that its reader drags, without Python or a network.

        Parameters
        ----------
        path : path
            Ends in .html.
        light : array_like, shape (3,) or (2,), optional
            The light to begin with, as in `toonkit.relight`.

        Raises
        ------
        ToonkitError
            If the suffix is another, the light is invalid, or the file cannot be written.
        """
        from toonkit.viz.offline_page import write_offline_page  # noqa: PLC0415 - viz stands above analyses

        write_offline_page(self, path, light)

    def _each_material(self) -> Iterator[tuple[PaintedMaterial, bool, ColorMap]]:
        """Yield of each material its pixels, whether it is flat, and its color map."""
        materials = self.materials
        return zip(self.drawing.painted_materials, materials.flat.tolist(), materials.color_maps, strict=True)

    def _composed(self, paint: FloatArray, *, highlights: float = 1.0) -> FloatArray:
        """Put other paint (P, 3) under the drawing's ink and highlights, and mix it where the drawing does."""
        mixed = self.drawing.mixed
        before, after = self.drawing.paint[mixed.sources], paint[mixed.sources]
        paint[mixed.pixels] = mixed.over(before, after, highlights)
        return paint

    def _painted(self, paint: FloatArray) -> ToonImage:
        """Return the picture of which the object's pixels have these colors (P, 3)."""
        return ToonImage.like(self.image, paint, paint[self.image.fringe_pixels])


def _unshade(
    pixels: NDArray[np.integer],
    value: FloatArray,
    color_map: ColorMap,
    lit: FloatArray,
    paint: FloatArray,
    piece: slice,
) -> None:
    """Replace the shading of some pixels of a material by its lit tone; keep their texture."""
    own = pixels[piece]
    detail = paint[own] - color_map(value[own])
    paint[own] = lit + texture_share(detail)[:, None] * detail


def _same(one: ColorMap, other: ColorMap) -> bool:
    return one is other or (one.domain == other.domain and np.array_equal(one.colors, other.colors))

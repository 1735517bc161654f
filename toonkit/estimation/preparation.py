"""A prepared drawing: islands, ink, materials and the inflated shape (Section 3.1), derived once for all that follows."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import BoolArray, FloatArray, as_labels, as_marks, of_type, refuse
from toonkit.estimation.inflation import inflate_islands
from toonkit.estimation.islands import Island, find_islands, with_surroundings
from toonkit.estimation.overview import ReducedPaint, reduce_paint
from toonkit.estimation.painted_tones import PaintedTones
from toonkit.estimation.shading_ratio import GrayPaint, PaintedMaterial, gray_paint
from toonkit.illustration.frame import Frame
from toonkit.illustration.ink import Ink, find_ink, told_ink
from toonkit.illustration.materials import FoundMaterials, label_materials, shows_one_ramp
from toonkit.illustration.mixed_pixels import MixedPixels, mixtures
from toonkit.illustration.noise import without_noise
from toonkit.illustration.palette import is_pixel_art
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.description import describe_object
from toonkit.model.image import ToonImage
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import MaskedGrid, bounding_box

MOST_PIXELS = 25_000_000
"""Pixels of an object at most, 5000 x 5000: an analysis needs up to 400 bytes of memory for each of them."""

TELLING, TELLING_SHARE = 4, 0.25
"""Islands from which the light is estimated, at most, and the least area of one relative to the largest."""

WHATEVER_IS_TOLD = (
    "grid", "islands", "telling_islands", "_coverage", "frame", "is_pixel_art", "found_ink", "initial_normals"
)  # fmt: skip
"""Parts of a prepared drawing that do not depend on what somebody knows of it."""

WHATEVER_MATERIALS = ("ink", "inked")
"""Parts that do not depend on its materials and highlights."""


class PreparedDrawing:
    """
    A drawing and what is derived from it alone, whatever the light: each part is computed when it is first asked for.

    It stands for its picture wherever a function takes a picture.

    Everything is computed on the object's bounding box, so that neither the answer nor time and memory depend on what is
    around the object. Arrays are compact: one entry for each of the object's P pixels, in row-major order.

    Parameters
    ----------
    image : ToonImage
        The drawing.
    materials : array_like of int, shape (H, W), optional
        Its materials, if somebody knows them: see `prepare`.
    ink, highlights : array_like of bool, shape (H, W), optional
        Its ink and its highlights, if somebody knows them.

    Raises
    ------
    ToonkitError
        If the object has more than `MOST_PIXELS` pixels, or the materials, ink or highlights are none.
    """

    def __init__(
        self,
        image: ToonImage,
        materials: ArrayLike | None = None,
        ink: ArrayLike | None = None,
        highlights: ArrayLike | None = None,
    ) -> None:
        pixels = int(np.count_nonzero(image.mask))
        if pixels > MOST_PIXELS:
            raise refuse(
                "image",
                f"must show an object of at most {MOST_PIXELS:,} pixels; reduce the drawing",
                f"{pixels:,}",
            )
        self.image = image
        self.box = bounding_box(image.mask)
        self._given_labels = None if materials is None else as_labels("materials", materials, image.mask)
        self.given_ink = None if ink is None else as_marks("ink", ink, image.mask)
        self.given_highlights = None if highlights is None else as_marks("highlights", highlights, image.mask)

    def __repr__(self) -> str:
        return f"PreparedDrawing({describe_object(self.mask)})"

    def told(
        self, materials: ArrayLike | None, ink: ArrayLike | None, highlights: ArrayLike | None
    ) -> PreparedDrawing:
        """Return the drawing with other materials, ink and highlights; they share what does not depend on these."""
        other = PreparedDrawing(self.image, materials, ink, highlights)
        same_ink = self.given_ink is None and other.given_ink is None
        for name in (*WHATEVER_IS_TOLD, *(WHATEVER_MATERIALS if same_ink else ())):
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other

    @property
    def mask(self) -> BoolArray:
        """True on the object, shape (H, W)."""
        return self.image.mask

    @property
    def color(self) -> FloatArray:
        """The picture's colors, sRGB, shape (H, W, 3)."""
        return self.image.color

    @property
    def alpha(self) -> FloatArray:
        """The picture's coverage, shape (H, W)."""
        return self.image.alpha

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the picture in pixels."""
        return self.image.shape

    @cached_property
    def grid(self) -> MaskedGrid:
        """The object's pixels on its bounding box."""
        return MaskedGrid(np.ascontiguousarray(self.image.mask[self.box]))

    @cached_property
    def islands(self) -> tuple[Island, ...]:
        """The parts of the object that do not touch."""
        return find_islands(self.grid, self._coverage)

    @cached_property
    def ink(self) -> Ink:
        """The lines over the paint, on the object's frame: those that are given, or else those that are found."""
        if self.given_ink is None:
            return self.found_ink
        return told_ink(self.found_ink, self.frame.cut(self.given_ink[self.box]), self.frame)

    @cached_property
    def found_ink(self) -> Ink:
        """The lines over the paint, on the object's frame. What one shaded material explains without any has none."""
        ink = find_ink(self.frame, hard_edges=self.is_pixel_art)
        if ink.coverage.any() and not ink.outlined and shows_one_ramp(self.frame, self.framed_normals):
            return replace(ink, coverage=np.zeros_like(ink.coverage), only_lines=False)
        return ink

    @cached_property
    def inked(self) -> BoolArray:
        """Which of the object's pixels ink covers, if only in part, shape (P,)."""
        return self.frame.compact(self.ink.coverage) > 0

    @property
    def ink_coverage(self) -> FloatArray:
        """How much of each pixel is ink, shape (H, W), 0 outside the mask."""
        return self._on_picture(self.ink.coverage, 0.0)

    @property
    def ink_color(self) -> FloatArray:
        """Color of the ink, sRGB, shape (H, W, 3); meaningless where there is none."""
        return self._on_picture(self.ink.color, 0.0)

    @cached_property
    def materials(self) -> Materials:
        """The materials, without color maps."""
        found = self._found
        return Materials(self._on_picture(found.labels.astype(np.intp), -1), found.tones, found.flat)

    @cached_property
    def mixed(self) -> MixedPixels:
        """The pixels that show ink, or the paint of two materials."""
        frame, found = self.frame, self._found
        mixed = mixtures(
            frame.color, self.ink.coverage, found.labels, found.sources, found.highlights, frame.mask
        )
        return replace(mixed, drawn=self._drawn[mixed.pixels])

    @cached_property
    def is_pixel_art(self) -> bool:
        """Whether the drawing is pixel art."""
        return is_pixel_art(self.image)

    def places(self, pixels: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column, in the picture, of some of the object's pixels."""
        rows, columns = self.box
        return self.grid.rows[pixels] + rows.start, self.grid.columns[pixels] + columns.start

    @cached_property
    def paint(self) -> FloatArray:
        """The colors without ink, mixtures of materials, and a compressor's noise, sRGB, shape (P, 3)."""
        paint = self.frame.compact(self.frame.color)
        paint[self.mixed.pixels] = paint[self.mixed.sources[:, 0]]
        return paint

    @property
    def without_ink(self) -> FloatArray:
        """The colors without ink, sRGB, shape (P, 3)."""
        return np.where(self.inked[:, None], self.paint, self._drawn)

    @cached_property
    def tones(self) -> PaintedTones:
        """The tones of the paint, as if it were one material."""
        return PaintedTones.of(self.paint, self.grid.rows, self.grid.columns)

    @cached_property
    def painted_materials(self) -> tuple[PaintedMaterial, ...]:
        """The tones of each material."""
        found = self._found
        if len(found.tones) == 1:
            return (PaintedMaterial(slice(None), None if found.flat[0] else self.tones),)
        labels, materials = self.frame.compact(found.labels), []
        for number, flat in enumerate(found.flat):
            pixels = np.flatnonzero(labels == number).astype(np.int32)
            place = self.grid.rows[pixels], self.grid.columns[pixels]
            tones = None if flat else PaintedTones.of(self.paint[pixels], *place)
            materials.append(PaintedMaterial(pixels, tones))
        return tuple(materials)

    @cached_property
    def initial_normals(self) -> NormalField:
        """N0, inflated from the silhouette."""
        return NormalField.of_pixels(inflate_islands(self.islands), self.image.mask)

    @cached_property
    def gray(self) -> GrayPaint:
        """The shading that the paint shows, whatever its material."""
        return gray_paint(self.painted_materials, self.grid, self.inked)

    @cached_property
    def reduced_paint(self) -> tuple[ReducedPaint, ...]:
        """Each island's tones and ink at about the resolution that the networks see."""
        gray = self.gray
        return tuple(
            reduce_paint(
                island.grid,
                gray.light[island.pixels],
                gray.tone[island.pixels],
                gray.hidden[island.pixels],
            )
            for island in self.islands
        )

    @cached_property
    def telling_islands(self) -> tuple[int, ...]:
        """Numbers of the islands whose shading says where the light is: the largest ones, `TELLING` at most."""
        by_area = sorted(range(len(self.islands)), key=lambda k: -self.islands[k].grid.size)
        least = TELLING_SHARE * self.islands[by_area[0]].grid.size
        return tuple(k for k in by_area[:TELLING] if self.islands[k].grid.size >= least)

    def interval(self, allowed: IlluminationInterval) -> IlluminationInterval:
        """Return an interval of the object's pixels (P,) as one of the picture, (H, W), NaN outside the mask."""
        lower, upper = np.full((2, *self.image.shape), np.nan)
        lower[self.image.mask], upper[self.image.mask] = allowed.lower, allowed.upper
        return IlluminationInterval(lower, upper)

    @cached_property
    def _coverage(self) -> FloatArray:
        return with_surroundings(self.image.alpha, self.box)

    @cached_property
    def frame(self) -> Frame:
        """The object, cut out, without a compressor's noise."""
        return without_noise(Frame.around(self.image.color[self.box], self.grid.mask))

    def _on_picture(self, framed: NDArray[Any], fill: float) -> NDArray[Any]:
        """Put values (h, w, ...) of the frame into the picture, (H, W, ...), filled elsewhere."""
        whole = np.full((*self.shape, *framed.shape[2:]), fill, framed.dtype)
        whole[self.box] = self.frame.inner(framed)
        return whole

    @property
    def _drawn(self) -> FloatArray:
        return self.grid.gather(self.image.color[self.box])

    @property
    def framed_normals(self) -> FloatArray:
        """N0 on the frame, shape (h, w, 3)."""
        vectors = np.zeros((*self.frame.mask.shape, 3))
        vectors[self.frame.mask] = self.initial_normals.compact
        return vectors

    @cached_property
    def _found(self) -> FoundMaterials:
        labels = highlights = None
        if self._given_labels is not None:
            labels = self.frame.cut(self._given_labels[self.box])
        if self.given_highlights is not None:
            highlights = self.frame.cut(self.given_highlights[self.box])
        return label_materials(
            self.frame, self.ink.coverage, self.framed_normals, labels=labels, highlights=highlights
        )


def prepare(
    drawing: ToonImage | PreparedDrawing,
    *,
    materials: ArrayLike | Materials | None = None,
    ink: ArrayLike | None = None,
    highlights: ArrayLike | None = None,
) -> PreparedDrawing:
    """
    Prepare a drawing for analysis.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing; one that is prepared returns as it is, unless materials, ink or highlights are given.
    materials : array_like of int, shape (H, W), or Materials, optional
        Number of the material of each pixel, 0 and up, and -1 where that is left to toonkit; ignored outside the mask.
        Found if not given.
    ink : array_like of bool, shape (H, W), optional
        True where lines cover the paint, if only in part; found if not given. Where lines are found, too, their soft edges
        stay; elsewhere the ink is opaque.
    highlights : array_like of bool, shape (H, W), optional
        True where the paint shows a highlight, or a cast shadow: what lies on the paint and says nothing about the shape.
        Found if not given.

    Returns
    -------
    PreparedDrawing
        The drawing with all that is derived from it. Pass it on instead of the picture, and nothing is derived twice.

    Raises
    ------
    ToonkitError
        If the drawing is neither, its object has more than `MOST_PIXELS` pixels, or the materials, the ink or the highlights
        are no such arrays.
    """
    if isinstance(materials, Materials):
        materials = materials.labels
    if isinstance(drawing, PreparedDrawing):
        if materials is None and ink is None and highlights is None:
            return drawing
        return drawing.told(materials, ink, highlights)
    of_type("image", drawing, ToonImage)
    return PreparedDrawing(drawing, materials, ink, highlights)


def find_materials(image: ToonImage | PreparedDrawing) -> Materials:
    """
    Find which parts of a drawing are painted with the same ramp of colors.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The drawing.

    Returns
    -------
    Materials
        Labels and tones, without color maps; at least one material.

    Raises
    ------
    ToonkitError
        If the image is not a `ToonImage`.

    Examples
    --------
    >>> color = np.full((32, 32, 3), (0.8, 0.2, 0.2))
    >>> color[:, 16:] = (0.2, 0.3, 0.8)
    >>> find_materials(ToonImage(color, np.ones((32, 32), bool))).count
    2
    """
    return prepare(image).materials

"""A prepared drawing: islands, ink, materials and the inflated shape (Section 3.1), derived once and then reused."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import BoolArray, FloatArray, as_labels, as_lines, as_marks, refuse
from toonkit.estimation.corrected_shape import CorrectedNormals, correct_normals
from toonkit.estimation.inflation import inflate_islands
from toonkit.estimation.islands import MOST, Island, find_islands, with_surroundings
from toonkit.estimation.painted_tones import EDGE_REACH, PaintedTones
from toonkit.estimation.pose import Pose
from toonkit.estimation.shading_ratio import PaintedMaterial
from toonkit.estimation.turn import turn_under_light
from toonkit.illustration.frame import Frame
from toonkit.illustration.ink import Ink, find_ink, unmix_known_ink
from toonkit.illustration.materials import FoundMaterials, label_materials, shows_one_ramp
from toonkit.illustration.mixed_pixels import MixedPixels, mixtures
from toonkit.illustration.neighborhoods import grow_mask
from toonkit.illustration.noise import remove_noise
from toonkit.illustration.palette import is_pixel_art
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.description import describe_object
from toonkit.model.image import ToonImage
from toonkit.model.luminance import REC709
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.model.shape_corrections import ShapeCorrections
from toonkit.model.whole_pixels import put_pixels
from toonkit.numerics.masked_grid import MaskedGrid, bounding_box

MOST_PIXELS = 25_000_000
"""Largest number of pixels of an object, 5000 x 5000: an analysis needs up to 400 bytes of memory for each of them."""

TELLING, TELLING_SHARE = 4, 0.25
"""Largest number of islands from which the light is estimated, and the least area of one relative to the largest."""

WHATEVER_IS_TOLD = (
    "grid", "islands", "telling_islands", "_moments", "frame", "is_pixel_art", "inflated_normals"
)  # fmt: skip
"""Parts of a prepared drawing that depend on its picture alone."""

WHATEVER_MATERIALS = ("ink", "inked")
"""Parts that do not depend on its materials or highlights."""


class PreparedDrawing:
    """
    A drawing and everything that is derived from it alone. Each part is computed when it is first used.

    Functions that take a picture also take a prepared drawing.

    Everything is computed on the object's bounding box, so that the background changes neither the result nor time and
    memory. Arrays are compact: one entry for each of the object's P pixels, in row-major order.

    Parameters
    ----------
    image : ToonImage
        The drawing.
    materials : array_like of int, shape (H, W), optional
        Its materials, if they are known: see `prepare`.
    ink, highlights : array_like of bool, shape (H, W), optional
        Its lines and its highlights, if they are known: see `prepare`.
    shape : ShapeCorrections, optional
        What a person says about its shape.
    views : int, optional
        How many views of the object it shows side by side. Lines are as wide as in one view, and all views share materials.

    Attributes
    ----------
    given_ink, given_highlights : ndarray of bool, shape (H, W), or None
        The lines and the highlights that were given, False outside the mask.
    given_shape : ShapeCorrections or None
        The corrections of the shape, if there are any.

    Raises
    ------
    ToonkitError
        If the object has more than `MOST_PIXELS` pixels, or the materials, ink, highlights or shape are not valid.
    """

    def __init__(
        self,
        image: ToonImage,
        materials: ArrayLike | None = None,
        *,
        ink: ArrayLike | None = None,
        highlights: ArrayLike | None = None,
        shape: ShapeCorrections | None = None,
        views: int = 1,
    ) -> None:
        pixels = int(np.count_nonzero(image.mask))
        if pixels > MOST_PIXELS:
            raise refuse(
                "image",
                f"must show an object of at most {MOST_PIXELS:,} pixels; reduce the drawing",
                f"{pixels:,}",
            )
        self.image = image
        self.views = views
        self.box = bounding_box(image.mask)
        self._given_labels = None if materials is None else as_labels("materials", materials, image.mask)
        self.given_ink = None if ink is None else as_lines("ink", ink, image.mask)
        self.given_highlights = None if highlights is None else as_marks("highlights", highlights, image.mask)
        self.given_shape = None if shape is None or shape.is_empty else shape.on(image.mask)
        self._pose: Pose | None = None

    def __repr__(self) -> str:
        return f"PreparedDrawing({describe_object(self.mask)})"

    def told(
        self,
        materials: ArrayLike | None = None,
        ink: ArrayLike | None = None,
        highlights: ArrayLike | None = None,
    ) -> PreparedDrawing:
        """Return the drawing with other materials, ink or highlights; both share all that is independent of these."""
        other = PreparedDrawing(
            self.image,
            self._given_labels if materials is None else materials,
            ink=self.given_ink if ink is None else ink,
            highlights=self.given_highlights if highlights is None else highlights,
            shape=self.given_shape,
            views=self.views,
        )
        for name in (*WHATEVER_IS_TOLD, *(WHATEVER_MATERIALS if ink is None else ())):
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other

    def reshaped(self, shape: ShapeCorrections) -> Self:
        """Return the drawing with other corrections of its shape, which shares everything but the initial normals."""
        other = copy(self)
        other.given_shape = None if shape.is_empty else shape.on(self.mask)
        other.__dict__.pop("initial_normals", None)
        return other

    @property
    def as_painted(self) -> PreparedDrawing:
        """The drawing at the size at which it was painted: itself, unless it was enlarged."""
        return self

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
        coverage = with_surroundings(self.image.alpha, self.box)
        return find_islands(self.grid, coverage, most=MOST * self.views)

    @cached_property
    def ink(self) -> Ink:
        """
        The lines over the paint, on the object's frame: those given, or found.

        A drawing that one shaded material explains has no ink, unless some is given.
        """
        if self.given_ink is not None:
            lines = self.frame.cut(self.given_ink[self.box])
            return unmix_known_ink(self.frame, lines, hard_edges=self.is_pixel_art)
        ink = find_ink(self.frame, hard_edges=self.is_pixel_art)
        if ink.coverage.any() and not ink.outlined and shows_one_ramp(self.frame, self.framed_normals):
            return Ink.none(self.frame.mask)
        return ink

    @cached_property
    def inked(self) -> BoolArray:
        """Which of the object's pixels ink covers at least in part, shape (P,)."""
        return self.frame.compact(self.ink.coverage) > 0

    @cached_property
    def hidden(self) -> BoolArray:
        """Where ink or a highlight hides how the object's paint is lit, shape (P,)."""
        hidden: BoolArray = self.inked | self.frame.compact(self._found.highlights)
        return hidden

    @property
    def ink_coverage(self) -> FloatArray:
        """Ink coverage of each pixel, 0 to 1, shape (H, W); 0 outside the mask."""
        return self._on_picture(self.ink.coverage, 0.0)

    @cached_property
    def materials(self) -> Materials:
        """The materials, without color maps."""
        found = self._found
        return Materials(self._on_picture(found.labels, -1), found.tones, found.flat)

    @cached_property
    def mixed(self) -> MixedPixels:
        """The pixels that show ink, or the paint of two materials."""
        frame, found = self.frame, self._found
        mixed = mixtures(
            frame.color, self.ink.coverage, found.labels, found.sources, found.highlights, frame.mask
        )
        return replace(mixed, drawn=self.image.pixels[mixed.pixels])

    @cached_property
    def is_pixel_art(self) -> bool:
        """Whether the drawing is pixel art."""
        return is_pixel_art(self.image, views=self.views)

    def places(self, pixels: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column, in the picture, of some of the object's pixels."""
        rows, columns = self.box
        return self.grid.rows[pixels] + rows.start, self.grid.columns[pixels] + columns.start

    @cached_property
    def paint(self) -> FloatArray:
        """The colors without ink, mixtures of materials, and a compressor's noise, sRGB, shape (P, 3)."""
        paint = self.frame.pixels.copy()
        paint[self.mixed.pixels] = paint[self.mixed.sources[:, 0]]
        return paint

    @property
    def without_ink(self) -> FloatArray:
        """The colors without ink, sRGB, shape (P, 3)."""
        return np.where(self.inked[:, None], self.paint, self.image.pixels)

    @cached_property
    def tones(self) -> PaintedTones:
        """The tones of the paint, as if it were one material."""
        return PaintedTones.of(self.paint, self.grid.rows, self.grid.columns)

    @cached_property
    def _beside_edges(self) -> BoolArray:
        """Which of the object's pixels lie near ink, a highlight or another material, shape (P,)."""
        marked = np.zeros(self.frame.mask.shape, np.bool_)
        marked.ravel()[np.flatnonzero(self.frame.mask)[self.mixed.pixels]] = True
        return self.frame.compact(grow_mask(marked, EDGE_REACH))

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
            tones = None if flat else PaintedTones.of(self.paint[pixels], *place, self._beside_edges[pixels])
            materials.append(PaintedMaterial(pixels, tones))
        return tuple(materials)

    @cached_property
    def inflated_normals(self) -> NormalField:
        """The normals inflated from the silhouette, without corrections."""
        return NormalField.of_pixels(inflate_islands(self.islands), self.image.mask)

    @cached_property
    def initial_normals(self) -> NormalField:
        """N0: inflated from the silhouette, with the corrections of the shape."""
        corrected = self.corrected(self.inflated_normals)
        if corrected is None:
            return self.inflated_normals
        return NormalField.of_pixels(corrected.vectors, self.image.mask)

    def corrected(self, normals: NormalField) -> CorrectedNormals | None:
        """Return normals with the corrections of the shape; None if there are none."""
        if self.given_shape is None:
            return None
        return correct_normals(self.given_shape, self.grid, self.box, normals.compact)

    def posed(self, light: FloatArray | None = None) -> Pose:
        """Turn each island so that its light comes from above; without a light, what is bright comes to lie there."""
        towards = np.zeros(3) if light is None else light
        turns = [turn_under_light(towards, moment) for moment in self._moments]
        pose = self._pose  # a thread that poses the drawing for another light may replace it
        if pose is None or turns != [island.turn for island in pose.islands]:
            labels = self.frame.compact(self._found.labels)
            islands = tuple(island.turned(turn) for island, turn in zip(self.islands, turns, strict=True))
            for island, turned in zip(self.islands, islands, strict=True):
                if turned is not island:  # no solver needs the unturned island again
                    island.grid.release()
            pose = self._pose = Pose(islands, self.painted_materials, self.hidden, labels)
        return pose

    def release(self) -> None:
        """Free what only an analysis under another light needs, which computes it again."""
        self._pose = None
        for grid in (self.grid, *(island.grid for island in self.islands)):
            grid.release()

    @cached_property
    def telling_islands(self) -> tuple[int, ...]:
        """Numbers of the islands from which the light is estimated: the largest ones, at most `TELLING`."""
        by_area = sorted(range(len(self.islands)), key=lambda k: -self.islands[k].grid.size)
        least = TELLING_SHARE * self.islands[by_area[0]].grid.size
        return tuple(k for k in by_area[:TELLING] if self.islands[k].grid.size >= least)

    def interval(self, allowed: IlluminationInterval) -> IlluminationInterval:
        """Return an interval of the object's pixels (P,) as one of the picture, (H, W), NaN outside the mask."""
        lower, upper = np.full((2, *self.image.shape), np.nan)
        lower[self.image.mask], upper[self.image.mask] = allowed.lower, allowed.upper
        return IlluminationInterval(lower, upper)

    @cached_property
    def _moments(self) -> list[FloatArray]:
        """Where each island is bright."""
        brightness = np.asarray(self.image.pixels @ REC709)
        return [island.moment(brightness) for island in self.islands]

    @cached_property
    def frame(self) -> Frame:
        """The object, cut out, without a compressor's noise."""
        return remove_noise(Frame.of_pixels(self.image.pixels, self.grid.mask, views=self.views))

    def _on_picture(self, framed: NDArray[Any], fill: float) -> NDArray[Any]:
        """Put values (h, w, ...) of the frame into the picture, (H, W, ...), filled elsewhere."""
        whole = np.full((*self.shape, *framed.shape[2:]), fill, framed.dtype)
        whole[self.box] = self.frame.inner(framed)
        return whole

    @property
    def framed_normals(self) -> FloatArray:
        """The inflated normals on the frame, shape (h, w, 3)."""
        vectors = np.zeros((*self.frame.mask.shape, 3))
        put_pixels(vectors, self.frame.mask, self.inflated_normals.compact)
        return vectors

    @cached_property
    def _found(self) -> FoundMaterials:
        labels = highlights = None
        if self._given_labels is not None:
            labels = self.frame.cut(self._given_labels[self.box])
        if self.given_highlights is not None:
            highlights = self.frame.cut(self.given_highlights[self.box])
        found = label_materials(
            self.frame, self.ink.coverage, self.framed_normals, labels=labels, highlights=highlights
        )
        self.frame.release()
        return found

"""A drawing enlarged by a whole factor, which is analyzed at the size it was painted at: one pixel for each block."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.illustration.enlargement import Enlargement
from toonkit.illustration.frame import Frame
from toonkit.illustration.ink import Ink
from toonkit.illustration.materials import FoundMaterials
from toonkit.illustration.mixed_pixels import MixedPixels
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.model.shape_corrections import ShapeCorrections
from toonkit.model.whole_pixels import pixels_at, put_pixels


class EnlargedDrawing(PreparedDrawing):
    """
    An enlarged drawing. Its ink, materials and mixed pixels are those of the drawing before it was enlarged.

    Parameters
    ----------
    image : ToonImage
        The drawing.
    enlargement : Enlargement
        How it was enlarged.
    materials, ink, highlights, shape, views
        As for `PreparedDrawing`. Materials, ink and highlights must be constant in each block. Parts in the corrections
        of the shape are read at the middle of each block.

    Attributes
    ----------
    reduced : PreparedDrawing
        The drawing before it was enlarged.
    """

    def __init__(
        self,
        image: ToonImage,
        enlargement: Enlargement,
        materials: ArrayLike | None = None,
        *,
        ink: ArrayLike | None = None,
        highlights: ArrayLike | None = None,
        shape: ShapeCorrections | None = None,
        views: int = 1,
    ) -> None:
        super().__init__(image, materials, ink=ink, highlights=highlights, shape=shape, views=views)
        self._enlargement = enlargement
        given = (self._given_labels, self.given_ink, self.given_highlights)
        labels, lines, marks = (None if told is None else enlargement.reduce(told) for told in given)
        self.reduced = PreparedDrawing(
            enlargement.image, labels, ink=lines, highlights=marks, shape=self._reduced_shape(), views=views
        )

    @classmethod
    def of(cls, drawing: PreparedDrawing, enlargement: Enlargement) -> PreparedDrawing:
        """Return a drawing as an enlarged one, or unchanged if given materials, ink or highlights differ within a block."""
        given = (drawing._given_labels, drawing.given_ink, drawing.given_highlights)
        if any(told is not None and enlargement.reduce(told) is None for told in given):
            return drawing
        labels, ink, highlights = given
        return cls(
            drawing.image,
            enlargement,
            labels,
            ink=ink,
            highlights=highlights,
            shape=drawing.given_shape,
            views=drawing.views,
        )

    @property
    def as_painted(self) -> PreparedDrawing:
        """The drawing before it was enlarged."""
        return self.reduced

    def told(
        self,
        materials: ArrayLike | None = None,
        ink: ArrayLike | None = None,
        highlights: ArrayLike | None = None,
    ) -> PreparedDrawing:
        """Return the drawing with other materials, ink or highlights."""
        return self.of(super().told(materials, ink, highlights), self._enlargement)

    def reshaped(self, shape: ShapeCorrections) -> Self:
        """Return the drawing with other corrections of its shape."""
        other = super().reshaped(shape)
        other.reduced = self.reduced.reshaped(other._reduced_shape())
        return other

    def _reduced_shape(self) -> ShapeCorrections:
        """Return the corrections of the shape at the size of the reduced drawing."""
        given, factor = self.given_shape, self._enlargement.factor
        if given is None:
            return ShapeCorrections()
        rows, columns = self._enlargement.place
        middles = slice(factor // 2, None, factor)
        normals = [
            replace(
                hint,
                row=(hint.row - rows.start) // factor,
                column=(hint.column - columns.start) // factor,
                radius=hint.radius / factor,
            )
            for hint in given.normals
        ]
        parts = {name: part[rows, columns][middles, middles] for name, part in given.parts.items()}
        return ShapeCorrections(**parts, normals=tuple(normals))

    def enlarge_normals(self, normals: NormalField) -> NormalField:
        """Return the normals of the reduced drawing as normals of this one."""
        return NormalField.of_pixels(normals.compact[self._enlargement.sources], self.mask)

    @cached_property
    def frame(self) -> Frame:
        """The object, cut out, without a compressor's noise."""
        frame = Frame.of_pixels(self.image.pixels, self.grid.mask)
        return replace(frame, pixels=self.reduced.frame.pixels[self._enlargement.sources])

    @cached_property
    def ink(self) -> Ink:
        """The lines over the paint, on the object's frame."""
        small = self.reduced
        coverage = self._enlarge(small.ink.coverage, 0.0)
        colors = np.zeros((*small.frame.mask.shape, 3))
        put_pixels(colors, small.ink.coverage > 0, small.ink.colors)
        return replace(
            small.ink, coverage=coverage, colors=pixels_at(self._enlarge(colors, 0.0), coverage > 0)
        )

    @cached_property
    def mixed(self) -> MixedPixels:
        """The pixels that show ink, or the paint of two materials."""
        small, sources = self.reduced.mixed, self._enlargement.sources
        row = np.full(self.reduced.grid.size, -1)
        row[small.pixels] = np.arange(len(small.pixels))
        pixels = np.flatnonzero(row[sources] >= 0)
        own = row[sources[pixels]]
        return MixedPixels(
            pixels,
            self._enlargement.firsts()[small.sources[own]],
            small.shares[own],
            self.image.pixels[pixels],
            small.highlit[own],
        )

    @cached_property
    def is_pixel_art(self) -> bool:
        """Whether the drawing is pixel art."""
        return self.reduced.is_pixel_art

    @cached_property
    def _found(self) -> FoundMaterials:
        found = self.reduced._found
        numbers = np.full(self.reduced.frame.mask.shape, 0)
        numbers[self.reduced.frame.mask] = np.arange(self.reduced.grid.size)
        places = np.flatnonzero(self.frame.mask)[self._enlargement.firsts()]
        sources = places[numbers.ravel()[found.sources]]
        return replace(
            found,
            labels=self._enlarge(found.labels, -1),
            sources=self._enlarge(sources, 0),
            highlights=self._enlarge(found.highlights, False),
        )

    def _enlarge(self, framed: NDArray[Any], fill: float) -> NDArray[Any]:
        """Enlarge values (h, w, ...) on the reduced drawing's frame to this one's; pixels beside the object get `fill`."""
        values = np.full((*self.frame.mask.shape, *framed.shape[2:]), fill, framed.dtype)
        values[self.frame.mask] = self.reduced.frame.compact(framed)[self._enlargement.sources]
        return values

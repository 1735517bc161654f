"""A prepared drawing: islands, ink, tones and the inflated shape (Section 3.1), derived once for every step that follows."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray, of_type, refuse
from toonkit.estimation.inflation import inflate_islands
from toonkit.estimation.islands import Island, find_islands, rim_pixels, with_surroundings
from toonkit.estimation.line_art import LineArt, find_line_art
from toonkit.estimation.overview import ReducedPaint, reduce_paint
from toonkit.estimation.painted_tones import PaintedTones, decoded
from toonkit.estimation.silhouette import cut_sides
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import MaskedGrid, bounding_box

MOST_PIXELS = 25_000_000
"""Pixels of an object at most, 5000 x 5000: an analysis needs up to 400 bytes of memory for each of them."""

TELLING, TELLING_SHARE = 4, 0.25
"""Islands from which the light is estimated, at most, and the least area of one relative to the largest."""


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

    Raises
    ------
    ToonkitError
        If the object has more than `MOST_PIXELS` pixels.
    """

    def __init__(self, image: ToonImage) -> None:
        pixels = int(np.count_nonzero(image.mask))
        if pixels > MOST_PIXELS:
            raise refuse(
                "image",
                f"must show an object of at most {MOST_PIXELS:,} pixels; reduce the drawing",
                f"{pixels:,}",
            )
        self.image = image
        self.box = bounding_box(image.mask)

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
    def line_art(self) -> LineArt | None:
        """The ink, if there is any."""
        return find_line_art(
            self._colors,
            self._decoded[1],
            self.grid,
            rim=rim_pixels(self.islands, self.grid.size),
            cut=cut_sides(self.grid.mask, self._coverage),
            area=max(island.grid.size for island in self.islands),
        )

    @property
    def inked_places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column, in the picture, of each pixel that the ink touches."""
        pixels = np.zeros(0, np.intp) if self.line_art is None else self.line_art.pixels
        rows, columns = self.box
        return self.grid.rows[pixels] + rows.start, self.grid.columns[pixels] + columns.start

    @property
    def paint(self) -> FloatArray:
        """The colors without the ink, sRGB, shape (P, 3)."""
        return self._colors if self.line_art is None else self.line_art.removed(self._colors)

    @cached_property
    def tones(self) -> PaintedTones:
        """The tones of the paint, without the ink."""
        if self.line_art is None:
            return PaintedTones.between(*self._decoded, self.grid)
        return PaintedTones.of(self.paint, self.grid)

    @cached_property
    def initial_normals(self) -> NormalField:
        """N0, inflated from the silhouette."""
        return NormalField.of_pixels(inflate_islands(self.islands), self.image.mask)

    @cached_property
    def reduced_paint(self) -> tuple[ReducedPaint, ...]:
        """Each island's tones and ink at about the resolution that the networks see."""
        inked = np.zeros(self.grid.size)
        if self.line_art is not None:
            inked[self.line_art.pixels] = 1.0
        return tuple(
            reduce_paint(
                island.grid,
                self.tones.light[island.pixels],
                self.tones.plain[island.pixels],
                inked[island.pixels],
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

    @property
    def _colors(self) -> FloatArray:
        return self.grid.gather(self.image.color[self.box])

    @cached_property
    def _decoded(self) -> tuple[FloatArray, FloatArray]:
        return decoded(self._colors)


def prepare(drawing: ToonImage | PreparedDrawing) -> PreparedDrawing:
    """
    Prepare a drawing for analysis.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing; one that is prepared returns as it is.

    Returns
    -------
    PreparedDrawing
        The drawing with all that is derived from it. Pass it on instead of the picture, and nothing is derived twice.

    Raises
    ------
    ToonkitError
        If the drawing is neither, or its object has more than `MOST_PIXELS` pixels.
    """
    if isinstance(drawing, PreparedDrawing):
        return drawing
    of_type("image", drawing, ToonImage)
    return PreparedDrawing(drawing)

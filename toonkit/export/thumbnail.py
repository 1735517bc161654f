"""Thumbnails: an analyzed drawing, cut out and reduced, painted from few of its pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.model.image import eight_bit
from toonkit.model.whole_pixels import opaque
from toonkit.numerics.masked_grid import bounding_box

SAMPLES = 3
"""Pixels of a drawing that are painted for a pixel of its thumbnail, at least, in a row and in a column."""

Places = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True, eq=False)
class Thumbnail:
    """
    Which pixels of a drawing its thumbnails show.

    Attributes
    ----------
    pixels : ndarray of int, shape (n + m,)
        Those of the object, counted in row-major order, and then those whose colors the m pixels of the fringe follow.
    object_places, fringe_places : ndarray of int, shapes (n,) and (m,)
        Where the n and the m are in the reduced picture, counted in row-major order.
    fringe_drawn, fringe_followed : ndarray, shape (m, 3)
        Colors of the fringe in the drawing, sRGB, and those that they follow.
    alpha : ndarray of uint8, shape (h, w)
        Coverage of the reduced picture.
    whole : (int, int)
        Height and width of the object with its fringe, not reduced.
    side : int
        The longer side of a thumbnail, in pixels.
    """

    pixels: NDArray[np.intp]
    object_places: NDArray[np.intp]
    fringe_places: NDArray[np.intp]
    fringe_drawn: FloatArray
    fringe_followed: FloatArray
    alpha: NDArray[np.uint8]
    whole: tuple[int, int]
    side: int

    @classmethod
    def of(cls, analysis: ToonAnalysis, side: int) -> Thumbnail:
        """Choose the pixels for thumbnails of some side."""
        image, drawing = analysis.image, analysis.drawing
        rows, columns = bounding_box(image.alpha > 0)
        whole = rows.stop - rows.start, columns.stop - columns.start
        step = max(1, max(whole) // (SAMPLES * side))
        if not image.mask[rows.start + step // 2 :: step, columns.start + step // 2 :: step].any():
            step = 1  # the object is finer than the grid
        top, left = rows.start + step // 2, columns.start + step // 2
        shown = slice(top, rows.stop, step), slice(left, columns.stop, step)
        mask = image.mask[shown]
        own, width = np.nonzero(mask), mask.shape[1]
        fringe = np.flatnonzero(_on_grid(image.fringe_places, (top, left), step))
        followed = image.fringe_pixels[fringe]
        box = [span.start for span in drawing.box]
        pixels = drawing.grid.index[own[0] * step + (top - box[0]), own[1] * step + (left - box[1])]
        return cls(
            pixels=np.concatenate([pixels, followed]).astype(np.intp),
            object_places=own[0] * width + own[1],
            fringe_places=(
                (image.fringe_places[0][fringe] - top) // step * width
                + (image.fringe_places[1][fringe] - left) // step
            ),
            fringe_drawn=image.fringe_colors[fringe],
            fringe_followed=image.pixels[followed],
            alpha=eight_bit(image.alpha[shown]),
            whole=whole,
            side=side,
        )

    @property
    def object_pixels(self) -> NDArray[np.intp]:
        """The first n of the pixels."""
        return self.pixels[: len(self.object_places)]

    def picture(self, colors: FloatArray, *, keep_detail: bool = True) -> Image.Image:
        """Paint the pixels in their order (n + m, 3); without its detail the fringe has the colors that it follows."""
        count = len(self.object_places)
        own, fringe = colors[:count], colors[count:]
        if keep_detail:
            fringe = np.clip(fringe + self.fringe_drawn - self.fringe_followed, 0.0, 1.0)
        rgba = np.zeros((*self.alpha.shape, 4), np.uint8)
        pixels = rgba.view(np.uint32).ravel()  # as wholes, they are put into place several times as fast
        for places, painted in ((self.object_places, own), (self.fringe_places, fringe)):
            pixels[places] = opaque(eight_bit(painted)).view(np.uint32).ravel()
        rgba[..., 3] = self.alpha
        return self._fitted(rgba)

    def of_object(self, colors: NDArray[np.uint8]) -> Image.Image:
        """Paint the pixels of the object alone, in colors (n, 3)."""
        rgba = np.zeros((*self.alpha.shape, 4), np.uint8)
        pixels = rgba.reshape(-1, 4)
        pixels[self.object_places, :3] = colors
        pixels[self.object_places, 3] = self.alpha.ravel()[self.object_places]
        return self._fitted(rgba)

    def _fitted(self, rgba: NDArray[np.uint8]) -> Image.Image:
        scale = self.side / max(self.whole)
        if scale >= 2:  # pixel art keeps its pixels
            return Image.fromarray(rgba.repeat(int(scale), axis=0).repeat(int(scale), axis=1))
        height, width = (max(1, round(length * scale)) for length in self.whole)
        return Image.fromarray(rgba).resize((width, height), Image.Resampling.LANCZOS)


def _on_grid(places: Places, first: tuple[int, int], step: int) -> NDArray[np.bool_]:
    """Tell which places lie in rows and columns that are shown: the first ones, and every `step` from there."""
    away = [at - start for at, start in zip(places, first, strict=True)]
    shown: NDArray[np.bool_] = np.logical_and(*((far >= 0) & (far % step == 0) for far in away))
    return shown

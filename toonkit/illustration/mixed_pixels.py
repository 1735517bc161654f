"""Mixed pixels: pixels that show ink or the paint of a neighboring material beside their own paint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.filling import Labels
from toonkit.model.luminance import luminance

REACH = 2
"""Distance from a border, in pixels, within which paint may be mixed with that on the other side."""

OFF_MIXTURE = 0.1
"""Greatest distance of a mixed pixel from the mixtures of two paints, in sRGB."""

LEAST_APART = 0.02
"""Distance of two paints, in sRGB, below which their mixtures cannot be distinguished from the paints."""

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class MixedPixels:
    """
    Pixels whose colors are composed of the paint of other pixels and of ink, which no light changes.

    Attributes
    ----------
    pixels : ndarray of int, shape (n,)
        Compact index of each, ascending.
    sources : ndarray of int, shape (n, 2)
        Those of the two pixels of pure paint that it shows: the first on its own side.
    shares : ndarray, shape (n, 2)
        How much of each it shows, 0 to 1; the rest is ink.
    drawn : ndarray, shape (n, 3)
        Colors as drawn, sRGB in [0, 1].
    highlit : ndarray of bool, shape (n,)
        Which of them show a highlight over the paint.
    """

    pixels: Indices
    sources: Indices
    shares: FloatArray
    drawn: FloatArray
    highlit: BoolArray

    def among(self, pixels: Indices) -> tuple[Indices, MixedPixels]:
        """Return which of some of the object's pixels (n,) are mixed, as places in that list, and these alone."""
        if len(self.pixels) == 0:
            return np.zeros(0, np.intp), self
        row = np.minimum(np.searchsorted(self.pixels, pixels), len(self.pixels) - 1)
        found = np.flatnonzero(self.pixels[row] == pixels)
        row = row[found]
        return found, MixedPixels(
            self.pixels[row], self.sources[row], self.shares[row], self.drawn[row], self.highlit[row]
        )

    def unmixed(self, paint: FloatArray) -> MixedPixels:
        """
        Return those of a drawing without anti-aliasing, in which no pixel shows more than one thing.

        They are ink where most of a pixel is ink, and highlights where it is brighter than the paint (n, 3) of its first
        source.
        """
        ink = ~self.highlit & (self.shares.sum(axis=1) < 0.5)
        kept = np.flatnonzero(ink | (self.highlit & (luminance(self.drawn) > luminance(paint))))
        return MixedPixels(
            self.pixels[kept],
            self.sources[kept],
            np.where(ink[kept, None], 0.0, self.shares[kept]),
            self.drawn[kept],
            self.highlit[kept],
        )

    def over(self, before: FloatArray, after: FloatArray, left: FloatArray | float = 1.0) -> FloatArray:
        """
        Return the colors (n, 3) of these pixels on other paint.

        The paint of the sources, (n, 2, 3) sRGB, is as drawn before, and as it has become after; `left` is how much of a
        highlight is left, 0 to 1.
        """
        colors: FloatArray = self.drawn + np.einsum("nk,nkc->nc", self.shares, after - before)
        gone = np.where(self.highlit, 1.0 - np.asarray(left), 0.0)
        colors -= gone[:, None] * (self.drawn - before[:, 0])
        return np.clip(colors, 0.0, 1.0)


def mixtures(
    color: FloatArray,
    coverage: FloatArray,
    labels: Labels,
    sources: Labels,
    highlights: BoolArray,
    mask: BoolArray,
) -> MixedPixels:
    """
    Unmix the pixels of an object.

    Parameters
    ----------
    color : ndarray, shape (h, w, 3)
        sRGB in [0, 1].
    coverage : ndarray, shape (h, w)
        Ink coverage of each pixel, 0 to 1.
    labels : ndarray of int, shape (h, w)
        Their materials.
    sources : ndarray of int, shape (h, w)
        Flat index of the pixel whose paint each shows; its own where it is pure.
    highlights : ndarray of bool, shape (h, w)
        Pixels that show a highlight.
    mask : ndarray of bool, shape (h, w)
        The object; False on the border of the array.

    Returns
    -------
    MixedPixels
        The pixels that are inked, or are not their own source.
    """
    flat = np.arange(mask.size).reshape(mask.shape)
    place = np.flatnonzero((mask & ((sources != flat) | (coverage > 0))).ravel())
    compact = np.cumsum(mask.ravel()) - 1
    near = sources.ravel()[place].astype(np.intp)
    covered = coverage.ravel()[place]
    highlit = highlights.ravel()[place] & (covered == 0)
    border = (covered == 0) & ~highlit
    far, share = near.copy(), np.zeros(len(place))
    far[border], share[border] = _other_sides(place[border], near[border], color, labels, sources, mask)
    shares = np.column_stack([1.0 - covered - share, share])
    return MixedPixels(
        compact[place],
        compact[np.column_stack([near, far])],
        shares,
        color.reshape(-1, 3)[place],
        highlit,
    )


def _other_sides(
    place: Indices, near: Indices, color: FloatArray, labels: Labels, sources: Labels, mask: BoolArray
) -> tuple[Indices, FloatArray]:
    """Find the pure pixel of another material that, mixed with the near one, explains each pixel best, and its share."""
    colors, materials = color.reshape(-1, 3), labels.ravel()
    height, width = mask.shape
    far, share = near.copy(), np.zeros(len(place))
    least = np.full(len(place), OFF_MIXTURE**2)
    own, start, material = colors[place], colors[near], materials[near]
    rows, columns = np.divmod(place, width)
    for down in range(-REACH, REACH + 1):
        for along in range(-REACH, REACH + 1):
            row, column = np.clip(rows + down, 0, height - 1), np.clip(columns + along, 0, width - 1)
            source = sources.ravel()[row * width + column].astype(np.intp)
            other = np.where(source >= 0, source, near)
            away = colors[other] - start
            square = np.einsum("nc,nc->n", away, away)
            part = np.einsum("nc,nc->n", own - start, away) / np.maximum(square, 1e-9)
            part = np.clip(part, 0.0, 1.0)
            off = own - start - part[:, None] * away
            miss = np.einsum("nc,nc->n", off, off)
            better = (materials[other] != material) & (square > LEAST_APART**2) & (miss < least)
            least[better], far[better], share[better] = miss[better], other[better], part[better]
    return far, share

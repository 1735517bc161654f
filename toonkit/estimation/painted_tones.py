"""The order of a drawing's colors, and which of them are mixtures, before any illumination is known (Section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.neighborhoods import grow_mask
from toonkit.model.luminance import REC709, linear_to_srgb, srgb_to_linear
from toonkit.numerics.masked_grid import IndexArray
from toonkit.numerics.parallel import run_on_chunks, run_on_row_chunks

FLAT = 2.5 / 255
"""Colors of one band differ by less than this: rounding, and a compressor's noise."""

FLAT_NEIGHBORS = 4
"""Fewest neighbors of its own tone that a pixel of a band has. A pixel of a band two pixels wide has five."""

SEAM, FREQUENT = 3, 4
"""Most steps of an 8-bit channel by which a seam differs from its paint, and how many times as many pixels the paint has."""

EDGE_REACH = 3
"""Distance from an edge, in pixels, within which it has seams."""

MIXING_REACH = 2
"""An anti-aliased band edge is at most this many pixels away from the bands it mixes."""

LEVELS = 65_536
"""Number of tones that are distinguished when pixels are sorted: the number of levels of a 16-bit channel."""

_PAIRS = ((0, 1), (1, 0), (1, 1), (1, -1))
"""(row, column) steps to four of a pixel's eight neighbors; the other four see it by the same steps."""


@dataclass(frozen=True, eq=False)
class OrderedLight:
    """
    The light of an object's pixels from the darkest to the brightest; those of one tone share theirs.

    Attributes
    ----------
    counts : ndarray of int, shape (n + 1,)
        How many pixels the k darkest tones have, for k of 0 to n.
    sums : ndarray, shape (n + 1, 3)
        The linear light of those pixels together.
    """

    counts: NDArray[np.intp]
    sums: FloatArray

    def of_darkest(self, pixels: NDArray[np.integer]) -> FloatArray:
        """Return the summed linear light (..., 3) of the given numbers (...) of darkest pixels."""
        channels = [np.interp(pixels, self.counts, channel) for channel in self.sums.T]
        return np.stack(channels, axis=-1)


@dataclass(frozen=True, eq=False)
class Mixtures:
    """
    The mixed pixels among some tones: few, which is why nothing is stored of the others.

    Attributes
    ----------
    pixels : ndarray of int, shape (m,)
        Their indices, ascending.
    nearer, darkest, brightest : ndarray, shape (m,)
        The tone of the nearer of the two bands that each mixes, and the tones of the bands that it lies between.
    noise : float
        See `PaintedTones`.
    """

    pixels: NDArray[np.intp]
    nearer: FloatArray
    darkest: FloatArray
    brightest: FloatArray
    noise: float

    def replaced(self, tone: FloatArray, own: FloatArray) -> FloatArray:
        """Return the tones (P,) with those of the mixed pixels replaced by others (m,)."""
        tones = tone.copy()
        tones[self.pixels] = own
        return tones


@dataclass(frozen=True, eq=False)
class PaintedTones:
    """
    Tones of an object's pixels, in row-major order.

    A pixel is flat if it has the tone of at least four of its neighbors, or of all of them if it has fewer. A pixel is
    mixed if it is not flat and its tone lies strictly between those of a darker and a brighter flat pixel within
    `MIXING_REACH` pixels. Wider transitions are not mixtures.

    Attributes
    ----------
    tone : ndarray, shape (P,)
        The tones, in [0, 1].
    mixtures : Mixtures
        The mixed pixels among them.
    ordered : OrderedLight
        The linear light in the order of the plain tones; a mixed pixel has that of the other pixels of its plain tone.
    """

    tone: FloatArray
    mixtures: Mixtures
    ordered: OrderedLight

    @classmethod
    def of(
        cls, colors: FloatArray, rows: IndexArray, columns: IndexArray, beside: BoolArray | None = None
    ) -> PaintedTones:
        """
        Read the colors (P, 3), sRGB in [0, 1], of pixels at some rows and columns (P,).

        If `beside` marks the pixels (P,) beside ink, highlights and other materials, seams are removed from these, and from
        the pixels within `EDGE_REACH` pixels of a mixed pixel.
        """
        light, tone = decoded(colors)
        mixtures = find_mixtures(tone, rows, columns)
        if beside is not None:
            near = beside | _near(mixtures.pixels, rows, columns)
            tone, mixtures = _without_seams(tone, mixtures, near)
        return cls(
            tone, mixtures, _in_order(light, mixtures.replaced(tone, mixtures.nearer), mixtures.pixels)
        )

    @property
    def plain(self) -> FloatArray:
        """Tones without mixtures, shape (P,): a mixed pixel takes the nearer tone of the two bands it mixes."""
        return self.mixtures.replaced(self.tone, self.mixtures.nearer)

    @property
    def darkest(self) -> FloatArray:
        """Tones of the darker bands that mixed pixels lie between; the tone itself of all others, shape (P,)."""
        return self.mixtures.replaced(self.tone, self.mixtures.darkest)

    @property
    def brightest(self) -> FloatArray:
        """Tones of the brighter bands that mixed pixels lie between; the tone itself of all others, shape (P,)."""
        return self.mixtures.replaced(self.tone, self.mixtures.brightest)

    @property
    def noise(self) -> float:
        """
        Standard deviation of the tones of one painted color.

        From the median second differences along rows and columns: zero for flat colors and for gradients, whatever the
        number of band edges.
        """
        return self.mixtures.noise


def find_mixtures(tone: FloatArray, rows: IndexArray, columns: IndexArray) -> Mixtures:
    """Find the mixed pixels among tones (P,) of pixels at some rows and columns (P,); see `PaintedTones`."""
    rows, columns = rows - rows.min(), columns - columns.min()
    reach = MIXING_REACH
    framed = np.full((rows.max() + 1 + 2 * reach, columns.max() + 1 + 2 * reach), np.nan)
    place = (rows + reach) * framed.shape[1] + columns + reach
    framed.ravel()[place] = tone
    level = np.zeros(framed.shape, np.bool_)
    run_on_row_chunks(_find_flat, framed, level)
    flat = level.ravel()[place]
    doubtful = np.flatnonzero(~flat)
    darker, brighter = _extremes(framed, place, flat, doubtful)
    own = tone[doubtful]
    between = (own > darker + FLAT) & (own < brighter - FLAT)
    mixed, own, darker, brighter = doubtful[between], own[between], darker[between], brighter[between]
    nearer = np.where(own - darker < brighter - own, darker, brighter)
    pure = np.ones(len(tone), np.bool_)
    pure[mixed] = False
    return Mixtures(mixed, nearer, *_extremes(framed, place, pure, mixed), _noise(framed))


def _near(pixels: NDArray[np.intp], rows: IndexArray, columns: IndexArray) -> BoolArray:
    """Mark which of the pixels at some rows and columns (P,) lie within `EDGE_REACH` of those with the given indices."""
    near = np.zeros(len(rows), np.bool_)
    if pixels.size:
        rows, columns = rows - rows.min(), columns - columns.min()
        marked = np.zeros((rows.max() + 1, columns.max() + 1), np.bool_)
        marked[rows[pixels], columns[pixels]] = True
        near = grow_mask(marked, EDGE_REACH)[rows, columns]
    return near


def _without_seams(tone: FloatArray, mixtures: Mixtures, near: BoolArray) -> tuple[FloatArray, Mixtures]:
    """
    Give pixels near an edge the tone of the paint that they differ from by a step or two.

    Scaling or compressing a picture leaves faint bright and dark seams along its edges. In the order of tones, seams would
    be the brightest and the darkest pixels of all.
    """
    if not near.any():
        return tone, mixtures
    level = np.rint(tone * 255).astype(np.intp)
    counts, levels = np.bincount(level, minlength=256), np.arange(256)
    usual = levels
    for step in range(1, SEAM + 1):
        for other in (np.maximum(levels - step, 0), np.minimum(levels + step, 255)):
            frequent = (counts[other] > FREQUENT * counts) & (counts[other] > counts[usual])
            usual = np.where(frequent, other, usual)
    usual = usual[usual[usual]]  # until the level is no other one's seam
    pure = np.ones(len(tone), np.bool_)
    pure[mixtures.pixels] = False
    shown = np.full(256, np.inf)
    np.minimum.at(shown, level[pure], tone[pure])  # the least one, whatever the order of pixels

    def settled(values: FloatArray) -> FloatArray:
        own = np.rint(values * 255).astype(np.intp)
        moved = (usual[own] != own) & np.isfinite(shown[usual[own]])
        return np.where(moved, shown[usual[own]], values)

    tone = tone.copy()
    tone[near] = settled(tone[near])
    nearer, darkest, brightest = map(settled, (mixtures.nearer, mixtures.darkest, mixtures.brightest))
    return tone, Mixtures(mixtures.pixels, nearer, darkest, brightest, mixtures.noise)


def _in_order(light: FloatArray, plain: FloatArray, mixed: NDArray[np.intp]) -> OrderedLight:
    """Order linear light (P, 3) by plain tones (P,)."""
    level = (plain * (LEVELS - 1) + 0.5).astype(np.intp)
    pixels = np.bincount(level, minlength=LEVELS)
    occurring = np.flatnonzero(pixels)
    pure = np.ones(len(level), np.bool_)
    pure[mixed] = False
    pure_pixels = np.bincount(level, weights=pure, minlength=LEVELS)[occurring]
    sums = [np.bincount(level, weights=pure * channel, minlength=LEVELS)[occurring] for channel in light.T]
    by_tone = np.stack(sums, axis=1) * (pixels[occurring] / pure_pixels)[:, None]
    return OrderedLight(
        np.append(0, np.cumsum(pixels[occurring])),
        np.concatenate([np.zeros((1, 3)), np.cumsum(by_tone, axis=0)]),
    )


def decoded(colors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return colors (P, 3), sRGB in [0, 1], as linear light, (P, 3), and their tones, (P,)."""
    light, tone = np.empty(colors.shape), np.empty(len(colors))
    run_on_chunks(_decode, len(colors), colors, light, tone)
    return light, tone


def _decode(colors: FloatArray, light: FloatArray, tone: FloatArray, piece: slice) -> None:
    """Write the light and the tones of colors."""
    light[piece] = srgb_to_linear(colors[piece])
    tone[piece] = linear_to_srgb(light[piece] @ REC709)


def _find_flat(framed: FloatArray, flat: BoolArray, first: int, last: int) -> None:
    """Mark the pixels of some rows that belong to a band."""
    above = min(first, 1)
    flat[first:last] = _is_flat(framed[first - above : last + 1])[above : above + last - first]


def _is_flat(framed: FloatArray) -> BoolArray:
    """Tell which pixels belong to a band: at a band's edge a mixed pixel resembles two neighbors along it at most."""
    alike, present = np.zeros((2, *framed.shape), np.int8)
    known = ~np.isnan(framed)
    height, width = framed.shape
    for down, along in _PAIRS:
        near = (slice(0, height - down), slice(max(-along, 0), width - max(along, 0)))
        far = (slice(down, height), slice(max(along, 0), width - max(-along, 0)))
        same = np.abs(framed[far] - framed[near]) < FLAT
        for place in (near, far):
            alike[place] += same
        present[near] += known[far]
        present[far] += known[near]
    flat: BoolArray = known & (alike >= np.minimum(present, FLAT_NEIGHBORS))
    return flat


def _extremes(
    framed: FloatArray, place: NDArray[np.intp], counted: BoolArray, pixels: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray]:
    """Least and greatest tone of the pixels that count within `MIXING_REACH` of some pixels; inf and -inf without any."""
    tones = np.full(framed.size, np.nan)
    tones[place[counted]] = framed.ravel()[place[counted]]
    least, greatest = np.full(len(pixels), np.inf), np.full(len(pixels), -np.inf)
    center, width = place[pixels], framed.shape[1]
    for down in range(-MIXING_REACH, MIXING_REACH + 1):
        for along in range(-MIXING_REACH, MIXING_REACH + 1):
            tone = tones[center + (down * width + along)]
            np.fmin(least, tone, out=least)
            np.fmax(greatest, tone, out=greatest)
    return least, greatest


def _noise(framed: FloatArray) -> float:
    return (_noise_along_rows(framed) + _noise_along_rows(framed.T)) / 2


def _noise_along_rows(framed: FloatArray) -> float:
    second = np.abs(framed[:, 2:] - 2 * framed[:, 1:-1] + framed[:, :-2])
    inside = second[np.isfinite(second)]
    if inside.size == 0:
        return 0.0
    # A second difference of independent noise has sqrt(6) times its deviation; the median of |x| is 0.6745 deviations.
    return float(np.median(inside) / (0.6745 * np.sqrt(6)))

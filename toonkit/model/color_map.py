"""ColorMap: the nonlinear reflectance M of c = M(L · N), and its inverse, an interval of illumination."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, as_array, as_real, is_count, is_number, refuse
from toonkit.model.description import preview_png
from toonkit.model.luminance import hex_color, tone

MONOTONE_TOLERANCE = 0.05
"""How far, in tone, a painted ramp may dip below an earlier sample: hue shifts and 8-bit colors wobble."""

INVERSE_SAMPLES = 1024
"""Least number of steps in which a map is inverted."""

PREVIEW_SIZE = (32, 512)
"""Height and width, in pixels, of the strip that notebooks show: illumination -1 at its left end to +1 at its right."""

NARROWEST = 1e-9
"""Least width of a color map's domain: the steps of a narrower one are lost in rounding."""

MOST_SAMPLES = 1 << 20
"""Samples of a resampled map at most, more than a thousand times those of a fitted one."""

HALF_STEP = 0.5 / 255
"""Half a step of an 8-bit picture: colors closer than this were painted alike."""


@dataclass(frozen=True, eq=False)
class IlluminationInterval:
    """
    Range of illumination that a painted color allows: I in [lower, upper] of Eq. 4.

    Attributes
    ----------
    lower, upper : ndarray, shape (...)
        Illumination, lower <= upper; NaN where the color was NaN.

    Raises
    ------
    ToonkitError
        If the bounds are no real numbers, differ in shape, or a lower bound lies above its upper one.
    """

    lower: FloatArray
    upper: FloatArray

    def __post_init__(self) -> None:
        lower, upper = as_real("lower", self.lower, copy=False), as_real("upper", self.upper, copy=False)
        if lower.shape != upper.shape:
            raise refuse("upper", f"must have the shape of lower {lower.shape}", upper.shape)
        if (lower > upper).any():
            raise refuse(
                "lower", "must not lie above upper", f"{int((lower > upper).sum())} intervals that do"
            )
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)

    def __repr__(self) -> str:
        known = ~np.isnan(self.lower)
        width = f", mean width {(self.upper - self.lower)[known].mean():.2f}" if known.any() else ""
        return f"IlluminationInterval(shape {self.lower.shape}{width})"


@dataclass(frozen=True, eq=False)
class ColorMap:
    """
    A color map M: illumination -> painted color.

    Parameters
    ----------
    colors : array_like, shape (K, 3)
        sRGB in [0, 1] at K >= 1 illuminations evenly spaced over the domain, dark to bright.
    domain : (float, float), optional
        Illumination of the first and last sample, -1 <= lo < hi <= 1.

    Raises
    ------
    ToonkitError
        If colors leave [0, 1], the ramp is not dark to bright, or the domain is not inside [-1, 1].

    Notes
    -----
    Between samples M is linear, outside its domain it is constant. Its inverse is an interval because a
    band of one color covers a range of illumination (Section 3.3, Eq. 4).

    Examples
    --------
    >>> two_tone = ColorMap([[0.2, 0.1, 0.3], [0.2, 0.1, 0.3], [0.9, 0.8, 0.6], [0.9, 0.8, 0.6]])
    >>> two_tone(0.9).tolist()
    [0.9, 0.8, 0.6]
    """

    colors: FloatArray
    domain: tuple[float, float] = (-1.0, 1.0)

    def __post_init__(self) -> None:
        colors = as_array("colors", self.colors, (None, 3))
        if len(colors) == 0:
            raise refuse("colors", "must hold at least one color", "none")
        if not np.isfinite(colors).all() or colors.min() < -1e-9 or colors.max() > 1 + 1e-9:
            raise refuse("colors", "must be sRGB in [0, 1]", f"{np.min(colors):.4g} to {np.max(colors):.4g}")
        ends = as_array("domain", self.domain, (2,))
        if not (np.isfinite(ends).all() and -1 <= ends[0] < ends[1] <= 1):
            raise refuse("domain", "must be (lo, hi) with -1 <= lo < hi <= 1", tuple(ends.tolist()))
        if ends[1] - ends[0] < NARROWEST:
            raise refuse("domain", f"must be at least {NARROWEST:g} wide", tuple(ends.tolist()))
        colors = np.clip(colors, 0.0, 1.0)
        tones = tone(colors)
        dip = float((np.maximum.accumulate(tones) - tones).max())
        if dip > MONOTONE_TOLERANCE:
            raise refuse(
                "colors",
                "must go from dark to bright in luminance",
                f"a ramp that falls by {dip:.3f} in tone",
            )
        object.__setattr__(self, "colors", colors)
        object.__setattr__(self, "domain", (float(ends[0]), float(ends[1])))

    def __repr__(self) -> str:
        lo, hi = self.domain
        ends = f"{hex_color(self.colors[0])} to {hex_color(self.colors[-1])}"
        samples = "1 sample" if len(self.colors) == 1 else f"{len(self.colors)} samples"
        return f"ColorMap({samples}, {ends}, illumination {lo:.2f} to {hi:.2f})"

    def _repr_png_(self) -> bytes:
        strip = self(np.linspace(-1.0, 1.0, PREVIEW_SIZE[1]))[None].repeat(PREVIEW_SIZE[0], axis=0)
        return preview_png(np.round(strip * 255).astype(np.uint8))

    @cached_property
    def illumination(self) -> FloatArray:
        """Illumination of each sample, shape (K,); a single sample stands at the middle of its domain."""
        lo, hi = self.domain
        return np.array([(lo + hi) / 2]) if len(self.colors) == 1 else np.linspace(lo, hi, len(self.colors))

    def __call__(self, illumination: ArrayLike) -> FloatArray:
        """
        Colors at the given illumination (any shape (...)): sRGB, shape (..., 3); NaN stays NaN.

        Values outside the domain take the color at its nearer end. Raises ToonkitError for anything but real numbers.
        """
        value = as_real("illumination", illumination, copy=False)
        lo, hi = self.domain
        count = len(self.colors)
        if count == 1:
            return np.where(np.isnan(value)[..., None], np.nan, self.colors[0])
        position = (np.clip(value, lo, hi) - lo) * ((count - 1) / (hi - lo))
        known = np.nan_to_num(position)
        start = np.minimum(known.astype(np.intp), count - 2)
        # More than one, by rounding, would leave the range of the ramp.
        weight = np.minimum(position - start, 1.0)[..., None]
        color: FloatArray = (1 - weight) * self.colors[start] + weight * self.colors[start + 1]
        return color

    def invert(self, color: ArrayLike, *, tolerance: float = HALF_STEP) -> IlluminationInterval:
        """
        Range of illumination that each color allows (the inverse of M, Eq. 4).

        Parameters
        ----------
        color : array_like, shape (..., 3)
            sRGB in [0, 1]; NaN gives NaN.
        tolerance : float, optional
            How far apart, in tone (0..1), two colors may be and still count as the same.

        Returns
        -------
        IlluminationInterval
            Bounds of shape (...). The darkest color reaches down to -1, the brightest up to +1.

        Raises
        ------
        ToonkitError
            If the tolerance is negative, or the color is no sRGB in [0, 1].
        """
        if not is_number(tolerance) or tolerance < 0:
            raise refuse("tolerance", "must be a number >= 0", tolerance)
        painted = as_real("color", color, copy=False)
        if painted.ndim == 0 or painted.shape[-1] != 3:
            raise refuse("color", "must have shape (..., 3)", painted.shape)
        if (painted < -1e-9).any() or (painted > 1 + 1e-9).any():
            raise refuse(
                "color", "must be sRGB in [0, 1]", f"{np.nanmin(painted):.4g} to {np.nanmax(painted):.4g}"
            )
        tones = tone(np.clip(painted, 0.0, 1.0))
        return self.allowed(tones - tolerance, tones + tolerance)

    def allowed(self, darkest: FloatArray, brightest: FloatArray) -> IlluminationInterval:
        """
        Range of illumination whose tones lie between two: see `invert`, which gives one color twice.

        Parameters
        ----------
        darkest, brightest : ndarray, shape (...)
            Tones; NaN gives NaN.

        Returns
        -------
        IlluminationInterval
            Bounds of shape (...).

        Raises
        ------
        ToonkitError
            If a tone is no real number.
        """
        darkest, brightest = (
            as_real(*tones, copy=False) for tones in (("darkest", darkest), ("brightest", brightest))
        )
        where, highest_so_far, lowest_to_come = self._tone_envelopes
        # Where the tones of a band are all the same, `interp` takes their last sample; backward it takes the first.
        lower = np.interp(-darkest, -highest_so_far[::-1], where[::-1])
        upper = np.interp(brightest, lowest_to_come, where)
        lower = np.where(darkest <= highest_so_far[0], -1.0, lower)
        upper = np.where(brightest >= lowest_to_come[-1], 1.0, np.maximum(upper, lower))
        unknown = np.isnan(darkest) | np.isnan(brightest)
        return IlluminationInterval(np.where(unknown, np.nan, lower), np.where(unknown, np.nan, upper))

    @cached_property
    def _tone_envelopes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Illuminations, and two nondecreasing envelopes of the tones: the highest so far, and the lowest still to come.

        They are equal for a monotone ramp. Where a ramp dips, a color's interval runs from the first
        illumination that is as bright to the last one that is as dark.
        """
        count = len(self.colors)
        where = self.illumination
        if count > 1:
            # Colors are linear between samples, their tones only nearly: so few samples that it shows get more between.
            where = np.linspace(*self.domain, (count - 1) * -(-INVERSE_SAMPLES // (count - 1)) + 1)
        tones = tone(self(where))
        return where, np.maximum.accumulate(tones), np.minimum.accumulate(tones[::-1])[::-1]

    def resampled(self, count: int) -> ColorMap:
        """Return the same map with `count` >= 2 evenly spaced samples over the same domain."""
        if not is_count(count, 2, MOST_SAMPLES):
            raise refuse("count", f"must be a whole number from 2 to {MOST_SAMPLES:,}", count)
        return ColorMap(self(np.linspace(*self.domain, count)), self.domain)

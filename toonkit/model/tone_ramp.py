"""ToneRamp: a color map as an artist thinks of it, a few tones, where each begins, and how soft the step to it is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from toonkit._validation import FloatArray, as_array, check_flag, describe_value, of_type, refuse
from toonkit.model.color_map import ColorMap
from toonkit.model.luminance import color_of_hex, hex_color

SAMPLES = 1024
"""Samples of the color map of a ramp, over all illuminations: a hard step passes over within one of them."""

MOST_TONES = 8
"""Tones of a ramp at most, for hands to have a hold of each."""

OFF_RAMP = 0.04
"""Color difference, in sRGB, up to which a ramp may be off the color map that it describes, and tones count as one."""

SHORTEST = 0.06
"""Illumination between two tones below which what lies between them is their step, whatever its colors."""

COARSER = 1.4
"""Factor by which `OFF_RAMP` is raised as long as a color map takes too many tones."""

_COLOR = re.compile("#(?:[0-9a-fA-F]{3}){1,2}")


@dataclass(frozen=True)
class ToneRamp:
    """
    Tones of a material, to be edited by hand; `ToonAnalysis.recolored` paints with them.

    Parameters
    ----------
    tones : sequence of str
        Colors as "#rrggbb", darkest first: 1 to 8.
    thresholds : sequence of float, optional
        Illumination halfway from each tone to the next one, rising, in [-1, 1].
    softness : sequence of float, optional
        Over how much illumination each passes to the next one, 0 to 2; 0 if not given.
    stays_flat : bool, optional
        True for a material that stays as drawn whatever the light.

    Raises
    ------
    ToonkitError
        If the tones are not colors or do not go from dark to bright, or thresholds and softness are out of range or not one
        for each step.

    Notes
    -----
    With tones t, thresholds θ and softness w the color at illumination x is t₀ + Σ (tₖ₊₁ - tₖ) clamp((x - θₖ) / wₖ + ½).

    Examples
    --------
    >>> ToneRamp(["#553366", "#ffddaa"], [0.2]).color_map()([0.0, 0.5]).round(2).tolist()
    [[0.33, 0.2, 0.4], [1.0, 0.87, 0.67]]
    """

    tones: Sequence[str]
    thresholds: Sequence[float] = ()
    softness: Sequence[float] = ()
    stays_flat: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        if not isinstance(self.tones, (list, tuple)) or not 1 <= len(self.tones) <= MOST_TONES:
            raise refuse("tones", f"must be a list of 1 to {MOST_TONES} colors", describe_value(self.tones))
        for text in self.tones:
            if not isinstance(text, str) or not _COLOR.fullmatch(text):
                raise refuse("tones", "must be colors as #rrggbb", describe_value(text))
        colors = [color_of_hex(text) for text in self.tones]
        steps = (len(colors) - 1,)
        thresholds = as_array("thresholds", self.thresholds, steps)
        softness = np.zeros(steps) if self.softness == () else as_array("softness", self.softness, steps)
        if not ((thresholds >= -1) & (thresholds <= 1)).all() or (np.diff(thresholds) < 0).any():
            raise refuse("thresholds", "must rise, from -1 to 1 at most", thresholds.tolist())
        if not ((softness >= 0) & (softness <= 2)).all():
            raise refuse("softness", "must lie in 0 to 2", softness.tolist())
        check_flag("stays_flat", self.stays_flat)
        object.__setattr__(self, "tones", tuple(hex_color(color) for color in colors))
        object.__setattr__(self, "thresholds", tuple(thresholds.tolist()))
        object.__setattr__(self, "softness", tuple(softness.tolist()))
        self.color_map()

    @classmethod
    def of(cls, color_map: ColorMap) -> ToneRamp:
        """
        Describe a color map by as few tones as show it.

        Parameters
        ----------
        color_map : ColorMap
            Any.

        Returns
        -------
        ToneRamp
            Mostly within `OFF_RAMP` of the color map; farther off if that takes more than `MOST_TONES` tones.
        """
        of_type("color_map", color_map, ColorMap)
        where = np.linspace(-1.0, 1.0, SAMPLES)
        colors = color_map(where)
        off = OFF_RAMP
        while len(runs := _runs(colors, off)) > MOST_TONES:
            off *= COARSER
        tones = [colors[first : last + 1].mean(axis=0) for first, last in runs]
        tones[0], tones[-1] = colors[0], colors[-1]
        ends = where[np.array(runs)]
        starts, stops = ends[:-1, 1], ends[1:, 0]
        return cls(
            [hex_color(tone) for tone in tones],
            np.round((starts + stops) / 2, 4).tolist(),
            np.round(stops - starts, 4).tolist(),
        )

    @property
    def colors(self) -> FloatArray:
        """The tones, sRGB in [0, 1], shape (n, 3)."""
        return np.array([color_of_hex(tone) for tone in self.tones])

    def color_map(self) -> ColorMap:
        """Return the color map that goes through the tones."""
        where, colors = np.linspace(-1.0, 1.0, SAMPLES), self.colors
        painted = np.repeat(colors[:1], SAMPLES, axis=0)
        for rise, threshold, width in zip(
            np.diff(colors, axis=0), self.thresholds, self.softness, strict=True
        ):
            share = np.clip((where - threshold) / max(width, 1e-6) + 0.5, 0.0, 1.0)
            painted += share[:, None] * rise
        return ColorMap(np.clip(painted, 0.0, 1.0))


def _runs(colors: FloatArray, off: float) -> list[tuple[int, int]]:
    """Return the first and last sample of each tone: between them colors (n, 3) pass evenly from one to the next."""
    corners = sorted(_corners(colors, 0, len(colors) - 1, off) | {0, len(colors) - 1})
    runs = [(corners[0], corners[0])]
    for corner in corners[1:]:
        first, last = runs[-1]
        if np.linalg.norm(colors[corner] - colors[last]) < off:
            runs[-1] = first, corner
        else:
            runs.append((corner, corner))
    shortest = SHORTEST * (len(colors) - 1) / 2
    steps = [runs[0]]
    for run, after in pairwise([*runs[1:], (len(colors), len(colors))]):
        if after[0] == len(colors) or after[0] - steps[-1][1] > shortest:
            steps.append(run)
    return steps


def _corners(colors: FloatArray, first: int, last: int, off: float) -> set[int]:
    """Return the samples between two at which a polygon within a distance of the colors bends (Douglas and Peucker)."""
    if last - first < 2:
        return set()
    share = np.linspace(0.0, 1.0, last - first + 1)[:, None]
    chord = (1.0 - share) * colors[first] + share * colors[last]
    away = np.linalg.norm(colors[first : last + 1] - chord, axis=1)
    farthest = int(away.argmax())
    if away[farthest] <= off:
        return set()
    middle = first + farthest
    return {middle} | _corners(colors, first, middle, off) | _corners(colors, middle, last, off)

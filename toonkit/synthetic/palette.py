"""Colors of materials: a base color from a family of colors, and the ramp of tones derived from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.oklab import oklab_to_srgb

Range = tuple[float, float]

FAMILIES: dict[str, tuple[Range, Range, tuple[Range, ...]]] = {
    "any": ((0.5, 0.85), (0.06, 0.18), ((0, 360),)),
    "vivid": ((0.55, 0.8), (0.13, 0.2), ((0, 360),)),
    "pale": ((0.82, 0.94), (0.02, 0.07), ((0, 360),)),
    "deep": ((0.32, 0.48), (0.05, 0.13), ((0, 360),)),
    "white": ((0.94, 1.0), (0.0, 0.015), ((0, 360),)),
    "gray": ((0.5, 0.78), (0.0, 0.02), ((230, 290),)),
    "black": ((0.18, 0.32), (0.0, 0.03), ((230, 300),)),
    "skin": ((0.58, 0.9), (0.05, 0.09), ((48, 68),)),
    "hair": ((0.28, 0.86), (0.03, 0.15), ((20, 100), (240, 360))),
    "wood": ((0.45, 0.65), (0.06, 0.1), ((50, 72),)),
    "brown": ((0.36, 0.52), (0.05, 0.09), ((40, 65),)),
    "red": ((0.52, 0.64), (0.16, 0.21), ((15, 32),)),
    "orange": ((0.68, 0.8), (0.12, 0.17), ((50, 68),)),
    "yellow": ((0.82, 0.92), (0.12, 0.18), ((85, 102),)),
    "green": ((0.5, 0.76), (0.1, 0.18), ((122, 155),)),
    "blue": ((0.5, 0.82), (0.06, 0.15), ((215, 265),)),
    "purple": ((0.4, 0.6), (0.1, 0.18), ((290, 330),)),
    "pink": ((0.74, 0.86), (0.08, 0.13), ((-10, 20),)),
}
"""OKLab lightness, chroma and hues (degrees) of families of colors."""

APART = 0.1
"""OKLab distance between base colors of two materials of one drawing, if that many colors can be found."""

_TRIES = 60
_SAMPLES = 401  # of a color map: a hard step is a two-hundredth of the illumination wide


@dataclass(frozen=True, eq=False)
class Shading:
    """
    Style of shading of a drawing, the same for all materials.

    Attributes
    ----------
    edges : tuple of float
        Illumination at which the darkest, the middle and the brightest step lie.
    softness : float
        Width of a step in illumination; 0 is hard.
    darkening : float
        Ratio of OKLab lightness from one tone to the next darker one.
    tint : ndarray, shape (2,)
        Offset of (a, b) from one tone to the next darker one: the hue toward which shadows shift.
    saturation : float
        Factor of (a, b) from one tone to the next darker one.
    """

    edges: tuple[float, float, float]
    softness: float
    darkening: float
    tint: FloatArray
    saturation: float


def random_shading(rng: np.random.Generator) -> Shading:
    """Draw how a painter shades: most steps are hard, and most shadows shift toward blue or purple."""
    middle = rng.uniform(0.1, 0.5)
    edges = (middle - rng.uniform(0.25, 0.5), middle, min(middle + rng.uniform(0.2, 0.4), 0.93))
    softness = 0.0 if rng.random() < 0.75 else rng.uniform(0.06, 0.3)
    cold = rng.random() < 0.8
    hue = np.deg2rad(rng.uniform(250, 310) if cold else rng.uniform(10, 50))
    tint = rng.uniform(0.0, 0.04) * np.array([np.cos(hue), np.sin(hue)])
    return Shading(edges, softness, rng.uniform(0.66, 0.84), tint, rng.uniform(0.85, 1.12))


def random_bases(families: Sequence[str], rng: np.random.Generator) -> FloatArray:
    """Draw a base color in OKLab for each family, (n, 3), no two alike."""
    chosen: list[FloatArray] = []
    for family in families:
        best, distance = _random_color(family, rng), -1.0
        for _ in range(_TRIES):
            candidate = _random_color(family, rng)
            nearest = min((float(np.linalg.norm(candidate - other)) for other in chosen), default=np.inf)
            if nearest > distance:
                best, distance = candidate, nearest
            if distance > APART:
                break
        chosen.append(best)
    return np.array(chosen)


def stepped_ramp(base: FloatArray, tones: int, shading: Shading, rng: np.random.Generator) -> ColorMap:
    """Make a color map of 1 to 4 tones around a base color, at the steps of the drawing."""
    darker = {1: 0, 2: 1, 3: int(rng.integers(1, 3)), 4: 2}[tones]  # tones below the base color
    colors = [_darker(base, step, shading) for step in range(darker, 0, -1)] + [base]
    colors += [_lighter(base)] * (tones - 1 - darker)
    first = 1 if darker < 2 else 0
    return tone_ramp(np.array(colors), shading.edges[first : first + tones - 1], shading.softness)


def tone_ramp(colors: FloatArray, edges: Sequence[float], softness: float) -> ColorMap:
    """Make a color map of tones in OKLab (k, 3), darkest first, with steps at k - 1 illuminations of a width `softness`."""
    srgb = np.clip(oklab_to_srgb(colors), 0.0, 1.0)
    if len(colors) == 1:
        return ColorMap(srgb)
    illumination = np.linspace(-1.0, 1.0, _SAMPLES)
    painted = np.tile(srgb[0], (_SAMPLES, 1))
    for edge, (dark, bright) in zip(edges, pairwise(srgb), strict=True):
        share = np.clip((illumination - edge) / max(softness, 1e-6) + 0.5, 0.0, 1.0)[:, None]
        painted += (bright - dark) * share**2 * (3 - 2 * share)
    return ColorMap(np.clip(painted, 0.0, 1.0))


def smooth_ramp(base: FloatArray, shading: Shading, rng: np.random.Generator) -> ColorMap:
    """Make a color map that passes gradually from shadow to light."""
    colors = np.array([_darker(base, 2, shading), _darker(base, 1, shading), base, _lighter(base)])
    places = np.array([-0.5, shading.edges[0], shading.edges[1] + 0.1, rng.uniform(0.9, 1.0)])
    if rng.random() < 0.5:
        colors, places = colors[:3], np.array([-0.3, shading.edges[0] + 0.2, places[3]])
    illumination = np.linspace(-1.0, 1.0, _SAMPLES)
    mixed = np.stack([np.interp(illumination, places, colors[:, k]) for k in range(3)], axis=-1)
    return ColorMap(np.clip(oklab_to_srgb(mixed), 0.0, 1.0))


def _darker(base: FloatArray, steps: int, shading: Shading) -> FloatArray:
    lightness = base[0] * shading.darkening**steps
    # Dark paints get darker by less, or they would all end in black.
    floor = min(0.12, 0.7 * base[0])
    chroma = base[1:] * shading.saturation**steps + shading.tint * steps
    return np.array([max(lightness, floor), *chroma])


def _lighter(base: FloatArray) -> FloatArray:
    return np.array([base[0] + 0.4 * (1.0 - base[0]), *(0.75 * base[1:])])


def _random_color(family: str, rng: np.random.Generator) -> FloatArray:
    lightness, chroma, hues = FAMILIES[family]
    light, colorful = rng.uniform(*lightness), rng.uniform(*chroma)
    hue = np.deg2rad(rng.uniform(*hues[int(rng.integers(len(hues)))]))
    return np.array([light, colorful * np.cos(hue), colorful * np.sin(hue)])

"""Ink: outlines, lines where one part ends in front of another or meets it, creases and marks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, zoom

from toonkit._validation import BoolArray, FloatArray
from toonkit.model.oklab import oklab_to_srgb, srgb_to_oklab
from toonkit.synthetic.surface_samples import SUBPIXELS, Samples

REFERENCE_SIZE = 256
"""Picture width, in pixels, to which line widths refer."""

WIDTHS = (1.0, 3.0)
"""Range of line widths of a drawing, in pixels at `REFERENCE_SIZE`."""

UNINKED = 0.08
"""Probability that a drawing has no lines."""

_JUMP = (
    6.0  # minimum depth step of an occlusion edge, in subpixels, beyond what the surface slope accounts for
)
_MIN_NZ = 0.3  # lower bound of n_z in a slope, which is unbounded at the rim
_CREASE_COSINE = 0.75  # creases are drawn where the cosine between neighboring normals is below this


@dataclass(frozen=True, eq=False)
class Ink:
    """
    Line art of a drawing.

    Attributes
    ----------
    covered : ndarray of bool, shape (n,)
        True for samples that the ink covers.
    color : ndarray, shape (n, 3)
        sRGB color of the ink at each sample.
    """

    covered: BoolArray
    color: FloatArray


@dataclass(frozen=True)
class Hand:
    """
    Style of the lines, and which lines there are.

    Attributes
    ----------
    outline, inner : float
        Widths of the outline (0: none) and of inner lines, in pixels at `REFERENCE_SIZE`.
    missing : float
        Probability that there is no line between two parts.
    patterns, creases : bool
        Whether patterns are outlined, and creases drawn.
    taper : float
        Variation of the width of lines, 0 to 1.
    """

    outline: float
    inner: float
    missing: float = 0.0
    patterns: bool = False
    creases: bool = False
    taper: float = 0.0


def random_ink(samples: Samples, bases: FloatArray, rng: np.random.Generator) -> Ink:
    """Draw line art; `bases` (m, 3) are the sRGB colors of the materials, from which tinted lines take their color."""
    color = _ink_colors(samples, bases, rng)
    if rng.random() < UNINKED:
        return Ink(np.zeros(len(samples.pixel), np.bool_), color)
    width = rng.uniform(*WIDTHS)
    hand = Hand(
        outline=width * rng.uniform(1.0, 1.3) if rng.random() < 0.92 else 0.0,
        inner=width * rng.uniform(0.55, 1.0),
        missing=float(rng.choice([0.0, 0.35], p=[0.7, 0.3])),
        patterns=bool(rng.random() < 0.25),
        creases=bool(rng.random() < 0.6),
        taper=float(rng.choice([0.0, 0.35, 0.8], p=[0.5, 0.3, 0.2])),
    )
    return draw_ink(samples, hand, color, rng)


def draw_ink(samples: Samples, hand: Hand, color: FloatArray, rng: np.random.Generator) -> Ink:
    """Draw line art in a given style; `color` (n, 3) is the sRGB color that the ink has at each sample."""
    unit = SUBPIXELS * samples.size / REFERENCE_SIZE
    seen = samples.seen
    pressure = _width_factor(seen.shape[0], hand.taper, rng)
    covered = np.zeros_like(seen)
    if hand.outline > 0:
        away, nearest = distance_transform_edt(np.pad(seen, 1), return_indices=True)
        rows, columns = (np.clip(index[1:-1, 1:-1] - 1, 0, len(seen) - 1) for index in nearest)
        covered |= away[1:-1, 1:-1] - 0.5 <= hand.outline * unit * pressure[rows, columns]
    lines = _inner_lines(samples, hand, rng)
    if lines.any():
        away, (rows, columns) = distance_transform_edt(~lines, return_indices=True)
        covered |= away <= hand.inner * unit / 2 * pressure[rows, columns]
    return Ink(covered[seen] | samples.marked, color)


def _width_factor(count: int, taper: float, rng: np.random.Generator) -> FloatArray:
    """Return line widths relative to the nominal width, per subpixel: constant, or varying smoothly."""
    if taper == 0.0:
        return np.ones((count, count))
    coarse = rng.normal(size=(9, 9))
    smooth = zoom(coarse, (count + 8) / 9, order=3)[:count, :count]
    return np.asarray(np.clip(1.0 - 0.4 * taper + taper * smooth, 0.0, 1.3))


def _inner_lines(samples: Samples, hand: Hand, rng: np.random.Generator) -> BoolArray:
    """Mark subpixels on lines inside the silhouette."""
    hits, seen = samples.hits, samples.seen
    part = hits.part.astype(np.int64)
    count = int(part.max()) + 2
    drawn = rng.random((count, count)) >= hand.missing  # whether the line between two parts is drawn
    drawn |= drawn.T
    slope = np.hypot(hits.normals[..., 0], hits.normals[..., 1]) / np.maximum(hits.normals[..., 2], _MIN_NZ)
    depth = np.where(seen, hits.depth, 0.0) / samples.spacing
    material = samples.on_grid(samples.material, outside=-1)
    lines = np.zeros_like(seen)
    for here, there in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        inside = seen[here] & seen[there]
        other = part[here] != part[there]
        wanted = other & drawn[part[here], part[there]]
        fall = depth[here] - depth[there]
        wanted |= np.abs(fall) > slope[here] + slope[there] + _JUMP
        if hand.creases:
            turn = np.einsum("rck,rck->rc", hits.normals[here], hits.normals[there])
            wanted |= ~other & (turn < _CREASE_COSINE)
        if hand.patterns:
            wanted |= ~other & (material[here] != material[there])
        wanted &= inside
        lines[here] |= wanted & (fall >= 0)
        lines[there] |= wanted & (fall < 0)
    return lines


def _ink_colors(samples: Samples, bases: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the color of the ink at each sample (n, 3): one color, or a dark shade of the material beneath."""
    kind = rng.choice(["black", "brown", "deep", "gray", "tinted"], p=[0.36, 0.16, 0.14, 0.12, 0.22])
    if kind == "tinted":
        lab = srgb_to_oklab(bases)
        lab[:, 0] = np.minimum(lab[:, 0] * rng.uniform(0.35, 0.5), 0.42)
        lab[:, 1:] *= rng.uniform(0.7, 1.0)
        return np.clip(oklab_to_srgb(lab), 0.0, 1.0)[samples.material]
    lightness, chroma, hue = {
        "black": (rng.uniform(0.0, 0.18), rng.uniform(0.0, 0.02), rng.uniform(0, 360)),
        "brown": (rng.uniform(0.2, 0.34), rng.uniform(0.03, 0.06), rng.uniform(30, 60)),
        "deep": (rng.uniform(0.2, 0.38), rng.uniform(0.05, 0.12), rng.uniform(240, 380)),
        "gray": (
            rng.uniform(0.38, 0.52),
            rng.uniform(0.0, 0.03),
            rng.uniform(0, 360),
        ),  # often lighter than paint
    }[str(kind)]
    turn = np.deg2rad(hue)
    color = oklab_to_srgb([lightness, chroma * np.cos(turn), chroma * np.sin(turn)])
    flat: NDArray[np.float64] = np.clip(color, 0.0, 1.0)
    return np.tile(flat, (len(samples.pixel), 1))

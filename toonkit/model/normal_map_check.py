"""What a normal map is off by: vectors that are not of unit length, and a green axis that disagrees with the outline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray

OFF_UNIT = 0.1
"""A vector this far off unit length is more than rounded."""

MOST_OFF = 0.5
"""Share of vectors off unit length from which on a picture is no normal map that blending or resizing has touched."""

DISAGREEMENT = -0.5
"""Correlation with the outward direction below which an axis of the rim's normals points inward."""

MIN_RIM = 32
"""Rim pixels from which on their normals are compared with the outline."""

_CONCENTRATED = 0.12  # half of the lengths lie within this share of their median
_BEHIND = -0.1  # z of a vector that clearly points away


@dataclass(frozen=True)
class NormalMapCheck:
    """
    What is odd about a normal map.

    Attributes
    ----------
    pixels : int
        Pixels of the object.
    off_unit : int
        Those whose vector is more than `OFF_UNIT` off unit length.
    worst : float
        The length farthest from one.
    outward : (float, float)
        How far the horizontal and the vertical components of the normals at the rim agree with the direction out of the
        object: 1 if they point outward, -1 if inward, NaN if the rim is too short or its normals do not vary.
    problem : str
        Why the picture cannot be a normal map; empty if it can.
    """

    pixels: int
    off_unit: int
    worst: float
    outward: tuple[float, float]
    problem: str

    @property
    def mirrored(self) -> tuple[bool, bool]:
        """Whether the horizontal, and the vertical, components point inward at the rim."""
        across, up = self.outward
        return across < DISAGREEMENT, up < DISAGREEMENT


def check_normal_map(vectors: FloatArray, mask: BoolArray) -> NormalMapCheck:
    """Examine decoded vectors (H, W, 3), x right, y up, z toward the viewer, before they are renormalized."""
    inside = vectors[mask]
    length = np.linalg.norm(inside, axis=1)
    off = np.abs(length - 1) > OFF_UNIT
    return NormalMapCheck(
        pixels=len(inside),
        off_unit=int(off.sum()),
        worst=float(length[np.argmax(np.abs(length - 1))]),
        outward=_outward(vectors, mask),
        problem=_problem(inside, length) if off.mean() > MOST_OFF else "",
    )


def _problem(vectors: FloatArray, length: FloatArray) -> str:
    """Say what the colors of vectors that are mostly off unit length may be instead."""
    share = f"{(np.abs(length - 1) > OFF_UNIT).mean():.0%} of the vectors more than {OFF_UNIT:.0%} off unit length"
    z_from_zero = np.linalg.norm(np.column_stack([vectors[:, :2], (vectors[:, 2] + 1) / 2]), axis=1)
    if (np.abs(z_from_zero - 1) <= OFF_UNIT).mean() > MOST_OFF:
        return f"{share}: blue holds z from 0 to 1"
    low, median, high = np.percentile(length, [25, 50, 75])
    if high - low <= 2 * _CONCENTRATED * median and (vectors[:, 2] < _BEHIND).mean() < MOST_OFF:
        return (
            f"{share}, most about {median:.2f} long: a color-managed render "
            '(export it without color management, in Blender with view transform "Raw")'
        )
    return f"{share}: a picture of something else"


def _outward(vectors: FloatArray, mask: BoolArray) -> tuple[float, float]:
    """Correlate the normals of the rim with the direction out of the object, across and up."""
    padded = np.pad(mask, 4)
    rim = (padded & ~ndimage.binary_erosion(padded))[4:-4, 4:-4]
    if int(rim.sum()) < MIN_RIM:
        return (float("nan"), float("nan"))
    # Wide enough to see past the steps of single pixels.
    coverage = ndimage.gaussian_filter(padded.astype(np.float64), 1.5)
    down, across = (slope[4:-4, 4:-4][rim] for slope in np.gradient(coverage))
    return _correlation(vectors[rim, 0], -across), _correlation(vectors[rim, 1], down)


def _correlation(one: FloatArray, other: FloatArray) -> float:
    scale = float(np.sqrt((one * one).sum() * (other * other).sum()))
    return float((one * other).sum()) / scale if scale > 1e-9 else float("nan")

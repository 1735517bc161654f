"""
Materials: which pixels are painted with the same ramp of colors.

The paint beside the ink falls into zones that are flat or change smoothly, their colors into tones, and tones into
materials. A wrong merge bleeds one material's color into another; a wrong split only leaves some painted shading behind. So
in doubt tones stay apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.illustration.filling import Labels, nearest_sources
from toonkit.illustration.frame import Frame
from toonkit.illustration.ink import PAINT
from toonkit.illustration.ramps import Facing, Groups, join_tones
from toonkit.illustration.tones import Tones, find_tones
from toonkit.illustration.zones import find_zones

TONE_SHARE = 0.01
"""Share of a material's pixels that a color must have to be listed as one of its tones."""


@dataclass(frozen=True, eq=False)
class Materials:
    """
    The materials of a drawing, the largest first.

    Attributes
    ----------
    labels : ndarray of int, shape (H, W)
        Material of each pixel, -1 outside the mask. Under ink it is that of the paint beside it.
    tones : tuple of ndarray, shape (k, 3)
        For each material its colors, sRGB in [0, 1], darkest first.
    """

    labels: NDArray[np.intp]
    tones: tuple[FloatArray, ...]

    @property
    def count(self) -> int:
        """How many materials there are."""
        return len(self.tones)


def label_materials(
    color: FloatArray,
    mask: NDArray[np.bool_],
    *,
    coverage: FloatArray | None = None,
    normals: FloatArray | None = None,
    light: FloatArray | None = None,
) -> Materials:
    """
    Find the materials of a drawing.

    Parameters
    ----------
    color : ndarray, shape (H, W, 3)
        sRGB in [0, 1] on the mask; ignored elsewhere.
    mask : ndarray of bool, shape (H, W)
        The object.
    coverage : ndarray, shape (H, W), optional
        How much of each pixel is ink, as `find_ink` says; none by default.
    normals : ndarray, shape (H, W, 3), optional
        Initial normals of the silhouette. Without them a drawing in one material whose hue turns far is split.
    light : ndarray, shape (3,), optional
        Unit vector toward the light, if it is known.

    Returns
    -------
    Materials
        At least one.

    Examples
    --------
    >>> color = np.full((32, 32, 3), (0.8, 0.2, 0.2))
    >>> color[:, 16:] = (0.2, 0.3, 0.8)
    >>> label_materials(color, np.ones((32, 32), bool)).count
    2
    """
    frame = Frame.around(color, mask)
    inked = frame.cut(np.zeros(mask.shape) if coverage is None else np.asarray(coverage, np.float64))
    paint = frame.mask & (inked < PAINT)
    if not paint.any():
        paint = frame.mask
    zones = find_zones(frame.lab, paint)
    tones = find_tones(zones)
    facing = None if normals is None else _facing(tones, frame, normals, light, bool((inked > 0).any()))
    labels, area = _numbered(tones, join_tones(tones, facing))
    source = nearest_sources(labels >= 0, frame.lab, frame.mask)
    labels = np.where(source >= 0, labels.ravel()[source], -1)
    whole = np.asarray(frame.embed(labels.astype(np.intp), mask.shape, -1))
    return Materials(np.where(mask, whole, -1), _colors(frame, tones, labels, len(area)))


def _facing(tones: Tones, frame: Frame, normals: FloatArray, light: FloatArray | None, inked: bool) -> Facing:
    """Sum the normals beneath each tone."""
    paint = tones.labels >= 0
    beneath = np.nan_to_num(np.asarray(frame.cut(normals))[paint])
    tone = tones.labels[paint]
    sums = [np.bincount(tone, component, len(tones.area)) for component in beneath.T]
    return Facing(np.column_stack(sums), beneath.T @ beneath, light, inked)


def _numbered(tones: Tones, group: Groups) -> tuple[Labels, NDArray[np.intp]]:
    """Assign numbers to materials by area, the largest first, and among equal ones the darker first."""
    _, which = np.unique(group, return_inverse=True)
    area = np.bincount(which, tones.area).astype(np.intp)
    darkest = np.full(len(area), len(group))
    np.minimum.at(darkest, which, np.arange(len(group)))
    order = np.lexsort((darkest, -area))
    rank = np.argsort(order)[which]
    labels = np.where(tones.labels >= 0, rank[tones.labels], -1).astype(np.int32)
    return labels, area[order]


def _colors(frame: Frame, tones: Tones, labels: Labels, count: int) -> tuple[FloatArray, ...]:
    """Mean sRGB of each material's tones."""
    paint = tones.labels >= 0
    tone, material = tones.labels[paint], labels[paint]
    number = len(tones.area)
    sums = [np.bincount(tone, channel, number) for channel in frame.color[paint].T]
    means = np.column_stack(sums) / tones.area[:, None]
    owner = np.zeros(number, np.intp)
    owner[tone] = material
    whole = np.bincount(owner, tones.area, count)
    large = tones.area >= TONE_SHARE * whole[owner]
    return tuple(means[large & (owner == which)] for which in range(count))

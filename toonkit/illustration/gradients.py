"""Gradients between paints: where one material is painted with several hues that run into each other."""

from __future__ import annotations

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.ramps import Groups
from toonkit.illustration.tones import Tones
from toonkit.illustration.zones import SAME, Zones

SURROUNDINGS = 25
"""Width of the window in which the change of the paint is measured, in pixels."""

STEEPER = 1.6
"""Change of the paint at a border, relative to that around it, above which the border is an edge, however blurred."""

SMOOTH = 0.7
"""Share of the border between two groups of tones that must not be an edge for them to be joined."""

LEAST, COMPARABLE = 0.01, 0.2
"""Least area of a group relative to all paint, and to the other group: a blush does not turn a cheek into a gradient."""


def join_gradients(tones: Tones, zones: Zones, group: Groups) -> tuple[Groups, BoolArray]:
    """
    Join the groups of tones that run into each other.

    No ramp explains the colors of such groups: otherwise they would be one group. So their hues are painted, not shaded.

    Parameters
    ----------
    tones : Tones
        The tones of the paint.
    zones : Zones
        The zones of the paint.
    group : ndarray of int, shape (n,)
        The label of each tone.

    Returns
    -------
    group : ndarray of int, shape (n,)
        Labels with such groups joined.
    painted : ndarray of bool, shape (n,)
        True for the tones of the joined groups.
    """
    names, which = np.unique(group, return_inverse=True)
    count = len(names)
    area = np.bincount(which, tones.area, count)
    smaller, larger = np.minimum(area[:, None], area), np.maximum(area[:, None], area)

    def is_smooth(smooth: FloatArray, border: FloatArray) -> BoolArray:
        return (smooth > SMOOTH * border) & (smooth > np.sqrt(smaller))

    # Where paint has no edge it is one zone, which is known already and rules out most drawings.
    member = np.eye(count)[which]
    joined = is_smooth(member.T @ tones.smooth @ member, member.T @ tones.contact @ member)
    joined &= (
        (smaller > LEAST * area.sum()) & (smaller > COMPARABLE * larger) & ~np.eye(count, dtype=np.bool_)
    )
    if not joined.any():
        return group, np.zeros(len(group), np.bool_)
    border, smooth = _borders(zones, np.where(tones.labels >= 0, which[tones.labels], -1), count)
    joined &= is_smooth(smooth, border)
    _, part = connected_components(coo_array(joined), directed=False)
    painted = np.bincount(part)[part] > 1
    return names[np.unique(part, return_index=True)[1]][part][which], painted[which]


def _borders(zones: Zones, labels: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Count the pairs of neighboring pixels in any two groups, labels (h, w), and those without an edge between them."""
    border, smooth = np.zeros((2, count, count))
    for axis in (0, 1):
        lab, zone, group = (np.moveaxis(values, axis, 0) for values in (zones.lab, zones.labels, labels))
        change = np.linalg.norm(lab[1:] - lab[:-1], axis=-1)
        inside = (zone[1:] == zone[:-1]) & (zone[1:] >= 0)
        around = ndimage.uniform_filter(np.where(inside, change, 0.0), SURROUNDINGS)
        around /= np.maximum(ndimage.uniform_filter(inside.astype(np.float64), SURROUNDINGS), 1e-9)
        no_edge = inside & ((change < SAME) | (change < STEEPER * around))
        meet = (group[1:] != group[:-1]) & (group[1:] >= 0) & (group[:-1] >= 0)
        pair = group[1:][meet] * count + group[:-1][meet]
        border += np.bincount(pair, minlength=count**2).reshape(count, count)
        smooth += np.bincount(pair, no_edge[meet], count**2).reshape(count, count)
    return border + border.T, smooth + smooth.T

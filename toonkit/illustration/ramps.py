"""
Ramps: decide which tones are shades of one material.

There are two kinds of evidence. The first is color. Groups of tones are merged by complete linkage: only if every pair
of their tones could be shades of one paint. The color of a shade lies near the ray from black through the brighter
tone. The farther it is from the ray, the darker it must be. Mixtures of two paints fit neither paint, so they do not
chain two materials together. The second is where tones touch. A step of shading is small, its boundary is long relative
to the tones' perimeters, and its bright side faces the light, which is the same for the whole drawing.

A drawing in one material is recognized as a whole: see `toonkit.illustration.one_ramp`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray
from toonkit.illustration.contact_cues import SPOT, contact_log_odds, enclosed_share
from toonkit.illustration.facing import Facing, explain_by_normals
from toonkit.illustration.one_ramp import LARGE, is_one_ramp
from toonkit.illustration.shades import out_of_range, shade_cost
from toonkit.illustration.tones import Matrix, Tones

LARGEST_SMOOTH_COST = 2.1
"""Maximum cost for merging groups whose contact is mostly smooth. A change of material would leave a visible edge."""

SMALL = 0.0006
"""Tones that cover at most this share of the paint cannot prevent a merge."""

LARGEST_COST = 1.2
"""Maximum cost at which the tones of two groups may be shades of one paint."""

STEP = 0.06
"""Minimum lightness difference between a spot and the tone that encloses it."""

UNLIKE, NO_HIGHLIGHT = 1.3, 0.55
"""Minimum cost for a bright spot to be a separate paint. Minimum excess of its mean illumination over that of the
enclosing tone, in standard deviations, for it to be a highlight instead."""

Groups = NDArray[np.intp]


def join_tones(tones: Tones, facing: Facing) -> Groups:
    """Group tones into materials: the label (n,) of each, arbitrary and not consecutive."""
    spots = _spots(tones, facing)
    others = np.flatnonzero(~spots)
    if is_one_ramp(tones.only(others), facing.only(others)):
        return np.where(spots, np.arange(len(spots)), others[0])
    large = tones.area > SMALL * tones.area.sum()
    cost = shade_cost(tones.lab)
    log_odds = contact_log_odds(tones, cost, facing)
    # A pair out of range forbids a merge, unless one of its tones is small.
    limited = np.where(out_of_range(tones.lab), np.maximum(cost, 2.0 * LARGEST_COST), cost)
    limited = np.where(large[:, None] & large, limited, np.minimum(limited, 0.9))
    return _agglomerate(limited, log_odds, tones)


def _spots(tones: Tones, facing: Facing) -> BoolArray:
    """Find tones (n,) enclosed by one other tone with a hard edge that are neither highlights nor shadows on it.

    Shadows reach the silhouette, so they are not enclosed. A bright spot is a highlight, not a separate paint, if its color
    could be a shade of the enclosing paint or if it faces the light more.
    """
    area = tones.area.astype(np.float64)
    large = area > LARGE * area.sum()
    rise = tones.lab[None, :, 0] - tones.lab[:, None, 0]
    enclosed = np.where(large & large[:, None], enclosed_share(tones), 0.0)
    _, light = explain_by_normals(tones.lab[:, 0], area, facing)
    mean = facing.sums @ light / area
    variance = np.maximum(np.einsum("nij,i,j->n", facing.moments, light, light) / area - mean**2, 1e-6)
    apart = (mean[:, None] - mean) / np.sqrt((variance[:, None] + variance) / 2)
    dark = (rise > STEP) & (enclosed > SPOT[1])
    bright = (rise < -STEP) & (enclosed > SPOT[0]) & (apart < NO_HIGHLIGHT) & (shade_cost(tones.lab) > UNLIKE)
    spots: BoolArray = (dark | bright).any(axis=1)
    return spots


def _agglomerate(cost: Matrix, log_odds: Matrix, tones: Tones) -> Groups:
    """Repeatedly merge the pair of touching groups with the highest mean log-odds, until none is positive."""
    count = len(cost)
    group, alive = np.arange(count), np.ones(count, np.bool_)
    cost, weight, weighted, smooth = (
        cost.copy(),
        tones.contact.copy(),
        tones.contact * log_odds,
        tones.smooth.copy(),
    )
    alone = np.eye(count, dtype=np.bool_)
    while True:
        most = np.where(smooth > 0.8 * weight, LARGEST_SMOOTH_COST, LARGEST_COST)
        possible: BoolArray = (weight > 0) & (cost <= most) & alive[:, None] & alive & ~alone
        mean = np.where(possible, weighted / np.maximum(weight, 1e-9), -np.inf)
        i, j = divmod(int(mean.argmax()), count)
        if mean[i, j] <= 0.0:
            return group
        cost[i] = cost[:, i] = np.maximum(cost[i], cost[j])
        for sums in (weight, weighted, smooth):
            sums[i] += sums[j]
            sums[:, i] += sums[:, j]
        alive[j] = False
        group[group == j] = i

"""Recognize a drawing that is painted in one material, however the hue of its ramp turns."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from toonkit.illustration.facing import Facing, explain_by_normals
from toonkit.illustration.shades import COLORED, shade_cost
from toonkit.illustration.tones import Tones

LARGE = 0.002
"""Minimum share of the paint for a tone to be considered in `is_one_ramp`."""

MAX_HUE_REVERSAL = 1.0
"""Maximum hue reversal of a ramp from dark to bright, in radians; see `_hue_reversal`."""

AMBIGUOUS = 0.015
"""Maximum share of the paint with different colors at equal lightness. Brushwork causes a little of this within one ramp."""

STEEPEST = 2.0
"""Maximum cost between consecutive tones of one ramp."""

HIDDEN = 1.35
"""Maximum cost between consecutive tones of one ramp that do not touch."""


def is_one_ramp(tones: Tones, facing: Facing) -> bool:
    """
    Tell whether a whole drawing is one material, however its hue turns.

    The tones of one material form a curve: tones of equal lightness have the same color, and the hue turns in one
    direction. Each tone touches the next one. The lightness follows the initial normals under some light from the
    front, and no brighter tone faces away from that light more than a darker one.
    """
    area, lightness = tones.area.astype(np.float64), tones.lab[:, 0]
    total = area.sum()
    smaller = np.minimum(area[:, None], area)
    rise = lightness[None, :] - lightness[:, None]
    apart = np.linalg.norm(tones.lab[:, None] - tones.lab, axis=2)
    ambiguous = (smaller * ((np.abs(rise) < 0.03) & (apart > 0.05))).sum() > AMBIGUOUS * total
    if ambiguous or _hue_reversal(tones) > MAX_HUE_REVERSAL or _steepest(tones) > STEEPEST:
        return False
    explained, light = explain_by_normals(lightness, area, facing)
    if explained < 0.1 or light[2] < -0.32:
        return False
    illumination = facing.sums @ light / area
    brighter = smaller * (rise > 0.03)
    wrong = np.clip(illumination[:, None] - illumination + 0.02, 0.0, 0.2) / 0.2
    reversed_share = (brighter * wrong).sum() / max(brighter.sum(), 1e-9)
    hidden = _hidden_steps(tones, 1.5 if facing.inked else 0.3)
    if reversed_share < 0.06 and hidden == 0.0:
        return True
    if facing.inked or hidden > HIDDEN:
        return False
    # Where parts overlap, or transitions are almost hard, other tones separate consecutive ones and hide their contact.
    in_front = light[2] > -0.1
    if (explained > 0.45 and reversed_share < 0.02) or (
        explained > 0.25 and in_front and reversed_share < 0.005
    ):
        return True
    # On a box each face has its own tone and may border any other face; the inflated normals are uninformative.
    faceted = explained > 0.22 and in_front and reversed_share < 0.36
    return faceted and _skipped_share(tones) > 0.38


def _steepest(tones: Tones) -> float:
    """Return the largest cost of a step from one large tone to the next brighter one."""
    large = np.flatnonzero(tones.area > 2.5 * LARGE * tones.area.sum())
    return float(np.diag(shade_cost(tones.lab[large]), 1).max(initial=0.0))


def _hue_reversal(tones: Tones) -> float:
    """Return the total absolute hue change minus the net change, in radians, from dark to bright."""
    chroma = np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    colored = np.flatnonzero((chroma > COLORED) & (tones.area >= LARGE * tones.area.sum()))
    colored = colored[np.argsort(tones.lab[colored, 0], kind="stable")]
    hue = np.arctan2(tones.lab[colored, 2], tones.lab[colored, 1])
    turns = np.angle(np.exp(1j * np.diff(hue)))
    return float(np.abs(turns).sum() - abs(turns.sum()))


def _skipped_share(tones: Tones) -> float:
    """Return the share of the contact that is hard and joins tones with another large tone between them in lightness."""
    lightness = tones.lab[:, 0]
    large = np.sort(lightness[tones.area > LARGE * tones.area.sum()])
    first, last = np.searchsorted(large, lightness + 0.02), np.searchsorted(large, lightness - 0.02)
    skips = first[:, None] < last[None, :]
    hard = (tones.contact - tones.smooth) * (skips | skips.T)
    return float(hard.sum() / max(tones.contact.sum(), 1.0))


def _hidden_steps(tones: Tones, least: float) -> float:
    """
    Return the largest cost between consecutive large tones whose sides touch too little.

    The contact of the tones just below and just above must be at least `least` times the square root of the smaller area.
    """
    lightness, count = tones.lab[:, 0], len(tones.area)
    cost, worst = shade_cost(tones.lab), 0.0
    large = np.flatnonzero(tones.area > 2.5 * LARGE * tones.area.sum())
    for lower, upper in pairwise(large):
        below = np.arange(count) <= lower
        near_below = below & (lightness > lightness[lower] - 0.03)
        near_above = ~below & (lightness < lightness[upper] + 0.03)
        touching = tones.contact[np.ix_(near_below, near_above)].sum()
        smaller = min(tones.area[below].sum(), tones.area[~below].sum())
        if touching < least * np.sqrt(smaller):
            worst = max(worst, float(cost[lower, upper]), 1e-9)
    return worst

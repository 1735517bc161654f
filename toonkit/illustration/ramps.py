"""
Ramps: decide which tones are shades of one material.

There are two kinds of evidence. The first is color. Groups of tones are merged by complete linkage: only if every pair
of their tones could be shades of one paint. The color of a shade lies near the ray from black through the brighter
tone. The farther it is from the ray, the darker it must be. Mixtures of two paints fit neither paint, so they do not
chain two materials together. The second is where tones touch. A step of shading is small, its boundary is long relative
to the tones' perimeters, and its bright side faces the light, which is the same for the whole drawing.

A drawing in one material is recognized as a whole: see `is_one_ramp`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.tones import Matrix, Tones

SPREAD, SPREAD_PER_DROP = 0.028, 0.17
"""OKLab distance from the ray that gives cost 1: base value, plus this much per unit of lightness difference."""

FADE, BOOST = 0.3, 1.35
"""Minimum and maximum chroma of a shade relative to that of the brighter tone."""

COLORED, MIN_HUE_COSINE = 0.04, 0.5
"""Minimum chroma for the hue to be meaningful, and the minimum cosine of the angle between the hues of two shades."""

LARGEST_SMOOTH_COST = 2.1
"""Maximum cost for merging groups whose contact is mostly smooth. A change of material would leave a visible edge."""

MIN_LIGHTNESS_RATIO = 0.3
"""Minimum lightness of a shade relative to the brighter tone."""

SPOT = (0.6, 0.85)
"""Share of a darker tone's perimeter on one brighter tone above which it starts to count as a spot, and above which it
fully does."""

SMALL = 0.0006
"""Tones that cover at most this share of the paint cannot prevent a merge."""

LARGEST_COST = 1.2
"""Maximum cost at which the tones of two groups may be shades of one paint."""

EVIDENCE = {
    "constant": 0.3,
    "cost": -3.0,
    "cost squared": -0.33,
    "drop": -4.6,
    "drop squared": -8.8,
    "spot": -7.7,
    "facing": 4.2,
    "facing squared": -3.0,
    "turn": -1.0,
    "contact": 4.7,
    "chroma": -9.4,
    "shadow's chroma": 20.5,
    "fade": 0.5,
    "darkness": 11.7,
}
"""
Weights of the cues in the log-odds that two tones that touch are one material: a logistic regression on generated drawings
(`python -m benchmarks.tone_pairs`), rounded. The constant is lower than fitted, so that tones stay separate when in doubt.
"""

MAX_FACING, MAX_TURN, MAX_FADE, DARK = 0.6, 1.5, 2.0, 0.3
"""Values at which the cues above are clipped: difference of illumination, hue angle in radians, ratio of chromas; and the
OKLab lightness below which paint counts as dark."""

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

STEP = 0.06
"""Minimum lightness difference between a spot and the tone that encloses it."""

UNLIKE, NO_HIGHLIGHT = 1.3, 0.55
"""Minimum cost for a bright spot to be a separate paint. Minimum excess of its mean illumination over that of the
enclosing tone, in standard deviations, for it to be a highlight instead."""

Groups = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Facing:
    """
    Statistics of the initial normals beneath tones.

    Attributes
    ----------
    sums : ndarray, shape (n, 3)
        Sum of the initial normals over each tone's pixels.
    moments : ndarray, shape (n, 3, 3)
        Sum of their outer products.
    inked : bool
        Whether lines divide some of the paint.
    """

    sums: FloatArray
    moments: FloatArray
    inked: bool

    def only(self, which: Groups) -> Facing:
        """Return the statistics of the given tones."""
        return Facing(self.sums[which], self.moments[which], self.inked)


def join_tones(tones: Tones, facing: Facing) -> Groups:
    """
    Group tones into materials.

    Parameters
    ----------
    tones : Tones
        The tones of the drawing.
    facing : Facing
        The normals beneath them.

    Returns
    -------
    ndarray of int, shape (n,)
        Material label of each tone. Labels are arbitrary and not consecutive.
    """
    spots = _spots(tones, facing)
    others = np.flatnonzero(~spots)
    if is_one_ramp(tones.only(others), facing.only(others)):
        return np.where(spots, np.arange(len(spots)), others[0])
    large = tones.area > SMALL * tones.area.sum()
    cost = shade_cost(tones.lab)
    evidence = touching_evidence(tones, cost, facing)
    # A pair out of range forbids a merge, unless one of its tones is small.
    limited = np.where(out_of_range(tones.lab), np.maximum(cost, 2.0 * LARGEST_COST), cost)
    limited = np.where(large[:, None] & large, limited, np.minimum(limited, 0.9))
    return _agglomerate(limited, evidence, tones)


def shade_cost(lab: FloatArray) -> Matrix:
    """
    Return, for all pairs, how poorly two tones fit as shades of one paint.

    At 1 the color is one spread away from the ray. Merging allows up to `LARGEST_COST`, or `LARGEST_SMOOTH_COST` where the
    contact is mostly smooth.

    Parameters
    ----------
    lab : ndarray, shape (n, 3)
        OKLab.

    Returns
    -------
    ndarray, shape (n, n)
        Symmetric, zero on the diagonal.
    """
    darker, brighter, drop = _ordered(lab)
    dot, square = (brighter * darker).sum(axis=2), (brighter**2).sum(axis=2)
    scale = np.clip(dot / np.maximum(square, 1e-6), FADE, BOOST)
    off = np.linalg.norm(darker - scale[..., None] * brighter, axis=2)
    cost: Matrix = off / (SPREAD + SPREAD_PER_DROP * drop)
    np.fill_diagonal(cost, 0.0)
    return cost


def touching_evidence(tones: Tones, cost: Matrix, facing: Facing) -> Matrix:
    """Return the log-odds (n, n) that touching tones are one material; meaningless for tones that do not touch."""
    cues = touching_cues(tones, cost, facing)
    odds: Matrix = sum((EVIDENCE[name] * cue for name, cue in cues.items()), np.zeros_like(cost))
    return np.clip(odds, -8.0, 8.0)


def touching_cues(tones: Tones, cost: Matrix, facing: Facing) -> dict[str, Matrix]:
    """Return the features (n, n), keyed as in `EVIDENCE`, that indicate whether touching tones are one material."""
    rise = tones.lab[None, :, 0] - tones.lab[:, None, 0]
    drop, cost = np.abs(rise), np.minimum(cost, 3.0)
    enclosed = _enclosed(tones)
    enclosed = np.where(rise > 0, enclosed, enclosed.T)
    toward = np.append(_azimuth(tones, cost), 1.0) / np.sqrt(2.0)
    illumination = facing.sums @ toward / tones.area
    turned = np.sign(rise) * (illumination - illumination[:, None])
    turned = np.clip(turned, -MAX_FACING, MAX_FACING)
    chroma = np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    dark = np.where(rise > 0, chroma[:, None], chroma)
    bright = np.where(rise > 0, chroma, chroma[:, None])
    hue = np.arctan2(tones.lab[:, 2], tones.lab[:, 1])
    turn = np.abs(np.angle(np.exp(1j * (hue[:, None] - hue))))
    turn *= np.clip(np.minimum(dark, bright) / COLORED, 0.0, 1.0)
    brighter = np.maximum(tones.lab[:, None, 0], tones.lab[:, 0])
    contact = tones.contact / np.maximum(np.minimum(tones.perimeter[:, None], tones.perimeter), 1.0)
    return {
        "constant": np.ones_like(cost),
        "cost": cost,
        "cost squared": cost**2,
        "drop": drop,
        "drop squared": drop**2,
        "spot": np.clip((enclosed - SPOT[0]) / (SPOT[1] - SPOT[0]), 0.0, 1.0),
        "facing": turned,
        "facing squared": turned * np.abs(turned),
        "turn": np.minimum(turn, MAX_TURN),
        "contact": np.minimum(contact, 1.0),
        "chroma": bright,
        "shadow's chroma": dark,
        "fade": np.minimum(dark / np.maximum(bright, 0.02), MAX_FADE),
        "darkness": np.clip((DARK - brighter) / DARK, 0.0, 1.0),
    }


def _enclosed(tones: Tones) -> Matrix:
    """Return the share (n, n) of each tone's perimeter that is a hard edge to each other tone."""
    return (tones.contact - tones.smooth) / np.maximum(tones.perimeter, 1.0)[:, None]


def _spots(tones: Tones, facing: Facing) -> BoolArray:
    """Find tones (n,) enclosed by one other tone with a hard edge that are neither highlights nor shadows on it.

    Shadows reach the silhouette, so they are not enclosed. A bright spot is a highlight, not a separate paint, if its color
    could be a shade of the enclosing paint or if it faces the light more.
    """
    area = tones.area.astype(np.float64)
    large = area > LARGE * area.sum()
    rise = tones.lab[None, :, 0] - tones.lab[:, None, 0]
    enclosed = np.where(large & large[:, None], _enclosed(tones), 0.0)
    _, light = _explained_by_normals(tones.lab[:, 0], area, facing)
    mean = facing.sums @ light / area
    variance = np.maximum(np.einsum("nij,i,j->n", facing.moments, light, light) / area - mean**2, 1e-6)
    apart = (mean[:, None] - mean) / np.sqrt((variance[:, None] + variance) / 2)
    dark = (rise > STEP) & (enclosed > SPOT[1])
    bright = (rise < -STEP) & (enclosed > SPOT[0]) & (apart < NO_HIGHLIGHT) & (shade_cost(tones.lab) > UNLIKE)
    spots: BoolArray = (dark | bright).any(axis=1)
    return spots


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
    explained, light = _explained_by_normals(lightness, area, facing)
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
    told = np.flatnonzero((chroma > COLORED) & (tones.area >= LARGE * tones.area.sum()))
    told = told[np.argsort(tones.lab[told, 0], kind="stable")]
    hue = np.arctan2(tones.lab[told, 2], tones.lab[told, 1])
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


def _ordered(lab: FloatArray) -> tuple[FloatArray, FloatArray, Matrix]:
    """Chroma vectors (n, n, 2) of the darker and the brighter tone of each pair, and how much darker it is (n, n)."""
    chroma = np.broadcast_to(lab[None, :, 1:], (len(lab), len(lab), 2))
    first_is_darker = (lab[:, None, 0] <= lab[None, :, 0])[..., None]
    other = chroma.transpose(1, 0, 2)
    darker, brighter = np.where(first_is_darker, other, chroma), np.where(first_is_darker, chroma, other)
    return darker, brighter, np.abs(lab[:, None, 0] - lab[None, :, 0])


def out_of_range(lab: FloatArray) -> NDArray[np.bool_]:
    """Mark pairs whose hue or lightness differs too much to be shades of one paint."""
    darker, brighter, drop = _ordered(lab)
    chroma = np.linalg.norm(darker, axis=2), np.linalg.norm(brighter, axis=2)
    colored = (chroma[0] > COLORED) & (chroma[1] > COLORED)
    turned = (darker * brighter).sum(axis=2) < MIN_HUE_COSINE * chroma[0] * chroma[1]
    deep = drop > (1.0 - MIN_LIGHTNESS_RATIO) * np.maximum(lab[:, None, 0], lab[None, :, 0])
    return np.asarray((colored & turned) | deep)


def _azimuth(tones: Tones, cost: Matrix) -> FloatArray:
    """Estimate the unit vector, right and up, toward the light: from dark to bright over all pairs that could be shades."""
    rise = tones.lab[None, :, 0] - tones.lab[:, None, 0]
    way = (tones.way * ((cost < 0.8) & (rise > 0.03))[..., None]).sum(axis=(0, 1))
    return np.asarray(way / max(float(np.hypot(*way)), 1e-9))


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


def _explained_by_normals(
    lightness: FloatArray, area: FloatArray, facing: Facing
) -> tuple[float, FloatArray]:
    """Return the share of the lightness variance that is linear in the normals, and the unit vector along which it grows."""
    total = area.sum()
    system = np.zeros((4, 4))
    system[:3, :3] = facing.moments.sum(axis=0)
    system[:3, 3] = system[3, :3] = facing.sums.sum(axis=0)
    system[3, 3] = total
    right = np.append(facing.sums.T @ lightness, area @ lightness)
    slope = np.linalg.lstsq(system, right, rcond=None)[0]
    mean = right[3] / total
    variance = float(area @ (lightness - mean) ** 2)
    explained = float(slope @ right - total * mean**2) / max(variance, 1e-9)
    direction: FloatArray = slope[:3].astype(np.float64) / max(float(np.linalg.norm(slope[:3])), 1e-9)
    return explained, direction


def _agglomerate(cost: Matrix, evidence: Matrix, tones: Tones) -> Groups:
    """Repeatedly merge the pair of touching groups with the highest mean evidence, until none is positive."""
    count = len(cost)
    group, alive = np.arange(count), np.ones(count, np.bool_)
    cost, weight, weighted, smooth = (
        cost.copy(),
        tones.contact.copy(),
        tones.contact * evidence,
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

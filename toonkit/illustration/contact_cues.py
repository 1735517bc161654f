"""Where tones touch: cues that two of them are shades of one material."""

from __future__ import annotations

import numpy as np

from toonkit._validation import FloatArray
from toonkit.illustration.facing import Facing
from toonkit.illustration.shades import COLORED
from toonkit.illustration.tones import Matrix, Tones

SPOT = (0.6, 0.85)
"""Share of a darker tone's perimeter on one brighter tone above which it starts to count as a spot, and above which it
fully does."""

CUE_WEIGHTS = {
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


def contact_log_odds(tones: Tones, cost: Matrix, facing: Facing) -> Matrix:
    """Return the log-odds (n, n) that touching tones are one material; meaningless for tones that do not touch."""
    cues = measure_contact_cues(tones, cost, facing)
    odds: Matrix = sum((CUE_WEIGHTS[name] * cue for name, cue in cues.items()), np.zeros_like(cost))
    return np.clip(odds, -8.0, 8.0)


def measure_contact_cues(tones: Tones, cost: Matrix, facing: Facing) -> dict[str, Matrix]:
    """Return the features (n, n), keyed as in `CUE_WEIGHTS`, that indicate whether touching tones are one material."""
    rise = tones.lab[None, :, 0] - tones.lab[:, None, 0]
    drop, cost = np.abs(rise), np.minimum(cost, 3.0)
    enclosed = enclosed_share(tones)
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


def enclosed_share(tones: Tones) -> Matrix:
    """Return the share (n, n) of each tone's perimeter that is a hard edge to each other tone."""
    return (tones.contact - tones.smooth) / np.maximum(tones.perimeter, 1.0)[:, None]


def _azimuth(tones: Tones, cost: Matrix) -> FloatArray:
    """Estimate the unit vector, right and up, toward the light: from dark to bright over all pairs that could be shades."""
    rise = tones.lab[None, :, 0] - tones.lab[:, None, 0]
    way = (tones.way * ((cost < 0.8) & (rise > 0.03))[..., None]).sum(axis=(0, 1))
    return np.asarray(way / max(float(np.hypot(*way)), 1e-9))

"""
Highlights: small bright spots of light on a material, which no color map explains.

Only what hardly can be anything else counts: a spot brighter and no more colorful than the material that encloses it nearly
all around, small beside that, and one of a few. Eyes, teeth and patterns are materials of their own.
"""

from __future__ import annotations

import numpy as np

from toonkit._validation import BoolArray
from toonkit.illustration.ramps import Groups
from toonkit.illustration.tones import Tones

BRIGHTER = 0.06
"""OKLab lightness by which a highlight is brighter than all large tones of its material, at least."""

PALEST = 0.02
"""OKLab chroma that a highlight may have beyond that of its material's brightest tone."""

ENCLOSED = 0.8
"""Share of a highlight's perimeter along its material, at least."""

LARGEST, LARGEST_BESIDE = 0.05, 0.2
"""Area of a highlight at most: shares of the object, and of its material."""

LARGE = 0.05
"""Share of a material from which a tone counts as a large one."""


def highlight_hosts(tones: Tones, group: Groups) -> Groups:
    """
    Find the groups of tones that are highlights.

    Parameters
    ----------
    tones : Tones
        The tones of a drawing.
    group : ndarray of int, shape (n,)
        Group of each tone, 0 to below m.

    Returns
    -------
    ndarray of int, shape (m,)
        For each group the one on which it is a highlight, -1 where it is none.
    """
    count = int(group.max()) + 1
    member = np.zeros((count, len(group)))
    member[group, np.arange(len(group))] = 1.0
    area = member @ tones.area
    contact = member @ tones.contact @ member.T
    perimeter = member @ tones.perimeter - np.diag(contact)
    np.fill_diagonal(contact, 0.0)
    host = contact.argmax(axis=1)
    enclosed = contact[np.arange(count), host] / np.maximum(perimeter, 1.0)
    lightness, chroma = tones.lab[:, 0], np.hypot(tones.lab[:, 1], tones.lab[:, 2])
    large = tones.area >= LARGE * area[group]
    brightest = np.array([lightness[(group == k) & large].max(initial=0.0) for k in range(count)])
    palest = np.array([chroma[(group == k) & large].max(initial=0.0) for k in range(count)])
    darkest = np.array([lightness[(group == k) & large].min(initial=1.0) for k in range(count)])
    found: BoolArray = (
        (enclosed > ENCLOSED)
        & (darkest > brightest[host] + BRIGHTER)
        & (palest < palest[host] + PALEST)
        & (area < LARGEST * area.sum())
        & (area < LARGEST_BESIDE * area[host])
    )
    found &= ~found[host]
    return np.where(found, host, -1)

"""How well regions and ink agree with the truth: the adjusted Rand index, and the F1 score."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from toonkit._validation import BoolArray


def adjusted_rand_index(
    labels: NDArray[np.integer], reference: NDArray[np.integer], where: BoolArray
) -> float:
    """
    Agreement of two divisions of some pixels into regions, whatever their numbers are called.

    Parameters
    ----------
    labels, reference : ndarray of int, shape (H, W)
        Regions.
    where : ndarray of bool, shape (H, W)
        Pixels that count.

    Returns
    -------
    float
        1 for the same division, about 0 for a random one; NaN if no pixel counts.

    Notes
    -----
    Of all pairs of pixels, the share on which both say "the same region" or both say "another one", corrected for chance.
    Hubert and Arabie, "Comparing partitions", Journal of Classification 2 (1985), https://doi.org/10.1007/BF01908075.
    """
    ours, theirs = (np.unique(regions[where], return_inverse=True)[1] for regions in (labels, reference))
    count = len(ours)
    if count == 0:
        return float("nan")
    table = coo_array((np.ones(count), (ours, theirs))).tocsr()  # adds up what falls on one entry
    together = _pairs(table.data)
    of_ours, of_theirs = (_pairs(np.asarray(table.sum(axis=axis)).ravel()) for axis in (1, 0))
    by_chance = of_ours * of_theirs / max(_pairs(np.array([float(count)])), 1.0)
    most = (of_ours + of_theirs) / 2
    # Both say "one region", or both say "every pixel for itself".
    return float((together - by_chance) / (most - by_chance)) if most != by_chance else 1.0


def f1_score(found: BoolArray, truth: BoolArray) -> float:
    """Return the harmonic mean of precision and recall of chosen pixels; 1 if none is chosen and none should be."""
    either = int(found.sum()) + int(truth.sum())
    return 2.0 * float((found & truth).sum()) / either if either else 1.0


def _pairs(sizes: NDArray[np.float64]) -> float:
    return float((sizes * (sizes - 1) / 2).sum())

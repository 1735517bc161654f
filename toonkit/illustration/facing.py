"""Facing: which way the surface beneath each tone looks, by the initial normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray


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

    def only(self, which: NDArray[np.intp]) -> Facing:
        """Return the statistics of the given tones."""
        return Facing(self.sums[which], self.moments[which], self.inked)


def explain_by_normals(lightness: FloatArray, area: FloatArray, facing: Facing) -> tuple[float, FloatArray]:
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

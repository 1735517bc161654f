"""Fill gaps between known pixels ring by ring: each pixel takes the neighbor whose color is nearest to its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray
from toonkit.model.oklab import Lab
from toonkit.numerics.compiled import njit

Labels = NDArray[np.int32]

ANY_DISTANCE = 1 << 30
"""More rings than any picture has."""


def find_nearest_sources(
    known: BoolArray, lab: Lab, wanted: BoolArray, *, within: int = ANY_DISTANCE
) -> NDArray[np.int32]:
    """
    Find the pixel that each wanted pixel takes its values from: its flat index (h, w), -1 where there is none.

    Known pixels are their own sources; wanted ones lie off the array's border, and at most `within` rings away. The
    result does not depend on the order of the pixels: a mirrored picture has mirrored sources, except among sources of
    one color.
    """
    source = np.full(known.size, -1, np.int32)
    inside = np.flatnonzero(known)
    source[inside] = inside
    left = np.flatnonzero((wanted & ~known).ravel()).astype(np.int32)
    _fill(source, lab.reshape(-1, 3), left, np.empty_like(left), np.int32(known.shape[1]), within)
    return source.reshape(known.shape)


@njit(cache=True, nogil=True, error_model="numpy")
def _fill(source, colors, left, found, width, rings):  # type: ignore[no-untyped-def]
    count = left.size
    for _ in range(rings):
        for k in range(count):
            p = left[k]
            found[k] = -1
            least = np.float32(1e9)
            for n in range(9):
                s = source[p + (n // 3 - 1) * width + n % 3 - 1]
                if s >= 0:
                    d0 = colors[s, 0] - colors[p, 0]
                    d1 = colors[s, 1] - colors[p, 1]
                    d2 = colors[s, 2] - colors[p, 2]
                    d = d0 * d0 + d1 * d1 + d2 * d2
                    if d < least:
                        least = d
                        found[k] = s
        kept = 0
        for k in range(count):
            if found[k] >= 0:
                source[left[k]] = found[k]
            else:
                left[kept] = left[k]
                kept += 1
        if kept == count:
            break
        count = kept

"""
Quarter turns and reflections: each island is analyzed in the one in which its light comes from above.

Solvers sweep in rows, blocks begin at a corner, and ties are broken by order. A drawing that is turned or reflected together
with its light comes to lie as before, so its normals are turned or reflected with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray

Real = TypeVar("Real", bound=np.floating[Any])

EXACT = 1e-9
"""Difference of two directions, or of two moments relative to their size, that is rounding."""


@dataclass(frozen=True)
class Turn:
    """
    One of the eight ways in which a picture can lie on its grid of pixels.

    Attributes
    ----------
    transposed : bool
        Whether rows become columns, before anything else.
    flipped : bool
        Whether the order of the rows is reversed.
    mirrored : bool
        Whether the order of the columns is reversed.
    """

    transposed: bool = False
    flipped: bool = False
    mirrored: bool = False

    @property
    def is_identity(self) -> bool:
        """Whether everything stays where it is."""
        return not (self.transposed or self.flipped or self.mirrored)

    def picture(self, image: NDArray[Any]) -> NDArray[Any]:
        """Turn an image (H, W, ...)."""
        if self.transposed:
            image = image.swapaxes(0, 1)
        rows, columns = (slice(None, None, -1 if reverse else 1) for reverse in (self.flipped, self.mirrored))
        return np.ascontiguousarray(image[rows, columns])

    def vectors(self, vectors: NDArray[Real]) -> NDArray[Real]:
        """Turn vectors (..., 3), x to the right and y up, with the picture that they are part of."""
        if self.is_identity:
            return vectors
        x, y, z = np.moveaxis(vectors, -1, 0)
        if self.transposed:
            x, y = -y, -x
        return np.stack([-x if self.mirrored else x, -y if self.flipped else y, z], axis=-1)

    def vectors_back(self, vectors: NDArray[Real]) -> NDArray[Real]:
        """Undo `vectors`."""
        if self.is_identity:
            return vectors
        x, y, z = np.moveaxis(vectors, -1, 0)
        x, y = -x if self.mirrored else x, -y if self.flipped else y
        if self.transposed:
            x, y = -y, -x
        return np.stack([x, y, z], axis=-1)


AS_DRAWN = Turn()
"""Everything stays where it is."""

TURNS = (
    AS_DRAWN,
    Turn(transposed=True, flipped=True),
    Turn(flipped=True, mirrored=True),
    Turn(transposed=True, mirrored=True),
    Turn(mirrored=True),
    Turn(transposed=True),
    Turn(flipped=True),
    Turn(transposed=True, flipped=True, mirrored=True),
)
"""All eight: by 0 to 3 quarters counter-clockwise, and the same of the mirror image."""


def turn_under_light(direction: FloatArray, moment: FloatArray) -> Turn:
    """
    Find the turn after which a direction points up, or up to 45 degrees to the left.

    Parameters
    ----------
    direction : ndarray, shape (2,) or (3,)
        x and y, and z, which does not matter. Without length, every turn does.
    moment : ndarray, shape (2,)
        Of several turns that do, the one after which this vector points farthest up, then to the left.

    Returns
    -------
    Turn
        The same picture for a drawing and for its turned and mirrored copies, unless the drawing is its own mirror image.
    """
    size = max(float(np.abs(moment).max()), 1e-300)

    def preference(turn: Turn) -> tuple[float, float]:
        along, up, _ = np.round(turn.vectors(np.array([*moment, 0.0])) / size / EXACT) * EXACT
        return float(up), float(-along)

    def fits(turn: Turn) -> bool:
        x, y, _ = turn.vectors(np.array([*direction[:2], 0.0]))
        return bool(x < EXACT and y > -x - EXACT)

    return max(filter(fits, TURNS), key=preference)

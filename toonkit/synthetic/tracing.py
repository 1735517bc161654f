"""Trace rays along -z through the primitives of parts: the first hit of each, and the normal there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray
from toonkit.synthetic.primitives import Solid
from toonkit.synthetic.tracing_kernels import NOTHING, trace_rays


@dataclass(frozen=True, eq=False)
class Frame:
    """
    A square from which rays start along -z.

    Attributes
    ----------
    center : tuple of float
        Its middle, x and y.
    width : float
        Length of its sides.
    """

    center: tuple[float, float]
    width: float


@dataclass(frozen=True, eq=False)
class Hits:
    """
    First hits of a square grid of rays along -z.

    Attributes
    ----------
    part : ndarray of int, shape (n, n)
        Index of the part, or `NOTHING`.
    depth : ndarray, shape (n, n)
        Its z; -inf where there is nothing.
    normals : ndarray, shape (n, n, 3)
        Unit vectors with z >= 0; 0 where there is nothing.
    """

    part: NDArray[np.int16]
    depth: FloatArray
    normals: FloatArray


class Tracer:
    """
    Parts, prepared for tracing rays.

    Parameters
    ----------
    parts : sequence of Solid
        Solids; where two overlap, both surfaces stay as they are and meet in a crease.
    view : ndarray, shape (3, 3)
        Rotation from their axes to those of the picture: x right, y up, z toward the viewer.
    """

    def __init__(self, parts: Sequence[Solid], view: FloatArray) -> None:
        pieces = [(piece, number) for number, solid in enumerate(parts) for piece in solid]
        self._kinds = np.array([piece.kind for piece, _ in pieces], np.int64)
        self._part_of = np.array([number for _, number in pieces], np.int64)
        self._centers = np.array([view @ piece.center for piece, _ in pieces])
        self._turns = np.array([piece.turn @ view.T for piece, _ in pieces])
        self._sizes = np.array([piece.sizes for piece, _ in pieces])
        self._fillets = np.array([piece.fillet for piece, _ in pieces])
        self._cuts = np.array([piece.cut for piece, _ in pieces])
        self._bounds = np.array([piece.bound for piece, _ in pieces])

    def enclosing_frame(self) -> Frame:
        """Return a square that encloses the silhouette closely."""
        reach = (self._bounds + self._fillets)[:, None]
        solid = ~self._cuts
        low = (self._centers - reach)[solid, :2].min(axis=0)
        high = (self._centers + reach)[solid, :2].max(axis=0)
        width = float((high - low).max())
        center = (low + high) / 2
        count = 128
        part = self.trace(Frame((float(center[0]), float(center[1])), width), count, normals=False).part
        rows, columns = np.nonzero(part != NOTHING)
        if len(rows) == 0:
            return Frame((float(center[0]), float(center[1])), width)
        step = width / count
        left, right = columns.min() - 1.0, columns.max() + 2.0  # up to a step is not seen on each side
        top, bottom = rows.min() - 1.0, rows.max() + 2.0
        middle = (
            float(center[0] + ((left + right) / 2 - count / 2) * step),
            float(center[1] - ((top + bottom) / 2 - count / 2) * step),
        )
        return Frame(middle, float(max(right - left, bottom - top) * step))

    def trace(self, frame: Frame, count: int, *, normals: bool = True) -> Hits:
        """Send `count` x `count` rays through a square; without `normals`, those are zero."""
        step = frame.width / count
        offset = (np.arange(count) + 0.5 - count / 2) * step
        part = np.full((count, count), NOTHING, np.int16)
        depth = np.full((count, count), -np.inf)
        vectors = np.zeros((count, count, 3))
        trace_rays(
            frame.center[0] + offset, frame.center[1] - offset, step, normals, self._kinds, self._part_of,
            self._centers, self._turns, self._sizes, self._fillets, self._cuts, self._bounds, part, depth, vectors,
        )  # fmt: skip
        return Hits(part, depth, vectors)

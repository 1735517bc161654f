"""What a visitor says about the shape of a drawing: painted, erased, tilted, and compared with what was said before."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from toonkit import NormalHint, ShapeCorrections
from toonkit._validation import as_array, one_of, refuse
from toonkit.model.shape_corrections import PARTS
from toonkit.viz.relight_page.codes import Numbers
from toonkit.viz.relight_page.regions import connected, path_of, stroke

BITS = {name: 1 << place for place, name in enumerate(PARTS)}
"""The bit of each kind of part in the marks of a pixel."""

ERASED = ""
"""Stands for no kind of part: pixels painted with it have the shape that was found."""

Marks = NDArray[np.uint8]


@dataclass(frozen=True)
class ShapeMarks:
    """
    One state of what is said about a shape; equal states say the same.

    Attributes
    ----------
    packed : bytes
        `BITS` of each pixel, shape (H, W), compressed; empty where no part is marked.
    normals : tuple of NormalHint
        Normals at points.
    """

    packed: bytes = b""
    normals: tuple[NormalHint, ...] = ()

    @classmethod
    def of(cls, shape: ShapeCorrections | None) -> ShapeMarks:
        """Return corrections as marks."""
        if shape is None or shape.is_empty:
            return NOTHING_SAID
        marks: Marks = np.zeros(next(iter(shape.parts.values()), np.zeros((0, 0))).shape, np.uint8)
        for name, part in shape.parts.items():
            marks |= np.uint8(BITS[name]) * part
        return cls(_packed(marks), shape.normals)

    def corrections(self, size: tuple[int, ...]) -> ShapeCorrections:
        """Return the marks of a picture of some size (H, W) as corrections."""
        marks = self.marks(size)
        parts = {name: (marks & bit) > 0 for name, bit in BITS.items()}
        return ShapeCorrections(**parts, normals=self.normals)

    def marks(self, size: tuple[int, ...]) -> Marks:
        """Return the bits of each pixel, shape (H, W)."""
        if not self.packed:
            return np.zeros(size, np.uint8)
        return np.frombuffer(zlib.decompress(self.packed), np.uint8).reshape(size).copy()

    def painted(
        self, path: Sequence[Sequence[float]], radius: float, kind: str, codes: Numbers
    ) -> ShapeMarks:
        """
        Mark what a round brush covers.

        Parameters
        ----------
        path : sequence of (float, float)
            Columns and rows along which the brush went, in pixels: as in `MaterialCorrections.paint`.
        radius : float
            Radius of the brush, in pixels.
        kind : str
            A kind of part, or `ERASED`, which removes normals at points as well.
        codes : ndarray of int, shape (H, W)
            The materials, -1 outside the object.
        """
        return self._marked(stroke(path_of(path), radius, codes.shape), kind, codes)

    def filled(self, place: Sequence[float], kind: str, codes: Numbers) -> ShapeMarks:
        """Mark the connected region of one material around a place, given as column and row."""
        return self._marked(connected(codes, place), kind, codes)

    def tilted(
        self,
        place: Sequence[float],
        normal: Sequence[float] | None,
        radius: float,
        which: int,
        codes: Numbers,
    ) -> ShapeMarks:
        """
        Set, change or remove the normal at a place.

        Parameters
        ----------
        place : (float, float)
            Column and row in pixels, 0.5 in the middle of the first one.
        normal : sequence of float or None
            The normal that is wanted there; None removes the hint.
        radius : float
            As for `NormalHint`.
        which : int
            Index of the hint that is replaced or removed; -1 adds one.
        codes : ndarray of int, shape (H, W)
            The materials, -1 outside the object.

        Raises
        ------
        ToonkitError
            If there is no such hint, the place does not lie on the object, or `NormalHint` refuses the rest.
        """
        if not -1 <= which < len(self.normals):
            raise refuse("which", f"must be a number from -1 to {len(self.normals) - 1}", which)
        hints = list(self.normals)
        if which >= 0:
            del hints[which]
        if normal is not None:
            column, row = (int(at) for at in np.floor(as_array("place", place, (2,))))
            inside = 0 <= row < codes.shape[0] and 0 <= column < codes.shape[1] and codes[row, column] >= 0
            if not inside:
                raise refuse("place", "must lie on the object", [column, row])
            x, y, z = as_array("normal", normal, (3,)).tolist()
            hints.insert(which if which >= 0 else len(hints), NormalHint(row, column, (x, y, z), radius))
        return replace(self, normals=tuple(hints))

    def _marked(self, region: NDArray[np.bool_], kind: str, codes: Numbers) -> ShapeMarks:
        one_of("kind", kind, (*BITS, ERASED))
        marks = self.marks(codes.shape)
        marks[region & (codes >= 0)] = BITS.get(kind, 0)
        kept = self.normals
        if kind == ERASED:
            kept = tuple(hint for hint in kept if not region[hint.row, hint.column])
        return ShapeMarks(_packed(marks), kept)


NOTHING_SAID = ShapeMarks()


def _packed(marks: Marks) -> bytes:
    return zlib.compress(marks.tobytes(), 1) if marks.any() else b""

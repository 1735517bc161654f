"""The square that the learned parts look at: a small picture of the object, turned and scaled alike for all."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray
from toonkit.numerics.compiled import njit
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid

SIZE = 96
"""Side of the square in pixels."""

FILL = 0.92
"""Share of that side which the object's longer extent takes."""


@dataclass(frozen=True)
class WorkingSquare:
    """
    A square on a picture.

    Attributes
    ----------
    row, column : float
        Its center, where whole numbers are pixel centers.
    width : float
        Its side, in pixels of the picture.
    cosine, sine : float
        Of the azimuth along which its columns run.
    """

    row: float
    column: float
    width: float
    cosine: float
    sine: float

    @classmethod
    def around(cls, grid: MaskedGrid, direction: FloatArray) -> WorkingSquare:
        """Fit the square to the object, its columns along a direction (x, y); along x if that has no length."""
        length = float(np.hypot(*direction))
        cosine, sine = direction / length if length > 1e-9 else (1.0, 0.0)
        # Nothing reaches further than the first and the last pixel of a row.
        ends = np.flatnonzero(np.diff(grid.rows))
        ends = np.unique(np.concatenate([[0], ends, ends + 1, [grid.size - 1]]))
        rows, columns = grid.rows[ends], grid.columns[ends]
        along = columns * cosine - rows * sine  # image rows run against y
        across = columns * sine + rows * cosine
        middle = (along.min() + along.max()) / 2, (across.min() + across.max()) / 2
        width = max(np.ptp(along), np.ptp(across)) + 1.0
        return cls(
            row=float(middle[1] * cosine - middle[0] * sine),
            column=float(middle[0] * cosine + middle[1] * sine),
            width=float(width / FILL),
            cosine=float(cosine),
            sine=float(sine),
        )

    def widened(self, factor: float) -> WorkingSquare:
        """Return a square so many times as wide around the same center."""
        return replace(self, width=factor * self.width)

    def enlarged(self, factor: int) -> WorkingSquare:
        """Return the same square on a picture so many times as fine."""
        middle = (factor - 1) / 2  # where the center of its first pixel lies on the finer one
        return replace(
            self,
            row=factor * self.row + middle,
            column=factor * self.column + middle,
            width=factor * self.width,
        )

    def sampled(self, picture: NDArray[Any]) -> NDArray[Any]:
        """Take the picture's pixel nearest to each pixel of the square; zero beyond its edge."""
        row, column, inside = self._places(picture.shape)
        kind = picture.dtype if picture.dtype == np.bool_ else np.float32
        taken = np.zeros((SIZE, SIZE, *picture.shape[2:]), kind)
        taken[inside] = picture[row[inside], column[inside]]
        return taken

    def sampled_pixels(self, grid: MaskedGrid) -> NDArray[np.int32]:
        """Compact index of the object's pixel at each pixel of the square; `OUTSIDE` beside the object."""
        row, column, inside = self._places(grid.mask.shape)
        pixels = np.full((SIZE, SIZE), OUTSIDE, np.int32)
        pixels[inside] = grid.index[row[inside], column[inside]]
        return pixels

    def _places(self, shape: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp], BoolArray]:
        """Row and column of the nearest pixel of a picture, and whether it has one."""
        offset = (np.arange(SIZE) - (SIZE - 1) / 2) * (self.width / SIZE)
        along, across = np.meshgrid(offset, offset)
        row = np.rint(self.row + across * self.cosine - along * self.sine).astype(np.intp)
        column = np.rint(self.column + along * self.cosine + across * self.sine).astype(np.intp)
        return row, column, (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])

    def spread(self, field: FloatArray, grid: MaskedGrid) -> FloatArray:
        """Interpolate a field (n, n, 3) on the square, of any resolution, at the object's pixels, shape (P, 3)."""
        values = np.empty((grid.size, field.shape[2]))
        grid.chunks.run(
            _interpolate, np.ascontiguousarray(field, np.float64), grid.rows, grid.columns,
            self.row, self.column, self.cosine, self.sine, len(field) / self.width, values,
        )  # fmt: skip
        return values

    def turned(self, vectors: NDArray[Any]) -> NDArray[Any]:
        """Express vectors of the picture in the square's axes."""
        x, y, z = np.moveaxis(vectors, -1, 0)
        return np.stack([self.cosine * x + self.sine * y, self.cosine * y - self.sine * x, z], axis=-1)

    def turned_back(self, vectors: NDArray[Any]) -> NDArray[Any]:
        """Express vectors of the square in the picture's axes."""
        x, y, z = np.moveaxis(vectors, -1, 0)
        return np.stack([self.cosine * x - self.sine * y, self.sine * x + self.cosine * y, z], axis=-1)


@njit(cache=True, nogil=True, error_model="numpy")
def _interpolate(field, rows, columns, row, column, cosine, sine, scale, values, first, last):  # type: ignore[no-untyped-def]
    """Interpolate a field (n, n, 3) linearly at pixels of the picture; what lies beside it takes the nearest."""
    end = field.shape[0] - 1.0
    for p in range(first, last):
        down, right = rows[p] - row, columns[p] - column
        x = (right * cosine - down * sine) * scale + end / 2
        y = (right * sine + down * cosine) * scale + end / 2
        # Written out, for min and max take long to compile.
        x = 0.0 if x < 0.0 else end if x > end else x
        y = 0.0 if y < 0.0 else end if y > end else y
        i, j = int(y), int(x)
        if i == end:
            i -= 1
        if j == end:
            j -= 1
        y -= i
        x -= j
        for c in range(3):
            above = (1.0 - x) * field[i, j, c] + x * field[i, j + 1, c]
            below = (1.0 - x) * field[i + 1, j, c] + x * field[i + 1, j + 1, c]
            values[p, c] = (1.0 - y) * above + y * below

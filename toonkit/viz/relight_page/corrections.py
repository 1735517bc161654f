"""Corrections of the materials that were found: merged, painted over, recolored, undone and done again. Knows no panel."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, as_array, is_number, refuse
from toonkit.model.tone_ramp import ToneRamp

MOST_MATERIALS = 4096
"""Materials at most, for their numbers to fit in 16 bits with room to spare."""

MOST_STEPS = 200
"""Corrections that can be undone."""

WIDEST_BRUSH = 4096
"""Pixels from the middle of a brush to its edge, at most."""

LONGEST_STROKE = 20_000
"""Points of a stroke at most: what a hand draws in minutes."""

Numbers = NDArray[np.int16]
LabelVersion = bytes
"""One state of the label map, compressed: a drawing of 512 by 512 pixels takes a few kilobytes."""


@dataclass(frozen=True)
class Version:
    """
    One state of the corrections.

    Attributes
    ----------
    labels : bytes
        The label map, compressed.
    ramps : tuple of (int, ToneRamp)
        Materials whose ramps were edited, in rising order, with these.
    """

    labels: LabelVersion
    ramps: tuple[tuple[int, ToneRamp], ...] = ()


class MaterialCorrections:
    """
    The materials of a drawing as they were found, and each correction since, to go back and forth in.

    A material keeps its number while others are merged into each other, so that numbers may be missing. An analysis numbers
    its materials from 0 on, in the same order.

    Parameters
    ----------
    found : ndarray of int, shape (H, W)
        The materials that were found, -1 outside the object.

    Raises
    ------
    ToonkitError
        From each correction, for a material that does not exist or a stroke that is none.

    Examples
    --------
    >>> corrections = MaterialCorrections(np.array([[0, 1, 2]]))
    >>> corrections.merge(1, 0)
    >>> corrections.labels.tolist()
    [[0, 0, 2]]
    >>> corrections.undo()
    >>> corrections.labels.tolist()
    [[0, 1, 2]]
    """

    def __init__(self, found: NDArray[np.integer]) -> None:
        self._shape = found.shape
        self._versions = [Version(_packed(found))]
        self._position = 0

    @property
    def labels_version(self) -> LabelVersion | None:
        """The label map as it is now, as something to compare and to come back to; None as it was found."""
        packed = self._version.labels
        return None if packed == self._versions[0].labels else packed

    @property
    def ramps(self) -> dict[int, ToneRamp]:
        """The edited ramps, by the number of their material."""
        return dict(self._version.ramps)

    @property
    def is_corrected(self) -> bool:
        """Whether anything is otherwise than it was found."""
        return self._version != self._versions[0]

    @property
    def _version(self) -> Version:
        return self._versions[self._position]

    @property
    def labels(self) -> Numbers:
        """Number of each pixel's material as it is now, shape (H, W), -1 outside the object."""
        return self.labels_of(self.labels_version)

    @property
    def can_undo(self) -> bool:
        """Whether there is a correction to take back."""
        return self._position > 0

    @property
    def can_redo(self) -> bool:
        """Whether a correction was taken back."""
        return self._position + 1 < len(self._versions)

    def labels_of(self, version: LabelVersion | None) -> Numbers:
        """Return the label map of a version."""
        return (
            np.frombuffer(zlib.decompress(version or self._versions[0].labels), np.int16)
            .reshape(self._shape)
            .copy()
        )

    def merge(self, material: int, into: int) -> None:
        """Give all pixels of a material to another one."""
        labels = self.labels
        numbers = numbers_in(labels)
        for name, number in (("material", material), ("into", into)):
            if number not in numbers:
                raise refuse(name, "must be one of the materials", number)
        labels[labels == material] = into
        self._add_labels(labels)

    def paint(self, path: Sequence[Sequence[float]], radius: float, material: int) -> None:
        """
        Give what a round brush covers to a material.

        Parameters
        ----------
        path : sequence of (float, float)
            Where the brush went: column and row of its middle, in pixels; those of the first pixel's middle are 0.5.
        radius : float
            From its middle to its edge, pixels.
        material : int
            Number of a material, or the next one after all of them for a new one.
        """
        labels = self.labels
        points = as_array("path", path, (None, 2))
        if not 1 <= len(points) <= LONGEST_STROKE:
            raise refuse("path", f"must have 1 to {LONGEST_STROKE:,} points", len(points))
        if not np.isfinite(points).all():
            raise refuse("path", "must be places in the picture", "a point that is not finite")
        if not is_number(radius) or not 0 < radius <= WIDEST_BRUSH:
            raise refuse("radius", f"must be above 0, and at most {WIDEST_BRUSH} pixels", radius)
        numbers = numbers_in(labels)
        if material not in (*numbers, numbers[-1] + 1) or material >= MOST_MATERIALS:
            raise refuse("material", "must be one of the materials, or the next number", material)
        covered = _stroke(points, float(radius), self._shape) & (labels >= 0)
        labels[covered] = material
        self._add_labels(labels)

    def recolor(self, material: int, ramp: ToneRamp | None) -> None:
        """Give a material other tones, or, with None, those that were found."""
        if material not in numbers_in(self.labels):
            raise refuse("material", "must be one of the materials", material)
        ramps = self.ramps
        ramps.pop(material, None)
        if ramp is not None:
            ramps[material] = ramp
        self._add(replace(self._version, ramps=tuple(sorted(ramps.items()))))

    def reset(self) -> None:
        """Return to the materials that were found; this can be undone, too."""
        self._add(self._versions[0])

    def undo(self) -> None:
        """Take the last correction back, if there is one."""
        self._position = max(self._position - 1, 0)

    def redo(self) -> None:
        """Do again what was taken back last, if anything was."""
        self._position = min(self._position + 1, len(self._versions) - 1)

    def restore(self, labels: LabelVersion | None) -> None:
        """Go back to an earlier label map; what came after it can be done again."""
        packed = labels or self._versions[0].labels
        places = [place for place, other in enumerate(self._versions) if other.labels == packed]
        if not places:  # corrected anew since
            self._versions.insert(self._position, replace(self._version, labels=packed))
            return
        self._position = min(places, key=lambda place: abs(place - self._position))

    def _add_labels(self, labels: Numbers) -> None:
        self._add(replace(self._version, labels=_packed(labels)))

    def _add(self, version: Version) -> None:
        if version == self._version:
            return
        self._versions[self._position + 1 :] = [version]
        if len(self._versions) > MOST_STEPS + 1:
            del self._versions[1]  # the first one is what was found
        self._position = len(self._versions) - 1


def numbers_in(labels: NDArray[np.integer]) -> list[int]:
    """Return the numbers of the materials that occur, in rising order: much faster than sorting them all."""
    numbers: list[int] = np.flatnonzero(np.bincount(labels.ravel() + 1)[1:]).tolist()
    return numbers


def _packed(labels: NDArray[np.integer]) -> LabelVersion:
    return zlib.compress(labels.astype(np.int16).tobytes(), 1)


def _stroke(points: NDArray[np.float64], radius: float, shape: tuple[int, ...]) -> BoolArray:
    """Mark the pixels (H, W) whose middles are at most a radius from a path."""
    covered = np.zeros(shape, np.bool_)
    for (x, y), (to_x, to_y) in zip(points, points[[*range(1, len(points)), -1]], strict=True):
        top, left = (max(int(min(pair) - radius), 0) for pair in ((y, to_y), (x, to_x)))
        bottom, right = (max(int(max(pair) + radius) + 1, 0) for pair in ((y, to_y), (x, to_x)))
        part = covered[top:bottom, left:right]
        if part.size:
            rows, columns = np.ogrid[: part.shape[0], : part.shape[1]]
            part |= _near(columns + left + 0.5 - x, rows + top + 0.5 - y, to_x - x, to_y - y, radius)
    return covered


def _near(x: NDArray[np.float64], y: NDArray[np.float64], dx: float, dy: float, radius: float) -> BoolArray:
    """Mark the places at most a radius from the way from (0, 0) to (dx, dy)."""
    along = np.clip((x * dx + y * dy) / max(dx * dx + dy * dy, 1e-12), 0.0, 1.0)
    near: BoolArray = (x - along * dx) ** 2 + (y - along * dy) ** 2 <= radius**2
    return near

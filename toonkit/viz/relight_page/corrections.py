"""Corrections of the materials that were found: merged, painted over, recolored, undone and done again. Knows no panel."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from toonkit import ToonAnalysis
from toonkit._validation import refuse
from toonkit.model.tone_ramp import ToneRamp
from toonkit.viz.relight_page.codes import (
    HIGHLIGHT,
    INK,
    MARKS,
    MOST_MATERIALS,
    PLAIN,
    SHADOW,
    LabelVersion,
    Numbers,
    materials_in,
    materials_of,
    numbers_in,
    packed_codes,
    unpacked_codes,
)
from toonkit.viz.relight_page.regions import connected, loop, path_of, stroke
from toonkit.viz.relight_page.shape_marks import NOTHING_SAID, ShapeMarks

MOST_STEPS = 200
"""Corrections that can be undone."""

Look = tuple[tuple[str, Hashable], ...]
Marks = NDArray[np.bool_]


@dataclass(frozen=True)
class Version:
    """
    One state of the corrections.

    Attributes
    ----------
    labels : bytes
        The label map, compressed: number of the material, and mark, of each pixel.
    ramps : tuple of (int, ToneRamp)
        Materials whose ramps were edited, in rising order, with these.
    shape : ShapeMarks
        What is said about the shape.
    look : tuple of (str, object)
        Names and values of everything else that is undone with them, such as the light.
    """

    labels: LabelVersion
    ramps: tuple[tuple[int, ToneRamp], ...] = ()
    shape: ShapeMarks = NOTHING_SAID
    look: Look = ()


class MaterialCorrections:
    """
    The materials of a drawing as they were found, and each correction since, to go back and forth in.

    A material keeps its number while others are merged into each other, so that numbers may be missing. An analysis numbers
    its materials from 0 on, in the same order.

    Parameters
    ----------
    found : ndarray of int, shape (H, W)
        The materials that were found, -1 outside the object.
    ink, highlights : ndarray of bool, shape (H, W), optional
        The ink and the highlights that were found; none by default.

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

    def __init__(
        self, found: NDArray[np.integer], ink: Marks | None = None, highlights: Marks | None = None
    ) -> None:
        self._shape = found.shape
        self._ink, self._highlights = (
            np.packbits(np.zeros(found.shape, np.bool_) if marks is None else marks)
            for marks in (ink, highlights)
        )
        self._versions = [Version(packed_codes(found))]
        self._position = 0

    @classmethod
    def of(cls, analysis: ToonAnalysis) -> MaterialCorrections:
        """Return the materials, the ink and the highlights that an analysis has found, without corrections."""
        drawing = analysis.drawing
        highlit = np.zeros(drawing.shape, np.bool_)
        highlit[drawing.places(drawing.mixed.pixels[drawing.mixed.highlit])] = True
        return cls(analysis.materials.labels, drawing.ink_coverage >= 0.5, highlit)

    @property
    def found_ink(self) -> Marks:
        """Where ink was found, shape (H, W)."""
        return self._unpacked(self._ink)

    @property
    def found_highlights(self) -> Marks:
        """Where highlights were found, shape (H, W)."""
        return self._unpacked(self._highlights)

    @property
    def labels_version(self) -> LabelVersion | None:
        """The label map as it is now, as something to compare and to come back to; None as it was found."""
        packed = self._version.labels
        return None if packed == self._versions[0].labels else packed

    @property
    def told(self) -> tuple[LabelVersion | None, ShapeMarks]:
        """What an analysis is told: the label map and the shape."""
        return self.labels_version, self.shape

    @property
    def ramps(self) -> dict[int, ToneRamp]:
        """The edited ramps, by the number of their material."""
        return dict(self._version.ramps)

    @property
    def is_corrected(self) -> bool:
        """Whether materials, marks or ramps are otherwise than they were found."""
        return self._version != replace(self._versions[0], look=self.look, shape=self.shape)

    @property
    def shape(self) -> ShapeMarks:
        """What is said about the shape as it is now."""
        return self._version.shape

    @property
    def look(self) -> Look:
        """The look as it is now."""
        return self._version.look

    @property
    def _version(self) -> Version:
        return self._versions[self._position]

    @property
    def codes(self) -> Numbers:
        """Number of each pixel's material plus its mark, see `MARKS`, as it is now; shape (H, W), -1 outside the object."""
        return self.codes_of(self.labels_version)

    @property
    def labels(self) -> Numbers:
        """Number of each pixel's material as it is now, shape (H, W), -1 where an analysis has to find it."""
        return materials_of(self.codes)

    @property
    def ink(self) -> Marks | None:
        """Where the ink is, shape (H, W); None as it was found."""
        mark = self.codes // MOST_MATERIALS
        if not np.isin(mark, (INK, PLAIN)).any():
            return None
        ink: Marks = (self.found_ink & (mark <= 0)) | (mark == INK)
        return ink

    @property
    def highlights(self) -> Marks | None:
        """Where highlights and cast shadows are, shape (H, W); None as they were found."""
        mark = self.codes // MOST_MATERIALS
        if not (mark > 0).any():
            return None
        kept = self.found_highlights & (mark <= 0)
        highlights: Marks = kept | (mark == HIGHLIGHT) | (mark == SHADOW)
        return highlights

    @property
    def can_undo(self) -> bool:
        """Whether there is a correction to take back."""
        return self._position > 0

    @property
    def can_redo(self) -> bool:
        """Whether a correction was taken back."""
        return self._position + 1 < len(self._versions)

    def codes_of(self, version: LabelVersion | None) -> Numbers:
        """Return the materials and marks of a version."""
        return unpacked_codes(version or self._versions[0].labels, self._shape)

    def merge(self, material: int, into: int) -> None:
        """Give all pixels of a material to another one."""
        codes = self.codes
        numbers = materials_in(codes)
        for name, number in (("material", material), ("into", into)):
            if number not in numbers:
                raise refuse(name, "must be one of the materials", number)
        own = (codes >= 0) & (codes % MOST_MATERIALS == material)
        codes[own] += np.int16(into - material)
        self._add_codes(codes)

    def paint(self, path: Sequence[Sequence[float]], radius: float, material: int) -> None:
        """
        Give what a round brush covers to a material, or mark it.

        Parameters
        ----------
        path : sequence of (float, float)
            Where the brush went: column and row of its middle, in pixels; those of the first pixel's middle are 0.5.
        radius : float
            From its middle to its edge, pixels.
        material : int
            Number of a material, or the next one after all of them for a new one, or one of `MARKS`.
        """
        codes = self.codes
        self._give(codes, stroke(path_of(path), radius, self._shape), material)

    def fill(self, place: Sequence[float], material: int) -> None:
        """Give all that is connected to a place, column and row, and of the same material or mark, to another one."""
        codes = self.codes
        self._give(codes, connected(codes, place), material)

    def split(self, path: Sequence[Sequence[float]], material: int) -> None:
        """Make of what a closed path encloses of a material, or of all with -1, a new one."""
        codes = self.codes
        enclosed = loop(path_of(path), self._shape)
        if material >= 0:
            enclosed &= codes == material
        self._give(codes, enclosed, max(materials_in(codes)) + 1)

    def recolor(self, material: int, ramp: ToneRamp | None) -> None:
        """Give a material other tones, or, with None, those that were found."""
        if material not in numbers_in(self.labels):
            raise refuse("material", "must be one of the materials", material)
        ramps = self.ramps
        ramps.pop(material, None)
        if ramp is not None:
            ramps[material] = ramp
        self._add(replace(self._version, ramps=tuple(sorted(ramps.items()))))

    def change_shape(self, shape: ShapeMarks) -> None:
        """Say something else about the shape."""
        self._add(replace(self._version, shape=shape))

    def change_look(self, look: Look, *, again: bool) -> None:
        """Go on with another look; again, if it only continues the last change, so that both are undone at once."""
        version = replace(self._version, look=look)
        if not again:
            self._add(version)
        elif self._position > 0 and version == self._versions[self._position - 1]:
            del self._versions[self._position]
            self._position -= 1
        else:
            self._versions[self._position] = version

    def resume(self, codes: Numbers, ramps: Mapping[int, ToneRamp], shape: ShapeMarks = NOTHING_SAID) -> None:
        """
        Go on with corrections that were made before, as one step.

        Parameters
        ----------
        codes : ndarray of int, shape (H, W)
            As `codes` has been.
        ramps : mapping of int to ToneRamp
            As `ramps` has been.
        shape : ShapeMarks, optional
            As `shape` has been.
        """
        inside, found = codes >= 0, self.codes_of(None) >= 0
        if not np.array_equal(inside, found) or codes.max() >= MOST_MATERIALS * (PLAIN + 1):
            raise refuse("codes", "must be materials and marks of the object's pixels", "others")
        version = replace(self._version, labels=packed_codes(codes), shape=shape)
        self._add(replace(version, ramps=tuple(sorted(ramps.items()))))

    def reset(self) -> None:
        """Return to the materials that were found; this can be undone, too."""
        self._add(replace(self._versions[0], look=self.look, shape=self.shape))

    def undo(self) -> None:
        """Take the last correction back, if there is one."""
        self._position = max(self._position - 1, 0)

    def redo(self) -> None:
        """Do again what was taken back last, if anything was."""
        self._position = min(self._position + 1, len(self._versions) - 1)

    def restore(self, labels: LabelVersion | None, shape: ShapeMarks = NOTHING_SAID) -> None:
        """Go back to an earlier label map and shape; what came after them can be done again."""
        wanted = labels or self._versions[0].labels, shape
        places = [
            place for place, other in enumerate(self._versions) if (other.labels, other.shape) == wanted
        ]
        if not places:  # corrected anew since
            self._versions.insert(self._position, replace(self._version, labels=wanted[0], shape=shape))
            return
        self._position = min(places, key=lambda place: abs(place - self._position))

    def _give(self, codes: Numbers, region: Marks, material: int) -> None:
        """Give a region (H, W) to a material, or mark it."""
        numbers, marked = materials_in(codes), material in MARKS.values()
        if not marked and (material not in (*numbers, numbers[-1] + 1) or material >= MOST_MATERIALS):
            raise refuse("material", "must be one of the materials, the next number, or a mark", material)
        region = region & (codes >= 0)
        codes[region] = codes[region] % MOST_MATERIALS + material if marked else material
        self._add_codes(codes)

    def _unpacked(self, bits: NDArray[np.uint8]) -> Marks:
        return np.unpackbits(bits, count=int(np.prod(self._shape))).reshape(self._shape).astype(np.bool_)

    def _add_codes(self, codes: Numbers) -> None:
        self._add(replace(self._version, labels=packed_codes(codes)))

    def _add(self, version: Version) -> None:
        if version == self._version:
            return
        self._versions[self._position + 1 :] = [version]
        if len(self._versions) > MOST_STEPS + 1:
            del self._versions[1]  # the first one is what was found
        self._position = len(self._versions) - 1

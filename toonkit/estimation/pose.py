"""A drawing whose islands are turned to their light, as the networks and the refinement see it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.islands import Island
from toonkit.estimation.overview import Overview, ReducedPaint, reduce_paint
from toonkit.estimation.shading_ratio import GrayPaint, PaintedMaterial, gray_paint
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import IndexArray


@dataclass(frozen=True, eq=False)
class Pose:
    """
    A drawing whose islands are turned.

    Attributes
    ----------
    islands : tuple of Island
        The parts of the object that do not touch.
    materials : tuple of PaintedMaterial
        The tones of each material.
    hidden : ndarray of bool, shape (P,)
        Where ink or a highlight covers the paint.
    labels : ndarray of int, shape (P,)
        Numbers of the materials.
    learned : dict of bytes to tuple of ndarray
        The change of N0 that the learned shape asks for on each island's square, under the light asked about last. It
        takes a quarter of an analysis to compute, and stays the same when a person corrects the shape.
    """

    islands: tuple[Island, ...]
    materials: tuple[PaintedMaterial, ...]
    hidden: BoolArray
    labels: IndexArray
    learned: dict[bytes, tuple[FloatArray, ...]] = field(default_factory=dict)

    @cached_property
    def gray(self) -> GrayPaint:
        """The shading that the paint shows, whatever its material."""
        return gray_paint(self.materials, self.islands, self.hidden)

    @cached_property
    def reduced_paint(self) -> tuple[ReducedPaint, ...]:
        """Each island's tones and ink at about the resolution that the networks see."""
        gray = self.gray
        self.__dict__.pop("gray", None)  # who needs all of it besides holds it already
        return tuple(
            reduce_paint(
                island.grid,
                gray.light[island.pixels],
                gray.tone[island.pixels],
                gray.hidden[island.pixels],
                self.labels[island.pixels],
            )
            for island in self.islands
        )

    def overview(self, number: int, initial_normals: NormalField) -> Overview:
        """Look at one of the islands, with N0 as it is in the picture."""
        own = self.islands[number].own_vectors(initial_normals.compact)
        return Overview.of(self.reduced_paint[number], own)

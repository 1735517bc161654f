"""Materials: which parts of a drawing are painted with the same ramp of colors, and those ramps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray, any_array, as_array, of_type, refuse
from toonkit.model.color_map import ColorMap
from toonkit.model.description import describe_object, preview_png
from toonkit.model.label_colors import label_picture


@dataclass(frozen=True, eq=False)
class Materials:
    """
    The materials of a drawing; those that were found stand in the order of their area, the largest first.

    Attributes
    ----------
    labels : ndarray of int, shape (H, W)
        Material of each pixel, -1 outside the mask. Under ink it is that of the paint beside it.
    tones : tuple of ndarray, shape (k, 3)
        For each material its colors, sRGB in [0, 1], darkest first. A gradient has many.
    flat : ndarray of bool, shape (count,)
        Which materials say nothing about illumination: they are painted in one tone, or are too small to tell.
    color_maps : tuple of ColorMap
        For each material its color map, once a shape and a light are known; empty before. That of a flat material is not
        read from the drawing but derived: see `toonkit.illustration.flat_shading`.

    Raises
    ------
    ToonkitError
        If there is no material, the labels are not their numbers, or tones, `flat` and color maps are not one for each.
    """

    labels: NDArray[np.integer]
    tones: tuple[FloatArray, ...]
    flat: BoolArray
    color_maps: tuple[ColorMap, ...] = ()

    def __post_init__(self) -> None:
        for name in ("tones", "color_maps"):
            of_type(name, getattr(self, name), tuple)
        if self.count == 0:
            raise refuse("tones", "must be those of at least one material", "none")
        for tones in self.tones:
            colors = as_array("tones", tones, (None, 3))
            if len(colors) == 0 or not ((colors >= 0) & (colors <= 1)).all():
                raise refuse(
                    "tones", "must be one or more colors in [0, 1] for each material", f"{len(colors)} colors"
                )
        flat = any_array("flat", self.flat)
        if flat.shape != (self.count,) or flat.dtype != np.bool_:
            raise refuse(
                "flat", f"must be {self.count} bools, one for each material", f"{flat.shape}, {flat.dtype}"
            )
        if self.color_maps and len(self.color_maps) != self.count:
            raise refuse("color_maps", f"must be {self.count}, one for each material", len(self.color_maps))
        for color_map in self.color_maps:
            of_type("color_maps", color_map, ColorMap)
        labels = any_array("labels", self.labels)
        if labels.ndim != 2 or labels.dtype.kind != "i" or labels.size == 0:
            raise refuse(
                "labels", "must be an (H, W) array of integers", f"shape {labels.shape}, {labels.dtype}"
            )
        if labels.min() < -1 or labels.max() >= self.count:
            raise refuse("labels", f"must lie in -1 to {self.count - 1}", f"{labels.min()} to {labels.max()}")

    @classmethod
    def single(cls, mask: BoolArray, color_map: ColorMap) -> Materials:
        """Return the one material of an object (H, W) that is painted with one color map."""
        labels = np.where(mask, 0, -1).astype(np.int32)
        return cls(labels, (color_map.colors[[0, -1]],), np.zeros(1, np.bool_), (color_map,))

    def __repr__(self) -> str:
        flat = int(self.flat.sum())
        count = "1 material" if self.count == 1 else f"{self.count} materials"
        maps = "" if self.color_maps else ", without color maps"
        return f"Materials({count}, {flat} flat, {describe_object(self.labels >= 0)}{maps})"

    def _repr_png_(self) -> bytes:
        return preview_png(label_picture(self.labels), smooth=False)

    @property
    def count(self) -> int:
        """How many materials there are."""
        return len(self.tones)

    @property
    def base_tones(self) -> FloatArray:
        """Base color of each material, sRGB, shape (count, 3): the mean of its tones."""
        return np.array([tones.mean(axis=0) for tones in self.tones])

    @cached_property
    def shares(self) -> FloatArray:
        """Share of the object that each material has, shape (count,)."""
        area = np.bincount(self.labels[self.labels >= 0], minlength=self.count)
        shares: FloatArray = area / area.sum()
        return shares

"""ToonImage: one painted object, its colors and its mask."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from toonkit._validation import BoolArray, FloatArray, as_array, as_coverage, as_mask, refuse, same_shape
from toonkit.model.description import describe_object, preview_png
from toonkit.model.whole_pixels import opaque, pieces, pixels_at, put_pixels


@dataclass(frozen=True, eq=False)
class ToonImage:
    """
    A cartoon-shaded picture of one object.

    Parameters
    ----------
    color : array_like, shape (H, W, 3)
        sRGB in [0, 1], as painted. Values outside the mask are ignored.
    mask : array_like, shape (H, W)
        True on the object. It may have several components and holes.
    alpha : array_like, shape (H, W), optional
        Coverage of each pixel by the object, 0 to 1; 1 on the mask and 0 elsewhere if not given. The outline is
        where it crosses one half. It is carried through to every picture made from this one.
    fringe : array_like, shape (H, W, 3), optional
        sRGB of the pixels that the object touches (alpha > 0) without filling them (outside the mask): kept for
        the output, never analyzed. By default they take the color of the nearest object pixel.

    Attributes
    ----------
    pixels : ndarray, shape (P, 3)
        Colors of the object's pixels alone, in row-major order: float64.
    color : ndarray, shape (H, W, 3)
        The same as an image, NaN outside the mask. Made when it is first asked for.
    mask : ndarray, shape (H, W)
        bool.
    alpha : ndarray, shape (H, W)
        float64 in [0, 1].
    fringe : ndarray, shape (H, W, 3)
        float64, NaN except where alpha > 0 outside the mask. Made when it is first asked for.
    fringe_colors : ndarray, shape (n, 3)
        The same of these pixels alone, in row-major order.

    Raises
    ------
    ToonkitError
        If shapes differ, the mask is empty or too small, or a color on the object is NaN or outside [0, 1].
    """

    color: FloatArray
    mask: BoolArray
    alpha: FloatArray = field(kw_only=True, default=None)  # type: ignore[arg-type]  # None until __post_init__
    fringe: FloatArray = field(kw_only=True, default_factory=lambda: None)  # type: ignore[arg-type,return-value]
    pixels: FloatArray = field(init=False, repr=False)
    fringe_colors: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        color = as_array("color", self.color, (None, None, 3), copy=False)
        mask = as_mask("mask", self.mask)
        same_shape("mask", mask.shape, color.shape[:2], "color")
        pixels = _check_colors("color", pixels_at(color, mask))
        shape = mask.shape
        alpha = (
            mask.astype(np.float64)
            if self.alpha is None
            else as_coverage("alpha", self.alpha, (shape[0], shape[1]))
        )
        given = self.__dict__.pop("fringe")  # `__getattr__` makes both images where they are asked for
        del self.__dict__["color"]
        self.__dict__.update(mask=mask, alpha=alpha, pixels=pixels)
        if len(self.fringe_places[0]) == 0:
            fringe = np.zeros((0, 3))
        elif given is None:
            fringe = pixels[self.fringe_pixels]
        else:
            if not isinstance(given, np.ndarray):
                given = as_array("fringe", given, (None, None, 3))
            same_shape("fringe", given.shape, color.shape, "color")
            fringe = _check_colors("fringe", as_array("fringe", given[self.fringe_places], (None, 3)))
        self.__dict__["fringe_colors"] = fringe

    @classmethod
    def like(cls, image: ToonImage, pixels: FloatArray, fringe_colors: FloatArray) -> ToonImage:
        """Make a picture on the mask and alpha of another one, of colors (P, 3) and (n, 3) that need no check or copy."""
        picture = object.__new__(cls)
        outline = ("mask", "alpha", "fringe_places", "fringe_sources", "fringe_pixels")
        shared = {name: getattr(image, name) for name in outline}
        picture.__dict__.update(shared, pixels=pixels, fringe_colors=fringe_colors)
        return picture

    def __getattr__(self, name: str) -> FloatArray:
        # Few ask for images of the whole frame, most of which may be NaN.
        if name not in ("color", "fringe") or "fringe_colors" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        image = np.full((*self.shape, 3), np.nan)
        if name == "color":
            put_pixels(image, self.mask, self.pixels)
        else:
            image[self.fringe_places] = self.fringe_colors
        self.__dict__[name] = image
        return image

    def __repr__(self) -> str:
        return f"ToonImage({describe_object(self.mask)})"

    def _repr_png_(self) -> bytes:
        return preview_png(self.to_rgba())

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        height, width = self.mask.shape
        return height, width

    @cached_property
    def fringe_places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column of the fringe's pixels, in row-major order."""
        rows, columns = np.nonzero((self.alpha > 0) & ~self.mask)
        return rows, columns

    @cached_property
    def fringe_sources(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column of the object pixel nearest to each pixel of the fringe, in its order."""
        places = self.fringe_places
        if len(places[0]) == 0:
            return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
        rows, columns = nearest_object_pixel(self.mask)
        return rows[places], columns[places]

    @cached_property
    def fringe_pixels(self) -> NDArray[np.intp]:
        """Which of the object's pixels these are, counted in row-major order."""
        return np.searchsorted(
            np.flatnonzero(self.mask), np.ravel_multi_index(self.fringe_sources, self.mask.shape)
        )

    def to_rgba(self) -> NDArray[np.uint8]:
        """Return the picture as 8-bit straight-alpha RGBA, shape (H, W, 4); transparent black where alpha is 0."""
        rgba = np.zeros((*self.shape, 4), np.uint8)
        put_pixels(rgba, self.mask, opaque(eight_bit(self.pixels)))
        rgba[(*self.fringe_places, slice(0, 3))] = eight_bit(self.fringe_colors)
        rgba[..., 3] = eight_bit(self.alpha)
        return rgba

    def save(self, path: str | PathLike[str]) -> None:
        """
        Write the picture without loss, its transparency included.

        Parameters
        ----------
        path : path
            Ends in .png or .webp. An older file is replaced once the new one is complete.

        Raises
        ------
        ToonkitError
            If the suffix is another or the file cannot be written.
        """
        from toonkit.export.picture import write_picture  # noqa: PLC0415 - export stands above the model

        write_picture(self, path)


def eight_bit(values: FloatArray) -> NDArray[np.uint8]:
    """Convert values in [0, 1] to uint8 in 0..255, rounding to nearest."""
    levels = np.empty(values.shape, np.uint8)
    flat, written = values.reshape(-1), levels.reshape(-1)
    for piece in pieces(flat.size):
        written[piece] = np.rint(flat[piece] * 255)
    return levels


def nearest_object_pixel(mask: BoolArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row and column of the object pixel nearest to each pixel, both of shape (H, W)."""
    rows, columns = distance_transform_edt(~mask, return_distances=False, return_indices=True)
    return rows, columns


def _check_colors(argument: str, colors: FloatArray) -> FloatArray:
    if np.isnan(colors).any():
        raise refuse(
            argument,
            "must be painted on every object pixel",
            f"{int(np.isnan(colors).any(1).sum())} NaN pixels",
        )
    if colors.min() < -1e-9 or colors.max() > 1 + 1e-9:
        raise refuse(
            argument, "must be sRGB in [0, 1]", f"values from {colors.min():.4g} to {colors.max():.4g}"
        )
    return np.clip(colors, 0.0, 1.0)

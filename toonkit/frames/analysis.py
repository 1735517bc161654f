"""Analyze the frames of a sheet or an animation together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray, any_array, of_type, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.preparation import prepare
from toonkit.frames.coupling import couple
from toonkit.frames.montage import Place, cut, montage
from toonkit.methods import analyze
from toonkit.methods.steps import StepProgress
from toonkit.model.loading import image_of
from toonkit.relighting import RelightOptions, relight

FramePixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class FrameAnalysis:
    """
    Frames taken apart together.

    Attributes
    ----------
    analysis : ToonAnalysis
        The analysis of the montage of all frames: one light, one set of materials and color maps.
    places : tuple of Place
        Where each frame is in the montage.
    """

    analysis: ToonAnalysis
    places: tuple[Place, ...]

    def __post_init__(self) -> None:
        of_type("analysis", self.analysis, ToonAnalysis)
        height, width = self.analysis.image.shape
        for place in self.places:
            of_type("places", place, Place)
            rows, columns = place.in_montage
            if rows.stop > height or columns.stop > width:
                raise refuse("places", f"must lie in the montage of {width} x {height} pixels", f"{place}")

    def cut(self, picture: NDArray[Any], fill: float = 0) -> list[NDArray[Any]]:
        """Return the frames (h, w, ...) of a picture (H, W, ...) of the montage, filled where nothing is visible."""
        return cut(picture, self.places, fill)

    def base_colors(self) -> list[FramePixels]:
        """Return the base color of each frame, 8-bit RGBA (h, w, 4)."""
        return self.cut(self.analysis.base_color.to_rgba())

    def normals(self) -> list[FloatArray]:
        """Return the normals of each frame, (h, w, 3), NaN outside the object."""
        return self.cut(self.analysis.normals.vectors, np.nan)

    def labels(self) -> list[NDArray[np.intp]]:
        """Return the material of each pixel of each frame, (h, w), -1 outside the object."""
        return self.cut(self.analysis.materials.labels, -1)

    def relight(self, new_light: ArrayLike, **options: Unpack[RelightOptions]) -> list[FramePixels]:
        """
        Put all frames under a new light.

        Parameters
        ----------
        new_light : array_like, shape (3,) or (2,)
            The new light, as in `toonkit.relight`.
        **options
            Those of `toonkit.relight`.

        Returns
        -------
        list of ndarray of uint8, shape (h, w, 4)
            The relit frames, sRGB and straight alpha, of the size of the frames.
        """
        return self.cut(relight(self.analysis, new_light, **options).to_rgba())


def analyze_frames(
    frames: Sequence[ArrayLike],
    light: ArrayLike | None = None,
    *,
    method: str = "toonkit",
    progress: StepProgress | None = None,
) -> FrameAnalysis:
    """
    Take frames apart that show one object, or several in one style, under one light.

    Parameters
    ----------
    frames : sequence of array_like of uint8, shape (h, w, 4)
        sRGB and straight alpha, such as `toonkit.read_frames(path).pictures`. Sizes may differ; frames may be empty.
    light : array_like, shape (3,) or (2,), optional
        The light of all frames, as for `toonkit.analyze`; estimated from all of them if not given.
    method : str, optional
        Name of an estimator in `METHODS`.
    progress : callable, optional
        As for `toonkit.analyze`.

    Returns
    -------
    FrameAnalysis
        The frames, with the same materials and color maps in all of them.

    Raises
    ------
    ToonkitError
        If the frames are no such arrays, nothing in them is visible, or `analyze` refuses them.

    Notes
    -----
    The frames are analyzed side by side as one drawing. So a color belongs to the same material in all frames and has the
    same place in its color map, and ink is found from all frames together. Widths of lines are judged by the size of one
    frame.

    The shape is found for each part of a frame by itself. If at least six frames of one size show an object that turns once
    around an upright axis by equal angles, seen from the side, and the direction of the turn can be found, `toonkit` and
    `classical` then make the frames agree on its shape: see `toonkit.frames.turntable`.
    """
    if not isinstance(frames, Sequence) and not (isinstance(frames, np.ndarray) and frames.ndim):
        raise refuse("frames", "must be a sequence of arrays", type(frames).__name__)
    pictures = [_checked(frame) for frame in frames]
    if not any(picture[..., 3].any() for picture in pictures):
        raise refuse("frames", "must show something", f"{len(pictures)} frames without any visible pixel")
    pixels, places = montage(pictures)
    views = sum(bool(place.height) for place in places)
    drawing = prepare(image_of(pixels, None), views=views)
    analysis = analyze(drawing, light, method=method, progress=progress)
    return FrameAnalysis(couple(analysis, places), places)


def _checked(frame: ArrayLike) -> FramePixels:
    array = any_array("frames", frame)
    if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] != 4 or 0 in array.shape:
        shown = f"shape {array.shape}, {array.dtype}"
        raise refuse("frames", "must be uint8 arrays of shape (h, w, 4)", shown)
    return array

"""Frames of one object agree on its shape, so that its normals change only as the object turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from toonkit._validation import FloatArray
from toonkit.analysis import ToonAnalysis
from toonkit.frames.montage import Place, cut
from toonkit.frames.turntable import Turntable, Views, find_turntable
from toonkit.methods.steps import Steps
from toonkit.methods.toonkit import OPTIONS
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import bounding_box
from toonkit.numerics.parallel import run_each, single_threaded_blas

COUPLED_METHODS = ("toonkit", "classical")
"""Methods whose normals are coupled. The other methods stay as published."""

COUPLED_OPTIONS = replace(OPTIONS, change_reach=0.01)
"""Normals on which all frames agree are better than those that one frame asks for, so changes stay near its tone edges."""


def couple(analysis: ToonAnalysis, places: Sequence[Place]) -> ToonAnalysis:
    """
    Let frames that show an object from all around agree on its shape.

    Parameters
    ----------
    analysis : ToonAnalysis
        The analysis of the montage of the frames.
    places : sequence of Place
        Where each frame is in the montage.

    Returns
    -------
    ToonAnalysis
        The same with other normals and color maps, or `analysis` itself if the frames do not show such an object or its
        method is not in `COUPLED_METHODS`.
    """
    if analysis.method not in COUPLED_METHODS or len({place.shape for place in places}) != 1:
        return analysis
    if not all(place.height for place in places):
        return analysis
    with single_threaded_blas():
        views = _views(analysis, places)
        turntable = find_turntable(views)
        if turntable is None:
            return analysis
        steps = Steps(analysis.drawing, analysis.light, analysis.initial_normals, None)
        start = _on_montage(analysis, places, turntable)
        coupled = steps.finish(analysis.method, steps.refine(start, None, COUPLED_OPTIONS))
    return replace(coupled, light_estimate=analysis.light_estimate)


def _views(analysis: ToonAnalysis, places: Sequence[Place]) -> Views:
    """Return the frames, cropped to the area in which any of them shows the object."""
    labels = np.array(cut(analysis.materials.labels, places, -1))
    box = (slice(None), *bounding_box(np.any(labels >= 0, axis=0)))
    normals = np.array([frame[box[1:]] for frame in cut(np.nan_to_num(analysis.normals.vectors), places)])
    return Views(labels[box] >= 0, labels[box], normals)


def _on_montage(analysis: ToonAnalysis, places: Sequence[Place], turntable: Turntable) -> NormalField:
    """Return the normals on which the frames agree, in the montage."""
    each: list[FloatArray] = run_each(
        [partial(turntable.fused_normals, frame) for frame in range(len(places))]
    )
    vectors = np.zeros((*analysis.image.shape, 3))
    for place, fused in zip(places, each, strict=True):
        own = vectors[place.in_montage]
        own[analysis.image.mask[place.in_montage]] = fused
    return NormalField.of_pixels(vectors[analysis.image.mask], analysis.image.mask)

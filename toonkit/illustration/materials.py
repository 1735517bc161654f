"""
Materials: which pixels are painted with the same ramp of colors.

The paint beside the ink is divided into zones that are flat or change smoothly. The colors of zones are grouped into
tones, and tones into materials. A wrong merge bleeds one material's color into another, whereas a wrong split only
leaves some painted shading behind. Therefore tones stay apart in doubt.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.filling import Labels, nearest_sources
from toonkit.illustration.frame import Frame
from toonkit.illustration.highlights import find_highlights, find_named_highlights
from toonkit.illustration.ink import PAINT
from toonkit.illustration.mixed_pixels import REACH
from toonkit.illustration.neighborhoods import grown
from toonkit.illustration.ramps import Facing, Groups, is_one_ramp, join_tones
from toonkit.illustration.tones import Tones, find_tones
from toonkit.illustration.zones import Zones, find_zones
from toonkit.model.whole_pixels import pixels_at

TONE_SHARE = 0.01
"""Share of a material's pixels that a color must have to be listed as one of its tones."""

STRAY_SHARE = 0.1
"""Share of a material below which a tone is rare in it."""

DETAIL = 0.002
"""Share of the object up to which a material is a detail, such as an eye or a button. It is too small to show the
light."""


@dataclass(frozen=True, eq=False)
class FoundMaterials:
    """
    The materials in a frame.

    Attributes
    ----------
    labels : ndarray of int32, shape (h, w)
        Material of each pixel, -1 outside the mask.
    sources : ndarray of int32, shape (h, w)
        Flat index of the pixel whose paint each shows: its own, or that of a pixel nearby where ink covers it or where it is
        mixed with the paint of another material.
    highlights : ndarray of bool, shape (h, w)
        Pixels that show a highlight on their material.
    tones : tuple of ndarray, shape (k, 3)
        For each material its colors, sRGB in [0, 1], darkest first, without those of highlights.
    flat : ndarray of bool, shape (count,)
        Which are painted in one tone, or are details.
    """

    labels: Labels
    sources: Labels
    highlights: BoolArray
    tones: tuple[FloatArray, ...]
    flat: BoolArray


def label_materials(
    frame: Frame,
    coverage: FloatArray,
    normals: FloatArray,
    *,
    labels: Labels | None = None,
    highlights: BoolArray | None = None,
) -> FoundMaterials:
    """
    Find the materials in a frame.

    Parameters
    ----------
    frame : Frame
        The object.
    coverage : ndarray, shape (h, w)
        How much of each pixel is ink.
    normals : ndarray, shape (h, w, 3)
        Initial normals of the silhouette.
    labels : ndarray of int, shape (h, w), optional
        Given materials, 0 and up; -1 where they are unknown.
    highlights : ndarray of bool, shape (h, w), optional
        Given highlights and cast shadows.

    Returns
    -------
    FoundMaterials
        At least one.
    """
    zones, tones, facing = read_tones(frame, coverage, normals)
    known, lit = _numbered(tones, join_tones(tones, facing))
    told = np.full_like(known, -1)
    if labels is not None:
        told[frame.mask] = labels[frame.mask]
        lit = (lit & ~_mostly(lit, told)) | find_named_highlights(tones, told)
        known = np.where(_strays(tones, told), -1, _completed(told, known))
    if highlights is not None:
        lit = highlights & frame.mask & (coverage < PAINT)
    source = _everywhere(nearest_sources(known >= 0, frame.lab, frame.mask), frame.mask)
    own = np.arange(source.size, dtype=np.int32).reshape(source.shape)
    pure = zones.sources.ravel()[source]
    pure = np.where(pure >= 0, pure, source)
    lit, pure = _under_highlights(lit, pure, source, zones.sources == own, frame)
    pure = _of_their_material(pure, told, (known >= 0) & ~lit & (zones.sources == own))
    shown = np.where(lit, known.ravel()[pure], known.ravel()[source])
    whole = _without_gaps(np.where(told >= 0, told, np.where(frame.mask, shown, -1)), told.max())
    # Between two tones of one material lies nothing but their own mixture.
    alone = (known >= 0) & ~lit & ~_beside_another(whole, frame.mask)
    colors = _colors(frame, tones, whole, (known >= 0) & ~lit & (zones.sources == own))
    area = np.bincount(whole[whole >= 0], minlength=len(colors))
    flat = np.array([len(shades) == 1 for shades in colors]) | (area < DETAIL * area.sum())
    return FoundMaterials(whole, np.where(alone, own, pure), lit, colors, flat)


def shows_one_ramp(frame: Frame, normals: FloatArray) -> bool:
    """Tell whether a drawing, all that seems to be ink included, is one shaded material; normals (h, w, 3) as above."""
    _, tones, facing = read_tones(frame, np.zeros(frame.mask.shape), normals)
    return is_one_ramp(tones, facing)


def read_tones(frame: Frame, coverage: FloatArray, normals: FloatArray) -> tuple[Zones, Tones, Facing]:
    """Find the zones and tones of the paint beside the ink, and how they face; all of the object, if that is ink."""
    paint = frame.mask & (coverage < PAINT)
    zones = find_zones(frame.lab, paint if paint.any() else frame.mask)
    tones = find_tones(zones)
    return zones, tones, _facing(tones, normals, inked=bool((coverage > 0).any()))


def _everywhere(source: Labels, mask: BoolArray) -> Labels:
    """Give pixels of islands that have no source of their own the nearest one; others beside the mask get any."""
    if (source[mask] >= 0).all():
        return np.maximum(source, 0)
    rows, columns = ndimage.distance_transform_edt(source < 0, return_distances=False, return_indices=True)
    return np.asarray(source[rows, columns])


def _facing(tones: Tones, normals: FloatArray, *, inked: bool) -> Facing:
    """Sum the normals beneath each tone."""
    paint = tones.labels >= 0
    beneath = np.nan_to_num(pixels_at(normals, paint))
    tone = tones.labels[paint]
    count = len(tones.area)
    sums = [np.bincount(tone, component, count) for component in beneath.T]
    moments = np.empty((count, 3, 3))
    for i, j in combinations_with_replacement(range(3), 2):
        moments[:, i, j] = moments[:, j, i] = np.bincount(tone, beneath[:, i] * beneath[:, j], count)
    return Facing(np.column_stack(sums), moments, inked)


def _beside_another(labels: Labels, mask: BoolArray) -> BoolArray:
    """Mark the pixels that have two materials within `REACH`."""
    width = 2 * REACH + 1
    least = ndimage.minimum_filter(np.where(mask & (labels >= 0), labels, np.iinfo(np.int32).max), width)
    beside: BoolArray = least < ndimage.maximum_filter(labels, width)
    return beside


def _mostly(lit: BoolArray, told: Labels) -> BoolArray:
    """Mark the pixels of materials, named by somebody, that highlights would cover: to them these are paint."""
    named = told >= 0
    area = np.bincount(told[named])
    mostly = 2 * np.bincount(told[named & lit], minlength=len(area)) > area
    return named & np.asarray(mostly[told])


def _strays(tones: Tones, told: Labels) -> BoolArray:
    """Mark the paint along a border drawn by somebody that is the neighbor's: its tone is rare here, and common there."""
    placed = (told >= 0) & (tones.labels >= 0)
    if not placed.any():
        return placed
    area = tones.area_by_material(told)
    rare = (area < STRAY_SHARE * area.sum(axis=1, keepdims=True)) & (2 * area < area.sum(axis=0))
    stray: BoolArray = placed & rare[told, tones.labels] & _beside_another(told, placed)
    return stray


def _completed(told: Labels, found: Labels) -> Labels:
    """Take the materials that somebody named, and number those found where nobody did after them."""
    left = (told < 0) & (found >= 0)
    known = np.where(found >= 0, told, -1)
    known[left] = told.max() + 1 + np.unique(found[left], return_inverse=True)[1]
    return known


def _without_gaps(labels: Labels, named: int) -> Labels:
    """Renumber the materials after those that somebody named, so that each number occurs."""
    found = labels > named
    if found.any():
        labels[found] = named + 1 + np.unique(labels[found], return_inverse=True)[1]
    return labels


def _under_highlights(
    lit: BoolArray, pure: Labels, source: Labels, unmixed: BoolArray, frame: Frame
) -> tuple[BoolArray, Labels]:
    """Give the pixels of highlights, and those mixed with one, the sources of the paint around."""
    if not lit.any():
        return lit, pure
    lit = frame.mask & lit.ravel()[source]
    lit |= ~unmixed & frame.mask & grown(lit, REACH)
    around = nearest_sources(unmixed & ~lit & frame.mask, frame.lab, lit)
    return lit, np.where(lit & (around >= 0), around, pure)


def _of_their_material(sources: Labels, told: Labels, clean: BoolArray) -> Labels:
    """Give pixels of a material, named by somebody, whose sources lie in another one the nearest clean ones of their own."""
    elsewhere = (told >= 0) & (told.ravel()[sources] != told)
    sources = sources.copy()
    for material in np.unique(told[elsewhere]):
        own = clean & (told == material)
        if own.any():
            rows, columns = ndimage.distance_transform_edt(~own, return_distances=False, return_indices=True)
            left = elsewhere & (told == material)
            sources[left] = rows[left] * sources.shape[1] + columns[left]
    return sources


def _numbered(tones: Tones, group: Groups) -> tuple[Labels, BoolArray]:
    """
    Assign numbers to the materials of pixels by area, the largest first, and among equal ones the darker first.

    The other array marks the pixels of highlights, which have the number of their color: the last ones where all of it is.
    """
    _, which = np.unique(group, return_inverse=True)
    lit = find_highlights(tones, which)
    painted = tones.labels >= 0
    area = np.bincount(which[tones.labels[painted & ~lit]], minlength=int(which.max()) + 1)
    darkest = np.full(len(area), len(group))
    np.minimum.at(darkest, which, np.arange(len(group)))
    rank = np.argsort(np.lexsort((darkest, -area)))[which]
    labels: Labels = np.where(painted, rank[tones.labels], -1).astype(np.int32)
    return labels, lit


def _colors(frame: Frame, tones: Tones, labels: Labels, pure: BoolArray) -> tuple[FloatArray, ...]:
    """Mean sRGB of each material's tones, but for those that are rare in it: of pixels that show nothing else."""
    paint = (tones.labels >= 0) & (labels >= 0) & pure
    count, number = int(labels.max()) + 1, len(tones.area)
    key = labels[paint].astype(np.intp) * number + tones.labels[paint]
    area = np.bincount(key, minlength=count * number)
    sums = np.column_stack(
        [np.bincount(key, channel, count * number) for channel in pixels_at(frame.color, paint).T]
    )
    area, sums = area.reshape(count, number), sums.reshape(count, number, 3)
    large = area >= np.maximum(TONE_SHARE * area.sum(axis=1, keepdims=True), 1)
    colors = []
    for which in range(count):
        occurring = np.flatnonzero(large[which])
        if occurring.size == 0:  # all of it is mixed or lies under ink
            colors.append(frame.color[labels == which].mean(axis=0, keepdims=True))
        else:
            colors.append(sums[which, occurring] / area[which, occurring, None])
    return tuple(colors)

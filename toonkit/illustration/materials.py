"""
Materials: which pixels are painted with the same ramp of colors.

The paint not covered by ink is divided into zones that are flat or change smoothly. The colors of zones are grouped into
tones, and tones into materials. A wrong merge bleeds one material's color into another, whereas a wrong split only
leaves some painted shading behind. When in doubt, tones are kept separate.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, FloatArray
from toonkit.illustration.facing import Facing
from toonkit.illustration.filling import Labels, find_nearest_sources
from toonkit.illustration.frame import Frame
from toonkit.illustration.gradients import join_gradients
from toonkit.illustration.highlights import find_highlights, find_named_highlights
from toonkit.illustration.ink import PAINT
from toonkit.illustration.mixed_pixels import REACH
from toonkit.illustration.neighborhoods import grow_mask
from toonkit.illustration.one_ramp import is_one_ramp
from toonkit.illustration.ramps import Groups, join_tones
from toonkit.illustration.tones import Tones, find_tones
from toonkit.illustration.zones import Zones, find_zones
from toonkit.model.whole_pixels import pixels_at

TONE_SHARE = 0.01
"""Share of a material's pixels that a color must have to be listed as one of its tones."""

STRAY_SHARE = 0.1
"""Share of a material below which a tone is rare in it."""

SEAM = 0.05
"""OKLab distance of a seam from its paint, at most."""

DETAIL = 0.002
"""Share of the object up to which a material is a detail, such as an eye or a button. It is too small to reveal
the direction of the light."""


@dataclass(frozen=True, eq=False)
class FoundMaterials:
    """
    The materials in a frame.

    Attributes
    ----------
    labels : ndarray of int32, shape (h, w)
        Material of each pixel, -1 outside the mask.
    sources : ndarray of int32, shape (h, w)
        Flat index of the pixel whose pure paint represents this one: itself, or a nearby pixel if this one is covered by
        ink, part of a highlight, or mixed with another material.
    highlights : ndarray of bool, shape (h, w)
        Pixels that show a highlight on their material.
    tones : tuple of ndarray, shape (k, 3)
        For each material its colors, sRGB in [0, 1], darkest first, without those of highlights.
    flat : ndarray of bool, shape (count,)
        True for materials treated as unshaded: of one tone, smaller than `DETAIL`, or painted in a gradient of hues.
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
        Ink coverage of each pixel, 0 to 1.
    normals : ndarray, shape (h, w, 3)
        Initial normals of the silhouette.
    labels : ndarray of int, shape (h, w), optional
        Material labels supplied by the user, >= 0; -1 where unknown.
    highlights : ndarray of bool, shape (h, w), optional
        Given highlights and cast shadows.

    Returns
    -------
    FoundMaterials
        The materials found; never empty.
    """
    zones, tones, facing = read_tones(frame, coverage, normals)
    group, painted = join_gradients(tones, zones, join_tones(tones, facing))
    known, lit = _renumber(tones, group)
    told = np.full_like(known, -1)
    if labels is not None:
        told[frame.mask] = labels[frame.mask]
        lit = (lit & ~_mostly_highlight(lit, told)) | find_named_highlights(tones, told)
        known = np.where(_strays(tones, told), -1, _fill_unlabeled(told, known))
    if highlights is not None:
        lit = highlights & frame.mask & (coverage < PAINT)
    source = _fill_missing_sources(find_nearest_sources(known >= 0, frame.lab, frame.mask), frame.mask)
    own = np.arange(source.size, dtype=np.int32).reshape(source.shape)
    pure = zones.sources.ravel()[source]
    pure = np.where(pure >= 0, pure, source)
    lit, pure = _under_highlights(lit, pure, source, zones.sources == own, frame)
    pure = _of_their_material(pure, told, (known >= 0) & ~lit & (zones.sources == own))
    shown = np.where(lit, known.ravel()[pure], known.ravel()[source])
    whole = _close_gaps(np.where(told >= 0, told, np.where(frame.mask, shown, -1)), told.max())
    # Pixels between two tones of one material are not mixed pixels; only those near another material are.
    alone = (known >= 0) & ~lit & ~_beside_another(whole, frame.mask)
    colors = _colors(frame, tones, whole, (known >= 0) & ~lit & (zones.sources == own))
    area = np.bincount(whole[whole >= 0], minlength=len(colors))
    flat = np.array([len(shades) == 1 for shades in colors]) | (area < DETAIL * area.sum())
    flat |= _mostly(painted[tones.labels] & (tones.labels >= 0), whole, area)
    return FoundMaterials(whole, np.where(alone, own, pure), lit, colors, flat)


def shows_one_ramp(frame: Frame, normals: FloatArray) -> bool:
    """Tell whether a drawing is one shaded material if apparent ink is counted as paint; `normals` (h, w, 3) are initial."""
    _, tones, facing = read_tones(frame, np.zeros(frame.mask.shape), normals)
    return is_one_ramp(tones, facing)


def read_tones(frame: Frame, coverage: FloatArray, normals: FloatArray) -> tuple[Zones, Tones, Facing]:
    """Find the zones and tones outside the ink, and each tone's normal statistics; if all is ink, use the whole object."""
    paint = frame.mask & (coverage < PAINT)
    zones = find_zones(frame.lab, paint if paint.any() else frame.mask)
    tones = find_tones(zones)
    return zones, tones, _facing(tones, normals, inked=bool((coverage > 0).any()))


def _fill_missing_sources(source: Labels, mask: BoolArray) -> Labels:
    """Give object pixels without a source the nearest one. Values outside the mask are arbitrary."""
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


def _mostly_highlight(lit: BoolArray, told: Labels) -> BoolArray:
    """Mark user-labeled materials of which highlights would cover more than half: these are bright paint, not highlights."""
    named = told >= 0
    area = np.bincount(told[named])
    mostly = 2 * np.bincount(told[named & lit], minlength=len(area)) > area
    return named & np.asarray(mostly[told])


def _mostly(marked: BoolArray, labels: Labels, area: NDArray[np.intp]) -> BoolArray:
    """Tell of which materials more than half of the pixels are marked, shape (count,)."""
    own = np.bincount(labels[marked & (labels >= 0)], minlength=len(area))
    return np.asarray(2 * own > area)


def _strays(tones: Tones, told: Labels) -> BoolArray:
    """
    Mark paint near a user-drawn border that belongs to the neighboring material.

    Its tone is rare in this material, and most of the tone lies in others.
    """
    placed = (told >= 0) & (tones.labels >= 0)
    if not placed.any():
        return placed
    area = tones.area_by_material(told)
    rare = (area < STRAY_SHARE * area.sum(axis=1, keepdims=True)) & (2 * area < area.sum(axis=0))
    stray: BoolArray = placed & rare[told, tones.labels] & _beside_another(told, placed)
    return stray


def _fill_unlabeled(told: Labels, found: Labels) -> Labels:
    """Keep user labels; append found materials where there is no user label, numbered after them."""
    left = (told < 0) & (found >= 0)
    known = np.where(found >= 0, told, -1)
    known[left] = told.max() + 1 + np.unique(found[left], return_inverse=True)[1]
    return known


def _close_gaps(labels: Labels, named: int) -> Labels:
    """Renumber the materials found, which follow the user's, so that each number occurs."""
    found = labels > named
    if found.any():
        labels[found] = named + 1 + np.unique(labels[found], return_inverse=True)[1]
    return labels


def _under_highlights(
    lit: BoolArray, pure: Labels, source: Labels, unmixed: BoolArray, frame: Frame
) -> tuple[BoolArray, Labels]:
    """Give highlight pixels, and pixels mixed with a highlight, the source of the surrounding paint."""
    if not lit.any():
        return lit, pure
    lit = frame.mask & lit.ravel()[source]
    lit |= ~unmixed & frame.mask & grow_mask(lit, REACH)
    around = find_nearest_sources(unmixed & ~lit & frame.mask, frame.lab, lit)
    # Scaling leaves seams beside a highlight. Behind them the paint is clean.
    beside = frame.mask & grow_mask(lit, REACH)
    behind = find_nearest_sources(unmixed & ~beside & frame.mask, frame.lab, beside)
    lab = frame.lab.reshape(-1, 3)
    alike = (behind >= 0) & (np.linalg.norm(lab[behind] - lab[around], axis=-1) < SEAM)
    around = np.where(alike, behind, around)
    return lit, np.where(lit & (around >= 0), around, pure)


def _of_their_material(sources: Labels, told: Labels, clean: BoolArray) -> Labels:
    """Replace sources outside a pixel's user-labeled material with the nearest clean pixel of that material."""
    elsewhere = (told >= 0) & (told.ravel()[sources] != told)
    sources = sources.copy()
    for material in np.unique(told[elsewhere]):
        own = clean & (told == material)
        if own.any():
            rows, columns = ndimage.distance_transform_edt(~own, return_distances=False, return_indices=True)
            left = elsewhere & (told == material)
            sources[left] = rows[left] * sources.shape[1] + columns[left]
    return sources


def _renumber(tones: Tones, group: Groups) -> tuple[Labels, BoolArray]:
    """
    Assign numbers to the materials of pixels by area, the largest first, and among equal ones the darker first.

    The other array marks highlight pixels, which keep the number of their own color. Colors that occur only as highlights
    come last.
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
    """Return the mean sRGB of each tone of each material, over unmixed pixels, without tones below `TONE_SHARE`."""
    paint = (tones.labels >= 0) & (labels >= 0) & pure
    count, number = int(labels.max()) + 1, len(tones.area)
    key = labels[paint].astype(np.intp) * number + tones.labels[paint]
    area = np.bincount(key, minlength=count * number)
    color = frame.color
    sums = np.column_stack(
        [np.bincount(key, channel, count * number) for channel in pixels_at(color, paint).T]
    )
    area, sums = area.reshape(count, number), sums.reshape(count, number, 3)
    large = area >= np.maximum(TONE_SHARE * area.sum(axis=1, keepdims=True), 1)
    colors = []
    for which in range(count):
        occurring = np.flatnonzero(large[which])
        if occurring.size == 0:  # all of it is mixed or lies under ink
            colors.append(color[labels == which].mean(axis=0, keepdims=True))
        else:
            colors.append(sums[which, occurring] / area[which, occurring, None])
    return tuple(colors)

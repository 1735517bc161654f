"""Objects on a plain background: find the background, and take it out of the anti-aliased outline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import MIN_OBJECT_PIXELS, BoolArray, FloatArray, refuse
from toonkit.model.checkerboard import has_checkerboard
from toonkit.model.image import ToonImage

TOLERANCE = 8 / 255
"""Largest difference of a channel from the background's color within it: JPEG wavers by about as much."""

MIN_FRAME_SHARE = 0.6
"""Share of the picture's frame that a plain background must cover: a portrait may be cut off at one side."""

OUTLINE_WIDTH = 2
"""Pixels from the background within which colors may be mixed with it: anti-aliasing is one or two wide."""

_RIPPLE_REACH = 10  # pixels; JPEG ripples stay within blocks of 8 or 16
_HALO_WIDTH = 4  # pixels: JPEG keeps hues at half the resolution and smooths them on the way back
_HALO_PER_NOISE = 5  # measured at JPEG qualities 75 and 90: the halo is that much stronger than the ripples
_FAINT = 3 * TOLERANCE
_SPECK = 64  # pixels: a faint island no larger than one JPEG block is a ripple
_MIX_TOLERANCE = 0.06  # how far off the line between two colors a mixture of them may lie
_WINDOW = [
    (down, right)
    for down in range(-OUTLINE_WIDTH, OUTLINE_WIDTH + 1)
    for right in range(-OUTLINE_WIDTH, OUTLINE_WIDTH + 1)
    if (down, right) != (0, 0)
]

Index = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Background:
    """
    A plain background.

    Attributes
    ----------
    color : ndarray, shape (3,)
        sRGB in [0, 1].
    mask : ndarray, shape (H, W)
        True on the background: pixels of its color that connect to the picture's frame.
    noise : float
        How far its pixels near the object waver from its color, 0..1: 0 in a lossless picture.
    """

    color: FloatArray
    mask: BoolArray
    noise: float


@dataclass(frozen=True, eq=False)
class _Unmixed:
    """What P outline pixels were before the background was mixed in: color (P, 3), coverage (P,)."""

    color: FloatArray
    coverage: FloatArray


def find_background(color: FloatArray) -> Background:
    """
    Find the plain background of a picture, (H, W, 3) float64 sRGB in [0, 1].

    Patches of the same color inside the object stay with the object. Raises `ToonkitError` if no color covers
    `MIN_FRAME_SHARE` of the frame, nothing else is in the picture, or a checkerboard of transparency is painted around
    the object.
    """
    frame = np.concatenate([color[0], color[-1], color[1:-1, 0], color[1:-1, -1]])
    # A color that most of the frame shares holds the median of each channel.
    background = np.median(frame, axis=0)
    alike = np.abs(frame - background).max(axis=1) <= TOLERANCE
    if has_checkerboard(color):
        rule = (
            "must be transparent where a program shows a checkerboard: save the drawing itself, not a screenshot or a "
            "preview of it, or pass mask=..."
        )
        raise refuse("source", rule, "an opaque picture with a checkerboard painted around the object")
    if alike.mean() < MIN_FRAME_SHARE:
        rule = (
            "must show where the object is: pass mask=..., or save the drawing with a transparent background "
            f"(or a plain one, alike on {MIN_FRAME_SHARE:.0%} of the picture's frame)"
        )
        raise refuse("source", rule, f"an opaque picture, alike on {alike.mean():.0%} of its frame")
    difference = np.abs(color - background).max(axis=-1)
    labels, _ = ndimage.label(difference <= TOLERANCE)
    edge = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    outside = np.isin(labels, np.unique(edge[edge > 0]))
    noise = _noise(difference, outside)
    outside = _with_halo(difference, outside, noise)
    outside |= _specks(difference, ~outside)
    _check_size(int((~outside).sum()))
    return Background(background, outside, noise)


def cut_out(color: FloatArray) -> ToonImage:
    """
    Cut an object out of its plain background; the picture is (H, W, 3) float64 sRGB in [0, 1].

    In its outline, `OUTLINE_WIDTH` wide, colors mixed with the background are replaced by the object's own and the
    mixing ratio becomes alpha, so that no background color gets into a color map. Raises errors as `find_background`
    does.
    """
    background = find_background(color)
    rest = ~background.mask
    depth = ndimage.distance_transform_edt(rest)
    rows, columns = np.nonzero(rest & (depth <= OUTLINE_WIDTH))
    unmixed = _unmix(color, depth, rows, columns, background)
    coverage = _no_hollow_outline(unmixed.coverage, depth, rows, columns)
    alpha = rest.astype(np.float64)
    alpha[rows, columns] = coverage
    painted = color.copy()
    mixed = coverage < 1
    painted[rows[mixed], columns[mixed]] = unmixed.color[mixed]
    mask = alpha >= 0.5
    _check_size(int(mask.sum()))
    return ToonImage(painted, mask, alpha=alpha, fringe=painted)


def _check_size(count: int) -> None:
    if count < MIN_OBJECT_PIXELS:
        rule = f"must show an object of at least {MIN_OBJECT_PIXELS} pixels"
        raise refuse("source", rule, f"{count} pixels that differ from its plain background")


def _noise(difference: FloatArray, outside: BoolArray) -> float:
    """Measure how far the background wavers near the object, where lossy compression leaves its ripples."""
    distance = ndimage.distance_transform_edt(outside)
    near = difference[(distance > OUTLINE_WIDTH) & (distance <= _RIPPLE_REACH)]
    return float(np.percentile(near, 99)) if near.size else 0.0


def _with_halo(difference: FloatArray, outside: BoolArray, noise: float) -> BoolArray:
    """Extend the background into the halo that lossy compression lays around an object."""
    halo = difference <= min(_HALO_PER_NOISE * noise, _FAINT)
    grown: BoolArray = ndimage.binary_dilation(outside, mask=outside | halo, iterations=_HALO_WIDTH)
    return grown


def _specks(difference: FloatArray, rest: BoolArray) -> BoolArray:
    """Small faint islands in the background: ripples, too, that do not touch the object."""
    labels, _ = ndimage.label(rest, structure=np.ones((3, 3)))
    size = np.bincount(labels.ravel())
    strong_pixels = np.bincount(labels[difference >= _FAINT], minlength=len(size))
    speck = (size < _SPECK) & (strong_pixels == 0)
    speck[0] = False
    found: BoolArray = speck[labels]
    return found


def _unmix(
    color: FloatArray, depth: FloatArray, rows: Index, columns: Index, background: Background
) -> _Unmixed:
    """
    Split outline pixels into object and background: c = a F + (1 - a) B, for F a color nearby.

    F is the neighbor, no closer to the background, that lies on the line from B through c and farthest along
    it: the least mixed of the colors that c can be a mixture of. A pixel painted like one deeper inside is
    not a mixture.
    """
    own = color[rows, columns]
    away = own - background.color
    tolerance = _MIX_TOLERANCE + _HALO_PER_NOISE * background.noise
    unmixed, coverage = own.copy(), np.ones(len(rows))
    reach = np.linalg.norm(away, axis=1)
    solid = np.zeros(len(rows), dtype=np.bool_)
    for down, right in _WINDOW:
        near, inside = _neighbors(depth.shape, rows, columns, down, right)
        candidate, deeper = color[near], depth[near] - depth[rows, columns]
        line = candidate - background.color
        length = np.linalg.norm(line, axis=1)
        share = (away * line).sum(axis=1) / np.maximum(length, 1e-12) ** 2
        off_line = np.linalg.norm(away - share[:, None] * line, axis=1)
        take = inside & (deeper >= 0) & (length > reach) & (share > 0) & (share < 1) & (off_line <= tolerance)
        unmixed[take], coverage[take], reach[take] = candidate[take], share[take], length[take]
        if max(abs(down), abs(right)) == 1:
            solid |= inside & (deeper > 0) & (np.abs(candidate - own).max(axis=1) <= TOLERANCE / 2)
    unmixed[solid], coverage[solid] = own[solid], 1.0
    return _Unmixed(unmixed, coverage)


def _no_hollow_outline(coverage: FloatArray, depth: FloatArray, rows: Index, columns: Index) -> FloatArray:
    """Let no outline pixel be less covered than a neighbor farther out: light bands are not transparent."""
    alpha = np.zeros_like(depth)
    alpha[rows, columns] = coverage
    raised = coverage.copy()
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        near, inside = _neighbors(depth.shape, rows, columns, down, right)
        outward = inside & (depth[near] > 0) & (depth[near] < depth[rows, columns])
        raised[outward] = np.maximum(raised, alpha[near])[outward]
    return raised


def _neighbors(
    shape: tuple[int, ...], rows: Index, columns: Index, down: int, right: int
) -> tuple[tuple[Index, Index], BoolArray]:
    """Index of the pixels at an offset (moved to the picture's edge if outside it), and which are inside."""
    row, column = rows + down, columns + right
    inside = (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
    return (np.clip(row, 0, shape[0] - 1), np.clip(column, 0, shape[1] - 1)), inside

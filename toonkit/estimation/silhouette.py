"""The silhouette: where it runs between pixels, and which way is outward (Section 3.1, the boundary of Eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from skimage.measure import find_contours

from toonkit._validation import FloatArray
from toonkit.numerics.masked_grid import STEPS, MaskedGrid

STAIRCASE_SMOOTHING = 10.0
"""Arc length in pixels over which a yes-or-no outline is smoothed.

The steps of a digitized arc of radius r are up to sqrt(2 r) pixels long, and not shape. With 10 the directions of discs of
32 to 256 pixels are right to 2 degrees; with 4, to 5.
"""

ANTIALIASED_SMOOTHING = 2.5
"""Arc length in pixels over which an outline is smoothed whose alpha says where it runs between pixels."""

SAMPLE_SPACING = 0.5
"""Pixels between the evenly spaced points on which an outline is smoothed."""

NEAREST = 0.1
"""Least distance, in pixels, from a pixel's center to the outline: closer ones would stiffen the system for nothing."""


@dataclass(frozen=True, eq=False)
class Silhouette:
    """
    Crossings of the outline with the links between an object pixel and a background pixel.

    Attributes
    ----------
    pixels : ndarray, shape (n,)
        Compact index of the object pixel of each crossing.
    directions : ndarray, shape (n,)
        Which neighbor of it lies across the outline: RIGHT, UP, LEFT or DOWN.
    distances : ndarray, shape (n,)
        From the pixel's center to the outline along that link, in pixels, in (0, 1].
    outward : ndarray, shape (n, 2)
        Unit outward direction (x, y) of the outline there: (nx, ny) of a normal with nz = 0.
    """

    pixels: NDArray[np.intp]
    directions: NDArray[np.intp]
    distances: FloatArray
    outward: FloatArray


def trace_silhouette(grid: MaskedGrid, alpha: FloatArray) -> Silhouette:
    """
    Find the outline at sub-pixel accuracy.

    Parameters
    ----------
    grid : MaskedGrid
        The object.
    alpha : ndarray, shape (H, W)
        Coverage in [0, 1]; the outline is where it crosses one half.

    Returns
    -------
    Silhouette
        One crossing for each link that leaves the object inside the picture. An object that is cut off by the frame has no
        outline there, unless it fills the picture.

    Notes
    -----
    Marching squares puts one vertex on every link that leaves the mask, in order along the outline; smoothing the curve
    along its arc length removes the pixel staircase, and gives tangents, without letting neighboring parts see each other.
    """
    level = _framed_level(grid, alpha)
    smoothing = ANTIALIASED_SMOOTHING if _is_antialiased(grid, alpha) else STAIRCASE_SMOOTHING
    parts = [_crossings(grid, level, contour, smoothing) for contour in find_contours(level, 0.5)]
    if not parts:
        nothing = np.zeros(0, dtype=np.intp)
        return Silhouette(nothing, nothing, np.zeros(0), np.zeros((0, 2)))
    return Silhouette(
        np.concatenate([part.pixels for part in parts]),
        np.concatenate([part.directions for part in parts]),
        np.concatenate([part.distances for part in parts]),
        np.concatenate([part.outward for part in parts]),
    )


def _is_antialiased(grid: MaskedGrid, alpha: FloatArray) -> bool:
    """Tell whether a good part of the rim says by its alpha where the outline runs between pixels."""
    rim = alpha[grid.rows[grid.rim], grid.columns[grid.rim]]
    return rim.size > 0 and float(np.mean(rim < 0.99)) > 0.2


def _framed_level(grid: MaskedGrid, alpha: FloatArray) -> FloatArray:
    """
    Alpha made to agree with the mask about which side of one half it is on, with a border around the picture.

    The border carries on what is beside it, so that no outline runs along the frame; around a picture that the object fills
    it is background.
    """
    inside = np.maximum(alpha, 0.5 + 1e-3)
    outside = np.minimum(alpha, 0.5 - 1e-3)
    level = np.where(grid.mask, inside, outside)
    return np.pad(level, 1) if grid.mask.all() else np.pad(level, 1, mode="edge")


def _crossings(grid: MaskedGrid, level: FloatArray, contour: FloatArray, smoothing: float) -> Silhouette:
    closed = len(contour) > 2 and bool((contour[0] == contour[-1]).all())
    vertices = contour[:-1] if closed else contour
    low, high = np.floor(vertices).astype(np.intp), np.ceil(vertices).astype(np.intp)
    low_inside = level[low[:, 0], low[:, 1]] > 0.5
    inside = np.where(low_inside[:, None], low, high)
    step = np.where(low_inside[:, None], high - low, low - high)
    distance = np.abs(vertices - inside).sum(axis=1)
    toward = np.stack([step[:, 1], -step[:, 0]], axis=1).astype(np.float64)  # (row, column) to (x, y up)

    points = np.stack([vertices[:, 1], -vertices[:, 0]], axis=1)
    smooth, outward = _smooth_curve(points, closed, smoothing)
    if np.sum(outward * toward) < 0:
        outward = -outward
    # How far smoothing moved the outline along the link: its displacement along the normal, over the link's share of it.
    moved = np.einsum("nc,nc->n", smooth - points, outward)
    share = np.maximum(np.einsum("nc,nc->n", toward, outward), 0.5)
    distance = np.clip(distance + moved / share, NEAREST, 1.0)

    row, column = inside[:, 0] - 1, inside[:, 1] - 1
    height, width = grid.mask.shape
    in_picture = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    row, column, step = row[in_picture], column[in_picture], step[in_picture]
    directions = np.argmax((step[:, None, :] == np.array(STEPS)).all(axis=2), axis=1)
    return Silhouette(
        grid.index[row, column].astype(np.intp), directions, distance[in_picture], outward[in_picture]
    )


def _smooth_curve(points: FloatArray, closed: bool, smoothing: float) -> tuple[FloatArray, FloatArray]:
    """Return the points of a curve smoothed along its length, and a unit normal at each (its sign is the caller's)."""
    chain = np.concatenate([points, points[:1]]) if closed else points
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))])
    if len(points) < 3:
        return points, np.tile([1.0, 0.0], (len(points), 1))
    count = max(int(np.ceil(arc[-1] / SAMPLE_SPACING)), 8)
    samples = np.linspace(0.0, arc[-1], count, endpoint=not closed)
    even = np.stack([np.interp(samples, arc, coordinate) for coordinate in chain.T], axis=1)
    # A small closed part must not shrink to its center.
    sigma = min(smoothing / SAMPLE_SPACING, count / 16)
    mode = "wrap" if closed else "nearest"
    once = gaussian_filter1d(even, sigma, axis=0, mode=mode)
    # Twicing: what one pass took off is smoothed and given back, so that curvature survives.
    smooth = once + gaussian_filter1d(even - once, sigma, axis=0, mode=mode)
    if closed:
        tangent = np.roll(smooth, -1, axis=0) - np.roll(smooth, 1, axis=0)
        samples = np.append(samples, arc[-1])
        smooth, tangent = np.concatenate([smooth, smooth[:1]]), np.concatenate([tangent, tangent[:1]])
    else:
        tangent = np.gradient(smooth, axis=0)
    at_points = arc[: len(points)]
    smooth = np.stack([np.interp(at_points, samples, coordinate) for coordinate in smooth.T], axis=1)
    tangent = np.stack([np.interp(at_points, samples, coordinate) for coordinate in tangent.T], axis=1)
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    tangent = np.where(length > 1e-9, tangent / np.maximum(length, 1e-9), [1.0, 0.0])
    return smooth, np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)

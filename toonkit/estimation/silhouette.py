"""The silhouette: where it runs between pixels, and which way is outward (Section 3.1, the boundary of Eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from toonkit._validation import BoolArray, FloatArray
from toonkit.numerics.masked_grid import DOWN, LEFT, OUTSIDE, RIGHT, STEPS, UP, MaskedGrid

STAIRCASE_SMOOTHING = 10.0
"""Arc length in pixels over which the outline of a binary mask is smoothed.

The steps of a digitized arc of radius r are up to sqrt(2 r) pixels long and carry no shape. With 10 the directions of discs
of 32 to 256 pixels are right to 2 degrees; with 4, to 5.
"""

ANTIALIASED_SMOOTHING = 2.5
"""Arc length in pixels over which an outline is smoothed when alpha places it between pixels."""

SAMPLE_SPACING = 0.5
"""Pixels between the evenly spaced points on which an outline is smoothed."""

FEWEST_SAMPLES = 8
"""Points of the shortest outline. The smoothing's standard deviation is at most the length of an outline over twice that."""

NEAREST = 0.1
"""Least distance, in pixels, from a pixel's center to the outline: smaller ones would only stiffen the system."""

CUT_SHARE, CUT_PER_ROOT = 0.5, 4.0
"""Length of a straight edge that the frame of a picture may have cut: relative to the side of the object's box, and to the
square root of that side in pixels. A digitized disc of diameter d touches its box along 2 sqrt(d) pixels."""

CUT_COVERED, CUT_CLEAR = 0.95, 0.05
"""Coverage of the pixels inside such an edge, at least, and of those beyond it, at most: the frame cuts between pixels."""


@dataclass(frozen=True, eq=False)
class Silhouette:
    """
    Crossings of the outline with the links between an object pixel and a background pixel.

    Attributes
    ----------
    pixels : ndarray, shape (n,)
        Compact index of the object pixel of each crossing.
    directions : ndarray, shape (n,)
        Which of its neighbors lies across the outline: RIGHT, UP, LEFT or DOWN.
    distances : ndarray, shape (n,)
        From the pixel's center to the outline along that link, in pixels, in (0, 1].
    outward : ndarray, shape (n, 2)
        Unit outward direction (x, y) of the outline there: (nx, ny) of a normal with nz = 0.
    """

    pixels: NDArray[np.intp]
    directions: NDArray[np.intp]
    distances: FloatArray
    outward: FloatArray


def trace_silhouette(grid: MaskedGrid, coverage: FloatArray) -> Silhouette:
    """
    Find the outline at sub-pixel accuracy.

    Parameters
    ----------
    grid : MaskedGrid
        The object, cropped to its bounding box.
    coverage : ndarray, shape (H + 2, W + 2)
        Alpha in [0, 1] of the box and of the pixels around it; the outline is where it crosses one half.

    Returns
    -------
    Silhouette
        One crossing for each link that leaves the object, but for sides that the frame of the picture cut off.

    Notes
    -----
    Where the mask has a link that leaves it, marching squares has a vertex. The outline is followed from vertex to vertex;
    pixels that touch at a corner only are apart. Smoothing the curve along its arc length removes the staircase of the
    pixels, and gives tangents, without letting neighboring parts see each other.
    """
    outline = _Outline.of(grid, coverage)
    smoothing = ANTIALIASED_SMOOTHING if _is_antialiased(grid, coverage) else STAIRCASE_SMOOTHING
    smooth, outward = outline.smoothed(smoothing)
    toward = outline.toward
    # How far smoothing moved the outline along the link: its displacement along the normal, over the link's share of it.
    moved = np.einsum("nc,nc->n", smooth - outline.points, outward)
    share = np.maximum(np.einsum("nc,nc->n", toward, outward), 0.5)
    distances = np.clip(outline.distances + moved / share, NEAREST, 1.0)
    return Silhouette(outline.pixels, outline.directions, distances, outward)


def _is_antialiased(grid: MaskedGrid, coverage: FloatArray) -> bool:
    """Tell whether a good part of the rim says by its alpha where the outline runs between pixels."""
    rim = coverage[1:-1, 1:-1][grid.rows[grid.rim], grid.columns[grid.rim]]
    return rim.size > 0 and float(np.mean(rim < 0.99)) > 0.2


def cut_sides(mask: BoolArray, coverage: FloatArray) -> tuple[bool, bool, bool, bool]:
    """
    Tell which sides of an object the frame of its picture cut off, whether or not that frame is still there.

    Parameters
    ----------
    mask : ndarray, shape (H, W)
        The object on its bounding box.
    coverage : ndarray, shape (H + 2, W + 2)
        Alpha of the box and of the pixels around it.

    Returns
    -------
    tuple of bool
        For RIGHT, UP, LEFT and DOWN whether the object ends there, but not on the opposite side, in a long straight edge
        between pixels. Two such edges, as of a bar or a box, are the object's own.
    """
    cut = [False] * len(STEPS)
    for direction, inner, outer, line in (
        (RIGHT, coverage[1:-1, -2], coverage[1:-1, -1], mask[:, -1]),
        (UP, coverage[1, 1:-1], coverage[0, 1:-1], mask[0]),
        (LEFT, coverage[1:-1, 1], coverage[1:-1, 0], mask[:, 0]),
        (DOWN, coverage[-2, 1:-1], coverage[-1, 1:-1], mask[-1]),
    ):
        straight = np.concatenate([[False], line & (inner >= CUT_COVERED) & (outer <= CUT_CLEAR), [False]])
        ends = np.flatnonzero(np.diff(straight))
        longest = int(np.max(ends[1::2] - ends[::2], initial=0))
        cut[direction] = longest >= max(CUT_SHARE * line.size, CUT_PER_ROOT * np.sqrt(line.size))
    right, up, left, down = cut
    sideways, upright = right != left, up != down
    return right and sideways, up and upright, left and sideways, down and upright


@dataclass(frozen=True, eq=False)
class _Outline:
    """
    The crossings in their order along the outline, one curve after the other.

    Attributes
    ----------
    pixels, directions, distances : ndarray, shape (n,)
        As in `Silhouette`, before any smoothing.
    points, toward : ndarray, shape (n, 2)
        Positions of the crossings, and unit steps from their pixels toward them, x right and y up.
    starts : ndarray, shape (m + 1,)
        First crossing of each curve, and n.
    closed : ndarray, shape (m,)
        Whether each curve closes.
    """

    pixels: NDArray[np.intp]
    directions: NDArray[np.intp]
    distances: FloatArray
    points: FloatArray
    toward: FloatArray
    starts: NDArray[np.intp]
    closed: BoolArray

    @classmethod
    def of(cls, grid: MaskedGrid, coverage: FloatArray) -> _Outline:
        """Follow the outline of an object; see `trace_silhouette`."""
        leaving = grid.neighbors == OUTSIDE
        height, width = grid.mask.shape
        ends = (grid.columns == width - 1, grid.rows == 0, grid.columns == 0, grid.rows == height - 1)
        for direction, cut in enumerate(cut_sides(grid.mask, coverage)):
            if cut:
                leaving[ends[direction], direction] = False
        pixels, directions = np.nonzero(leaving)
        number = np.full(leaving.shape, OUTSIDE, np.intp)  # of the crossing, by pixel and direction
        number[pixels, directions] = np.arange(len(pixels))
        order, starts, closed = _followed(_successors(grid, number, pixels, directions))
        pixels, directions = pixels[order], directions[order]
        rows, columns, steps = grid.rows[pixels], grid.columns[pixels], np.array(STEPS)[directions]
        # Alpha and the mask agree about which side of one half a pixel is on.
        inside = np.maximum(coverage[rows + 1, columns + 1], 0.5 + 1e-3)
        outside = np.minimum(coverage[rows + 1 + steps[:, 0], columns + 1 + steps[:, 1]], 0.5 - 1e-3)
        distances = (inside - 0.5) / (inside - outside)
        toward = np.stack([steps[:, 1], -steps[:, 0]], axis=1).astype(
            np.float64
        )  # (row, column) to (x, y up)
        points = np.stack([columns, -rows], axis=1) + distances[:, None] * toward
        return cls(pixels, directions, distances, points, toward, starts, closed)

    def smoothed(self, smoothing: float) -> tuple[FloatArray, FloatArray]:
        """Return the points smoothed over some arc length, and the unit outward normals there, both of shape (n, 2)."""
        smooth, tangents = self.points.copy(), np.empty_like(self.points)
        lengths = np.diff(self.starts)
        arc, totals = _arc_lengths(self.points, self.starts, self.closed)
        counts = np.maximum(np.ceil(totals / SAMPLE_SPACING).astype(np.intp), FEWEST_SAMPLES)
        # Curves of as many samples are smoothed at once: dithered drawings have tens of thousands.
        kind = 2 * counts + self.closed
        order = np.argsort(kind, kind="stable")
        for curves in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
            which = _concatenated_ranges(self.starts[curves], lengths[curves])
            smooth[which], tangents[which] = _smooth_curves(
                self.points[which], arc[which], totals[curves], lengths[curves],
                count=int(counts[curves[0]]), closed=bool(self.closed[curves[0]]), smoothing=smoothing,
            )  # fmt: skip
        norm = np.linalg.norm(tangents, axis=1, keepdims=True)
        # The object is on the left of the way along its outline, so that outward is to the right.
        outward = np.stack([tangents[:, 1], -tangents[:, 0]], axis=1)
        return smooth, np.where(norm > 1e-9, outward / np.maximum(norm, 1e-9), self.toward)


def _successors(
    grid: MaskedGrid, number: NDArray[np.intp], pixels: NDArray[np.intp], directions: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return the number of the crossing after each one, counter-clockwise; `OUTSIDE` where a curve ends."""
    ahead = (directions + 1) % 4
    beside = grid.neighbors[pixels, ahead]
    across = np.where(beside == OUTSIDE, OUTSIDE, grid.neighbors[np.maximum(beside, 0), directions])
    return np.where(
        beside == OUTSIDE,
        number[pixels, ahead],  # around the corner of the pixel
        np.where(across == OUTSIDE, number[beside, directions], number[across, (directions + 3) % 4]),
    )


def _followed(successors: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp], BoolArray]:
    """
    Put crossings in the order of their curves.

    Parameters
    ----------
    successors : ndarray, shape (n,)
        Number of the crossing that follows each one, `OUTSIDE` at the end of an open curve.

    Returns
    -------
    order : ndarray, shape (n,)
        Numbers of the crossings, curve after curve.
    starts : ndarray, shape (m + 1,)
        Where each curve begins in that order, and n.
    closed : ndarray, shape (m,)
        Whether it closes. A closed curve begins at its lowest number.
    """
    count = len(successors)
    everyone, linked = np.arange(count), np.flatnonzero(successors != OUTSIDE)
    graph = coo_array((np.ones(len(linked), np.int8), (linked, successors[linked])), (count, count))
    curves, curve = connected_components(graph, directed=False)
    is_first = np.ones(count, np.bool_)
    is_first[successors[linked]] = False
    closed = np.ones(curves, np.bool_)
    closed[curve[is_first]] = False
    heads = np.unique(curve, return_index=True)[1]
    # Closed curves are cut ahead of their heads; then pointer doubling counts the steps that are left.
    ends = (successors == OUTSIDE) | (closed[curve] & (successors == heads[curve]))
    jump = np.where(ends, everyone, successors)
    left = (~ends).astype(np.intp)
    while (farther := jump[jump]).tobytes() != jump.tobytes():
        left += left[jump]
        jump = farther
    starts = np.append(0, np.cumsum(np.bincount(curve, minlength=curves)))
    order = np.empty(count, np.intp)
    order[starts[1:][curve] - 1 - left] = everyone
    return order, starts, closed


def _arc_lengths(
    points: FloatArray, starts: NDArray[np.intp], closed: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far along its curve each point lies, (n,), and the lengths of the curves, (m,)."""
    step = np.zeros(len(points))
    step[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    heads, tails = starts[:-1], starts[1:] - 1
    step[heads] = 0.0
    run = np.cumsum(step)
    arc = run - np.repeat(run[heads], np.diff(starts))
    back = np.linalg.norm(points[heads] - points[tails], axis=1)
    return arc, arc[tails] + np.where(closed, back, 0.0)


def _concatenated_ranges(starts: NDArray[np.intp], lengths: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return start, start + 1, ... start + length - 1 of each range, one range after the other."""
    offsets = np.cumsum(lengths) - lengths
    ranges: NDArray[np.intp] = np.arange(int(lengths.sum())) + np.repeat(starts - offsets, lengths)
    return ranges


def _smooth_curves(
    points: FloatArray,
    arc: FloatArray,
    totals: FloatArray,
    lengths: NDArray[np.intp],
    *,
    count: int,
    closed: bool,
    smoothing: float,
) -> tuple[FloatArray, FloatArray]:
    """
    Smooth m curves of as many samples each.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Points of the curves, one after the other.
    arc : ndarray, shape (n,)
        How far along its curve each of them lies.
    totals, lengths : ndarray, shape (m,)
        Lengths of the curves, and of how many points they consist.
    count : int
        Samples of each curve.
    closed : bool
        Whether the curves close.
    smoothing : float
        Standard deviation of the smoothing, in pixels.

    Returns
    -------
    points, tangents : ndarray, shape (n, 2)
        Smoothed points, and the way along the curve there, of any length.
    """
    # Each curve has a stretch of its own on one axis, in units of its length, so that all are interpolated at once.
    curve = np.repeat(np.arange(len(lengths)), lengths)
    here = 2.0 * curve + arc / np.maximum(totals[curve], 1e-12)
    knots, corners = here, points
    if closed:  # back to the first point
        heads = np.cumsum(lengths) - lengths
        knots = np.insert(here, heads + lengths, 2.0 * np.arange(len(lengths)) + 1.0)
        corners = np.insert(points, heads + lengths, points[heads], axis=0)
    axis = 2.0 * np.arange(len(lengths))[:, None] + np.linspace(0.0, 1.0, count, endpoint=not closed)
    even = np.stack([np.interp(axis, knots, coordinate) for coordinate in corners.T], axis=-1)
    # A small closed part must not shrink to its center.
    sigma = min(smoothing / SAMPLE_SPACING, count / (2 * FEWEST_SAMPLES))
    mode = "wrap" if closed else "nearest"
    once = gaussian_filter1d(even, sigma, axis=1, mode=mode)
    # Twicing: what one pass took off is smoothed and given back, so that curvature survives.
    smooth = once + gaussian_filter1d(even - once, sigma, axis=1, mode=mode)
    if closed:
        tangents = np.roll(smooth, -1, axis=1) - np.roll(smooth, 1, axis=1)
        axis = np.concatenate([axis, axis[:, :1] + 1.0], axis=1)
        smooth, tangents = (np.concatenate([part, part[:, :1]], axis=1) for part in (smooth, tangents))
    else:
        tangents = np.gradient(smooth, axis=1)
    return _at(here, axis, smooth), _at(here, axis, tangents)


def _at(places: FloatArray, axis: FloatArray, samples: FloatArray) -> FloatArray:
    """Interpolate samples (m, count, 2), which stand at places (m, count) of an axis, at other places (n,)."""
    return np.stack(
        [np.interp(places, axis.ravel(), part.ravel()) for part in np.moveaxis(samples, -1, 0)], axis=-1
    )

"""What interior contours would buy: self-occlusions inside the silhouette as one-sided constraints of the inflation.

    python -m benchmarks.interior_contours -o notebooks/study/interior_contours.csv

Where one part of an object hides another the nearer one has a rim: its normal lies in the image plane and faces across the
contour, as on the silhouette, and nothing holds the farther side to it. Each method starts from the plain inflation, from
one with the contours that the colors show (edges where the illumination jumps farther than a smooth shape allows, of which
one side alone can be a rim under the light), and from one that knows the true contours, which no method can.

Runs on the pictures of `benchmarks.ablation`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter, label

from benchmarks.ablation import run
from toonkit import NormalField, ToonAnalysis, ToonImage, illumination
from toonkit._validation import BoolArray, FloatArray, as_light
from toonkit.estimation.inflation import RESIDUAL_TOLERANCE, inflate, silhouette_system
from toonkit.estimation.reading import reading
from toonkit.estimation.shape_prior import correct_shape
from toonkit.estimation.silhouette import trace_silhouette
from toonkit.estimation.tone_ranks import ToneRanks
from toonkit.methods import Method
from toonkit.methods.steps import Inflated, StepProgress
from toonkit.methods.toonkit import OPTIONS
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid
from toonkit.numerics.membrane import Membrane, solve_membrane
from toonkit.study.rendering import RenderedShape
from toonkit.study.trials import Painting

ACROSS = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
"""(x, y) of the way to each of the four neighbors of `MaskedGrid`."""

STEEPEST = 0.35
"""Smallest z of a nearer side's normal by which its slope is taken: at a rim it would have no end."""

GAP, PER_BEND = 0.12, 3.0
"""Jump of the illumination that no smooth shape has between neighbors: so much, and so much per bend of the inflation."""

FITS, BETTER_BY = 0.12, 0.1
"""Illumination by which a rim may miss its colors, on the mean of a contour; and by how much less than the other side."""

SHORTEST = 0.08
"""Shortest contour, in square roots of the object's area."""

STIFFNESS, LEFT = 2.0, 1e-3
"""Of a tie to a contour that runs half a pixel away; and what is left of a link that crosses one."""

SMOOTHING = 1.5
"""Pixels over which illumination is smoothed to tell where a contour faces."""


class Contours(NamedTuple):
    """
    Interior contours on a `MaskedGrid`.

    `cut`, shape (P, 4): links that cross one. `outward`, shape (P, 2): where the rim of a pixel on the nearer side faces,
    zero for all others.
    """

    cut: BoolArray
    outward: FloatArray


def true_contours(truth: RenderedShape) -> Contours:
    """Return the contours that a shape has: where its depth drops by more than its slopes explain."""
    grid = MaskedGrid(truth.normals.mask)
    depth, normals = truth.depth[grid.mask], truth.normals.compact
    sideways = np.hypot(normals[:, 0], normals[:, 1])
    own, behind = (sideways / np.maximum(normals[:, 2], least) for least in (STEEPEST, 1e-6))
    cut = np.zeros(grid.neighbors.shape, dtype=np.bool_)
    outward = np.zeros((grid.size, 2))
    for direction, there in enumerate(grid.neighbors.T):
        here = np.flatnonzero(there != OUTSIDE)
        other = there[here]
        # A drop, in pixels, that neither side's slope explains; a surface that goes on to its own rim is steepest there.
        drops = depth[here] - depth[other] > own[here] + behind[other] + 1.0
        near = here[drops]
        cut[near, direction] = True
        outward[near] += normals[near, :2]
    length = np.linalg.norm(outward, axis=1, keepdims=True)
    return Contours(_both_ways(grid, cut), outward / np.maximum(length, 1e-12))


def found_contours(image: ToonImage, light: FloatArray) -> Contours:
    """Return the contours that the colors show, where only one side can be the nearer one."""
    grid = MaskedGrid(image.mask)
    initial_normals = inflate(image.mask, alpha=image.alpha)
    ranks = ToneRanks.of(reading(image).tones.plain)
    ordered = np.sort(illumination(initial_normals, light)[grid.mask])
    lower, upper = ordered[ranks.below], ordered[ranks.upto - 1]  # as rank matching allows, mixtures apart
    normals = initial_normals.compact
    cut = np.zeros(grid.neighbors.shape, dtype=np.bool_)
    brighter = np.zeros(grid.size, dtype=np.bool_)
    darker = np.zeros(grid.size, dtype=np.bool_)
    for direction, there in enumerate(grid.neighbors.T):
        here = np.flatnonzero(there != OUTSIDE)
        other = there[here]
        allowed = GAP + PER_BEND * np.linalg.norm(normals[here] - normals[other], axis=1)
        above, below = lower[here] - upper[other] > allowed, lower[other] - upper[here] > allowed
        cut[here[above | below], direction] = True
        brighter[here[above]] = True
        darker[here[below]] = True
    toward_bright = _rise(grid, (lower + upper) / 2)
    outward = np.zeros((grid.size, 2))
    pieces, count = label(grid.scatter(cut.any(axis=1)) > 0, np.ones((3, 3)))
    piece = pieces[grid.mask]
    for number in range(1, count + 1):
        if np.sum(piece == number) < SHORTEST * np.sqrt(grid.size):
            continue
        sides = []
        for side, facing in ((brighter & ~darker, -toward_bright), (darker & ~brighter, toward_bright)):
            chosen = np.flatnonzero(side & (piece == number))
            lit = facing[chosen] @ light[:2]
            missed = np.abs(lit - np.clip(lit, lower[chosen], upper[chosen]))
            sides.append((missed.mean() if len(chosen) else np.inf, chosen[missed < FITS], facing))
        (best, nearer, facing), (worse, _, _) = sorted(sides, key=lambda side: side[0])
        if best < FITS and worse - best > BETTER_BY:
            outward[nearer] = facing[nearer]
    tied = outward.any(axis=1)
    cut &= tied[:, None] | tied[np.maximum(grid.neighbors, 0)]  # an edge without a nearer side is a crease
    return Contours(_both_ways(grid, cut), outward)


def inflated_within(image: ToonImage, contours: Contours) -> NormalField:
    """Inflate a silhouette as `toonkit.inflate` does, with contours inside it."""
    grid = MaskedGrid(image.mask)
    alpha = image.mask.astype(np.float64) if image.alpha is None else image.alpha
    membrane, pull = silhouette_system(grid, trace_silhouette(grid, alpha))
    tied = contours.outward.any(axis=1)
    links = membrane.links * np.where(contours.cut, LEFT, 1.0).astype(np.float32)
    membrane = Membrane(grid, links, membrane.ties + STIFFNESS * tied)
    pull = pull + STIFFNESS * (contours.outward[:, 0] + 1j * contours.outward[:, 1])
    sideways, _ = solve_membrane(membrane, pull, tolerance=RESIDUAL_TOLERANCE)
    flat = sideways / np.maximum(np.abs(sideways), 1.0)
    forward = np.sqrt(np.maximum(1.0 - flat.real**2 - flat.imag**2, 0.0))
    return NormalField.of_pixels(np.stack([flat.real, flat.imag, forward], axis=1), image.mask)


def _both_ways(grid: MaskedGrid, cut: BoolArray) -> BoolArray:
    """Cut each link from both ends."""
    for direction, there in enumerate(grid.neighbors.T):
        crossing = np.flatnonzero(cut[:, direction] & (there != OUTSIDE))
        cut[there[crossing], (direction + 2) % 4] = True
    return cut


def _rise(grid: MaskedGrid, values: FloatArray) -> FloatArray:
    """Return where smoothed values (P,) rise, unit vectors of shape (P, 2) in x and y."""
    inside = gaussian_filter(grid.mask.astype(np.float64), SMOOTHING)
    smooth = gaussian_filter(np.where(grid.mask, np.nan_to_num(grid.scatter(values)), 0.0), SMOOTHING)
    down, right = np.gradient(smooth / np.maximum(inside, 1e-6))
    rise = np.stack([right, -down], axis=-1)[grid.mask]
    return rise / np.maximum(np.linalg.norm(rise, axis=1, keepdims=True), 1e-12)


Finder = Callable[[ToonImage, FloatArray], Contours]
"""From a picture and its light to contours."""


def started(
    image: ToonImage,
    light: ArrayLike,
    *,
    progress: StepProgress | None = None,
    finder: Finder | None,
    learned: bool,
) -> ToonAnalysis:
    """Analyze a picture as `toonkit` does, or as `classical`, from an inflation that knows of contours."""
    direction = as_light("light", light)
    if finder is None:
        initial = inflate(image.mask, alpha=image.alpha)
    else:
        initial = inflated_within(image, finder(image, direction))
    steps = Inflated(image, direction, initial, progress)
    normals = correct_shape(image, direction, initial) if learned else initial
    return steps.finished("started", steps.refined(normals, None, OPTIONS if learned else None))


def variants(painting: Painting) -> dict[str, Method]:
    """Name -> method: classical and ours, without interior contours, with those found and with the true ones."""

    def told(_image: ToonImage, _light: FloatArray) -> Contours:
        return true_contours(painting.truth)

    finders = {"": None, ", contours found": found_contours, ", contours true": told}
    return {
        name + suffix: functools.partial(started, finder=finder, learned=learned)
        for name, learned in (("classical", False), ("toonkit", True))
        for suffix, finder in finders.items()
    }


def main(arguments: Sequence[str] | None = None) -> None:
    run(variants, "What interior contours would buy.", arguments)


if __name__ == "__main__":
    main()

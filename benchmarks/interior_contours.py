"""What interior contours buy: self-occlusions inside the silhouette as one-sided constraints of the inflation.

    python -m benchmarks.interior_contours -o notebooks/study/interior_contours.csv

Where one part of an object hides another the nearer one has a rim: its normal lies in the image plane and faces across the
contour, as on the silhouette, and nothing holds the farther side to it. Each method starts from the plain inflation, from
one with the contours that the colors show (edges where the illumination jumps farther than a smooth shape allows, of which
one side alone can be a rim under the light), and from one that knows the true contours, which no method can.

Then the same pictures in ink: dark lines along the silhouette and the true contours. Each method reads the lines as shading,
as it would without `toonkit.illustration.ink`; takes them off; and takes them for contours, too.

Runs on the pictures of `benchmarks.ablation`. The seconds of those in ink hold the drawing of it, too.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import distance_transform_edt, gaussian_filter, label

from benchmarks.ablation import run
from benchmarks.drawn_contours import BETTER_BY, FITS, Contours, cut_both_ways, drawn_contours
from toonkit import NormalField, ToonAnalysis, ToonImage, illumination
from toonkit._validation import FloatArray, as_light
from toonkit.estimation.inflation import RESIDUAL_TOLERANCE, inflate, silhouette_system
from toonkit.estimation.islands import join
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.estimation.shape_prior import correct_shape
from toonkit.estimation.tone_ranks import ToneRanks
from toonkit.methods import Method
from toonkit.methods.steps import StepProgress, Steps
from toonkit.methods.toonkit import OPTIONS
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid
from toonkit.numerics.screened_poisson import ScreenedPoisson, solve_screened_poisson
from toonkit.study.painting import Painting
from toonkit.study.rendering import RenderedShape

STEEPEST = 0.35
"""Smallest z of a nearer side's normal by which its slope is taken: at a rim it would have no end."""

GAP, PER_BEND = 0.12, 3.0
"""Jump of the illumination that no smooth shape has between neighbors: so much, and so much per bend of the inflation."""

SHORTEST = 0.08
"""Shortest contour, in square roots of the object's area."""

SMOOTHING = 1.5
"""Pixels over which illumination is smoothed to tell where a contour faces."""

STIFFNESS, LEFT = 2.0, 1e-3
"""Screening toward a contour that runs half a pixel away, and what is left of an edge weight across one."""

INK = (0.05, 0.04, 0.06)
"""sRGB of the lines."""

LINE = 0.012
"""Their width, in square roots of the object's area; never less than 1.2 pixels."""


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
    return Contours(cut_both_ways(grid, cut), outward / np.maximum(length, 1e-12))


def found_contours(image: ToonImage, light: FloatArray) -> Contours:
    """Return the contours that the colors show, where only one side can be the nearer one."""
    grid = MaskedGrid(image.mask)
    initial_normals = inflate(image.mask, alpha=image.alpha)
    ranks = ToneRanks.of(prepare(image).tones.plain)
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
    return Contours(cut_both_ways(grid, cut), outward)


def lines_found(image: ToonImage, light: FloatArray) -> Contours | None:
    """Return the contours that the lines of a drawing show, where its colors tell which side is the nearer one."""
    read = prepare(image)
    if read.mixed.pixels.size == 0:
        return None
    lit = read.initial_normals.compact @ light
    return drawn_contours(read.mixed, read.tones.plain, lit, light, read.grid)


def inflated_within(image: ToonImage, contours: Contours | None) -> NormalField:
    """Inflate a silhouette as `toonkit.inflate` does, with contours inside it."""
    if contours is None:
        return prepare(image).initial_normals
    islands = prepare(image).islands
    fields = []
    for island in islands:
        cut, outward = contours.cut[island.pixels], contours.outward[island.pixels]
        system, pull = silhouette_system(island.grid, island.silhouette)
        edge_weights = system.edge_weights * np.where(cut, LEFT, 1.0).astype(np.float32)
        system = ScreenedPoisson(
            island.grid, edge_weights, system.screening + STIFFNESS * outward.any(axis=1)
        )
        pull = pull + STIFFNESS * (outward[:, 0] + 1j * outward[:, 1])
        sideways, _ = solve_screened_poisson(system, pull, tolerance=RESIDUAL_TOLERANCE)
        flat = sideways / np.maximum(np.abs(sideways), 1.0)
        forward = np.sqrt(np.maximum(1.0 - flat.real**2 - flat.imag**2, 0.0))
        fields.append(np.stack([flat.real, flat.imag, forward], axis=1))
    return NormalField.of_pixels(join(islands, fields), image.mask)


def in_ink(image: ToonImage, truth: RenderedShape) -> ToonImage:
    """Draw lines along a picture's silhouette, within the object, and along its true contours, on the nearer side."""
    grid = MaskedGrid(truth.mask)
    width = max(LINE * np.sqrt(grid.size), 1.2)
    inward = distance_transform_edt(np.pad(grid.mask, 1))[1:-1, 1:-1] - 0.5
    covered = width - inward + 0.5
    nearer = np.zeros(grid.mask.shape, np.bool_)
    nearer[grid.mask] = true_contours(truth).outward.any(axis=1)
    if nearer.any():
        covered = np.maximum(covered, width / 2 - distance_transform_edt(~nearer) + 1.0)
    share = np.clip(covered, 0.0, 1.0)[..., None]
    return ToonImage(image.color * (1 - share) + share * np.array(INK), image.mask, alpha=image.alpha)


def _rise(grid: MaskedGrid, values: FloatArray) -> FloatArray:
    """Return where smoothed values (P,) rise, unit vectors of shape (P, 2) in x and y."""
    inside = gaussian_filter(grid.mask.astype(np.float64), SMOOTHING)
    smooth = gaussian_filter(np.where(grid.mask, np.nan_to_num(grid.scatter(values)), 0.0), SMOOTHING)
    down, right = np.gradient(smooth / np.maximum(inside, 1e-6))
    rise = np.stack([right, -down], axis=-1)[grid.mask]
    return rise / np.maximum(np.linalg.norm(rise, axis=1, keepdims=True), 1e-12)


Finder = Callable[[ToonImage, FloatArray], Contours | None]
"""From a picture and its light to contours."""

Drawing = Callable[[ToonImage], ToonImage | PreparedDrawing]
"""From a picture to another drawing of it."""


def started(
    image: ToonImage,
    light: ArrayLike,
    *,
    progress: StepProgress | None = None,
    finder: Finder | None,
    learned: bool,
    drawing: Drawing | None = None,
) -> ToonAnalysis:
    """Analyze a picture, or another drawing of it, as `toonkit` does or as `classical`, from an inflation with contours."""
    direction = as_light("light", light)
    seen = prepare(image if drawing is None else drawing(image))
    initial = inflated_within(seen, None if finder is None else finder(seen, direction))
    steps = Steps(seen, direction, initial, progress)
    normals = correct_shape(seen, direction, initial) if learned else initial
    analysis = steps.finish("started", steps.refine(normals, None, OPTIONS if learned else None))
    return replace(analysis, image=image)  # what is relit is the picture without lines


def variants(painting: Painting) -> dict[str, Method]:
    """Name -> method: classical and ours, without interior contours, with those found and the true ones; then in ink."""

    def told(_image: ToonImage, _light: FloatArray) -> Contours:
        return true_contours(painting.truth)

    def inked(image: ToonImage) -> ToonImage:
        return in_ink(image, painting.truth)

    def overlooked(image: ToonImage) -> PreparedDrawing:
        drawing = prepare(inked(image))
        drawing.ink = replace(drawing.ink, coverage=np.zeros_like(drawing.ink.coverage))
        return drawing

    kinds: dict[str, tuple[Finder | None, Drawing | None]] = {
        "": (None, None),
        ", contours found": (found_contours, None),
        ", contours true": (told, None),
        ", in ink, read as shading": (None, overlooked),
        ", in ink, taken off": (None, inked),
        ", in ink, for contours too": (lines_found, inked),
    }
    return {
        name + suffix: functools.partial(started, finder=finder, learned=learned, drawing=drawing)
        for name, learned in (("classical", False), ("toonkit", True))
        for suffix, (finder, drawing) in kinds.items()
    }


def main(arguments: Sequence[str] | None = None) -> None:
    run(variants, "What interior contours buy.", arguments)


if __name__ == "__main__":
    main()

"""Which inflation of the silhouette is the best start: four ways to round a shape, and a mix, each alone and refined.

    python -m benchmarks.inflations -o notebooks/study/inflations.csv

Runs on the pictures of `benchmarks.ablation`: twenty shapes, six color maps, 256², the light given. Refined
means by the energy of `classical`, from that start, with the color map fitted on it. Nothing here is learned.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.linalg import spsolve

from benchmarks.ablation import run
from toonkit import NormalField, ToonAnalysis, ToonImage, inflate
from toonkit._validation import BoolArray, FloatArray, as_light
from toonkit.estimation.preparation import prepare
from toonkit.estimation.refinement import Refinement
from toonkit.methods import Method
from toonkit.methods.steps import StepProgress, Steps
from toonkit.numerics.report import NOT_REFINED
from toonkit.study.painting import Painting

SCREENS = (1 / 24, 1 / 12, 1 / 6, np.inf)
"""Lengths over which the multi-scale inflation forgets the outline, in square roots of the object's area."""

RIM = 1.5
"""Pixels from the outline within which every inflation takes the rim's own normals, known to a part of a pixel."""


def harmonic(image: ToonImage) -> NormalField:
    """Inflate as ours and the baselines do: x and y of the normals are harmonic functions (Section 3.1)."""
    return inflate(image.mask, alpha=image.alpha)


def poisson(image: ToonImage) -> NormalField:
    """Give the square of the height a constant Laplacian: a disc becomes a half sphere."""
    return _of_squared_height(image, _screened(image.mask, np.inf))


def multi_scale(image: ToonImage) -> NormalField:
    """Average such squares that forget the outline over different lengths: wide parts flatten, thin ones stay round."""
    side = np.sqrt(image.mask.sum())
    return _of_squared_height(
        image, np.mean([_screened(image.mask, share * side) for share in SCREENS], axis=0)
    )


def medial(image: ToonImage) -> NormalField:
    """Unite the balls whose great circles are the largest discs inside the silhouette."""
    outside = np.pad(image.mask, 1)
    radius = distance_transform_edt(outside)[1:-1, 1:-1]
    # Highest of all balls, a dimension at a time: max over q of r(q)² - (p - q)².
    height = np.where(image.mask, radius**2, -np.inf)
    for axis in (0, 1):
        count = height.shape[axis]
        apart = np.subtract.outer(np.arange(count), np.arange(count)) ** 2
        lines = np.moveaxis(height, axis, -1)
        height = np.moveaxis(np.stack([(line - apart).max(axis=-1) for line in lines]), -1, axis)
    return _of_squared_height(image, np.where(image.mask, height, 0.0))


def mixed(image: ToonImage) -> NormalField:
    """Meet half way between the harmonic inflation and Poisson's."""
    total = harmonic(image).compact + poisson(image).vectors[image.mask]
    return _field(image.mask, total)


INFLATIONS: dict[str, Callable[[ToonImage], NormalField]] = {
    "harmonic": harmonic,
    "Poisson": poisson,
    "multi-scale": multi_scale,
    "medial": medial,
    "harmonic and Poisson": mixed,
}


def _screened(mask: BoolArray, length: float) -> FloatArray:
    """Solve Δh - h / length² = -4 on the mask with h = 0 beside it; shape (H, W)."""
    number = np.full(mask.shape, -1)
    number[mask] = np.arange(mask.sum())
    padded = np.pad(number, 1, constant_values=-1)
    rows, columns = np.nonzero(mask)
    own = number[mask]
    matrix = sparse.eye(len(own), format="csr") * (4.0 + 1.0 / length**2)
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        other = padded[rows + 1 + down, columns + 1 + right]
        inside = other >= 0
        neighbors = sparse.coo_array((np.ones(inside.sum()), (own[inside], other[inside])), matrix.shape)
        matrix = matrix - neighbors.tocsr()
    solution = np.zeros(mask.shape)
    solution[mask] = spsolve(matrix.tocsc(), np.full(len(own), 4.0))
    return solution


def _of_squared_height(image: ToonImage, squared: FloatArray) -> NormalField:
    """Return the normals of z = sqrt(squared), where (-∂z/∂x, -∂z/∂y, 1) is as (-∂z²/∂x, -∂z²/∂y, 2 z)."""
    down, right = np.gradient(squared)
    vectors = np.stack([-right, down, 2.0 * np.sqrt(np.maximum(squared, 0.0))], axis=-1)
    near = image.mask & (distance_transform_edt(np.pad(image.mask, 1))[1:-1, 1:-1] <= RIM)
    vectors[near] = harmonic(image).vectors[near]
    return _field(image.mask, vectors[image.mask])


def _field(mask: BoolArray, vectors: FloatArray) -> NormalField:
    field = np.full((*mask.shape, 3), np.nan)
    field[mask] = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return NormalField(field, mask)


def started(
    image: ToonImage,
    light: ArrayLike,
    *,
    progress: StepProgress | None = None,
    inflation: Callable[[ToonImage], NormalField],
    refined: bool,
) -> ToonAnalysis:
    """Analyze a picture as `lumo` does, or as `classical`, from an inflation."""
    steps = Steps(prepare(image), as_light("light", light), inflation(image), progress)
    if not refined:
        return steps.finish("inflated", Refinement(steps.initial_normals, NOT_REFINED))
    return steps.finish("refined", steps.refine(steps.initial_normals, None))


def variants(painting: Painting) -> dict[str, Method]:
    """Name -> method: every inflation as it is, and refined."""
    del painting
    return {
        name + (", refined" if refined else ""): functools.partial(
            started, inflation=inflation, refined=refined
        )
        for refined in (False, True)
        for name, inflation in INFLATIONS.items()
    }


def main(arguments: Sequence[str] | None = None) -> None:
    run(variants, "Which inflation of the silhouette is the best start.", arguments)


if __name__ == "__main__":
    main()

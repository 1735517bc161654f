"""Ground truth that needs no program: discs, ellipses and the surfaces over them, in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit import ColorMap, NormalField, ToonImage, illumination, light_direction

LIGHT = light_direction(130, 50)

TWO_TONE = ColorMap([[0.35, 0.2, 0.45]] * 600 + [[0.95, 0.8, 0.6]] * 400)
SOFT = ColorMap(np.linspace([0.1, 0.05, 0.2], [1.0, 0.95, 0.8], 64))


@dataclass(frozen=True)
class Ellipse:
    """An ellipse and the ellipsoid of equal depth over it, sampled at pixel centers."""

    mask: np.ndarray
    coverage: np.ndarray
    x: np.ndarray
    y: np.ndarray
    normals: NormalField


def ellipse(half_width: float, half_height: float, *, offset: float = 0.3, oversampling: int = 8) -> Ellipse:
    """An ellipse whose center lies off the pixel lattice, with the coverage of each pixel."""
    size = int(2 * max(half_width, half_height)) + 9
    center = (size - 1) / 2 + offset

    def value(row: np.ndarray, column: np.ndarray) -> np.ndarray:
        return ((column - center) / half_width) ** 2 + ((center - row) / half_height) ** 2

    fine = (np.arange(size * oversampling) + 0.5) / oversampling - 0.5
    inside = value(fine[:, None], fine[None, :]) < 1
    coverage = inside.reshape(size, oversampling, size, oversampling).mean(axis=(1, 3))
    row, column = np.mgrid[:size, :size].astype(float)
    x, y = column - center, center - row
    mask = value(row, column) < 1
    depth = min(half_width, half_height)
    forward = np.sqrt(np.maximum(1 - value(row, column), 0)) / depth
    vectors = np.stack([x / half_width**2, y / half_height**2, forward], axis=-1)
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    on_edge = np.where(mask, np.maximum(coverage, 0.5), np.minimum(coverage, 0.499))
    return Ellipse(mask, on_edge, x, y, NormalField(vectors, mask))


def painted(
    normals: NormalField, color_map: ColorMap, *, light: np.ndarray = LIGHT, alpha: np.ndarray | None = None
) -> ToonImage:
    """The picture of a normal field."""
    return ToonImage(color_map(illumination(normals, light)), normals.mask, alpha=alpha)


def scrambled(normals: NormalField, seed: int, amount: float = 0.4) -> np.ndarray:
    """Unit vectors near the given ones, in image form, for derivatives to be taken at."""
    random = np.random.default_rng(seed)
    vectors = np.nan_to_num(normals.vectors) + amount * random.normal(size=normals.vectors.shape)
    vectors[..., 2] = np.abs(vectors[..., 2]) + 0.05
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def blob_mask(seed: int, size: int = 24) -> np.ndarray:
    """An irregular mask with holes, thin parts and several components."""
    random = np.random.default_rng(seed)
    noise = random.normal(size=(size, size))
    for _ in range(3):
        noise = (noise + np.roll(noise, 1, 0) + np.roll(noise, 1, 1) + np.roll(noise, -1, 0)) / 4
    mask = noise > -0.05
    mask[size // 2, :] = True
    return mask

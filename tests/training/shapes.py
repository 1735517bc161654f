"""Shapes to learn from that need no renderer: ellipsoids in closed form, each without a corner of its silhouette."""

from __future__ import annotations

from functools import cache

import numpy as np

from tests.analytic import ellipse
from toonkit import inflate
from toonkit.estimation.working_square import SIZE
from toonkit.training.dataset import Dataset


@cache
def ellipsoids(count: int) -> Dataset:
    """A dataset of `count` shapes without symmetry, each of two parts, an upper and a lower one."""
    truth, initial, masks, parts = [], [], [], []
    for half_height in np.linspace(22, 43, count):
        shape = ellipse((SIZE - 9) / 2, half_height)
        mask = shape.mask & ~((shape.x < -5) & (shape.y > 6))
        truth.append(np.where(mask[..., None], shape.normals.vectors, 0))
        initial.append(np.nan_to_num(inflate(mask).vectors))
        masks.append(mask)
        parts.append(np.where(mask, np.where(shape.y > 0, 0, 1), -1))
    contours = np.zeros_like(masks)
    contours[:, 30:60, SIZE // 2] = True  # as if something ended there
    return Dataset(
        np.array(truth, np.float16),
        np.array(initial, np.float16),
        np.array(masks),
        contours & masks,
        np.array(parts, np.int8),
    )

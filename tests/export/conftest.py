"""Analyses for the tests of what is written about them: balls in one material and in several."""

import numpy as np
import pytest

from toonkit import ColorMap, Materials, NormalField, ToonAnalysis, ToonImage, analyze, light_direction, shade
from toonkit.numerics.report import SolverReport

SIZE = 48
RADIUS = 20.0


@pytest.fixture(scope="session")
def analysis():
    """A two-tone ball with a soft outline."""
    row, column = np.indices((SIZE, SIZE))
    x, y = (column - 23.5) / RADIUS, (23.5 - row) / RADIUS
    alpha = np.clip(RADIUS * (1 - np.hypot(x, y)) + 0.5, 0, 1)
    mask = alpha >= 0.5
    vectors = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, None))], axis=-1)
    length = np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    normals = NormalField(vectors / length, mask)
    flatter = vectors / length + [0, 0, 0.5]
    initial = NormalField(flatter / np.linalg.norm(flatter, axis=-1, keepdims=True), mask)
    color_map = ColorMap(np.repeat([[0.3, 0.1, 0.35], [1.0, 0.8, 0.5]], 8, axis=0), (-0.7, 0.9))
    light = light_direction(135, 40)
    painted = shade(normals, light, color_map).color
    return ToonAnalysis(
        image=ToonImage(
            painted, mask, alpha=alpha, fringe=np.where(mask[..., None], np.nan, [0.25, 0.2, 0.3])
        ),
        method="toonkit",
        light=light,
        normals=normals,
        initial_normals=initial,
        materials=Materials.single(mask, color_map),
        report=SolverReport(12, np.array([3.5, 1.25, 1.2]), "nothing was left to gain", converged=True),
    )


@pytest.fixture(scope="session")
def several():
    """A ball in two shaded halves, with a spot in one tone and a soft outline in ink, under an estimated light."""
    row, column = np.indices((80, 80))
    x, y = (column - 39.5) / 36, (39.5 - row) / 36
    alpha = np.clip(36 * (1 - np.hypot(x, y)) + 0.5, 0, 1)
    light = light_direction(135, 40)
    lit = x * light[0] + y * light[1] + np.sqrt(np.clip(1 - x**2 - y**2, 0, None)) * light[2] > 0.3
    orange = np.where(lit[..., None], [1.0, 0.7, 0.3], [0.7, 0.3, 0.2])
    blue = np.where(lit[..., None], [0.4, 0.7, 1.0], [0.2, 0.3, 0.7])
    labels = np.where(x + y < 0.2, 0, 1)
    labels[np.hypot(x + 0.3, y + 0.2) < 0.2] = 2
    color = np.select([(labels == 0)[..., None], (labels == 1)[..., None]], [orange, blue], [0.3, 0.8, 0.4])
    color[np.hypot(x, y) > 0.9] = [0.05, 0.02, 0.1]
    return analyze(ToonImage(color, alpha >= 0.5, alpha=alpha), materials=labels)

"""A painted ball whose true normals are known, as an analysis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from tests.pixel_art import sprite
from toonkit import (
    ColorMap,
    Materials,
    NormalField,
    ToonAnalysis,
    ToonImage,
    analyze,
    illumination,
    light_direction,
)
from toonkit.numerics.report import SolverReport


def painted_ball(size=120, seed=1):
    """Four tones with brushwork on them, and an antialiased outline of a color of its own."""
    y, x = (size - 1) / 2 - np.mgrid[:size, :size][0], np.mgrid[:size, :size][1] - (size - 1) / 2
    radius = size * 0.45
    distance = np.hypot(x, y)
    z = np.sqrt(np.maximum(0, 1 - (distance / radius) ** 2))
    alpha = np.clip(radius + 0.5 - distance, 0, 1)
    mask = alpha >= 0.5
    vectors = np.stack([x / radius, y / radius, z], axis=-1)
    normals = NormalField(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True), mask)
    light = light_direction(130, 45)
    ramp = ColorMap([[0.2, 0.1, 0.3], [0.5, 0.2, 0.4], [0.8, 0.4, 0.4], [1.0, 0.8, 0.5]], (-0.6, 0.9))
    brushwork = np.random.default_rng(seed).normal(0, 0.06, (size, size, 1))
    painted = np.clip(ramp(illumination(normals, light)) + brushwork, 0, 1)
    eight_bits = np.round(painted * 255) / 255
    fringe = np.full_like(eight_bits, 0.4)
    image = ToonImage(eight_bits, mask, alpha=alpha, fringe=fringe)
    report = SolverReport(1, np.array([1.0, 0.5]), "exact", True)
    return ToonAnalysis(
        image=image,
        method="toonkit",
        light=light,
        normals=normals,
        initial_normals=normals,
        materials=Materials.single(mask, ramp),
        report=report,
    )


@pytest.fixture(scope="session")
def ball():
    return painted_ball()


@pytest.fixture(scope="session")
def inked_ball():
    """The painted ball with a black outline and a line across."""
    ball = painted_ball()
    image = ball.image
    inward = distance_transform_edt(np.pad(image.mask, 1))[1:-1, 1:-1]
    middle = np.abs(np.arange(len(image.mask)) - len(image.mask) / 2)[:, None]
    share = np.clip(np.maximum(4.0 - inward, 2.5 - middle), 0, 1)[..., None]
    color = np.round(255 * image.color * (1 - share)) / 255
    return replace(ball, image=ToonImage(color, image.mask, alpha=image.alpha, fringe=image.fringe))


def harlequin_ball(size=120, fine=4):
    """A ball half red with a highlight, half blue with a flat badge, a black line across and an outline, antialiased."""
    y, x = (fine * size - 1) / 2 - np.mgrid[: fine * size, : fine * size]
    x = -x
    radius = 0.45 * fine * size
    distance = np.hypot(x, y)
    mask = distance < radius
    height = np.sqrt(np.maximum(radius**2 - distance**2, 0))
    value = np.stack([x, y, height], axis=-1) @ light_direction(130, 45) / radius
    tones = np.array([[[0.4, 0.1, 0.15], [0.9, 0.3, 0.25]], [[0.1, 0.15, 0.4], [0.3, 0.5, 0.9]]])
    color = tones[(x > 0.3 * y).astype(int), (value > 0.3).astype(int)]
    badge = np.hypot(x - 0.2 * radius, y + 0.45 * radius) < 0.25 * radius
    color[badge] = (0.95, 0.85, 0.3)
    color[np.hypot(x + 0.4 * radius, y - 0.55 * radius) < 0.1 * radius] = 1.0
    color[(np.abs(y - 0.3 * radius) < 1.1 * fine) | (distance > radius - 2.5 * fine)] = 0.0
    blocks = (size, fine, size, fine)
    alpha = mask.reshape(blocks).mean(axis=(1, 3))
    color = (color * mask[..., None]).reshape(*blocks, 3).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)[
        ..., None
    ]
    color = np.round(255 * color) / 255
    image = ToonImage(color, alpha >= 0.5, alpha=alpha, fringe=color)
    return analyze(image, light_direction(130, 45), method="lumo")


@pytest.fixture(scope="session")
def harlequin():
    return harlequin_ball()


@pytest.fixture(scope="session")
def pixel_sprite():
    """Pixel art, with a highlight, a flat detail and translucent pixels beside it."""
    image = sprite(48)
    above = np.roll(image.color, -1, axis=0)
    beside = ~image.mask & ~np.isnan(above[..., 0])
    alpha = np.where(image.mask, 1.0, np.where(beside, 128 / 255, 0.0))
    fringe = np.where(beside[..., None], above, 0.0)
    return analyze(ToonImage(image.color, image.mask, alpha=alpha, fringe=fringe), light_direction(130, 45))

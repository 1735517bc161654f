"""Small drawings whose ink and materials are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SIZE = 96
OVER = 3
"""Drawn three times as large and reduced: edges are mixed as drawing programs mix them."""

LIGHT = np.array([-0.5, 0.5, np.sqrt(0.5)])

RED = ((0.45, 0.10, 0.12), (0.80, 0.22, 0.20))
GREEN = ((0.16, 0.36, 0.18), (0.30, 0.62, 0.32))
SKIN = ((0.80, 0.55, 0.45), (0.97, 0.81, 0.69))
BLUE = ((0.20, 0.26, 0.50), (0.36, 0.47, 0.82))
BLACK = (0.04, 0.03, 0.05)


@dataclass(frozen=True)
class Ball:
    """A ball painted with tones that step at `at`: row, column and radius in pixels."""

    row: float
    column: float
    radius: float
    tones: tuple[tuple[float, float, float], ...]
    at: tuple[float, ...] = (0.3,)


class Canvas:
    """A picture in the making, OVER times as large."""

    def __init__(self, size: int = SIZE) -> None:
        large = size * OVER
        self.rows, self.columns = (np.indices((large, large)) + 0.5) / OVER - 0.5
        self.color = np.zeros((large, large, 3))
        self.label = np.full((large, large), -1)
        self.ink = np.zeros((large, large), bool)
        self.normals = np.zeros((large, large, 3))

    def disc(self, row: float, column: float, radius: float) -> NDArray[np.bool_]:
        return np.hypot(self.rows - row, self.columns - column) < radius

    def fill(self, where: NDArray[np.bool_], color: object, label: int) -> None:
        self.color[where] = color
        self.label[where] = label

    def ball(self, ball: Ball, label: int) -> NDArray[np.bool_]:
        where = self.disc(ball.row, ball.column, ball.radius)
        x = (self.columns[where] - ball.column) / ball.radius
        y = (ball.row - self.rows[where]) / ball.radius
        self.normals[where] = np.column_stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))])
        lit = self.normals[where] @ LIGHT
        self.fill(where, np.array(ball.tones)[np.digitize(lit, ball.at[: len(ball.tones) - 1])], label)
        return where

    def line(self, where: NDArray[np.bool_], color: object = BLACK) -> None:
        where = where & (self.label >= 0)
        self.color[where] = color
        self.ink |= where

    def outline(self, ball: Ball, width: float, color: object = BLACK) -> None:
        ring = self.disc(ball.row, ball.column, ball.radius) & ~self.disc(
            ball.row, ball.column, ball.radius - width
        )
        self.line(ring, color)

    def drawn(self) -> Drawn:
        on = self.label >= 0
        share = _reduced(on.astype(float))
        mask = share >= 0.5
        color = _reduced(self.color * on[..., None]) / np.maximum(share, 1e-9)[..., None]
        counts = np.stack([_reduced((self.label == k).astype(float)) for k in range(self.label.max() + 1)])
        label = np.where(mask, counts.argmax(axis=0), -1)
        ink = np.where(mask, _reduced((self.ink & on).astype(float)) / np.maximum(share, 1e-9), 0.0)
        normals = _reduced(self.normals)
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-9)
        return Drawn(np.round(np.clip(color, 0, 1) * 255) / 255, mask, label, ink, normals)


@dataclass(frozen=True)
class Drawn:
    """A drawing and its truth."""

    color: NDArray[np.float64]
    mask: NDArray[np.bool_]
    label: NDArray[np.intp]
    ink: NDArray[np.float64]
    normals: NDArray[np.float64]


def _reduced(values: NDArray[np.float64]) -> NDArray[np.float64]:
    size = len(values) // OVER
    return values.reshape(size, OVER, size, OVER, *values.shape[2:]).mean(axis=(1, 3))


def agreement(first: NDArray[np.intp], second: NDArray[np.intp]) -> float:
    """Adjusted Rand index of two labelings (n,) of the same pixels."""
    table = np.zeros((first.max() + 1, second.max() + 1))
    np.add.at(table, (first, second), 1.0)

    def pairs(counts: NDArray[np.float64]) -> float:
        return float((counts * (counts - 1) / 2).sum())

    rows, columns = pairs(table.sum(axis=1)), pairs(table.sum(axis=0))
    expected, most = rows * columns / pairs(np.array([table.sum()])), (rows + columns) / 2
    return 1.0 if most == expected else (pairs(table) - expected) / (most - expected)


def same_partition(first: NDArray[np.intp], second: NDArray[np.intp]) -> bool:
    """Tell whether two labelings (n,) divide the pixels alike, whatever the numbers."""
    both = len(np.unique(np.stack([first, second]), axis=1).T)
    return both == len(np.unique(first)) == len(np.unique(second))

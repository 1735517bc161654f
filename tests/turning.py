"""An object that turns before the viewer, painted frame by frame under one light; all is known of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

LIGHT = (130.0, 45.0)

AXES = np.array([1.0, 1.15, 0.7])
"""Half axes of the ellipsoid, in half widths of a frame times `FILL`."""

FILL = 0.8
TONES = {
    "skin": ((208, 150, 120), (250, 206, 172)),
    "shirt": ((40, 84, 130), (84, 150, 206)),
    "hair": ((104, 30, 44), (176, 62, 70)),
}
INK = (24, 18, 28)
AT = 0.35
"""Illumination at which the tone of each material changes."""

OUTLINE = 2.0
"""Width of the outline in pixels."""

OVER = 3
"""Samples of a pixel along each side."""


@dataclass(frozen=True)
class Turned:
    """
    One frame.

    Attributes
    ----------
    picture : ndarray of uint8, shape (n, n, 4)
        RGBA.
    points : ndarray, shape (n, n, 3)
        Where on the object each pixel is, in its own frame; NaN outside.
    normals : ndarray, shape (n, n, 3)
        Normals as the viewer sees them.
    turn : ndarray, shape (3, 3)
        From the object's frame to the viewer's.
    """

    picture: NDArray[np.uint8]
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    turn: NDArray[np.float64]


def direction(azimuth: float, elevation: float) -> NDArray[np.float64]:
    a, e = np.deg2rad([azimuth, elevation])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def turned(angle: float, size: int = 96, light: tuple[float, float] = LIGHT) -> Turned:
    """Paint the object, turned by an angle in degrees around the vertical."""
    a = np.deg2rad(angle)
    turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    fine = size * OVER
    row, column = (np.indices((fine, fine)) + 0.5) / fine * 2 - 1
    x, y = column / FILL, -row / FILL
    # |D turn^T (x, y, z)|² = 1 is a quadratic equation for z.
    shape = turn @ np.diag(AXES**-2.0) @ turn.T
    half_b = shape[0, 2] * x + shape[1, 2] * y
    c = shape[0, 0] * x**2 + 2 * shape[0, 1] * x * y + shape[1, 1] * y**2 - 1
    root = half_b**2 - shape[2, 2] * c
    on = root > 0
    z = (-half_b + np.sqrt(np.maximum(root, 0))) / shape[2, 2]
    seen = np.stack([x, y, z], axis=-1)
    normals = seen @ shape
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    points = seen @ turn
    tone = (normals @ direction(*light) > AT).astype(int)
    around = np.arctan2(points[..., 0], points[..., 2])
    part = np.where(points[..., 1] > 0.45 + 0.2 * np.sin(3 * around), "hair", "skin")
    part = np.where(points[..., 1] < -0.25, "shirt", part)
    color = np.zeros((fine, fine, 3))
    for name, tones in TONES.items():
        color = np.where((part == name)[..., None], np.array(tones)[tone], color)
    depth = ndimage.distance_transform_edt(on)
    color[on & (depth < OUTLINE * OVER)] = INK
    share = _reduced(on.astype(float))
    mixed = _reduced(color * on[..., None]) / np.maximum(share, 1e-9)[..., None]
    picture = np.round(np.dstack([mixed, 255 * share])).astype(np.uint8)
    middle = OVER // 2
    mask = share >= 0.5
    return Turned(
        picture,
        np.where(mask[..., None], points[middle::OVER, middle::OVER], np.nan),
        np.where(mask[..., None], normals[middle::OVER, middle::OVER], np.nan),
        turn,
    )


def _reduced(values: NDArray[np.float64]) -> NDArray[np.float64]:
    size = len(values) // OVER
    return values.reshape(size, OVER, size, OVER, *values.shape[2:]).mean(axis=(1, 3))


def turning(count: int = 12, size: int = 96, *, step: float | None = None) -> list[Turned]:
    """Paint the object from all sides, or with some degrees between frames."""
    return [turned(number * (360 / count if step is None else step), size) for number in range(count)]

"""Pixel art whose palette is known: hard edges, a ramp for each material, an outline."""

from __future__ import annotations

import numpy as np

from toonkit import ToonImage, light_direction

LIGHT = (130.0, 45.0)

RAMPS = {
    "red": ((96, 24, 40), (168, 48, 56), (232, 96, 80)),
    "blue": ((24, 40, 96), (48, 88, 168)),
}
OUTLINE, GLINT, BUTTON = (16, 12, 24), (255, 255, 255), (248, 208, 72)
PALETTE = [*RAMPS["red"], *RAMPS["blue"], OUTLINE, GLINT, BUTTON]


def sprite(size: int = 48) -> ToonImage:
    """A ball, half red with a highlight and half blue with a button, in an outline one pixel wide."""
    y, x = (size - 1) / 2 - np.mgrid[:size, :size]
    x = -x
    radius = 0.47 * size
    distance = np.hypot(x, y)
    value = np.stack([x, y, np.sqrt(np.maximum(radius**2 - distance**2, 0))], axis=-1) / radius
    value = value @ light_direction(*LIGHT)
    color = np.zeros((size, size, 3), np.uint8)
    for name, side in (("red", x < 0.2 * radius), ("blue", x >= 0.2 * radius)):
        ramp = np.array(RAMPS[name])
        steps = np.linspace(0.0, 1.0, len(ramp) + 1)[1:-1]
        color[side] = ramp[np.digitize(value, steps)][side]
    color[np.hypot(x + 0.4 * radius, y - 0.5 * radius) < 0.1 * radius] = GLINT
    color[np.hypot(x - 0.5 * radius, y + 0.3 * radius) < 0.09 * radius] = BUTTON
    color[(distance > radius - 1.2) | (np.abs(x - 0.2 * radius) < 0.5)] = OUTLINE
    return ToonImage(color / 255, distance < radius)

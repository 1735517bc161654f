"""The list of recipes: what can be drawn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toonkit._validation import FloatArray
from toonkit.synthetic.model import Model, Part, Pattern, near
from toonkit.synthetic.primitives import ball, both_sides, ellipsoid, rotation

Recipe = Callable[[np.random.Generator], Model]

RECIPES: dict[str, Recipe] = {}
"""Functions that make a model of random proportions, by name."""


def recipe(build: Recipe) -> Recipe:
    """Register a recipe under the name of its function."""
    RECIPES[build.__name__] = build
    return build


def turned_view(
    rng: np.random.Generator, yaw: float = 35.0, pitch: tuple[float, float] = (0.0, 16.0)
) -> FloatArray:
    """Return a random view: turned sideways by up to `yaw` degrees, from above by `pitch`, and tilted a little."""
    side, above, tilt = rng.uniform(-yaw, yaw), rng.uniform(*pitch), rng.normal(scale=2.0)
    return np.asarray(rotation(z=tilt) @ rotation(x=above) @ rotation(y=side))


def eyes(
    rng: np.random.Generator, at: tuple[float, float, float], size: float, *, plain: float = 0.5
) -> tuple[Part, ...]:
    """Return a pair of eyes in "dark", which with a probability of 1 - `plain` is on "white" balls."""
    x, y, z = at
    if rng.random() < plain:
        whole = both_sides(ellipsoid(at, (size * 0.75, size, size * 0.6)))
        lit = [
            (x + 0.25 * size, y + 0.4 * size, z + 0.5 * size),
            (-x + 0.25 * size, y + 0.4 * size, z + 0.5 * size),
        ]
        return (Part(whole, "dark", (Pattern("white", near(lit, 0.32 * size)),)),)
    look = rng.uniform(-0.3, 0.3) * size
    pupils = [(x + look, y, z + size), (-x + look, y, z + size)]
    return (Part(both_sides(ball(at, size)), "white", (Pattern("dark", near(pupils, 0.62 * size)),)),)

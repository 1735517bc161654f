"""DrawnScene: a generated drawing in several materials and ink, with its ground truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray, as_light, refuse
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.model.normals import NormalField
from toonkit.synthetic.inking import Ink, random_ink
from toonkit.synthetic.painting import Painter, random_painter
from toonkit.synthetic.recipes import RECIPES
from toonkit.synthetic.surface_samples import Samples, sample_model

ELEVATIONS = (20.0, 75.0)
"""Least and greatest elevation of the light, in degrees."""

FROM_ABOVE = 0.75
"""Share of the drawings whose light comes from above. In the others it comes from any side."""

MIN_SIZE = 16
"""Smallest size of a picture, in pixels. In smaller ones parts vanish."""


@dataclass(frozen=True, eq=False)
class DrawnScene:
    """
    A drawing and its truth: c = ink over M_m(L · N).

    Attributes
    ----------
    recipe : str
        What is drawn: a name in `synthetic.recipes.RECIPES`.
    image : ToonImage
        The drawing, in steps of an 8-bit picture.
    paint : ToonImage
        The same without its ink.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    normals : NormalField
        Normals of the visible surface. In a pixel that shows several materials, those of its own one.
    labels : ndarray of int, shape (H, W)
        Material of most of each pixel, also beneath ink and highlights; -1 outside the mask.
    materials : tuple of str
        Names of the materials, by label.
    color_maps : tuple of ColorMap
        M of each material. That of a flat material has one sample.
    ink : ndarray, shape (H, W)
        Share of each pixel's object that ink covers.
    ink_color : ndarray, shape (H, W, 3)
        sRGB of the ink, NaN where there is none.
    highlight, cast_shadow : ndarray, shape (H, W)
        Share of each pixel's object under a highlight, and in a cast shadow.

    Notes
    -----
    A flat material, painted in one tone, keeps its color under every light, as an artist would paint it. A highlight
    moves to where the normal lies halfway between the light and the viewer. A cast shadow falls where the new light
    casts it. Ink stays.
    """

    recipe: str
    image: ToonImage
    paint: ToonImage
    light: FloatArray
    normals: NormalField
    labels: NDArray[np.int64]
    materials: tuple[str, ...]
    color_maps: tuple[ColorMap, ...]
    ink: FloatArray
    ink_color: FloatArray
    highlight: FloatArray
    cast_shadow: FloatArray
    _painter: Painter

    @property
    def flat(self) -> NDArray[np.bool_]:
        """Which materials are painted in one tone, bool of shape (m,)."""
        return np.array([len(color_map.colors) == 1 for color_map in self.color_maps])

    def relit(self, light: ArrayLike) -> ToonImage:
        """
        Draw the same under another light.

        Parameters
        ----------
        light : array_like, shape (3,)
            Direction from the surface to the light.

        Returns
        -------
        ToonImage
            The relit drawing, with the same mask, alpha and ink. Under the light of the drawing it is the drawing
            itself.

        Raises
        ------
        ToonkitError
            If the light is zero, not finite or from behind.
        """
        painted = self._painter.paint(as_light("light", light))
        color = self._painter.samples.mean(painted.color)
        return ToonImage(_inked(color, self.ink, self.ink_color), self.image.mask, alpha=self.image.alpha)


def draw_scene(seed: int | np.random.Generator, *, size: int = 256, recipe: str | None = None) -> DrawnScene:
    """
    Draw a random scene.

    Parameters
    ----------
    seed : int or Generator
        Source of all random choices. The same seed, size and recipe give the same drawing.
    size : int, optional
        Width and height in pixels.
    recipe : str, optional
        What to draw, a name in `synthetic.recipes.RECIPES`; any by default.

    Returns
    -------
    DrawnScene
        The drawing and its truth.

    Raises
    ------
    ToonkitError
        If the size is too small or there is no such recipe.
    """
    if size < MIN_SIZE:
        raise refuse("size", f"must be at least {MIN_SIZE} pixels", size)
    if recipe is not None and recipe not in RECIPES:
        raise refuse("recipe", f"must be one of {', '.join(RECIPES)}", repr(recipe))
    rng = np.random.default_rng(seed)
    chosen = str(rng.choice(list(RECIPES)))
    name = chosen if recipe is None else recipe
    model = RECIPES[name](rng)
    light = _random_light(rng)
    samples = sample_model(model, size)
    painter = random_painter(samples, model, rng)
    bases = np.array([color_map(0.6) for color_map in painter.color_maps])
    ink = random_ink(samples, bases, rng)
    return compose_scene(name, painter, ink, light)


def compose_scene(name: str, painter: Painter, ink: Ink, light: FloatArray) -> DrawnScene:
    """Put together the scene of a painter and ink, under a light, a unit vector; its recipe gets this name."""
    samples, painted = painter.samples, painter.paint(light)
    alpha = samples.coverage()
    mask = alpha >= 0.5
    coverage, ink_color = samples.share(ink.covered), samples.mean(ink.color, ink.covered.astype(np.float64))
    color = samples.mean(painted.color)
    every = samples.labels()
    nothing = np.zeros_like(coverage)
    bare = ToonImage(_inked(color, nothing, ink_color), mask, alpha=alpha)
    return DrawnScene(
        recipe=name,
        image=ToonImage(_inked(color, coverage, ink_color), mask, alpha=alpha),
        paint=bare,
        light=light,
        normals=NormalField(_mean_normals(samples, every), mask),
        labels=np.where(mask, every, -1),
        materials=samples.names,
        color_maps=painter.color_maps,
        ink=coverage,
        ink_color=ink_color,
        highlight=samples.share(painted.highlight),
        cast_shadow=samples.share(painted.shadow),
        _painter=painter,
    )


def _inked(color: FloatArray, coverage: FloatArray, ink_color: FloatArray) -> FloatArray:
    """Put ink over paint, in steps of an 8-bit picture."""
    share = coverage[..., None]
    covered = np.where(share > 0, share * np.nan_to_num(ink_color) + (1 - share) * color, color)
    return np.asarray(np.rint(np.clip(covered, 0.0, 1.0) * 255) / 255)


def _mean_normals(samples: Samples, labels: NDArray[np.int64]) -> FloatArray:
    """Return unit normals (H, W, 3) of the samples that are of each pixel's material."""
    own = samples.material == labels.ravel()[samples.pixel]
    mean = samples.mean(samples.normals, own.astype(np.float64))
    return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=-1, keepdims=True), 1e-12))


def _random_light(rng: np.random.Generator) -> FloatArray:
    azimuth = rng.uniform(20.0, 160.0) if rng.random() < FROM_ABOVE else rng.uniform(0.0, 360.0)
    return light_direction(azimuth, rng.uniform(*ELEVATIONS))

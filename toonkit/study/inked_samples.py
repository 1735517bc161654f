"""Sample drawings in several materials and ink, with chosen colors, models and lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from PIL import ImageColor

from toonkit._validation import FloatArray
from toonkit.model.color_map import ColorMap
from toonkit.model.oklab import srgb_to_oklab
from toonkit.synthetic.drawing import DrawnScene, compose_scene
from toonkit.synthetic.inking import Hand, draw_ink
from toonkit.synthetic.model import Model, Part
from toonkit.synthetic.painting import Highlights, Painter
from toonkit.synthetic.palette import tone_ramp
from toonkit.synthetic.primitives import rotation
from toonkit.synthetic.surface_samples import sample_model

EDGES = {1: (), 2: (0.32,), 3: (0.12, 0.72)}
"""Illuminations at which the steps of a material lie, by its number of tones."""

SOFTNESS = 0.02
"""Width of a hard step in illumination: about as wide as an anti-aliased edge."""

SHINE = 13.0
"""Degrees around the direction halfway between light and viewer within which a highlight lies."""

HAND = Hand(outline=2.0, inner=1.5)
"""How the lines are drawn."""


@dataclass(frozen=True)
class Tones:
    """
    How a material of an inked sample is painted.

    Attributes
    ----------
    colors : tuple of str
        Hexadecimal sRGB, darkest first. A material in one color is flat.
    softness : float
        Width of the steps between them, in illumination. From about 1 on they form one gradient.
    glossy : bool
        Whether the material has highlights.
    """

    colors: tuple[str, ...]
    softness: float = SOFTNESS
    glossy: bool = False

    def color_map(self) -> ColorMap:
        """Return the color map M."""
        colors = srgb_to_oklab(np.array([_srgb(color) for color in self.colors]))
        return tone_ramp(colors, EDGES[len(self.colors)], self.softness)


@dataclass(frozen=True)
class SampleScene:
    """
    What an inked sample shows.

    Attributes
    ----------
    parts : callable
        Returns the parts of the model.
    tones : dict of str to Tones
        How each material is painted.
    ink : str
        Hexadecimal sRGB of the lines.
    yaw, pitch, roll : float
        Degrees by which the model is turned: sideways, seen from above, and in the picture.
    """

    parts: Callable[[], tuple[Part, ...]]
    tones: dict[str, Tones]
    ink: str
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0

    def model(self) -> Model:
        """Return the model, in the names of the materials."""
        view = rotation(z=self.roll) @ rotation(x=self.pitch) @ rotation(y=self.yaw)
        return Model(self.parts(), dict.fromkeys(self.tones, "any"), view)


def draw_sample_scene(scene: SampleScene, light: FloatArray, *, size: int) -> DrawnScene:
    """
    Draw a scene.

    Parameters
    ----------
    scene : SampleScene
        What to draw.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    size : int
        Width and height in pixels.

    Returns
    -------
    DrawnScene
        The drawing and its truth.
    """
    model = scene.model()
    samples = sample_model(model, size)
    tones = [scene.tones[name] for name in samples.names]
    glossy = np.array([one.glossy for one in tones])
    shine = Highlights(glossy, float(np.cos(np.deg2rad(SHINE))), np.ones(3), opacity=0.9)
    painter = Painter(samples, model, tuple(one.color_map() for one in tones), shine, shadow_tint=None)
    color = np.tile(_srgb(scene.ink), (len(samples.pixel), 1))
    ink = draw_ink(samples, HAND, color, np.random.default_rng(0))
    return compose_scene("sample", painter, ink, light)


def _srgb(color: str) -> FloatArray:
    return np.array(ImageColor.getrgb(color)) / 255.0

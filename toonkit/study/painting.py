"""StudySettings and Painting: a shape painted with a color map, which is the input of a trial (Section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from toonkit._validation import FloatArray, is_number, refuse
from toonkit.metrics import PictureError, picture_error
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.light import direction_of, light_direction
from toonkit.model.shading import shade
from toonkit.study.rendering import MIN_SIZE, RenderedShape

Angles = tuple[float, float]
"""Azimuth and elevation of a light, in degrees."""

NEW_LIGHTS: tuple[Angles, ...] = tuple(
    (azimuth, elevation) for azimuth in (0, 90, 180, 270) for elevation in (25, 60)
)
"""Azimuth and elevation, in degrees, of the lights for relighting."""


@dataclass(frozen=True)
class StudySettings:
    """
    Settings that all trials of a study share.

    Attributes
    ----------
    size : int
        Width and height of the pictures in pixels; the paper's 512.
    light : (float, float)
        Azimuth and elevation, in degrees, of the light L_t under which the shapes are painted.
    new_lights : tuple of (float, float)
        Azimuth and elevation, in degrees, of the lights for relighting.
    """

    size: int = 512
    light: Angles = (129.0, 50.0)
    new_lights: tuple[Angles, ...] = NEW_LIGHTS

    def __post_init__(self) -> None:
        if not isinstance(self.size, int) or isinstance(self.size, bool) or self.size < MIN_SIZE:
            raise refuse("size", f"must be a whole number of pixels, at least {MIN_SIZE}", self.size)
        if not self.new_lights:
            raise refuse("new_lights", "must hold at least one light", "none")
        object.__setattr__(self, "light", _checked_angles("light", self.light))
        lights = tuple(_checked_angles("new_lights", angles) for angles in self.new_lights)
        object.__setattr__(self, "new_lights", lights)


def _checked_angles(argument: str, angles: Angles) -> Angles:
    if len(angles) != 2 or not all(is_number(angle) for angle in angles):
        raise refuse(argument, "must be azimuth and elevation in degrees", angles)
    azimuth, elevation = (float(angle) for angle in angles)
    direction_of(argument, (azimuth, elevation))
    return azimuth, elevation


@dataclass(frozen=True, eq=False)
class Painting:
    """
    A shape painted with a color map: the input of a trial, with the truth.

    Attributes
    ----------
    truth : RenderedShape
        The shape, with its true normals N_t.
    color_map : ColorMap
        M_t.
    settings : StudySettings
        The lights.
    image : ToonImage
        c_t = M_t(L_t · N_t), with the shape's coverage as alpha.
    relit : tuple of ToonImage
        Ground-truth pictures under each of the new lights.
    """

    truth: RenderedShape
    color_map: ColorMap
    settings: StudySettings
    image: ToonImage
    relit: tuple[ToonImage, ...]

    @property
    def light(self) -> FloatArray:
        """L_t, shape (3,)."""
        return light_direction(*self.settings.light)

    @cached_property
    def changes(self) -> tuple[PictureError, ...]:
        """Change of the ground-truth picture under each of the new lights."""
        return tuple(picture_error(relit, self.image) for relit in self.relit)


def paint(truth: RenderedShape, color_map: ColorMap, settings: StudySettings) -> Painting:
    """Paint a shape under the study's light, and under its new lights for comparison."""
    painted = shade(truth.normals, light_direction(*settings.light), color_map)
    image = ToonImage(painted.color, painted.mask, alpha=truth.coverage)
    lights = (light_direction(*angles) for angles in settings.new_lights)
    relit = tuple(shade(truth.normals, light, color_map) for light in lights)
    return Painting(truth, color_map, settings, image, relit)

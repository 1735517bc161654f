"""The path of the new light as a setting: key lights, how long it takes, and whether it returns. Independent of Panel."""

from __future__ import annotations

from typing import Any

import param

from toonkit._validation import is_number
from toonkit.export.animation import FRAME_MILLISECONDS

MOST_KEY_LIGHTS = 12
"""Largest number of key lights of a path: as many as fit in a row."""

PATH_SECONDS = (0.5, 10.0)
"""Least and greatest duration of a path, in seconds."""


class KeyLights(param.List):
    """A list of at most `MOST_KEY_LIGHTS` lights, azimuth and elevation in degrees each."""

    def __init__(self, default: list[list[float]] | None = None, **params: Any) -> None:
        super().__init__(default=[] if default is None else default, bounds=(0, MOST_KEY_LIGHTS), **params)

    def _validate(self, val: object) -> None:
        super()._validate(val)
        for light in val if isinstance(val, list) else []:
            is_pair = isinstance(light, list | tuple) and len(light) == 2 and all(map(is_number, light))
            if not (is_pair and -90 <= light[1] <= 90):
                raise ValueError(f"a key light must be azimuth and elevation in degrees, not {light!r}")


class LightPathSettings(param.Parameterized):
    """A path along which the new light travels."""

    key_lights = KeyLights(doc="Azimuth and elevation of each light on the path, degrees.")
    path_seconds = param.Number(3.0, bounds=PATH_SECONDS, doc="Duration of the path in seconds.")
    path_loops = param.Boolean(True, doc="Whether the light returns to the first one and starts again.")

    @property
    def travels(self) -> bool:
        """Whether there are two or more lights to travel between."""
        return len(self.key_lights) > 1

    @property
    def path_frames(self) -> int:
        """Frames of an animation of the path."""
        frames: int = round(1000 * self.path_seconds / FRAME_MILLISECONDS)
        return frames

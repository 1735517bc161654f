"""How a drawing is analyzed and relit: what a visitor of the relight page sets beside its materials. Knows no panel."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import param

import toonkit
from toonkit import ToonAnalysis, ToonImage
from toonkit.model.light import OPENING_LIGHT
from toonkit.model.luminance import color_of_hex
from toonkit.relighting import RelightOptions
from toonkit.viz.relight_page.corrections import Look
from toonkit.viz.relight_page.key_lights import LightPathSettings

METHOD_DESCRIPTIONS = {
    "toonkit": ("toonkit", "Recommended: knows shapes, keeps the colors"),
    "classical": ("classical", "The same without what it has learned"),
    "todo": ("Todo et al.", "The published method, step by step"),
    "lumo": ("Lumo", "Puffs up the outline, ignores the shading"),
    "lambert": ("Lambert", "Reads the tones as plain, even shading"),
}
"""Name for people and one line of advice for each method."""

DEFAULT_METHOD = "toonkit"

PATH_SETTINGS = ("key_lights", "path_seconds", "path_loops")
"""Names of the settings of the new light's path."""

ANIMATION_SUFFIXES = (".gif", ".webp", ".apng")
"""Formats of animations to choose from."""

SETTINGS = (
    "new_light", "original_light", "method", "keep_detail", "flat_shading", "light_color", "ambient", *PATH_SETTINGS
)  # fmt: skip
"""What is undone and done again beside corrections of the materials."""


class RelightSettings(LightPathSettings):
    """A method, two lights, what else `toonkit.relight` is told, and a path for the new light."""

    method = param.String(DEFAULT_METHOD, doc="Name of the estimator in METHODS.")
    original_light = param.List(
        [135.0, 45.0], bounds=(2, 2), doc="Azimuth and elevation of the artist's light, degrees."
    )
    new_light = param.List(
        list(OPENING_LIGHT), bounds=(2, 2), doc="Azimuth and elevation of the new light, degrees."
    )
    keep_detail = param.Boolean(True, doc="Keep what the artist painted on top of the color map.")
    flat_shading = param.Number(1.0, bounds=(0, 1), doc="How much materials in one tone answer to the light.")
    light_color = param.Color("#ffffff", allow_named=False, doc="Color of the new light.")
    ambient = param.Number(0.0, bounds=(0, 1), doc="How much light comes from all sides.")

    animation_suffix = param.Selector(
        default=".gif", objects=list(ANIMATION_SUFFIXES), doc="Format of the animation to download."
    )

    @property
    def look(self) -> Look:
        """The settings, as something to compare."""
        return tuple((name, _comparable(getattr(self, name))) for name in SETTINGS)

    def take(self, look: Look) -> None:
        """Change the settings to those of another look, all at once."""
        different = dict(set(look) - set(self.look))
        self.param.update(**{name: _editable(value) for name, value in different.items()})

    def relight(self, analysis: ToonAnalysis) -> ToonImage:
        """Return an analyzed picture under the new light."""
        return toonkit.relight(analysis, self.new_light, **self.relight_options)

    @property
    def relight_options(self) -> RelightOptions:
        """What `toonkit.relight` is told beside the light."""
        return {
            "keep_detail": self.keep_detail,
            "flat_shading": self.flat_shading,
            "light_color": color_of_hex(self.light_color),
            "ambient": self.ambient,
        }


def _comparable(value: Any) -> Hashable:
    """Return a setting with its lists as tuples, and angles rounded."""
    if isinstance(value, list | tuple):
        return tuple(round(part, 3) if isinstance(part, float) else _comparable(part) for part in value)
    return value  # type: ignore[no-any-return]


def _editable(value: Any) -> Any:
    return [_editable(part) for part in value] if isinstance(value, tuple) else value

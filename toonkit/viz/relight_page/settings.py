"""How a drawing is analyzed and relit: what a visitor of the relight page sets beside its materials. Knows no panel."""

from __future__ import annotations

import param

import toonkit
from toonkit import ToonAnalysis, ToonImage
from toonkit.model.light import OPENING_LIGHT
from toonkit.model.luminance import color_of_hex
from toonkit.viz.relight_page.corrections import Look

METHOD_DESCRIPTIONS = {
    "toonkit": ("toonkit", "Recommended: knows shapes, keeps the colors"),
    "classical": ("classical", "The same without what it has learned"),
    "todo": ("Todo et al.", "The published method, step by step"),
    "lumo": ("Lumo", "Puffs up the outline, ignores the shading"),
    "lambert": ("Lambert", "Reads the tones as plain, even shading"),
}
"""Name for people and one line of advice for each method."""

DEFAULT_METHOD = "toonkit"

SETTINGS = (
    "new_light", "original_light", "method", "keep_detail", "flat_shading", "light_color", "ambient"
)  # fmt: skip
"""What is undone and done again beside corrections of the materials."""


class RelightSettings(param.Parameterized):
    """A method, two lights, and what else `toonkit.relight` is told."""

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

    @property
    def look(self) -> Look:
        """The settings, as something to compare."""
        values = ((name, getattr(self, name)) for name in SETTINGS)
        return tuple(
            (name, tuple(round(angle, 3) for angle in value) if isinstance(value, list) else value)
            for name, value in values
        )

    def take(self, look: Look) -> None:
        """Change the settings to those of another look, all at once."""
        different = dict(set(look) - set(self.look))
        self.param.update(
            **{name: list(value) if isinstance(value, tuple) else value for name, value in different.items()}
        )

    def relight(self, analysis: ToonAnalysis) -> ToonImage:
        """Return an analyzed picture under the new light."""
        return toonkit.relight(
            analysis,
            self.new_light,
            keep_detail=self.keep_detail,
            flat_shading=self.flat_shading,
            light_color=color_of_hex(self.light_color),
            ambient=self.ambient,
        )

"""The color maps of a drawing: a ramp for each material, where the chosen one is, and how it was fitted."""

from __future__ import annotations

import asyncio
from typing import Any

import holoviews as hv
import numpy as np
import panel as pn
import panel_material_ui as pmui
import param

from toonkit.analysis import ToonAnalysis
from toonkit.model.materials import Materials
from toonkit.viz.choice_cards import ChoiceCards, ramp_choices
from toonkit.viz.elements import color_map_fit, material_place

LIST_WIDTH = 200
PLACE_WIDTH = 220
"""Pixels on screen: the list of ramps, and the most that the picture of a material has."""

FIT_NOTE = (
    "Each dot is a pixel in its own color, placed by the light it would get if the drawing were just puffed up; dark "
    "outlines and lines are left out, for they stay as drawn. "
    "The curve is the color map of the shape that was recovered, and a bar is the range of light that one color stands for."
)
FLAT_NOTE = (
    "This material is painted in one tone, or is too small to tell, so it does not show how it looks in shadow. "
    "Its ramp is derived: it darkens as the drawing's shaded materials do, or like a plain cool shadow where none is shaded."
)
SEVERAL_NOTE = (
    "Every material has a color map of its own: choose one to see where it is and how it was found. "
)


class ColorMapsView(pn.viewable.Viewer):
    """
    The fit of one material at a time, and the list of all, the largest first, where there are several.

    Slow enough to be made in a thread.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    height : int
        Pixels on screen.
    chosen : str, optional
        Number of the material to begin with; the largest one by default.
    """

    chosen = param.String("", doc="Number of the material on screen.")

    def __init__(self, analysis: ToonAnalysis, *, height: int, chosen: str = "") -> None:
        self._analysis, self._height = analysis, height
        rows, columns = analysis.image.shape
        scale = min(PLACE_WIDTH / columns, height / rows)
        self._place_size = {"width": round(scale * columns), "height": round(scale * rows)}
        order = np.argsort(-analysis.materials.shares, kind="stable")
        super().__init__(chosen=chosen or str(order[0]))
        place, fit = self._drawn(int(self.chosen))
        self._place, self._fit = hv.streams.Pipe(data=place), hv.streams.Pipe(data=fit)
        self._note = pmui.Typography(
            self._words(), variant="body2", color="text.secondary", margin=(8, 10, 4, 10)
        )
        self._cards = ChoiceCards(
            choices=ramp_choices({str(k): _described(analysis.materials, k) for k in order}),
            value=self.chosen,
            label="Material",
            sizing_mode="stretch_width",
            margin=(2, 8, 2, 2),
        )
        self._cards.link(self, bidirectional=True, value="chosen")

    @property
    def analysis(self) -> ToonAnalysis:
        """The analysis whose color maps are shown."""
        return self._analysis

    @param.depends("chosen", watch=True)
    async def _show(self) -> None:
        chosen = self.chosen
        place, fit = await asyncio.to_thread(self._drawn, int(chosen))
        if chosen == self.chosen:
            self._note.object = self._words()
            self._place.send(place)
            self._fit.send(fit)

    def _drawn(self, material: int) -> tuple[hv.RGB, hv.Overlay]:
        place = material_place(self._analysis, material).opts(responsive=False, **self._place_size)
        # Without a height of its own the plot would collapse when it is updated.
        return place, color_map_fit(self._analysis, material=material).opts(height=self._height)

    def _words(self) -> str:
        materials = self._analysis.materials
        note = FLAT_NOTE if materials.flat[int(self.chosen)] else FIT_NOTE
        return SEVERAL_NOTE + note if materials.count > 1 else note

    def __panel__(self) -> pn.viewable.Viewable:
        fit = pn.pane.HoloViews(
            hv.DynamicMap(_passed, streams=[self._fit]), height=self._height, sizing_mode="stretch_width"
        )
        if self._analysis.materials.count == 1:
            return pn.Column(self._note, fit, sizing_mode="stretch_width")
        place = pn.pane.HoloViews(
            hv.DynamicMap(_passed, streams=[self._place]), sizing_mode="fixed", **self._place_size
        )
        listed = pn.Column(
            self._cards, width=LIST_WIDTH, scroll="y-auto", styles={"max-height": f"{self._height}px"}
        )
        fit.styles = {"flex": "1 1 320px", "min-width": "0"}
        return pn.Column(
            self._note,
            pn.FlexBox(listed, place, fit, gap="12px", sizing_mode="stretch_width"),
            sizing_mode="stretch_width",
        )


def _passed(data: Any) -> Any:
    """Show what a stream brings."""
    return data


def _described(materials: Materials, material: int) -> tuple[str, str, Any]:
    """Return share, kind and color map of a material, for its card."""
    percent = 100 * materials.shares[material]
    share = f"{percent:.0f} %" if percent >= 1 else f"{percent:.1f} %" if percent >= 0.1 else "< 0.1 %"
    return share, "flat" if materials.flat[material] else "", materials.color_maps[material]

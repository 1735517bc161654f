"""The relight view: a drawing beside its relit picture, both with a light to drag (WebGL2, in the browser).

A drag never waits for Python: the fragment shader in `shader.js` evaluates the formula of
`toonkit.relighting`, and the light is sent back ten times a second. Where WebGL2 is missing, Python paints.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import asdict
from io import BytesIO
from typing import Any

import numpy as np
import panel as pn
import param
from numpy.typing import NDArray
from PIL import Image

from toonkit.analysis import ToonAnalysis
from toonkit.model.light import light_direction
from toonkit.model.luminance import color_of_hex
from toonkit.model.tone_ramp import ToneRamp
from toonkit.relighting import DETAIL_RANGE, DETAIL_SIZE, FULL_TURN, HIGHLIGHT_RANGE, relight
from toonkit.viz.relight_page.codes import MARKS, materials_of, numbers_in
from toonkit.viz.relight_page.key_lights import LightPathSettings
from toonkit.viz.relight_page.scripts import EDITOR, joined
from toonkit.viz.relight_page.shape_marks import NOTHING_SAID, ShapeMarks
from toonkit.viz.relight_page.textures import describe_picture, encode_textures

OUTSIDE, INKED = 0xFFFF, 0x8000
"""Numbers in the label map of the page: of pixels outside the object, and what is added where ink covers the paint."""

SHOWN_INK = 0.5
"""Coverage from which on the page shows ink."""

TEXTURES = ("color", "normals", "parts", "mixtures", "color_maps", "materials", "ramps")
"""Parameters that hold what `RelightTextures` describes."""


class RelightView(LightPathSettings, pn.custom.JSComponent):
    """
    The picture as drawn and as relit, with light balls and sliders.

    Call `show` with each new analysis. `on_msg` delivers what its user asks for: `{"action": "estimate"}`, `cancel`,
    `undo`, `redo`, `reset`, `merge` with `material` and `into`, `paint`, `fill`, `split` and `recolor`, `shape_paint`,
    `shape_fill`, `shape_tilt` and `shape_reset`, with what `RelightState` takes. All but the first two are answered by one
    more in `settled`.

    Examples
    --------
    >>> view = RelightView(new_light=[30, 50])  # doctest: +SKIP
    >>> view.show(toonkit.analyze(image))  # doctest: +SKIP
    """

    original_light = param.List(
        [135.0, 45.0], bounds=(2, 2), doc="Azimuth and elevation of the artist's light, degrees."
    )
    new_light = param.List(
        [45.0, 45.0], bounds=(2, 2), doc="Azimuth and elevation of the new light, degrees."
    )
    keep_detail = param.Boolean(True, doc="Keep what the artist painted on top of the color map.")
    flat_shading = param.Number(1.0, bounds=(0, 1), doc="How much materials in one tone answer to the light.")
    light_color = param.Color("#ffffff", allow_named=False, doc="Color of the new light.")
    ambient = param.Number(0.0, bounds=(0, 1), doc="How much light comes from all sides.")
    step = param.String("", doc='What is being computed; "" when idle.')
    fraction = param.Number(0.0, bounds=(0, 1), doc="How much of it is done.")
    idle = param.Integer(
        0, doc="Grows while nothing is computed: an update of `step` may come after one made later."
    )

    color = param.Bytes(b"", doc="RGBA8 texture: see RelightTextures, as for the next ones.")
    normals = param.Bytes(b"", doc="RG16F or RG32F texture.")
    parts = param.Bytes(b"", doc="R32UI texture, or none.")
    mixtures = param.Bytes(b"", doc="RGBA32UI texture, or none.")
    color_maps = param.Bytes(b"", doc="RGBA32F texture, a row for each material.")
    materials = param.Bytes(b"", doc="RGBA32F texture, a row for each material.")
    ramps = param.Bytes(b"", doc="RGBA32F texture, a row for each material.")
    picture_size = param.List([0, 0], bounds=(2, 2), doc="Width and height of the picture, pixels.")
    analyzed_light = param.List(
        [135.0, 45.0], bounds=(2, 2), doc="The light of the analysis on screen, degrees."
    )
    detail_range = param.Number(DETAIL_RANGE, doc="Change of illumination over which details fade.")
    detail_size = param.Number(DETAIL_SIZE, doc="Color difference up to which a detail is texture.")
    highlight_range = param.Number(HIGHLIGHT_RANGE, doc="Change of illumination over which highlights fade.")

    full_turn = param.Number(
        FULL_TURN, doc="Turn of the light, radians, from which on flat shading is all there."
    )

    webgl = param.Boolean(True, doc="Whether the browser has WebGL2; told by the browser.")
    narrow = param.Boolean(False, doc="Whether the window is as narrow as a phone; told by the browser.")
    fallback_picture = param.Bytes(b"", doc="PNG of the relit picture, only without WebGL2.")

    labels = param.Bytes(
        b"",
        doc="Number of each pixel's material plus mark, `INKED` where there is ink, `OUTSIDE` the object: uint16, deflated.",
    )
    numbers = param.List(
        [], item_type=int, doc="Numbers of the materials, in the order of their texture rows."
    )
    found_ramps = param.List(
        [], item_type=dict, doc="The `ToneRamp` that describes each material as it is drawn."
    )
    edited_ramps = param.Dict({}, doc="That of each material that has another one, by its number as a text.")
    shape_marks = param.Bytes(
        b"", doc="What is said of each pixel's shape: `BITS` of `ShapeMarks`, uint8, deflated; or none."
    )
    shape_normals = param.List([], item_type=dict, doc="The `NormalHint` that there are, as they are made.")
    selected = param.Integer(-1, doc="Number of the chosen material; -1 for none.")
    can_undo = param.Boolean(False, doc="Whether a correction can be undone.")
    can_redo = param.Boolean(False, doc="Whether one can be done again.")
    corrected = param.Boolean(False, doc="Whether there is anything to reset.")
    settled = param.Integer(0, doc="How many of the corrections that were asked for are done with.")

    _esm = joined(EDITOR)

    def __init__(self, **params: Any) -> None:
        self._analysis: ToonAnalysis | None = None
        self._ramps: Mapping[int, ToneRamp] = {}
        super().__init__(**{"sizing_mode": "stretch_width", **params})

    def show(
        self,
        analysis: ToonAnalysis,
        codes: NDArray[np.integer] | None = None,
        shape: ShapeMarks = NOTHING_SAID,
    ) -> None:
        """
        Put an analysis on screen; the new light stays where it is.

        Parameters
        ----------
        analysis : ToonAnalysis
            Any method's result.
        codes : ndarray of int, shape (H, W), optional
            Other numbers for its materials, in the same order, with marks; -1 outside the object.
        shape : ShapeMarks, optional
            What is said about its shape.
        """
        self._analysis = analysis
        codes = analysis.materials.labels if codes is None else codes
        shown = np.where(codes < 0, OUTSIDE, codes).astype("<u2")
        shown[(analysis.drawing.ink_coverage > SHOWN_INK) & (shown < MARKS["ink"])] |= INKED
        picture = describe_picture(analysis, keep_detail=self.keep_detail)
        self.param.update(
            **picture,
            numbers=numbers_in(materials_of(codes)),
            found_ramps=[asdict(ToneRamp.of(color_map)) for color_map in analysis.materials.color_maps],
            shape_marks=shape.packed,
            shape_normals=[asdict(hint) for hint in shape.normals],
            labels=zlib.compress(shown.tobytes(), 1),  # a few kilobytes
            original_light=[round(angle, 3) for angle in picture["analyzed_light"]],  # as RelightState has it
        )
        self._paint()

    def recolor(self, ramps: Mapping[int, ToneRamp]) -> None:
        """
        Paint some materials in other tones.

        Parameters
        ----------
        ramps : mapping of int to ToneRamp
            Tones by the number of a material, of which there may be others than those on screen.
        """
        self._ramps = ramps
        self.edited_ramps = {str(number): asdict(ramp) for number, ramp in ramps.items()}
        self._paint()

    def close(self) -> None:
        """Let go of the analysis and its textures: nobody looks any more."""
        self._analysis = None
        with param.parameterized.discard_events(self):
            self.param.update(dict.fromkeys((*TEXTURES, "labels", "shape_marks"), b""), fallback_picture=b"")

    @param.depends("keep_detail", watch=True)
    def _take_palette(self) -> None:
        """Give pixel art other textures with and without its palette."""
        if self._analysis is not None and self._analysis.drawing.is_pixel_art:
            textures = asdict(encode_textures(self._analysis, keep_detail=self.keep_detail))
            self.param.update({name: textures[name] for name in TEXTURES})

    @param.depends("webgl", "new_light", "keep_detail", "flat_shading", "light_color", "ambient", watch=True)
    def _paint(self) -> None:
        """Paint in Python what a browser without WebGL2 cannot."""
        analysis = self._analysis
        if self.webgl or analysis is None:
            return
        places = {number: place for place, number in enumerate(self.numbers)}
        relit = relight(
            analysis.recolored({places[k]: ramp for k, ramp in self._ramps.items() if k in places}),
            light_direction(*self.new_light),
            keep_detail=self.keep_detail,
            flat_shading=self.flat_shading,
            light_color=color_of_hex(self.light_color),
            ambient=self.ambient,
        )
        self.fallback_picture = _png(relit.to_rgba())


def _png(rgba: NDArray[np.uint8]) -> bytes:
    """Encode RGBA quickly: the network is local, time matters more than bytes."""
    buffer = BytesIO()
    Image.fromarray(rgba).save(buffer, "PNG", compress_level=1)
    return buffer.getvalue()

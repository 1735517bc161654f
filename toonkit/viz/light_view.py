"""The relight view outside the dashboard: a relit picture whose light is dragged, in a notebook or in a Panel app."""

from __future__ import annotations

from typing import Any

import panel as pn
import param
from numpy.typing import ArrayLike

from toonkit._validation import of_type
from toonkit.analysis import ToonAnalysis
from toonkit.model.light import OPENING_LIGHT, direction_of, light_angles
from toonkit.viz.relight_page.scripts import VIEW, joined
from toonkit.viz.relight_page.textures import describe_picture, encode_recolored


class LightView(pn.custom.JSComponent):
    """
    A relit picture with a light to drag. It needs WebGL2 in the browser, and no Python while the light is dragged.

    Examples
    --------
    >>> relight_view(toonkit.analyze("sample:cat"))  # doctest: +SKIP
    """

    heading = param.String("Relit", doc="What stands above the picture.")
    new_light = param.List(
        list(OPENING_LIGHT), bounds=(2, 2), doc="Azimuth and elevation of the light, degrees."
    )
    keep_detail = param.Boolean(True, doc="As in `toonkit.relight`, like the next ones.")
    flat_shading = param.Number(1.0, bounds=(0, 1))
    light_color = param.Color("#ffffff", allow_named=False)
    ambient = param.Number(0.0, bounds=(0, 1))

    color = param.Bytes(b"", doc="RGBA8 texture: see RelightTextures, as for the next ones.")
    normals = param.Bytes(b"")
    parts = param.Bytes(b"")
    mixtures = param.Bytes(b"")
    color_maps = param.Bytes(b"")
    materials = param.Bytes(b"")
    ramps = param.Bytes(b"")
    recolored = param.Bytes(b"", doc="See `encode_recolored`.")
    picture_size = param.List([0, 0], bounds=(2, 2), doc="Width and height of the picture, pixels.")
    analyzed_light = param.List([135.0, 45.0], bounds=(2, 2), doc="The light of the analysis, degrees.")
    detail_range = param.Number(1.0)
    detail_size = param.Number(1.0)
    highlight_range = param.Number(1.0)
    full_turn = param.Number(1.0)

    _esm = joined(VIEW)


def relight_view(analysis: ToonAnalysis, light: ArrayLike = OPENING_LIGHT, **options: Any) -> LightView:
    """
    Show an analyzed picture under a light that is moved by dragging.

    Parameters
    ----------
    analysis : ToonAnalysis
        The picture taken apart.
    light : array_like, shape (3,) or (2,), optional
        The light to begin with, as in `toonkit.relight`.
    **options
        `heading`, `keep_detail`, `flat_shading`, `light_color` as "#rrggbb", `ambient`, and those of any Panel component.

    Returns
    -------
    LightView
        A Panel component: the last line of a notebook cell shows it. Its `new_light` follows the light, in degrees.

    Raises
    ------
    ToonkitError
        If the analysis is not a `ToonAnalysis`, or the light is invalid.

    Examples
    --------
    >>> relight_view(toonkit.analyze("sample:cat"), ambient=0.2)  # doctest: +SKIP
    """
    of_type("analysis", analysis, ToonAnalysis)
    angles = list(light_angles(direction_of("light", light)))
    picture = describe_picture(analysis, keep_detail=options.get("keep_detail", True))
    return LightView(
        **{"sizing_mode": "stretch_width", **options},
        **picture,
        recolored=encode_recolored(analysis),
        new_light=angles,
    )

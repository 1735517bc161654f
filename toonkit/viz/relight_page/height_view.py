"""The recovered surface in 3-D, drawn by the browser (WebGL2): no renderer is needed where Python runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import panel as pn
import param

from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.viz.height_grid import reduce_to_grid


class HeightView(pn.custom.JSComponent):
    """
    A height surface with arrows along its normals, to be turned by dragging.

    The same view shows one surface after another: a new one arrives as a few hundred kilobytes.

    Examples
    --------
    >>> view = HeightView(height=380)  # doctest: +SKIP
    >>> view.show(analysis.normals, analysis.image)  # doctest: +SKIP
    """

    grid_size = param.List([0, 0], bounds=(2, 2), doc="Width and height of the grid, samples.")
    heights = param.Bytes(b"", doc="float32, row 0 at the top; NaN outside the object.")
    normals = param.Bytes(b"", doc="float32 x, y, z of each sample.")
    colors = param.Bytes(b"", doc="RGBA8 of each sample.")
    arrow_feet = param.Bytes(b"", doc="uint32: indices of the samples that carry an arrow.")
    arrow_spacing = param.Integer(1, doc="Samples between two arrows.")

    _esm = Path(__file__).with_name("height_view.js")

    def __init__(self, **params: Any) -> None:
        super().__init__(**{"sizing_mode": "stretch_width", **params})

    def show(self, normals: NormalField, color: ToonImage) -> None:
        """
        Put a surface on screen, seen from where the last one was.

        Parameters
        ----------
        normals : NormalField
            Normals, (H, W).
        color : ToonImage
            The picture that the surface is painted with, (H, W).
        """
        self.param.update(**encode_surface(normals, color))


def encode_surface(normals: NormalField, color: ToonImage) -> dict[str, Any]:
    """
    Encode a surface as the parameters of a `HeightView`.

    Parameters
    ----------
    normals : NormalField
        Normals, (H, W).
    color : ToonImage
        The picture that the surface is painted with, (H, W).

    Returns
    -------
    dict
        Values by parameter. Computing them is slow and belongs in a thread; setting them is fast.
    """
    grid = reduce_to_grid(normals)
    height, width = grid.field.mask.shape
    mask = grid.field.mask
    picture = color.color[:: grid.step, :: grid.step]
    painted = np.zeros((height, width, 4), dtype=np.uint8)
    painted[mask, :3] = np.round(picture[mask] * 255)
    painted[mask, 3] = 255
    return {
        "grid_size": [width, height],
        "heights": grid.field.height.astype("<f4").tobytes(),
        "normals": grid.normals.vectors.astype("<f4").tobytes(),
        "colors": painted.tobytes(),
        "arrow_feet": np.flatnonzero(grid.arrow_feet).astype("<u4").tobytes(),
        "arrow_spacing": grid.arrow_spacing,
    }

"""The line art of a drawing as a layer of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import of_type
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.model.image import eight_bit
from toonkit.model.whole_pixels import opaque, put_pixels


def line_art(drawing: PreparedDrawing) -> NDArray[np.uint8]:
    """
    Return the line art of a drawing on a transparent background.

    Parameters
    ----------
    drawing : PreparedDrawing
        The drawing, such as `analysis.drawing`.

    Returns
    -------
    ndarray of uint8, shape (H, W, 4)
        RGBA, straight alpha: ink color, with the ink coverage of each pixel as alpha.

    Raises
    ------
    ToonkitError
        If `drawing` is not a `PreparedDrawing`.
    """
    of_type("drawing", drawing, PreparedDrawing)
    image, frame, ink = drawing.image, drawing.frame, drawing.ink
    rgba = np.zeros((*image.shape, 4), np.uint8)
    top, left = (side.start for side in drawing.box)
    coverage = frame.inner(ink.coverage)
    put_pixels(rgba[drawing.box], coverage > 0, opaque(eight_bit(ink.colors)))
    rgba[(*drawing.box, 3)] = eight_bit(coverage * image.alpha[drawing.box])
    # Line art continues to where the object's soft outline ends.
    around = coverage[image.fringe_sources[0] - top, image.fringe_sources[1] - left]
    continued = around > 0
    fringe, nearest = (
        tuple(at[continued] for at in places) for places in (image.fringe_places, image.fringe_sources)
    )
    rgba[fringe] = rgba[nearest]
    rgba[(*fringe, 3)] = eight_bit(around[continued] * image.alpha[fringe])
    return rgba

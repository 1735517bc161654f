"""The line art of a drawing as a layer of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import of_type
from toonkit.estimation.preparation import PreparedDrawing
from toonkit.model.image import eight_bit


def line_art(drawing: PreparedDrawing) -> NDArray[np.uint8]:
    """
    Return the ink of a drawing without the paint beneath.

    Parameters
    ----------
    drawing : PreparedDrawing
        The drawing, such as `analysis.drawing`.

    Returns
    -------
    ndarray of uint8, shape (H, W, 4)
        RGBA: the color of the ink, and as straight alpha how much of each pixel it covers.

    Raises
    ------
    ToonkitError
        If the drawing is not prepared.
    """
    of_type("drawing", drawing, PreparedDrawing)
    image, frame, ink = drawing.image, drawing.frame, drawing.ink
    rgba = np.zeros((*image.shape, 4), np.uint8)
    top, left = (side.start for side in drawing.box)
    coverage, color = frame.inner(ink.coverage), frame.inner(ink.color)
    inked = np.nonzero(coverage > 0)
    places = inked[0] + top, inked[1] + left
    # Line art continues to where the object's soft outline ends.
    sources = image.fringe_sources[0] - top, image.fringe_sources[1] - left
    continued = coverage[sources] > 0
    for source, place in (
        (inked, places),
        (tuple(at[continued] for at in sources), tuple(at[continued] for at in image.fringe_places)),
    ):
        rgba[(*place, slice(0, 3))] = eight_bit(color[source])
        rgba[(*place, 3)] = eight_bit(coverage[source] * image.alpha[place])
    return rgba

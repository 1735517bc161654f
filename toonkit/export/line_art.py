"""The line art of a drawing as a layer of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import of_type
from toonkit.estimation.preparation import PreparedDrawing


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
    image, color, coverage = drawing.image, drawing.ink_color, drawing.ink_coverage
    # Line art continues to where the object's soft outline ends.
    for values in (color, coverage):
        values[image.fringe_places] = values[image.fringe_sources]
    rgba = np.zeros((*image.shape, 4))
    inked = coverage > 0
    rgba[inked, :3] = color[inked]
    rgba[..., 3] = coverage * image.alpha
    return np.round(rgba * 255).astype(np.uint8)

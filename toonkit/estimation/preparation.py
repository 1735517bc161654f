"""Prepare a drawing: what every analysis starts with (Section 3.1)."""

from __future__ import annotations

from numpy.typing import ArrayLike

from toonkit._validation import of_type
from toonkit.estimation.enlarged_drawing import EnlargedDrawing
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.illustration.enlargement import find_enlargement
from toonkit.model.image import ToonImage
from toonkit.model.materials import Materials
from toonkit.model.shape_corrections import ShapeCorrections


def prepare(
    drawing: ToonImage | PreparedDrawing,
    *,
    materials: ArrayLike | Materials | None = None,
    ink: ArrayLike | None = None,
    highlights: ArrayLike | None = None,
    shape: ShapeCorrections | None = None,
    views: int = 1,
) -> PreparedDrawing:
    """
    Prepare a drawing for analysis.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing. A prepared drawing is returned unchanged, unless something is given, and shares what stays the same.
    materials : array_like of int, shape (H, W), or Materials, optional
        Number of the material of each pixel, 0 and up, and -1 where that is left to toonkit; ignored outside the mask.
        Found if not given.
    ink : array_like of bool, shape (H, W), optional
        True where line art covers most of a pixel, False everywhere if there is none; ignored outside the mask. Found if not
        given.
    highlights : array_like of bool, shape (H, W), optional
        True where the paint shows a highlight, or a cast shadow: what lies on the paint and says nothing about the shape.
        Found if not given.
    shape : ShapeCorrections, optional
        What a person says about the shape; an empty one takes back what was said before.
    views : int, optional
        How often a picture shows its object side by side: see `PreparedDrawing`.

    Returns
    -------
    PreparedDrawing
        The prepared drawing. Pass it on instead of the picture, so that nothing is computed twice.

    Raises
    ------
    ToonkitError
        If the drawing is of another type, its object has more than `MOST_PIXELS` pixels, the materials or the highlights are
        not such arrays, the ink is not such a mask or covers all of the object, or the shape is of another size or type.
    """
    if shape is not None:
        of_type("shape", shape, ShapeCorrections)
    if isinstance(materials, Materials):
        materials = materials.labels
    if isinstance(drawing, PreparedDrawing):
        if not (materials is None and ink is None and highlights is None):
            drawing = drawing.told(materials, ink, highlights)
        return drawing if shape is None else drawing.reshaped(shape)
    of_type("image", drawing, ToonImage)
    prepared = PreparedDrawing(drawing, materials, ink=ink, highlights=highlights, shape=shape, views=views)
    enlargement = find_enlargement(drawing)
    return prepared if enlargement is None else EnlargedDrawing.of(prepared, enlargement)


def find_materials(image: ToonImage | PreparedDrawing) -> Materials:
    """
    Find which parts of a drawing are painted with the same ramp of colors.

    Parameters
    ----------
    image : ToonImage or PreparedDrawing
        The drawing.

    Returns
    -------
    Materials
        Labels and tones, without color maps; at least one material.

    Raises
    ------
    ToonkitError
        If the image is not a `ToonImage`.

    Examples
    --------
    >>> import numpy as np
    >>> color = np.full((32, 32, 3), (0.8, 0.2, 0.2))
    >>> color[:, 16:] = (0.2, 0.3, 0.8)
    >>> find_materials(ToonImage(color, np.ones((32, 32), bool))).count
    2
    """
    return prepare(image).materials

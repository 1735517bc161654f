"""load_layers: a layered document as a drawing, with the materials and the ink that its layers tell apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, refuse, warn
from toonkit.model.decoding import PictureSource, read_pixels
from toonkit.model.description import describe_object
from toonkit.model.documents.document import Document, Layer
from toonkit.model.documents.flats import labels_of_flats
from toonkit.model.documents.opening import open_document
from toonkit.model.documents.roles import (
    INKED,
    find_flats_layers,
    find_ink_layers,
    ink_coverage,
    layers_named,
)
from toonkit.model.image import ToonImage
from toonkit.model.loading import image_of


@dataclass(frozen=True, eq=False)
class LayeredDrawing:
    """
    A drawing, and what its layers say about it.

    Attributes
    ----------
    image : ToonImage
        The merged picture.
    materials : ndarray of int, shape (H, W), or None
        For `analyze(materials=)`: a number for each flat color, -1 where there is none; None without a layer of flat colors.
    ink : ndarray of bool, shape (H, W), or None
        For `analyze(ink=)`: True where line art covers most of a pixel; None without a layer of lines.
    ink_layers, flats_layers : tuple of str
        Names of the layers that these are from.
    """

    image: ToonImage
    materials: NDArray[np.integer] | None = None
    ink: BoolArray | None = None
    ink_layers: tuple[str, ...] = ()
    flats_layers: tuple[str, ...] = ()

    def __repr__(self) -> str:
        parts = [describe_object(self.image.mask)]
        if self.ink is not None:
            parts.append(f"ink from {', '.join(self.ink_layers)}")
        if self.materials is not None:
            parts.append(f"{self.materials.max() + 1} materials from {', '.join(self.flats_layers)}")
        return f"LayeredDrawing({'; '.join(parts)})"


def load_layers(
    source: PictureSource,
    *,
    mask: PictureSource | None = None,
    ink_layer: str | Sequence[str] | None = None,
    flats_layer: str | Sequence[str] | None = None,
) -> LayeredDrawing:
    """
    Read a layered drawing, with its line art and materials where layers hold them.

    Parameters
    ----------
    source : path, binary file object or array_like
        A Photoshop (.psd, .psb), OpenRaster (.ora) or Krita (.kra) document that holds its merged picture; a folder of PNG
        or WebP layers of one size; or any picture that `load_image` reads, which has no layers.
    mask : path, binary file object or array_like, optional
        Where the object is, as for `load_image`.
    ink_layer, flats_layer : str or sequence of str, optional
        Names of the layers, or of groups of them, that hold the line art and the flat colors; an empty sequence if none
        does. By default they are found, see Notes.

    Returns
    -------
    LayeredDrawing
        `analyze(drawing.image, materials=drawing.materials, ink=drawing.ink)` is what `analyze(source)` does.

    Raises
    ------
    ToonkitError
        If the source is refused, it has no layer of a given name, or one that is named does not hold what it should.

    Warns
    -----
    ToonkitWarning
        If a layer that is called flat has too many colors to be so, or one that is called ink covers all of the drawing.

    Notes
    -----
    Layers are told by their names, or those of their groups: words such as "line", "lineart", "ink" and "outline", and
    "flats", "flat" and "base". Where no visible layer is called one of the former, visible layers on top that show nothing
    but dark, thin lines are the line art. Hidden layers hold no line art, but flat colors if no visible one does.

    Ink that other layers hide is left out, and ink that is multiplied with what is below, or drawn on opaque paper, counts
    as far as it is dark. Of flat colors each is one material.
    """
    document = open_document("source", source)
    if document is None:
        _refuse_layers_of_a_plain_picture(ink_layer=ink_layer, flats_layer=flats_layer)
        return LayeredDrawing(image_of(read_pixels("source", source), mask))
    image = image_of(document.read_merged(), mask)
    inked = _layers("ink_layer", document, ink_layer, lambda: find_ink_layers(document, image.mask))
    flat = _layers("flats_layer", document, flats_layer, lambda: find_flats_layers(document))
    ink = _ink(document, inked, image.mask, named=ink_layer is not None) if inked else None
    materials = _materials(flat, image.mask, named=flats_layer is not None) if flat else None
    ink_layers = () if ink is None else tuple(layer.name for layer in inked)
    flats_layers = () if materials is None else tuple(layer.name for layer in flat)
    return LayeredDrawing(image, materials, ink, ink_layers, flats_layers)


def _refuse_layers_of_a_plain_picture(**named: object) -> None:
    for argument, names in named.items():
        if names:
            raise refuse(argument, "must come with a layered document", f"{names!r} and a plain picture")


def _layers(
    argument: str, document: Document, names: object, find: Callable[[], tuple[Layer, ...]]
) -> tuple[Layer, ...]:
    if names is None:
        return find()
    wanted = [names] if isinstance(names, str) else names
    if not isinstance(wanted, Sequence) or not all(isinstance(name, str) for name in wanted):
        raise refuse(argument, "must be the name of a layer, or several", repr(names))
    return layers_named(argument, document, wanted)


def _ink(document: Document, layers: Sequence[Layer], mask: BoolArray, *, named: bool) -> BoolArray | None:
    ink: BoolArray = mask & (ink_coverage(document, layers, mask) >= INKED)
    shown = ", ".join(layer.name for layer in layers)
    if ink.any() and not (ink == mask).all():
        return ink
    if named:
        what = "covers all of the drawing" if ink.any() else "shows no ink on the drawing"
        raise refuse("ink_layer", "must hold line art", f"{shown}, which {what}")
    if ink.any():
        warn("source", f"the layer {shown} covers all of the drawing and is not taken for line art")
    return None


def _materials(layers: Sequence[Layer], mask: BoolArray, *, named: bool) -> NDArray[np.intp] | None:
    labels = labels_of_flats(layers, mask)
    shown = ", ".join(layer.name for layer in layers)
    if labels is None and named:
        raise refuse("flats_layer", "must hold flat colors on the drawing", f"{shown}, which does not")
    if labels is None:
        warn("source", f"the layer {shown} is not flat and is not taken for the materials")
    return labels

"""OpenRaster documents (.ora), as https://www.openraster.org describes them."""

from __future__ import annotations

import io
from collections.abc import Iterator
from functools import partial
from typing import Any
from xml.etree import ElementTree

from toonkit._validation import refuse
from toonkit.model.decoding import Pixels, read_pixels
from toonkit.model.documents.document import Document, Layer, LayerPixels, on_canvas
from toonkit.model.documents.pictures import read_layer_picture
from toonkit.model.documents.zip_members import ZipMembers

MERGED = "mergedimage.png"

_BLENDS: dict[str, Any] = {"svg:src-over": "normal", "svg:multiply": "multiply"}


def open_raster(argument: str, members: ZipMembers) -> Document:
    """Open an OpenRaster document: its merged picture, and its layers."""
    root = members.read_xml("stack.xml")
    shape = members.canvas_shape(root, ("h", "w"))
    layers = [
        layer
        for stack in root.findall("stack")
        for layer in _layers(stack, argument, members, shape, ((), 1.0, True))
    ]
    return Document(members.name, tuple(layers[::-1]), partial(read_merged, argument, members, shape))


def read_merged(argument: str, members: ZipMembers, shape: tuple[int, int]) -> Pixels:
    """Read the merged picture that an OpenRaster or Krita document holds, of the canvas's size (H, W)."""
    if MERGED not in members:
        rule = f"must hold its merged picture, {MERGED} (save it again with the program that made it)"
        raise refuse(argument, rule, f"{members.name} without it")
    pixels = read_pixels(argument, io.BytesIO(members.read(MERGED, most_bytes(shape))))
    if pixels.color.shape[:2] != shape:
        raise members.damaged(f"{MERGED} is not of the canvas's size")
    return pixels


def most_bytes(shape: tuple[int, int]) -> float:
    """Bytes that a picture (H, W) may take in a document: four channels of 16 bits, and some more."""
    return 8.1 * shape[0] * shape[1] + 2**20


def _layers(
    stack: ElementTree.Element,
    argument: str,
    members: ZipMembers,
    shape: tuple[int, int],
    around: tuple[tuple[str, ...], float, bool],
) -> Iterator[Layer]:
    """Yield the layers of a stack, from the top to the bottom."""
    groups, opacity, visible = around
    for element in stack:
        name = element.get("name", "")
        own = opacity * _number(element, "opacity", 1.0)
        shown = visible and element.get("visibility", "visible") == "visible"
        if element.tag == "stack":
            inside = groups if not name else (name, *groups)
            yield from _layers(element, argument, members, shape, (inside, own, shown))
        elif element.tag == "layer" and "src" in element.attrib:
            place = round(_number(element, "y", 0.0)), round(_number(element, "x", 0.0))
            yield Layer(
                name,
                groups,
                shape[0] * shape[1],
                partial(_read_layer, argument, members, element.attrib["src"], place, shape),
                _BLENDS.get(element.get("composite-op", "svg:src-over"), "other"),
                shown,
                own,
            )


def _read_layer(
    argument: str, members: ZipMembers, source: str, place: tuple[int, int], shape: tuple[int, int]
) -> LayerPixels:
    # A layer may be larger than the canvas.
    data = members.read(source, 4 * most_bytes(shape))
    pixels = read_layer_picture(argument, data, f"{source} in {members.name}")
    return on_canvas(pixels, *place, shape)


def _number(element: ElementTree.Element, name: str, default: float) -> float:
    """Return a number that an element states, within what makes sense, or the default."""
    try:
        number = float(element.get(name, default))
    except ValueError:
        return default
    return number if abs(number) < 2**31 else default

"""
Krita documents (.kra): a ZIP archive with the merged picture, maindoc.xml, and the tiles of each layer.

A layer's file is a text header (VERSION 2, the size of a tile, the bytes of a pixel, the number of tiles), and for each tile
a line "x,y,LZF,bytes" and its data: a byte that says whether it is compressed, and then the pixels, blue, green, red and
alpha. Compressed tiles hold all first bytes of the pixels, then all second ones and so on, packed by LZF.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from functools import partial
from typing import Any
from xml.etree import ElementTree

import imagecodecs
import numpy as np
from numpy.typing import NDArray

from toonkit._validation import ToonkitError
from toonkit.model.decoding import MAX_PIXELS
from toonkit.model.documents.document import Document, Layer, LayerPixels
from toonkit.model.documents.open_raster import read_merged
from toonkit.model.documents.zip_members import ZipMembers

DESCRIPTION = "maindoc.xml"

SIDE = 64
"""Rows and columns of a tile."""

MOST_TILES = 4 * MAX_PIXELS // SIDE**2
"""Tiles of a layer at most, those outside the canvas among them."""

_PIXEL: dict[str, np.dtype[Any]] = {"RGBA": np.dtype("u1"), "RGBA16": np.dtype("<u2")}
_HEADER = re.compile(
    rb"VERSION 2\nTILEWIDTH 64\nTILEHEIGHT 64\nPIXELSIZE (\d{1,2})\nDATA (\d{1,9})\n", re.ASCII
)
_TILE = re.compile(rb"(-?\d{1,9}),(-?\d{1,9}),LZF,(\d{1,9})\n", re.ASCII)
_BLENDS: dict[str, Any] = {"normal": "normal", "multiply": "multiply"}


def open_krita(argument: str, members: ZipMembers) -> Document:
    """Open a Krita document: its merged picture, and its paint layers in RGB of 8 or 16 bits."""
    image = next((element for element in members.read_xml(DESCRIPTION) if _tag(element) == "IMAGE"), None)
    if image is None:
        raise members.damaged(f"{DESCRIPTION} without a picture")
    shape = members.canvas_shape(image, ("height", "width"))
    folder = f"{image.get('name', '')}/layers"
    layers = tuple(_layers(image, members, folder, shape, ((), 1.0, True)))
    return Document(members.name, layers[::-1], partial(read_merged, argument, members, shape))


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _layers(
    parent: ElementTree.Element,
    members: ZipMembers,
    folder: str,
    shape: tuple[int, int],
    around: tuple[tuple[str, ...], float, bool],
) -> Iterator[Layer]:
    """Yield the paint layers in an element, from the top to the bottom."""
    groups, opacity, visible = around
    for element in parent:
        if _tag(element) == "layers":
            yield from _layers(element, members, folder, shape, around)
        if _tag(element) != "layer":
            continue
        name = element.get("name", "")
        own, shown = (
            opacity * _whole(element, "opacity", 255) / 255,
            visible and element.get("visible") != "0",
        )
        if element.get("nodetype") == "grouplayer":
            yield from _layers(element, members, folder, shape, ((name, *groups), own, shown))
        pixel = _PIXEL.get(element.get("colorspacename", ""))
        if element.get("nodetype") == "paintlayer" and pixel is not None:
            member = f"{folder}/{element.get('filename', '')}"
            offset = _whole(element, "y", 0), _whole(element, "x", 0)
            yield Layer(
                name,
                groups,
                shape[0] * shape[1],
                partial(_read_layer, members, member, pixel, offset, shape),
                _BLENDS.get(element.get("compositeop", "normal"), "other"),
                shown,
                own,
                clipped=element.get("channelflags", "").endswith("0"),  # the last flag is that of alpha
            )


def _read_layer(
    members: ZipMembers, member: str, pixel: np.dtype[Any], offset: tuple[int, int], shape: tuple[int, int]
) -> LayerPixels:
    size = 4 * pixel.itemsize
    canvas = np.zeros((*shape, 4), pixel)
    default = f"{member}.defaultpixel"
    if default in members:
        ground = members.read(default, 1 << 10)
        if len(ground) == size:
            canvas[...] = np.frombuffer(ground, pixel)
    data = members.read(member, 4 * size * (shape[0] + SIDE) * (shape[1] + SIDE) + 2**20)
    try:
        for place, tile in _tiles(data, size):
            _put(canvas, tile.view(pixel), (place[0] + offset[0], place[1] + offset[1]))
    except ToonkitError:
        raise
    except Exception as error:  # decoders have types of their own
        raise members.damaged(f"{member}: {error}") from error
    if pixel.itemsize == 2:
        canvas = (canvas >> 8).astype(np.uint8)
    return np.ascontiguousarray(canvas[..., [2, 1, 0, 3]])


def _tiles(data: bytes, size: int) -> Iterator[tuple[tuple[int, int], NDArray[np.uint8]]]:
    """Yield row, column and the bytes (SIDE, SIDE, size) of each tile of a layer's file."""
    header = _HEADER.match(data)
    if header is None or int(header[1]) != size or int(header[2]) > MOST_TILES:
        raise ValueError("its tiles are of an unknown kind")
    stream, length = io.BytesIO(data), SIDE * SIDE * size
    stream.seek(header.end())
    for _ in range(int(header[2])):
        line = _TILE.fullmatch(stream.readline(64))
        if line is None:
            raise ValueError("a tile is missing")
        content = stream.read(int(line[3]))
        if len(content) != int(line[3]) or len(content) < 2:
            raise ValueError("a tile is cut off")
        if content[0]:
            planes = np.frombuffer(imagecodecs.lzf_decode(content[1:], out=length), np.uint8)
            tile = np.ascontiguousarray(planes.reshape(size, SIDE, SIDE).transpose(1, 2, 0))
        else:
            tile = np.frombuffer(content[1:], np.uint8).reshape(SIDE, SIDE, size)
        yield (int(line[2]), int(line[1])), tile


def _put(canvas: NDArray[Any], tile: NDArray[Any], place: tuple[int, int]) -> None:
    """Put a tile at its row and column on a canvas; what lies outside is cut off."""
    starts = [max(0, -at) for at in place]
    stops = [min(SIDE, whole - at) for at, whole in zip(place, canvas.shape[:2], strict=True)]
    if starts[0] < stops[0] and starts[1] < stops[1]:
        part = tile[starts[0] : stops[0], starts[1] : stops[1]]
        top, left = place[0] + starts[0], place[1] + starts[1]
        canvas[top : top + part.shape[0], left : left + part.shape[1]] = part


def _whole(element: ElementTree.Element, name: str, default: int) -> int:
    """Return a whole number that an element states, or the default."""
    text = element.get(name, "")
    return int(text) if re.fullmatch(r"-?\d{1,6}", text, re.ASCII) else default

"""Layered files of every format, written from layers in memory."""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from xml.etree import ElementTree

import imagecodecs
import numpy as np
from PIL import Image
from psd_tools import PSDImage
from psd_tools.constants import BlendMode


@dataclass(frozen=True)
class Made:
    """A layer of a file: RGBA pixels (h, w, 4) at a row and column of the canvas."""

    name: str
    pixels: np.ndarray
    place: tuple[int, int] = (0, 0)
    blend: str = "normal"
    visible: bool = True
    opacity: int = 255
    group: str | None = None


def png(pixels):
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def merged(layers, shape):
    """Compose visible layers, bottom first."""
    color, alpha = np.zeros((*shape, 3)), np.zeros((*shape, 1))
    for layer in layers:
        if not layer.visible:
            continue
        whole = np.zeros((*shape, 4))
        height, width = layer.pixels.shape[:2]
        top, left = layer.place
        whole[top : top + height, left : left + width] = layer.pixels / 255
        share = whole[..., 3:] * layer.opacity / 255
        paint = whole[..., :3]
        if layer.blend == "multiply":
            paint = np.where(alpha > 0, paint * color, paint)
        total = share + alpha * (1 - share)
        color = (share * paint + alpha * (1 - share) * color) / np.maximum(total, 1e-9)
        alpha = total
    return np.round(255 * np.dstack([color, alpha])).astype(np.uint8)


def psd_file(layers, shape):
    document = PSDImage.new("RGBA", shape[::-1])
    groups = {}
    for layer in layers:
        parent = document
        if layer.group is not None:
            parent = groups.setdefault(layer.group, None) or document.create_group(name=layer.group)
            groups[layer.group] = parent
        made = parent.create_pixel_layer(
            Image.fromarray(layer.pixels),
            name=layer.name,
            top=layer.place[0],
            left=layer.place[1],
            opacity=layer.opacity,
            blend_mode=BlendMode.MULTIPLY if layer.blend == "multiply" else BlendMode.NORMAL,
        )
        made.visible = layer.visible
    info = document._record.layer_and_mask_information.layer_info
    info.layer_count = -abs(info.layer_count)  # the fourth channel is transparency
    file = io.BytesIO()
    document.save(file)
    return file.getvalue()


def zip_file(members, *, packed=zipfile.ZIP_STORED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", packed) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name), content, packed if name != "mimetype" else 0)
    return file.getvalue()


def ora_members(layers, shape):
    image = ElementTree.Element("image", w=str(shape[1]), h=str(shape[0]))
    stack = ElementTree.SubElement(image, "stack")
    members = {"mimetype": "image/openraster", "stack.xml": "", "mergedimage.png": png(merged(layers, shape))}
    for number, layer in enumerate(layers):
        source = f"data/{number}.png"
        members[source] = png(layer.pixels)
        attributes = {
            "name": layer.name,
            "src": source,
            "y": str(layer.place[0]),
            "x": str(layer.place[1]),
            "opacity": str(layer.opacity / 255),
            "visibility": "visible" if layer.visible else "hidden",
            "composite-op": "svg:multiply" if layer.blend == "multiply" else "svg:src-over",
        }
        element = ElementTree.Element("layer", attributes)
        if layer.group is not None:
            inside = ElementTree.Element("stack", name=layer.group)
            inside.append(element)
            element = inside
        stack.insert(0, element)
    members["stack.xml"] = ElementTree.tostring(image)
    return members


def krita_tiles(pixels, *, packed=True):
    """The file of a Krita layer, as KisTileCompressor2 writes it."""
    height, width = -(-pixels.shape[0] // 64) * 64, -(-pixels.shape[1] // 64) * 64
    whole = np.zeros((height, width, 4), np.uint8)
    whole[: pixels.shape[0], : pixels.shape[1]] = pixels[..., [2, 1, 0, 3]]
    tiles = []
    for top in range(0, height, 64):
        for left in range(0, width, 64):
            tile = whole[top : top + 64, left : left + 64]
            content = b"\0" + tile.tobytes()
            if packed:
                content = b"\1" + imagecodecs.lzf_encode(tile.transpose(2, 0, 1).tobytes())
            tiles.append(f"{left},{top},LZF,{len(content)}\n".encode() + content)
    head = f"VERSION 2\nTILEWIDTH 64\nTILEHEIGHT 64\nPIXELSIZE 4\nDATA {len(tiles)}\n"
    return head.encode() + b"".join(tiles)


def kra_members(layers, shape):
    document = ElementTree.Element("DOC", xmlns="http://www.calligra.org/DTD/krita")
    size = {"width": str(shape[1]), "height": str(shape[0])}
    image = ElementTree.SubElement(document, "IMAGE", name="cat", colorspacename="RGBA", **size)
    stack = ElementTree.SubElement(image, "layers")
    members = {
        "mimetype": "application/x-krita",
        "maindoc.xml": "",
        "mergedimage.png": png(merged(layers, shape)),
    }
    for number, layer in enumerate(layers):
        members[f"cat/layers/layer{number}"] = krita_tiles(layer.pixels, packed=number % 2 == 0)
        members[f"cat/layers/layer{number}.defaultpixel"] = bytes(4)
        attributes = {
            "name": layer.name,
            "filename": f"layer{number}",
            "nodetype": "paintlayer",
            "colorspacename": "RGBA",
            "y": str(layer.place[0]),
            "x": str(layer.place[1]),
            "opacity": str(layer.opacity),
            "visible": str(int(layer.visible)),
            "compositeop": layer.blend,
            "channelflags": "",
        }
        element = ElementTree.Element("layer", attributes)
        if layer.group is not None:
            inside = ElementTree.Element("layer", name=layer.group, nodetype="grouplayer", visible="1")
            ElementTree.SubElement(inside, "layers").append(element)
            element = inside
        stack.insert(0, element)
    members["maindoc.xml"] = ElementTree.tostring(document)
    return members


def write_folder(layers, shape, folder):
    folder.mkdir()
    for number, layer in enumerate(layers):
        whole = np.zeros((*shape, 4), np.uint8)
        height, width = layer.pixels.shape[:2]
        top, left = layer.place
        whole[top : top + height, left : left + width] = layer.pixels
        (folder / f"{number} {layer.name}.png").write_bytes(png(whole))


def write_layered(kind, layers, shape, folder):
    """Write layers as a file, or folder, of some kind; return its path."""
    path = folder / f"drawing.{kind}"
    if kind == "psd":
        path.write_bytes(psd_file(layers, shape))
    elif kind == "ora":
        path.write_bytes(zip_file(ora_members(layers, shape)))
    elif kind == "kra":
        path.write_bytes(zip_file(kra_members(layers, shape), packed=zipfile.ZIP_DEFLATED))
    else:
        path = folder / "layers"
        write_folder(layers, shape, path)
    return path

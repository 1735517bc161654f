"""Layers as files: a folder of PNGs with a description, an OpenRaster document, or a Photoshop document."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO
from xml.etree import ElementTree

import numpy as np
from PIL import Image

from toonkit._validation import expand_home, of_type, refuse
from toonkit.export.atomic import PathLike, atomic_write
from toonkit.export.folder import make_folder
from toonkit.export.layers import Layers, Pixels
from toonkit.export.picture import encode_picture, write_picture

if TYPE_CHECKING:
    from psd_tools import PSDImage

DESCRIPTION_NAME = "layers.json"
"""Name of the file that says how the PNGs of a folder are composed."""

PICTURE_NAME = "relit.png"
"""Name of the picture that they compose to."""

THUMBNAIL_SIDE = 256
"""Longest side of an OpenRaster thumbnail, as its specification says."""

_SVG = {"normal": "svg:src-over", "multiply": "svg:multiply", "add": "svg:plus"}


def write_layers(layers: Layers, path: PathLike) -> list[Path]:
    """
    Write layers for painting programs and engines.

    Parameters
    ----------
    layers : Layers
        As `split_layers` returns them.
    path : path
        Ends in .ora (OpenRaster: Krita, GIMP, MyPaint), in .psd (Photoshop and most others), or is a folder, which is
        created if need be: a PNG for each layer, relit.png, and layers.json, which says how they are composed.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ToonkitError
        If the path has another suffix, cannot be written to, or psd-tools is missing for a .psd.

    Notes
    -----
    A Photoshop document has the groups Ink, Light and Color. An OpenRaster document has Ink and Color, with shadow and
    light inside of Color: GIMP blends the layers of a group with nothing below the group.
    """
    of_type("layers", layers, Layers)
    target = expand_home(path)
    suffix = target.suffix.lower()
    if suffix == "":
        return _write_folder(layers, make_folder(path))
    if suffix == ".psd":
        document = _photoshop_document(layers)
        with atomic_write(target) as file:
            document.save(file)
    elif suffix == ".ora":
        with atomic_write(target) as file:
            _write_open_raster(layers, file)
    else:
        raise refuse("path", "must end in .ora or .psd, or be a folder, whose name has no suffix", f"{path}")
    return [target]


def _write_folder(layers: Layers, folder: Path) -> list[Path]:
    entries = []
    for key, kind, pixels in layers:
        write_picture(pixels, folder / f"{key}.png")
        entries.append({"file": f"{key}.png", "name": kind.name, "group": kind.group, "blend": kind.blend})
    write_picture(layers.picture, folder / PICTURE_NAME)
    height, width = layers.picture.shape[:2]
    description = {
        "width": width,
        "height": height,
        "colors": "sRGB, blended as stored",
        "alpha": "straight",
        "order": "bottom to top",
        "layers": entries,
        "composed": PICTURE_NAME,
    }
    with atomic_write(folder / DESCRIPTION_NAME) as file:
        file.write((json.dumps(description, indent=2) + "\n").encode())
    return [folder / name for name in (*(entry["file"] for entry in entries), PICTURE_NAME, DESCRIPTION_NAME)]


def _write_open_raster(layers: Layers, file: BinaryIO) -> None:
    """Write the zip file that https://www.openraster.org describes."""
    height, width = layers.picture.shape[:2]
    image = ElementTree.Element("image", version="0.0.3", w=str(width), h=str(height), name="toonkit")
    stack = ElementTree.SubElement(image, "stack")
    # The document lists layers from the top down.
    groups = {name: ElementTree.SubElement(stack, "stack", _attributes(name)) for name in ("Ink", "Color")}
    parts: dict[str, bytes] = {}
    for key, kind, pixels in layers:
        source = f"data/{key}.png"
        parts[source] = encode_picture(pixels, ".png")
        attributes = {**_attributes(kind.name, _SVG[kind.blend]), "src": source, "x": "0", "y": "0"}
        groups["Ink" if kind.group == "Ink" else "Color"].insert(0, ElementTree.Element("layer", attributes))
    parts["stack.xml"] = ElementTree.tostring(image, encoding="UTF-8", xml_declaration=True)
    parts["mergedimage.png"] = encode_picture(layers.picture, ".png")
    parts["Thumbnails/thumbnail.png"] = encode_picture(_thumbnail(layers.picture), ".png")
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr(
            zipfile.ZipInfo("mimetype"), "image/openraster"
        )  # first and not compressed, to be recognized
        for name, data in parts.items():
            packed = zipfile.ZIP_DEFLATED if name.endswith(".xml") else zipfile.ZIP_STORED
            archive.writestr(zipfile.ZipInfo(name), data, packed)


def _attributes(name: str, composite: str = "svg:src-over") -> dict[str, str]:
    return {"name": name, "composite-op": composite, "opacity": "1.0", "visibility": "visible"}


def _thumbnail(picture: Pixels) -> Pixels:
    image = Image.fromarray(picture)
    image.thumbnail((THUMBNAIL_SIDE, THUMBNAIL_SIDE))
    return np.asarray(image)


def _photoshop_document(layers: Layers) -> PSDImage:
    try:
        from psd_tools import PSDImage  # noqa: PLC0415  # slow to load, and needed for this alone
        from psd_tools.constants import BlendMode  # noqa: PLC0415
    except ImportError as error:
        rule = "may end in .psd only where psd-tools is installed: pip install psd-tools"
        raise refuse("path", rule, f"{error}") from error
    blends = {"normal": BlendMode.NORMAL, "multiply": BlendMode.MULTIPLY, "add": BlendMode.LINEAR_DODGE}
    height, width = layers.picture.shape[:2]
    document = PSDImage.new("RGBA", (width, height))
    groups = {name: document.create_group(name=name) for name in ("Color", "Light", "Ink")}
    for _, kind, pixels in layers:
        layer = Image.fromarray(pixels)
        groups[kind.group].create_pixel_layer(layer, name=kind.name, blend_mode=blends[kind.blend])
    # A negative count says that the fourth channel is the transparency of the picture, and no channel of its own.
    info = document._record.layer_and_mask_information.layer_info
    info.layer_count = -abs(info.layer_count)
    return document

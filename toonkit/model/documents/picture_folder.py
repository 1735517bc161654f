"""A folder of pictures of one size, each a layer."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from toonkit._validation import refuse
from toonkit.model.decoding import MAX_BYTES, Pixels, check_size, read_pixels
from toonkit.model.documents.document import Document, Layer, LayerPixels
from toonkit.model.documents.pictures import picture_size, read_layer_picture
from toonkit.model.documents.roles import role_of
from toonkit.model.file_bytes import read_bytes

SUFFIXES = (".png", ".webp")

MERGED_NAMES = ("merged", "mergedimage", "composite", "flattened")
"""Names, without suffix, of the file that shows all layers together."""

DESCRIPTION = "layers.json"
"""The file that says how layers are composed: `toonkit relight --layers` writes one."""

MOST_LAYERS = 256

_ANALYSIS = "analysis.npz"


def open_folder(argument: str, folder: Path) -> Document:
    """
    Open a folder of layers, which are named like their files.

    It holds layers.json, or PNG and WebP files that are sorted by their names, the bottom first; numbers in them count
    as numbers. One may be named like the first of `MERGED_NAMES`; else the layers are put over one another. Raises
    `ToonkitError` if no file in it says that it holds layers, or they are not of one size.
    """
    files = sorted(
        (path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and path.name[0] != "."),
        key=_by_number,
    )
    merged = next((path for path in files if path.stem.lower() in MERGED_NAMES), None)
    blends: dict[str, Any] = {}
    if (folder / DESCRIPTION).is_file():
        files, merged, blends = _described(argument, folder)
    layers = [path for path in files if path != merged]
    named = any(role_of((path.stem,)) for path in layers)
    if not layers or (folder / _ANALYSIS).exists() or not (named or merged or blends):
        rule = "must be a folder of layers: pictures named lines and flats, or one named merged beside the layers"
        raise refuse(argument, rule, f"the folder {folder}")
    if len(layers) > MOST_LAYERS:
        raise refuse(argument, f"must be a folder of at most {MOST_LAYERS} layers", f"{len(layers)}")
    shapes = {path: picture_size(argument, _content(argument, path), str(path)) for path in layers}
    shape = shapes[layers[0]]
    check_size(argument, shape[1], shape[0])
    for path, other in shapes.items():
        if other != shape:
            shown = f"{path} of {other[1]} x {other[0]} beside {shape[1]} x {shape[0]}"
            raise refuse(argument, "must be a folder of layers of one size", shown)
    known = tuple(
        Layer(
            path.stem,
            (),
            shape[0] * shape[1],
            partial(_read_layer, argument, path),
            blends.get(path.name, "normal"),
        )
        for path in layers
    )
    if merged is not None:
        return Document(str(folder), known, partial(_read_merged, argument, merged, shape))
    if any(layer.blend != "normal" for layer in known):
        rule = f"must hold the picture that {DESCRIPTION} says its layers compose to"
        raise refuse(argument, rule, f"the folder {folder} without it")
    return Document(str(folder), known, partial(_put_together, known, shape))


def _described(argument: str, folder: Path) -> tuple[list[Path], Path | None, dict[str, Any]]:
    """Read layers.json: the files from the bottom to the top, the one they compose to, and their blend modes."""
    try:
        described = json.loads((folder / DESCRIPTION).read_text(encoding="utf-8"))
        names = [str(layer["file"]) for layer in described["layers"]]
        blends = {str(layer["file"]): str(layer.get("blend", "normal")) for layer in described["layers"]}
        composed = described.get("composed")
    except (OSError, RecursionError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise refuse(
            argument, f"must have a {DESCRIPTION} that lists layers", f"{folder} ({error})"
        ) from error
    outside = [name for name in (*names, composed or "") if Path(name).name != name]
    if outside:
        raise refuse(argument, f"must have a {DESCRIPTION} that names files beside it", outside[0])
    known = {name: blend if blend in ("normal", "multiply") else "other" for name, blend in blends.items()}
    return [folder / name for name in names], folder / composed if composed else None, known


def _by_number(path: Path) -> list[tuple[int, str]]:
    """Sort "layer 2" before "layer 10"."""
    parts = re.findall(r"\d{1,18}|\D+", path.name.lower())
    return [(int(part), "") if part[0].isdecimal() else (-1, part) for part in parts]


def _content(argument: str, path: Path) -> bytes:
    return read_bytes(argument, path, limit=MAX_BYTES, kind="a layer")[0]


def _read_layer(argument: str, path: Path) -> LayerPixels:
    return read_layer_picture(argument, _content(argument, path), str(path))


def _read_merged(argument: str, path: Path, shape: tuple[int, int]) -> Pixels:
    pixels = read_pixels(argument, path)
    if pixels.color.shape[:2] != shape:
        raise refuse(argument, "must be a folder of pictures of one size", f"{path} of another size")
    return pixels


def _put_together(layers: tuple[Layer, ...], shape: tuple[int, int]) -> Pixels:
    """Put layers over one another."""
    color, alpha = np.zeros((*shape, 3)), np.zeros((*shape, 1))
    for layer in layers:
        pixels = layer.read()
        share = pixels[..., 3:] / 255.0
        total = share + alpha * (1 - share)
        mixed = share * (pixels[..., :3] / 255.0) + alpha * (1 - share) * color
        color = np.divide(mixed, total, out=np.zeros_like(mixed), where=total > 0)
        alpha = total
    return Pixels(color, alpha[..., 0])

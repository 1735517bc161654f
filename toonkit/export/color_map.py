"""Color maps as files: a strip of pixels for engines and painters, JSON for exact values."""

from __future__ import annotations

import json

import numpy as np

from toonkit._validation import ToonkitError, of_type, refuse
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.export.picture import encode_picture
from toonkit.model.color_map import ColorMap
from toonkit.model.decoding import read_pixels
from toonkit.model.file_bytes import read_bytes
from toonkit.model.materials import Materials

STRIP_SIZE = (32, 512)
"""Height and width of a strip in pixels."""

MOST_JSON = 1 << 26
"""Bytes that a color map's JSON file may have."""

FORMAT_VERSION = 1


def write_color_map(color_map: ColorMap, path: PathLike) -> None:
    """
    Write a color map.

    Parameters
    ----------
    color_map : ColorMap
        M.
    path : path
        Ends in .json for its samples and domain, exactly; in .png for an 8-bit strip over all of the
        illumination, L · N = -1 in the leftmost column to +1 in the rightmost, which is what a shader reads
        at 0.5 + 0.5 L · N.

    Raises
    ------
    ToonkitError
        If the suffix is another or the file cannot be written.
    """
    of_type("color_map", color_map, ColorMap)
    suffix = suffix_of(path, (".png", ".json"))
    content = _json("toonkit color map", **_samples(color_map)) if suffix == ".json" else _strips([color_map])
    with atomic_write(path) as file:
        file.write(content)


def write_color_maps(materials: Materials, path: PathLike) -> None:
    """
    Write the color maps of several materials, that of the largest first.

    Parameters
    ----------
    materials : Materials
        Those of an analysis.
    path : path
        Ends in .json for a list of label, share of the object, whether it is flat, domain and samples of each; in .png for
        the strips of `write_color_map`, one below the other.

    Raises
    ------
    ToonkitError
        If the suffix is another or the file cannot be written.
    """
    of_type("materials", materials, Materials)
    if not materials.color_maps:
        raise refuse("materials", "must have a color map each", "none")
    suffix = suffix_of(path, (".png", ".json"))
    by_area = np.argsort(-materials.shares, kind="stable").tolist()
    if suffix == ".json":
        listed = [
            {
                "label": label,
                "share": float(materials.shares[label]),
                "flat": bool(materials.flat[label]),
                **_samples(materials.color_maps[label]),
            }
            for label in by_area
        ]
        content = _json("toonkit color maps", color_maps=listed)
    else:
        content = _strips([materials.color_maps[label] for label in by_area])
    with atomic_write(path) as file:
        file.write(content)


def read_color_map(path: PathLike) -> ColorMap:
    """
    Read a color map.

    Parameters
    ----------
    path : path
        A .json file of `write_color_map`; or a .png strip of one or more rows, painted by anyone: its middle row is
        read, from -1 at the left to +1 at the right.

    Returns
    -------
    ColorMap
        Exactly what was written to JSON; from a strip, one sample a column, rounded as the strip is.

    Raises
    ------
    ToonkitError
        If the file is missing, of another kind, or its colors do not go from dark to bright.
    """
    if suffix_of(path, (".png", ".json")) == ".png":
        strip = read_pixels("path", path, min_side=1).color
        return ColorMap(strip[len(strip) // 2])
    content, _ = read_bytes("path", path, limit=MOST_JSON, kind="a color map")
    try:
        found = json.loads(content)
    except (RecursionError, ValueError) as error:
        raise refuse("path", "must hold JSON", f"{path} ({error})") from error
    if not isinstance(found, dict) or found.get("format") != "toonkit color map":
        raise refuse("path", "must be a color map written by toonkit", f"{path}")
    version = found.get("version")
    if version != FORMAT_VERSION:
        raise refuse("path", f"must be of version {FORMAT_VERSION}", f"{path} of version {version}")
    try:
        return ColorMap(np.array(found["colors"], dtype=np.float64), tuple(found["domain"]))
    except (KeyError, OverflowError, TypeError, ToonkitError, ValueError) as error:
        raise refuse("path", "must hold colors and a domain", f"{path} ({error})") from error


def _json(kind: str, **content: object) -> bytes:
    header = {"format": kind, "version": FORMAT_VERSION, "encoding": "sRGB, 0 to 1"}
    return json.dumps({**header, **content}).encode() + b"\n"


def _samples(color_map: ColorMap) -> dict[str, object]:
    return {"domain": list(color_map.domain), "colors": color_map.colors.tolist()}


def _strips(color_maps: list[ColorMap]) -> bytes:
    """Return a PNG file of one strip for each color map, from top to bottom."""
    height, width = STRIP_SIZE
    rows = np.array([color_map(np.linspace(-1.0, 1.0, width)) for color_map in color_maps])
    return encode_picture(np.repeat(np.round(rows * 255).astype(np.uint8), height, axis=0), ".png")

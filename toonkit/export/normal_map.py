"""Normal maps as PNG files of 8 or 16 bits a channel."""

from __future__ import annotations

from typing import Literal

from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.export.picture import encode_png
from toonkit.model.normals import GreenAxis, NormalField, encode_normal_map


def write_normal_map(
    normals: NormalField, path: PathLike, *, bits: Literal[8, 16] = 8, green: GreenAxis = "opengl"
) -> None:
    """
    Write normals as a normal map.

    Parameters
    ----------
    normals : NormalField
        The normals; outside their mask the map is flat.
    path : path
        Ends in .png. An older file is replaced once the new one is complete.
    bits : {8, 16}, optional
        Bits a channel. Eight turn a normal by up to half a degree, sixteen by less than 0.002 degrees.
    green : {"opengl", "directx"}, optional
        Green up (OpenGL, Unity, Blender, Godot) or down (DirectX, Unreal).

    Raises
    ------
    ToonkitError
        If `bits`, `green` or the suffix is none of these, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    colors = encode_normal_map(normals, bits=bits, green=green)
    encoded = encode_png(colors)
    with atomic_write(path) as file:
        file.write(encoded)

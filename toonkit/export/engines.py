"""Normal maps as game engines and renderers read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from toonkit._validation import of_type, one_of
from toonkit.analysis import ToonAnalysis
from toonkit.export.atomic import PathLike
from toonkit.export.normal_map import write_normal_map
from toonkit.model.normals import GreenAxis

BLEED = 16
"""Pixels by which normals go on outside the object by default: enough for four mipmap levels."""


SUFFIX = "_n"
"""What the name of a normal map has after that of its sprite, as SpriteIlluminator and the tools after it write it."""


@dataclass(frozen=True)
class Engine:
    """
    What a program expects of a normal map.

    In all of them red points right, a component from -1 to 1 fills the whole range of a channel, and flat is (0, 0, 1),
    which 8 bits store as (128, 128, 255).

    Attributes
    ----------
    green : {"opengl", "directx"}
        Which way green points: up or down.
    bits : {8, 16}
        Bits a channel that it makes use of. Engines compress textures from 8 bits; a renderer reads 16.
    page : str
        Where that is documented.
    """

    green: GreenAxis
    bits: Literal[8, 16]
    page: str


ENGINES = {
    # "Godot expects the normal map to use X+, Y+, and Z+ coordinates."
    "godot": Engine("opengl", 8, "https://docs.godotengine.org/en/stable/classes/class_canvastexture.html"),
    # "Unity uses Y+ normal maps, known as OpenGL format."
    "unity": Engine("opengl", 8, "https://unity.huh.how/textures/normal-map-format.html"),
    # Unreal reads DirectX maps, in which green points down.
    "unreal": Engine(
        "directx", 8, "https://www.strayspark.studio/blog/directx-vs-opengl-normal-maps-explained"
    ),
    # "Blender uses the OpenGL convention by default", in an image texture set to Non-Color.
    "blender": Engine(
        "opengl",
        16,
        "https://docs.blender.org/manual/en/latest/render/shader_nodes/displacement/normal_map.html",
    ),
    # Cocos2d-x reads what SpriteIlluminator writes: the suffix _n, blue from 128 to 255.
    "cocos": Engine("opengl", 8, "https://www.codeandweb.com/spriteilluminator/documentation/export"),
    # The shader of a material decides; those in use follow OpenGL.
    "defold": Engine(
        "opengl", 8, "https://forum.defold.com/t/normal-map-lighting-for-2d-pixel-art-sprites/70967"
    ),
}
"""The programs by name."""


def write_engine_normal_map(
    analysis: ToonAnalysis, path: PathLike, engine: str, *, bleed: float = BLEED
) -> None:
    """
    Write the normal map of a drawing as one engine expects it, with the alpha of the drawing.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    path : path
        Ends in .png; by custom the name of the sprite and `SUFFIX`. An older file is replaced.
    engine : str
        A key of `ENGINES`: "godot", "unity", "unreal", "blender", "cocos" (SpriteIlluminator too) or "defold".
    bleed : float, optional
        Pixels by which the normals of the rim go on outward, as in `write_normal_map`.

    Raises
    ------
    ToonkitError
        If an argument breaks these rules, or the file cannot be written.
    """
    of_type("analysis", analysis, ToonAnalysis)
    one_of("engine", engine, ENGINES)
    preset = ENGINES[engine]
    write_normal_map(
        analysis.normals,
        path,
        bits=preset.bits,
        green=preset.green,
        alpha=analysis.image.alpha,
        bleed=bleed,
    )

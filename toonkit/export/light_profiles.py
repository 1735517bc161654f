"""Light profiles: a drawing lit from five sides, from which sprite-lighting tools compute normals of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import of_type
from toonkit.analysis import ToonAnalysis
from toonkit.export.atomic import PathLike
from toonkit.export.folder import make_folder
from toonkit.export.picture import write_picture
from toonkit.model.image import ToonImage
from toonkit.model.light import light_direction
from toonkit.model.shading import illumination
from toonkit.relighting import RelightOptions, relight

PROFILE_LIGHTS = {
    "left": (180.0, 0.0),
    "right": (0.0, 0.0),
    "top": (90.0, 0.0),
    "bottom": (270.0, 0.0),
    "front": (0.0, 90.0),
}
"""Azimuth and elevation, in degrees, of the light of each profile."""


def light_profiles(
    analysis: ToonAnalysis, *, color: bool = False, **options: Unpack[RelightOptions]
) -> dict[str, NDArray[np.uint8]]:
    """
    Light a drawing from the left, the right, the top, the bottom and the front.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    color : bool, optional
        False gives the surface in plain gray, True the relit drawing.
    **options
        Those of `relight`, for relit drawings.

    Returns
    -------
    dict of str to ndarray of uint8, shape (H, W, 4)
        For each key of `PROFILE_LIGHTS` a picture with the alpha of the drawing.

    Raises
    ------
    ToonkitError
        As `relight` does.

    Notes
    -----
    Gray is max(0, L · N), stored as it is: right minus left is N_x, top minus bottom N_y, and front N_z.
    """
    of_type("analysis", analysis, ToonAnalysis)
    profiles = {}
    for name, angles in PROFILE_LIGHTS.items():
        light = light_direction(*angles)
        if color:
            picture = relight(analysis, light, **options)
        else:
            lit = np.maximum(illumination(analysis.normals, light), 0.0)
            gray = np.repeat(lit[..., None], 3, axis=-1)
            picture = ToonImage(gray, analysis.image.mask, alpha=analysis.image.alpha)
        profiles[name] = picture.to_rgba()
    return profiles


def write_light_profiles(
    analysis: ToonAnalysis, folder: PathLike, **options: Unpack[RelightOptions]
) -> list[Path]:
    """
    Write the light profiles of a drawing, gray and relit.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    folder : path
        Created if need be. It gets left.png, right.png, top.png, bottom.png and front.png in gray, and left_color.png and
        so on in color.
    **options
        Those of `relight`.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ToonkitError
        As `relight` does, or if the folder cannot be written to.
    """
    target = make_folder(folder)
    written = []
    gray = light_profiles(analysis)
    relit = light_profiles(analysis, color=True, **options)
    for suffix, profiles in (("", gray), ("_color", relit)):
        for name, pixels in profiles.items():
            write_picture(pixels, target / f"{name}{suffix}.png")
            written.append(target / f"{name}{suffix}.png")
    return written

"""Lights as they are typed: AZIMUTH,ELEVATION in degrees, and their colors as #RRGGBB."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from toonkit._validation import refuse

if TYPE_CHECKING:
    from toonkit._validation import FloatArray


def parse_light(text: str, *, behind: bool = False) -> FloatArray:
    """Return the direction, shape (3,), of a light typed as AZIMUTH,ELEVATION; raises `ToonkitError` for anything else."""
    from toonkit.model.light import direction_of  # noqa: PLC0415

    return direction_of("--light", parse_angles(text), behind=behind)


def parse_angles(text: str, option: str = "--light") -> tuple[float, float]:
    """Return azimuth and elevation, degrees, as typed for an option; raises `ToonkitError` for anything else."""
    try:
        azimuth, elevation = (float(part) for part in text.split(","))
    except ValueError:
        raise refuse(option, "must be AZIMUTH,ELEVATION in degrees, such as 135,45", repr(text)) from None
    return azimuth, elevation


def parse_color(text: str) -> tuple[float, float, float]:
    """Return a color, sRGB in [0, 1], typed as #RRGGBB; raises `ToonkitError` for anything else."""
    from toonkit.model.luminance import color_of_hex  # noqa: PLC0415

    if not re.fullmatch(r"#?[0-9a-fA-F]{6}", text):
        raise refuse("--light-color", "must be #RRGGBB, such as #ffc080", repr(text))
    return color_of_hex(text)

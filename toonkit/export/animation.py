"""Animated pictures: frames as they are, and a light that circles the object or travels from light to light."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from toonkit._validation import FloatArray, check_callable, is_count, is_number, of_type, refuse, warn
from toonkit.analysis import ToonAnalysis
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.model.frame_files import Timing
from toonkit.model.light import light_angles, light_direction
from toonkit.model.light_path import MOST_FRAMES, light_path
from toonkit.relighting import RelightOptions, relight

FRAME_MILLISECONDS = 60
"""How long a frame is shown: 36 frames take about two seconds."""

ANIMATED = (".gif", ".webp", ".apng", ".png")
"""Suffixes of animations."""

_STEEPEST = 60.0  # degrees: a light at the viewer's eye would circle without any change
_SHALLOWEST = 15.0
_PALETTE_SAMPLES = 8
_PALETTE_SIDE = 256
_GIF_COLORS = 255  # one of 256 is left for transparency


def write_orbit(
    analysis: ToonAnalysis,
    path: PathLike,
    *,
    frames: int = 36,
    elevation: float | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[RelightOptions],
) -> None:
    """
    Write an endless animation of the light going once around the object.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    path : path
        Ends in .gif (256 colors, hard outline), .webp, .apng or .png (an APNG); all but GIF are lossless with
        soft alpha.
    frames : int, optional
        Number of frames, 2 to 720.
    elevation : float, optional
        Degrees, -90 to 90, below 0 for a light that circles behind the picture; by default that of the analyzed light,
        kept within 15 to 60.
    progress : callable, optional
        Called with the fraction done, 0..1, after each frame.
    **options
        Those of `relight`.

    Raises
    ------
    ToonkitError
        If an argument breaks these rules or the file cannot be written.

    Notes
    -----
    The first frame has the azimuth of the analyzed light, which then turns counter-clockwise.
    """
    suffix = suffix_of(path, ANIMATED)
    of_type("analysis", analysis, ToonAnalysis)
    check_callable("progress", progress)
    if not is_count(frames, 2, MOST_FRAMES):
        raise refuse("frames", f"must be a whole number from 2 to {MOST_FRAMES}", frames)
    azimuth, analyzed_elevation = light_angles(analysis.light)
    if elevation is None:
        elevation = min(max(analyzed_elevation, _SHALLOWEST), _STEEPEST)
    elif not is_number(elevation) or not -90 <= elevation <= 90:
        raise refuse("elevation", "must lie in -90 to 90 degrees", elevation)
    azimuths = azimuth + np.arange(frames) * (360 / frames)
    lights = np.array([light_direction(float(turned), elevation) for turned in azimuths])
    _write_lights(analysis, path, suffix, lights, loops=0, progress=progress, options=options)


def write_light_path(
    analysis: ToonAnalysis,
    path: PathLike,
    lights: Sequence[ArrayLike] | ArrayLike,
    *,
    frames: int = 36,
    loop: bool = True,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[RelightOptions],
) -> None:
    """
    Write an animation of the light traveling from one light to the next.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    path : path
        As in `write_orbit`.
    lights : sequence of array_like
        Two or more lights in the order of travel, as in `toonkit.model.light_path.light_path`.
    frames : int, optional
        Number of frames, 2 to 720.
    loop : bool, optional
        Whether the light returns to the first one, in an endless animation; otherwise the animation plays once and ends at
        the last one.
    progress : callable, optional
        Called with the fraction done, 0..1, after each frame.
    **options
        Those of `relight`.

    Raises
    ------
    ToonkitError
        If an argument breaks these rules or the file cannot be written.
    """
    suffix = suffix_of(path, ANIMATED)
    of_type("analysis", analysis, ToonAnalysis)
    check_callable("progress", progress)
    directions = light_path(lights, frames, loop=loop)
    _write_lights(
        analysis, path, suffix, directions, loops=0 if loop else 1, progress=progress, options=options
    )


def _write_lights(
    analysis: ToonAnalysis,
    path: PathLike,
    suffix: str,
    lights: FloatArray,
    *,
    loops: int,
    progress: Callable[[float], None] | None,
    options: RelightOptions,
) -> None:
    """Write one frame for each light (n, 3)."""
    frames = len(lights)

    def picture(index: int) -> Image.Image:
        return Image.fromarray(relight(analysis, lights[index], **options).to_rgba())

    def pictures() -> Iterator[Image.Image]:
        for index in range(frames):
            yield picture(index)
            if progress is not None:
                progress((index + 1) / frames)

    timing = Timing((FRAME_MILLISECONDS,) * frames, loops)
    with atomic_write(path) as file:  # first of all: a place that cannot be written to costs no painting
        if suffix == ".gif":
            samples = range(0, frames, max(1, frames // _PALETTE_SAMPLES))
            palette = _common_palette([picture(index) for index in samples])
            file.write(_encode_gif(pictures(), palette, timing))
        else:
            file.write(_encode(pictures(), suffix, timing))


def write_animation(frames: Sequence[NDArray[np.uint8]], timing: Timing, path: PathLike) -> None:
    """
    Write frames as an animation.

    Parameters
    ----------
    frames : sequence of ndarray of uint8, shape (h, w, 4)
        RGBA with straight alpha, all of one size.
    timing : Timing
        How long each is shown.
    path : path
        Ends in .gif (256 colors for all frames, pixels opaque or not), .webp, .apng or .png (an APNG); all but GIF are
        lossless. Frames that are the same as the one before make that one longer.

    Raises
    ------
    ToonkitError
        If the frames are no such arrays, or the file cannot be written.

    Warns
    -----
    ToonkitWarning
        If pixels are less than half opaque and the format is GIF, which drops them.
    """
    suffix = suffix_of(path, ANIMATED)
    of_type("timing", timing, Timing)
    if (
        len(frames) == 0
        or len(frames) != len(timing.milliseconds)
        or len({frame.shape for frame in frames}) > 1
    ):
        shown = f"{len(frames)} for {len(timing.milliseconds)} times"
        raise refuse("frames", "must be one or more of one size, with a time each", shown)
    pictures = [Image.fromarray(frame) for frame in frames]
    with atomic_write(path) as file:
        if suffix != ".gif":
            file.write(_encode(iter(pictures), suffix, timing))
            return
        faint = sum(int(np.count_nonzero((frame[..., 3] > 0) & (frame[..., 3] < 128))) for frame in frames)
        if faint:
            warn(
                "path", f"GIF drops {faint:,} pixels that are less than half opaque; WebP and APNG keep them"
            )
        file.write(_encode_gif(iter(pictures), _common_palette(pictures), timing))


def _encode(pictures: Iterator[Image.Image], suffix: str, timing: Timing) -> bytes:
    return _encode_webp(pictures, timing) if suffix == ".webp" else _encode_apng(pictures, timing)


def _encode_webp(pictures: Iterator[Image.Image], timing: Timing) -> bytes:
    encoded = io.BytesIO()
    next(pictures).save(
        encoded,
        "WEBP",
        save_all=True,
        append_images=pictures,
        duration=list(timing.milliseconds),
        loop=timing.loops,
        lossless=True,
    )
    return encoded.getvalue()


def _encode_apng(pictures: Iterator[Image.Image], timing: Timing) -> bytes:
    encoded = io.BytesIO()
    first, *others = pictures  # Pillow goes through them twice
    first.save(
        encoded,
        "PNG",
        save_all=True,
        append_images=others,
        duration=list(timing.milliseconds),
        loop=timing.loops,
        blend=0,  # each frame replaces the one before, alpha included
    )
    return encoded.getvalue()


def _common_palette(samples: list[Image.Image]) -> Image.Image:
    """One palette for all frames, so that a color that stays does not flicker."""
    small = [sample.copy() for sample in samples]
    for image in small:
        image.thumbnail((_PALETTE_SIDE, _PALETTE_SIDE), Image.Resampling.NEAREST)
    painted = np.concatenate([_opaque_colors(image) for image in small])
    strip = Image.fromarray(painted[None])
    return strip.quantize(_GIF_COLORS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _opaque_colors(image: Image.Image) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    rgba = np.asarray(image)
    colors: np.ndarray[tuple[int, ...], np.dtype[np.uint8]] = rgba[rgba[..., 3] >= 128][:, :3]
    return colors


def _encode_gif(pictures: Iterator[Image.Image], palette: Image.Image, timing: Timing) -> bytes:
    encoded = io.BytesIO()
    indexed = (_to_palette(picture, palette) for picture in pictures)
    # What has no count is shown once; browsers take a count of 1 for once more.
    count = {} if timing.loops == 1 else {"loop": timing.loops}
    next(indexed).save(
        encoded,
        "GIF",
        save_all=True,
        append_images=indexed,
        duration=list(timing.milliseconds),
        **count,
        disposal=2,  # back to transparent: the outline does not move, but shadows of partial frames would
        transparency=_GIF_COLORS,
        optimize=False,  # or the palette is reordered and the transparent index with it
    )
    return encoded.getvalue()


def _to_palette(picture: Image.Image, palette: Image.Image) -> Image.Image:
    indexed = picture.convert("RGB").quantize(palette=palette, dither=Image.Dither.NONE)
    index = np.asarray(indexed).copy()
    index[np.asarray(picture)[..., 3] < 128] = _GIF_COLORS
    hard = Image.fromarray(index)
    colors = (palette.getpalette() or [])[: 3 * _GIF_COLORS]
    hard.putpalette(colors + [0] * (768 - len(colors)))
    return hard

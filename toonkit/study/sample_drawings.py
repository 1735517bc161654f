"""The sample drawings that ship with toonkit, drawn from the study's shapes and ramps.

`python -m toonkit.study.sample_drawings` writes them anew, byte for byte the same.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt, gaussian_filter, label, rotate

from toonkit._validation import BoolArray, FloatArray
from toonkit.export.atomic import atomic_write
from toonkit.model.image import nearest_object_pixel
from toonkit.model.light import light_direction
from toonkit.model.shading import illumination
from toonkit.samples import FOLDER
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import RenderedShape, render_shape
from toonkit.study.shapes import SHAPES

SIZE = 640
OVERSAMPLING = 3
"""Drawn three times as large and reduced: outlines and band edges are then mixed as drawing programs mix them."""

PEN_WIDTH = 3.2
"""Of the ink line, in pixels of the sample."""

INK = np.array([0.13, 0.09, 0.14])


@dataclass(frozen=True)
class Sample:
    """
    One drawing.

    Attributes
    ----------
    name, title : str
        Its file name and what the dashboard calls it.
    shape : str
        Name in `SHAPES`.
    ramp : str or mapping
        Name of the color map, or one for each material of the shape.
    light : (float, float)
        Azimuth and elevation in degrees.
    shows : str
        What it is a sample of.
    ink : bool
        Whether lines are drawn along outlines, folds and materials.
    brush : float
        Strength of the brush texture, in sRGB; 0 is none.
    """

    name: str
    title: str
    shape: str
    ramp: str | Mapping[str, str]
    light: tuple[float, float]
    shows: str
    ink: bool = False
    brush: float = 0.0


SAMPLES = (
    Sample("cat", "Sunset cat", "cat", "sunset", (130, 42), "three tones with hue-shifted shadows"),
    Sample("duck", "Lemon duck", "duck", "teal_lemon", (115, 38), "two hard tones"),
    Sample(
        "rabbit",
        "Inked rabbit",
        "rabbit",
        {"fur": "skin_cel", "nose": "velvet", "eyes": "steel_rim", "tail": "porcelain"},
        (135, 35),
        "line art",
        ink=True,
    ),
    Sample("donut", "Candy donut", "torus", "candy", (130, 42), "four tones on a shape with a hole"),
    Sample("pear", "Peach pear", "pear", "peach_soft", (50, 42), "soft, painterly transitions"),
    Sample(
        "mushroom",
        "Toadstool",
        "mushroom",
        {"stem": "peach_soft", "cap": "cherry_gloss", "spots": "porcelain"},
        (125, 45),
        "several materials",
    ),
    Sample("fish", "Brushed fish", "fish", "watercolor", (60, 45), "brush strokes", brush=0.03),
    Sample("ghost", "Pale ghost", "drapery", "pastel_mist", (130, 42), "pastel tones of low contrast"),
)


def draw_sample(sample: Sample, *, size: int = SIZE) -> FloatArray:
    """
    Draw a sample.

    Parameters
    ----------
    sample : Sample
        What to draw.
    size : int, optional
        Side of the picture in pixels.

    Returns
    -------
    ndarray, shape (size, size, 4)
        sRGB and straight alpha in [0, 1].
    """
    large = render_shape(SHAPES[sample.shape], size * OVERSAMPLING)
    color = _painted(sample, large)
    if sample.brush:
        color = color + sample.brush * _brush_texture(color.shape[0])[..., None]
    if sample.ink:
        lines = _line_coverage(large, PEN_WIDTH * OVERSAMPLING * size / SIZE)
        color = color + lines[..., None] * (INK - color)
    # Color under partly covered pixels: what the nearest object pixel has.
    rows, columns = nearest_object_pixel(large.mask)
    color = np.clip(color[rows, columns], 0.0, 1.0)
    alpha = _reduced(large.coverage)
    weighted = np.stack(
        [_reduced(channel * large.coverage) for channel in np.moveaxis(color, -1, 0)], axis=-1
    )
    plain = np.stack([_reduced(channel) for channel in np.moveaxis(color, -1, 0)], axis=-1)
    covered = alpha[..., None] > 0
    straight = np.where(covered, weighted / np.where(covered, alpha[..., None], 1.0), plain)
    return np.concatenate([np.where(covered, straight, 0.0), alpha[..., None]], axis=-1)


def write_samples(folder: Path, samples: Sequence[Sample] = SAMPLES, *, size: int = SIZE) -> Iterator[Path]:
    """
    Draw samples into a folder, which is made if need be, and `samples.json` beside them.

    Parameters
    ----------
    folder : Path
        Where to.
    samples : sequence of Sample, optional
        What to draw.
    size : int, optional
        Side of the pictures in pixels.

    Yields
    ------
    Path
        Each picture once it is written; the list comes last.

    Raises
    ------
    ToonkitError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for sample in samples:
        path = folder / f"{sample.name}.png"
        with atomic_write(path) as file:
            Image.fromarray(to_bytes(draw_sample(sample, size=size))).save(file, format="PNG", optimize=True)
        yield path
    records = [
        {"name": sample.name, "title": sample.title, "light": list(sample.light), "shows": sample.shows}
        for sample in samples
    ]
    with atomic_write(folder / "samples.json") as file:
        file.write((json.dumps(records, indent=1) + "\n").encode())


def to_bytes(picture: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Round a picture in [0, 1] to 8 bits."""
    return np.round(picture * 255).astype(np.uint8)


def _painted(sample: Sample, shape: RenderedShape) -> FloatArray:
    light = illumination(shape.normals, light_direction(*sample.light))
    color_maps = load_color_maps()
    if isinstance(sample.ramp, str):
        return color_maps[sample.ramp](light)
    color = np.full((*light.shape, 3), np.nan)
    for part, material in enumerate(SHAPES[sample.shape].materials):
        where = shape.part == part
        color[where] = color_maps[sample.ramp[material]](light[where])
    return color


def _brush_texture(size: int) -> FloatArray:
    """Strokes from the lower left to the upper right: noise of unit deviation, stretched along them."""
    noise = np.random.default_rng(7).normal(size=(size * 3 // 2, size * 3 // 2))
    strokes = gaussian_filter(noise, (1.6 * OVERSAMPLING, 14 * OVERSAMPLING))
    turned = rotate(strokes, 32, reshape=False, order=1)
    start = size // 4
    texture = turned[start : start + size, start : start + size]
    unit: FloatArray = texture / texture.std()
    return unit


def _line_coverage(shape: RenderedShape, width: float) -> FloatArray:
    """How much of each pixel is ink, 0 or 1: the pen's width inside the outline, and along folds and materials."""
    lines = np.zeros_like(shape.mask)
    for axis in (0, 1):
        lines |= _jumps(shape, axis)
    labels, count = label(lines, structure=np.ones((3, 3)))
    short = np.flatnonzero(np.bincount(labels.ravel(), minlength=count + 1) < 6 * width)
    lines &= ~np.isin(labels, short)
    # The outline lies inside the object, a line within the object on both its sides.
    inked = distance_transform_edt(shape.mask) < width
    if lines.any():
        inked |= distance_transform_edt(~lines) < width / 2
    return np.where(shape.mask, inked.astype(np.float64), 0.0)


def _jumps(shape: RenderedShape, axis: int) -> BoolArray:
    """Where depth, orientation or material changes abruptly from one pixel to the next along an axis."""
    depth = np.nan_to_num(shape.depth)
    vectors = np.nan_to_num(shape.normals.vectors)
    step = np.abs(depth - np.roll(depth, 1, axis))
    turn = np.sum(vectors * np.roll(vectors, 1, axis), axis=-1)
    other = shape.part != np.roll(shape.part, 1, axis)
    both = shape.mask & np.roll(shape.mask, 1, axis)
    # A surface as steep as that turns away from the viewer: what follows lies behind it.
    jumps: BoolArray = both & ((step > 0.005 * len(depth)) | (turn < np.cos(np.deg2rad(40))) | other)
    return jumps


def _reduced(channel: FloatArray) -> FloatArray:
    size = channel.shape[0] // OVERSAMPLING
    blocks: FloatArray = channel.reshape(size, OVERSAMPLING, size, OVERSAMPLING).mean(axis=(1, 3))
    return blocks


def main() -> None:
    """Write the samples into the package, or where `-o` says."""
    parser = argparse.ArgumentParser(description="Draw toonkit's sample drawings.")
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, metavar="DIR")
    for path in write_samples(parser.parse_args().output):
        print(path, flush=True)


if __name__ == "__main__":
    main()

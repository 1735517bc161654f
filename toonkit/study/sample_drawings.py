"""The sample drawings that ship with toonkit: inked ones in several materials, and shapes of the study in its ramps.

`python -m toonkit.study.sample_drawings` writes them anew, byte for byte the same.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter, rotate

from toonkit._validation import FloatArray
from toonkit.export.atomic import atomic_write
from toonkit.model.image import nearest_object_pixel
from toonkit.model.light import light_direction
from toonkit.model.shading import illumination
from toonkit.samples import FOLDER
from toonkit.study.color_maps import load_color_maps
from toonkit.study.inked_samples import SampleScene, draw_sample_scene
from toonkit.study.rendering import render_shape
from toonkit.study.sample_scenes import CAT, DONUT, ROCKET, TOADSTOOL, WITCH
from toonkit.study.shapes import SHAPES

SIZE = 640
"""Side of a painted solid's picture in pixels."""

INKED_SIZE = 512
"""Side of an inked picture in pixels."""

OVERSAMPLING = 3
"""Factor of supersampling. Outlines and band edges are then anti-aliased as in drawing programs."""


@dataclass(frozen=True)
class PaintedSolid:
    """
    A shape of the study in one material.

    Attributes
    ----------
    shape : str
        Name in `SHAPES`.
    ramp : str
        Name of the color map.
    brush : float
        Strength of the brush texture, in sRGB; 0 is none.
    """

    shape: str
    ramp: str
    brush: float = 0.0


@dataclass(frozen=True)
class Sample:
    """
    One drawing.

    Attributes
    ----------
    name, title : str
        Its file name, and its title in the dashboard.
    scene : SampleScene or PaintedSolid
        What is drawn: in several materials and ink, or in one material.
    light : (float, float)
        Azimuth and elevation in degrees.
    shows : str
        What the sample demonstrates.
    """

    name: str
    title: str
    scene: SampleScene | PaintedSolid
    light: tuple[float, float]
    shows: str

    @property
    def size(self) -> int:
        """Side of the picture in pixels."""
        return INKED_SIZE if isinstance(self.scene, SampleScene) else SIZE


SAMPLES = (
    Sample("cat", "Tabby cat", CAT, (130, 42), "nine materials and ink"),
    Sample("witch", "Little witch", WITCH, (125, 45), "a soft gradient, and flat white cuffs"),
    Sample("donut", "Glazed donut", DONUT, (125, 45), "highlights, and flat sprinkles"),
    Sample("mushroom", "Toadstool", TOADSTOOL, (125, 45), "a gradient, and flat spots"),
    Sample("rocket", "Rocket", ROCKET, (120, 45), "hard tones, and a flat flame"),
    Sample("duck", "Lemon duck", PaintedSolid("duck", "teal_lemon"), (115, 38), "two hard tones, no ink"),
    Sample("pear", "Peach pear", PaintedSolid("pear", "peach_soft"), (50, 42), "soft, painterly transitions"),
    Sample("fish", "Brushed fish", PaintedSolid("fish", "watercolor", 0.03), (60, 45), "brush strokes"),
)


def draw_sample(sample: Sample, *, size: int | None = None) -> FloatArray:
    """
    Draw a sample.

    Parameters
    ----------
    sample : Sample
        What to draw.
    size : int, optional
        Side of the picture in pixels; the sample's own by default.

    Returns
    -------
    ndarray, shape (size, size, 4)
        sRGB and straight alpha in [0, 1].
    """
    size, light = size or sample.size, light_direction(*sample.light)
    if isinstance(sample.scene, SampleScene):
        return draw_sample_scene(sample.scene, light, size=size).image.to_rgba() / 255.0
    return _draw_solid(sample.scene, light, size)


def _draw_solid(scene: PaintedSolid, light: FloatArray, size: int) -> FloatArray:
    large = render_shape(SHAPES[scene.shape], size * OVERSAMPLING)
    color = load_color_maps()[scene.ramp](illumination(large.normals, light))
    if scene.brush:
        color = color + scene.brush * _brush_texture(color.shape[0])[..., None]
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


def write_samples(
    folder: Path, samples: Sequence[Sample] = SAMPLES, *, size: int | None = None
) -> Iterator[Path]:
    """
    Draw samples into a folder, which is created if necessary, and write `samples.json` beside them.

    Parameters
    ----------
    folder : Path
        The folder.
    samples : sequence of Sample, optional
        What to draw.
    size : int, optional
        Side of the pictures in pixels; each sample's own by default.

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


def _brush_texture(size: int) -> FloatArray:
    """Strokes from the lower left to the upper right: noise of unit deviation, stretched along them."""
    noise = np.random.default_rng(7).normal(size=(size * 3 // 2, size * 3 // 2))
    strokes = gaussian_filter(noise, (1.6 * OVERSAMPLING, 14 * OVERSAMPLING))
    turned = rotate(strokes, 32, reshape=False, order=1)
    start = size // 4
    texture = turned[start : start + size, start : start + size]
    unit: FloatArray = texture / texture.std()
    return unit


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

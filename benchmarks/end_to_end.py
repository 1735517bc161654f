"""From a drawing's file to the files of its analysis, beside the analysis alone.

    python -m benchmarks.end_to_end -o benchmarks/results/end_to_end.csv

Enlarges a sample, and does with it in a warm process what `toonkit analyze FILE -o OUT` does, in turn with the analysis of
the picture when it is loaded. Machines are noisy: the ratio is the median over pairs that ran one after the other. Writes
one row for each sample, size and kind of light: estimated, as the command does unless it is told the light, or given.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

import toonkit
from benchmarks.shape_rows import Row
from benchmarks.speed import again, peak_bytes, timed
from toonkit.cli.drawing_work import ESTIMATED, DrawingWork, analyze_drawing
from toonkit.export.folder import ARCHIVE_NAME
from toonkit.export.picture import write_picture
from toonkit.samples import sample_light, sample_names, sample_path

SIZES = (512, 1024, 2048, 4096)
WARM = 256
"""Side of the drawing with which the process is made warm."""

FEW = 2048
"""Side from which on one pair less is run."""


def enlarged(name: str, size: int, folder: Path) -> Path:
    """Write a sample at another size."""
    with Image.open(sample_path(name)) as picture:
        pixels = picture.convert("RGBA").resize((size, size), Image.Resampling.BICUBIC)
    path = folder / f"{name}.png"
    write_picture(np.asarray(pixels), path)
    return path


def measured(name: str, size: int, *, given: bool, pairs: int) -> Row:
    """Time and memory of one drawing, from file to files and of the analysis alone."""
    light = sample_light(name) if given else None
    typed = ESTIMATED if light is None else f"{light[0]},{light[1]}"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)

        def from_file_to_files(path: Path) -> None:
            analyze_drawing(DrawingWork(name, path, typed), folder / "analysis")

        from_file_to_files(enlarged(name, WARM, folder))
        path = enlarged(name, size, folder)
        image = toonkit.load_image(path)

        def alone() -> None:
            toonkit.analyze(again(image), light)

        times = [(timed(lambda: from_file_to_files(path)), timed(alone)) for _ in range(pairs)]
        whole, analysis = zip(*times, strict=True)
        peak, own_peak = peak_bytes(lambda: from_file_to_files(path)), peak_bytes(alone)
        object_pixels = int(image.mask.sum())
        archive = (folder / "analysis" / ARCHIVE_NAME).stat().st_size
    # What the picture itself takes is there before an analysis of it begins.
    picture = sum(part.nbytes for part in (image.pixels, image.mask, image.alpha))
    return {
        "drawing": name,
        "size": size,
        "light": "given" if given else "estimated",
        "object_share": object_pixels / size**2,
        "seconds": float(np.median(whole)),
        "analysis_seconds": float(np.median(analysis)),
        "ratio": float(np.median(np.divide(whole, analysis))),
        "peak_bytes_per_pixel": peak / size**2,
        "analysis_peak_bytes_per_pixel": (own_peak + picture) / size**2,
        "archive_bytes_per_object_pixel": archive / object_pixels,
    }


def table(rows: pd.DataFrame) -> str:
    """One line per size and kind of light, as a Markdown table."""
    lines = [
        "| size | light | from file to files | analysis alone | ratio | peak memory per pixel | archive per object pixel |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.size}² | {row.light} | {row.seconds:.1f} s | {row.analysis_seconds:.1f} s | {row.ratio:.1f} "
        f"| {row.peak_bytes_per_pixel:.0f} B | {row.archive_bytes_per_object_pixel:.1f} B |"
        for row in rows.itertuples(index=False)
    ]
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="From a drawing's file to the files of its analysis.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per drawing and size")
    parser.add_argument("--samples", nargs="+", default=["cat"], choices=sample_names(), metavar="SAMPLE")
    parser.add_argument("--sizes", nargs="+", type=int, default=list(SIZES), metavar="PIXELS")
    parser.add_argument("--lights", nargs="+", default=["estimated", "given"], choices=["estimated", "given"])
    parser.add_argument("--pairs", type=int, default=3, help="runs of each (default: 3)")
    given = parser.parse_args(arguments)
    rows = pd.DataFrame(
        measured(name, size, given=light == "given", pairs=max(given.pairs - (size >= FEW), 1))
        for name in given.samples
        for light in given.lights
        for size in given.sizes
    )
    print(rows.to_string(index=False, float_format="{:.2f}".format))
    if given.output is not None:
        rows.round(4).to_csv(given.output, index=False)


if __name__ == "__main__":
    main()

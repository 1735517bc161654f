"""Speed and memory of the analysis, side by side in one process.

    python -m benchmarks.speed -o benchmarks/results/speed.csv

For each size: a disc and the silhouette of a cat, painted in four soft tones. Medians over repeats after one warm-up run, so
that compiling and caching do not count. Machines are noisy: read the times as ratios to those beside them.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.ndimage import zoom
from tqdm import tqdm

import toonkit
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES

LIGHT = toonkit.light_direction(129, 50)
NEW_LIGHT = toonkit.light_direction(20, 40)
RENDERED = 256
"""Side at which the silhouettes are rendered; larger ones are interpolated from it, which speed does not mind."""

Row = dict[str, str | float]


def drawing(shape: str, size: int) -> toonkit.ToonImage:
    truth = render_shape(SHAPES[shape], min(RENDERED, size))
    color_map = load_color_maps()["lilac_soft"]
    factor = size / truth.mask.shape[0]
    vectors = np.nan_to_num(truth.normals.vectors) + np.array([0.0, 0.0, 1e-6])
    vectors = np.stack([zoom(part, factor, order=1) for part in np.moveaxis(vectors, -1, 0)], axis=-1)
    coverage = np.clip(zoom(truth.coverage, factor, order=1), 0.0, 1.0)
    vectors /= np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    mask = (coverage >= 0.5) & (np.linalg.norm(vectors, axis=-1) > 0.5)
    return toonkit.ToonImage(color_map(np.clip(vectors @ LIGHT, -1, 1)), mask, alpha=coverage)


def median_seconds(work: Callable[[], object], repeats: int) -> float:
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def peak_bytes(work: Callable[[], object]) -> int:
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def measured(shape: str, size: int, method: str, repeats: int) -> Row:
    image = drawing(shape, size)

    def work() -> toonkit.ToonAnalysis:
        return toonkit.analyze(image, LIGHT, method=method)

    seconds = median_seconds(work, repeats)
    analysis = work()
    return {
        "shape": shape,
        "size": size,
        "method": method,
        "object_pixels": int(image.mask.sum()),
        "analyze_seconds": seconds,
        "analyze_microseconds_per_pixel": seconds / size**2 * 1e6,
        "peak_bytes_per_pixel": peak_bytes(work) / size**2,
        "relight_seconds": median_seconds(lambda: toonkit.relight(analysis, NEW_LIGHT), repeats),
        "iterations": analysis.report.iterations,
    }


def table(rows: list[Row]) -> str:
    """One line per case, as a Markdown table."""
    lines = [
        "| shape | size | method | analyze | per pixel | peak memory per pixel | relight |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        lines.append(
            f"| {row['shape']} | {int(row['size'])}² | `{row['method']}` | {float(row['analyze_seconds']):.2f} s "
            f"| {float(row['analyze_microseconds_per_pixel']):.1f} µs | {float(row['peak_bytes_per_pixel']):.0f} B "
            f"| {1000 * float(row['relight_seconds']):.0f} ms |"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description="Speed and memory of the analysis.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write the table")
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--methods", nargs="+", default=list(toonkit.METHODS), choices=list(toonkit.METHODS))
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    cases = [
        (shape, size, method)
        for size in arguments.sizes
        for shape in ("sphere", "cat")
        for method in arguments.methods
    ]
    rows = [measured(*case, arguments.repeats) for case in tqdm(cases, file=sys.stderr, unit="case")]
    print(table(rows))
    if arguments.output is not None:
        with arguments.output.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[0]))
            writer.writeheader()
            writer.writerows(
                {
                    key: float(f"{value:.4g}") if isinstance(value, float) else value
                    for key, value in row.items()
                }
                for row in rows
            )


if __name__ == "__main__":
    main()

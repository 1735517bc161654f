"""How well the light is found when nobody gives it, and whether the estimate knows how sure it may be.

    python benchmarks/lights.py -o notebooks/study/lights.csv

Estimates the light of the study's twenty shapes, each painted with all of its 24 color maps under nine lights, at 512².
Writes one row per picture, and prints the errors: of all, of the surer half and of the rest, and by the light's elevation.
"""

from __future__ import annotations

import argparse
import csv
import functools
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

import toonkit
from toonkit.estimation.light_fit import estimate_light
from toonkit.model.light import light_angles
from toonkit.model.normals import NormalField
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import MIN_SIZE, RenderedShape, render_shape
from toonkit.study.shapes import SHAPES
from toonkit.viz.figures.light_errors import light_errors

ELEVATIONS = (20.0, 47.5, 75.0)
LIGHTS = tuple((40.0 * step, ELEVATIONS[step % len(ELEVATIONS)]) for step in range(9))
"""Azimuth and elevation, degrees: all around, three at each elevation."""

COLUMNS = (
    *("shape", "color_map", "size", "azimuth", "elevation"),
    *("estimated_azimuth", "estimated_elevation", "error", "confidence"),
)

Row = dict[str, str | float]


def measured(shape: str, color_maps: Sequence[str], size: int) -> list[Row]:
    """Estimate the light of one shape under each color map and light."""
    truth = render_shape(SHAPES[shape], size)
    initial = toonkit.inflate(truth.mask, alpha=truth.coverage)
    known = load_color_maps()
    return [
        {"shape": shape, "color_map": name, "size": size, **_estimated(truth, initial, known[name], *angles)}
        for name in color_maps
        for angles in LIGHTS
    ]


def _estimated(
    truth: RenderedShape, initial: NormalField, color_map: toonkit.ColorMap, azimuth: float, elevation: float
) -> Row:
    light = toonkit.light_direction(azimuth, elevation)
    painted = toonkit.shade(truth.normals, light, color_map)
    image = toonkit.ToonImage(painted.color, painted.mask, alpha=truth.coverage)
    estimate = estimate_light(image, initial_normals=initial)
    apart = np.arctan2(np.linalg.norm(np.cross(estimate.light, light)), estimate.light @ light)
    estimated_azimuth, estimated_elevation = light_angles(estimate.light)
    return {
        "azimuth": azimuth,
        "elevation": elevation,
        "estimated_azimuth": estimated_azimuth % 360.0,
        "estimated_elevation": estimated_elevation,
        "error": float(np.rad2deg(apart)),
        "confidence": float(estimate.confidence),
    }


def all_measured(
    shapes: Sequence[str], color_maps: Sequence[str], size: int, *, workers: int
) -> Iterator[list[Row]]:
    """Yield the rows of shape after shape, in order; measured in this process if there are no workers."""
    work = functools.partial(measured, color_maps=color_maps, size=size)
    if workers == 0:
        yield from map(work, shapes)
        return
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ.setdefault(
            f"{library}_NUM_THREADS", "1"
        )  # one core each: workers would wait for each other
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(work, shapes)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="How well the light is found.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per picture")
    parser.add_argument("--size", type=int, default=512, help="side of the pictures (default: 512)")
    parser.add_argument("--shapes", nargs="+", default=list(SHAPES), choices=list(SHAPES), metavar="SHAPE")
    known = list(load_color_maps())
    parser.add_argument("--maps", nargs="+", default=known, choices=known, metavar="COLOR_MAP")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: cores)")
    given = parser.parse_args(arguments)
    if given.size < MIN_SIZE:
        parser.error(f"--size must be at least {MIN_SIZE}")
    found = all_measured(given.shapes, given.maps, given.size, workers=given.workers)
    rows = [row for of in tqdm(found, total=len(given.shapes), file=sys.stderr, unit="shape") for row in of]
    print(light_errors(pd.DataFrame(rows)).to_string(float_format="{:.3g}".format))
    if given.output is not None:
        with given.output.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=COLUMNS)
            writer.writeheader()
            writer.writerows(
                {key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()}
                for row in rows
            )


if __name__ == "__main__":
    main()

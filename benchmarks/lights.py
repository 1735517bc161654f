"""How well the light is found when nobody gives it, and whether the estimate knows how sure it may be.

    python -m benchmarks.lights -o notebooks/study/lights.csv

Estimates the light of the study's twenty shapes, each painted with all of its 24 color maps under nine lights, at 256²: the
network sees every picture on a small square.
Writes one row per picture, and prints the errors: of all, of the surer half and of the rest, and by the light's elevation.
"""

from __future__ import annotations

import argparse
import functools
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import toonkit
from benchmarks.shape_rows import Row, measured_rows, write_rows
from notebooks.plots.light_errors import light_errors
from toonkit.estimation.light_fit import estimate_light
from toonkit.model.light import light_angles
from toonkit.model.normals import NormalField
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import MIN_SIZE, RenderedShape, render_shape
from toonkit.study.shapes import SHAPES

ELEVATIONS = (20.0, 47.5, 75.0)
LIGHTS = tuple((40.0 * step, ELEVATIONS[step % len(ELEVATIONS)]) for step in range(9))
"""Azimuth and elevation, degrees: all around, three at each elevation."""

COLUMNS = (
    *("shape", "color_map", "size", "azimuth", "elevation"),
    *("estimated_azimuth", "estimated_elevation", "error", "confidence"),
)


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


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="How well the light is found.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per picture")
    parser.add_argument("--size", type=int, default=256, help="side of the pictures (default: 256)")
    parser.add_argument("--shapes", nargs="+", default=list(SHAPES), choices=list(SHAPES), metavar="SHAPE")
    known = list(load_color_maps())
    parser.add_argument("--maps", nargs="+", default=known, choices=known, metavar="COLOR_MAP")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: cores)")
    given = parser.parse_args(arguments)
    if given.size < MIN_SIZE:
        parser.error(f"--size must be at least {MIN_SIZE}")
    work = functools.partial(measured, color_maps=given.maps, size=given.size)
    rows = measured_rows(work, given.shapes, workers=given.workers)[list(COLUMNS)]
    print(light_errors(rows).to_string(float_format="{:.3g}".format))
    if given.output is not None:
        write_rows(rows, given.output)


if __name__ == "__main__":
    main()

"""Accuracy of every method on shapes whose normals are known: six shapes x four color maps, one light.

    python benchmarks/accuracy.py -o benchmarks/results/accuracy.csv

Prints the means and writes one row per shape, color map and method. Every method gets the same picture, mask, alpha and
light; relit pictures are compared with the truth under eight new lights, each by its own color map.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tqdm import tqdm

import toonkit
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import RenderedShape, render_shape
from toonkit.study.shapes import SHAPES

SHAPE_NAMES = ("ellipsoid", "torus", "pear", "cat", "duck", "teapot")
COLOR_MAP_NAMES = ("plum_cream", "terracotta", "lilac_soft", "dusk_smooth")
LIGHT = toonkit.light_direction(129, 50)
NEW_LIGHTS = [
    toonkit.light_direction(azimuth, elevation) for azimuth in (0, 90, 180, 270) for elevation in (25, 60)
]

Row = dict[str, str | float]
MEASURES = ("angular_error", "angular_error_without_rim", "relight_rmse", "relight_response", "input_rmse")


def trials(size: int) -> Iterator[Row]:
    for shape in SHAPE_NAMES:
        truth = render_shape(SHAPES[shape], size)
        for name, color_map in ((name, load_color_maps()[name]) for name in COLOR_MAP_NAMES):
            for method in toonkit.METHODS:
                yield {
                    "shape": shape,
                    "color_map": name,
                    "method": method,
                    **measured(truth, color_map, method),
                }


def measured(truth: RenderedShape, color_map: toonkit.ColorMap, method: str) -> dict[str, float]:
    painted = toonkit.shade(truth.normals, LIGHT, color_map)
    image = toonkit.ToonImage(painted.color, painted.mask, alpha=truth.coverage)
    analysis = toonkit.analyze(image, LIGHT, method=method)
    angle = toonkit.angular_error(analysis.normals, truth.normals)
    relit = [toonkit.relight(analysis, light) for light in NEW_LIGHTS]
    reference = [toonkit.shade(truth.normals, light, color_map) for light in NEW_LIGHTS]
    return {
        "angular_error": angle.mean,
        "angular_error_without_rim": angle.mean_without_rim,
        "relight_rmse": mean(
            toonkit.color_rmse(ours, true) for ours, true in zip(relit, reference, strict=True)
        ),
        "relight_response": mean(
            toonkit.relight_response(analysis.picture, ours, image, true)
            for ours, true in zip(relit, reference, strict=True)
        ),
        "input_rmse": toonkit.color_rmse(analysis.picture, image),
    }


def mean(values: Iterator[float]) -> float:
    return float(np.mean(list(values)))


def table(rows: list[Row]) -> str:
    """Means over all trials as a Markdown table."""
    groups: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        groups[str(row["method"])].append(row)
    lines = [
        "| method | normals, mean error | relit, color RMSE | response to the light | input, color RMSE |",
        "|---|---|---|---|---|",
    ]
    for method, group in groups.items():
        angle, _, relight, response, fit = (float(np.mean([row[name] for row in group])) for name in MEASURES)
        lines.append(f"| `{method}` | {angle:.1f}° | {relight:.3f} | {response:.2f} | {fit:.3f} |")
    return "\n".join(lines)


def orders(rows: list[Row]) -> str:
    """Where the expected order of the methods does not hold, shape by shape."""
    means: dict[tuple[str, str], dict[str, float]] = {}
    for shape in SHAPE_NAMES:
        for method in toonkit.METHODS:
            group = [row for row in rows if row["shape"] == shape and row["method"] == method]
            means[shape, method] = {name: float(np.mean([row[name] for row in group])) for name in MEASURES}
    lines = []
    for shape in SHAPE_NAMES:
        angles = {method: means[shape, method]["angular_error"] for method in toonkit.METHODS}
        relit = {method: means[shape, method]["relight_rmse"] for method in toonkit.METHODS}
        if not angles["toonkit"] < angles["todo"] < angles["lumo"]:
            shown = ", ".join(f"{method} {angles[method]:.1f}°" for method in ("toonkit", "todo", "lumo"))
            lines.append(f"{shape}: normals not in the order toonkit < todo < lumo ({shown})")
        if min(relit, key=relit.__getitem__) != "toonkit":
            lines.append(f"{shape}: relit best by {min(relit, key=relit.__getitem__)}")
    return (
        "\n".join(lines)
        or "The order toonkit < todo < lumo holds on every shape, and toonkit relights each best."
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Accuracy of every method on shapes whose normals are known."
    )
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per trial")
    parser.add_argument("--size", type=int, default=256, help="side of the pictures in pixels (default: 256)")
    arguments = parser.parse_args()
    total = len(SHAPE_NAMES) * len(COLOR_MAP_NAMES) * len(toonkit.METHODS)
    rows = list(tqdm(trials(arguments.size), total=total, file=sys.stderr, unit="trial"))
    print(table(rows))
    print()
    print(orders(rows))
    if arguments.output is not None:
        with arguments.output.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[0]))
            writer.writeheader()
            writer.writerows(
                {key: round(value, 5) if isinstance(value, float) else value for key, value in row.items()}
                for row in rows
            )


if __name__ == "__main__":
    main()

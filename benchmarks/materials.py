"""Drawings in several materials and ink: how well they are taken apart, and relit.

    python -m benchmarks.materials -o /tmp/materials --drawings 60 --split held-out
    python -m benchmarks.materials -o /tmp/materials --folder DRAWINGS

Without a folder it draws scenes whose truth is known, analyzes them under their true light, and compares regions, ink,
normals, the estimated light and relit pictures with the truth, in which flat materials stay flat; `drawings.csv` holds one
row per drawing. With a folder it
takes real drawings, whose truth nobody knows, as lit from azimuth 130°, elevation 50°, and measures leak and response under
six other lights; `folder.csv` holds one row per drawing, and beside it stands a contact sheet of each. A drawing that is
refused has no numbers, but the reason.

Seeds are split: choices are tuned on those of one half, and reported on those of the other.
"""

from __future__ import annotations

import argparse
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

import toonkit
from benchmarks.agreement import adjusted_rand_index, f1_score
from benchmarks.material_sheets import sheet
from benchmarks.shape_rows import Row, measured_rows, write_rows
from toonkit._validation import BoolArray
from toonkit.export.picture import write_picture
from toonkit.metrics import leak, picture_error, response
from toonkit.synthetic.drawing import DrawnScene, draw_scene
from toonkit.synthetic.recipes import RECIPES

Split = Literal["tuning", "held-out"]

FIRST_SEEDS: dict[Split, int] = {"tuning": 10_000, "held-out": 20_000}
"""Seed of the first drawing of each half; the others follow."""

LIGHTS = tuple((45.0 * step, 30.0 if step % 2 else 60.0) for step in range(8))
"""Azimuth and elevation, degrees, under which generated drawings are relit."""

FOLDER_LIGHT = (130.0, 50.0)
"""Where the light of real drawings is taken to stand: upper left, as most painters have it."""

FOLDER_LIGHTS = ((40.0, 40.0), (130.0, 40.0), (180.0, 15.0), (0.0, 15.0), (270.0, 25.0), (0.0, 90.0))
"""Where real drawings are relit from."""

TOUCHED = 0.1
"""Share of a pixel that ink covers from which on it says nothing about regions."""

SUFFIXES = (".png", ".webp", ".jpg", ".jpeg", ".tif", ".tiff", ".gif", ".bmp")


def drawn(seed: int, size: int) -> DrawnScene:
    """Draw the scene of a seed; neighboring seeds draw different things, so that a few drawings show many."""
    names = list(RECIPES)
    return draw_scene(seed, size=size, recipe=names[seed % len(names)])


def measured_drawing(seed: str, *, size: int) -> list[Row]:
    """Take one generated drawing apart, relight it, and compare with its truth."""
    scene = drawn(int(seed), size)
    analysis = toonkit.analyze(scene.image, scene.light)
    mask, labels = scene.image.mask, analysis.materials.labels
    clear = mask & (scene.ink < TOUCHED)
    light = toonkit.estimate_light(scene.image).light
    return [
        {
            "seed": int(seed),
            "recipe": scene.recipe,
            "materials": len(scene.materials),
            "regions": len(np.unique(labels[mask])),
            "rand_index": adjusted_rand_index(labels, scene.labels, clear),
            "ink_f1": f1_score((analysis.drawing.ink_coverage >= 0.5)[mask], (scene.ink >= 0.5)[mask]),
            "normals": toonkit.angular_error(analysis.normals, scene.normals).mean,
            "light": float(np.rad2deg(np.arccos(np.clip(light @ scene.light, -1.0, 1.0)))),
            **_relit(scene, analysis),
        }
    ]


def _relit(scene: DrawnScene, analysis: toonkit.ToonAnalysis) -> Row:
    """Compare relit pictures with the truth and with doing nothing, over all and where materials are shaded."""
    shaded = scene.image.mask & ~scene.flat[scene.labels]
    rows = []
    for angles in LIGHTS:
        direction = toonkit.light_direction(*angles)
        truth, ours = scene.relit(direction), toonkit.relight(analysis, direction, flat_shading=0.0)
        rows.append(
            {
                "relit": picture_error(ours, truth).rmse,
                "nothing": picture_error(scene.image, truth).rmse,
                "relit_shaded": _rmse(ours, truth, shaded),
                "nothing_shaded": _rmse(scene.image, truth, shaded),
                "leak": leak(scene.image, ours),
                "true_leak": leak(scene.image, truth),
                "response": response(scene.image, ours),
                "true_response": response(scene.image, truth),
            }
        )
    return dict(pd.DataFrame(rows).mean())


def _rmse(picture: toonkit.ToonImage, truth: toonkit.ToonImage, where: BoolArray) -> float:
    return float(np.sqrt(((picture.color[where] - truth.color[where]) ** 2).mean()))


def measured_file(path: str, *, output: Path | None) -> list[Row]:
    """Relight one real drawing, and write its contact sheet."""
    try:
        image = toonkit.load_image(path)
        analysis = toonkit.analyze(image, FOLDER_LIGHT)
    except toonkit.ToonkitError as error:
        return [
            {"file": Path(path).name, "regions": 0, "leak": np.nan, "response": np.nan, "refused": str(error)}
        ]
    pictures = [toonkit.relight(analysis, toonkit.light_direction(*angles)) for angles in FOLDER_LIGHTS]
    labels = analysis.materials.labels
    if output is not None:
        write_picture(sheet(image, labels, analysis.base_color, pictures), output / f"{Path(path).stem}.png")
    return [
        {
            "file": Path(path).name,
            "regions": len(np.unique(labels[image.mask])),
            "leak": float(np.mean([leak(image, picture) for picture in pictures])),
            "response": float(np.mean([response(image, picture) for picture in pictures])),
            "refused": "",
        }
    ]


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """Return mean, median, least and greatest of every number of a table, a row each."""
    numbers = rows.drop(columns="seed", errors="ignore").select_dtypes("number")
    return numbers.agg(["mean", "median", "min", "max"]).T


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="How well drawings in several materials are relit.")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="write a table and contact sheets"
    )
    parser.add_argument(
        "--drawings", type=int, default=60, metavar="N", help="drawings to make (default: 60)"
    )
    parser.add_argument("--split", choices=list(FIRST_SEEDS), help="one half of the seeds (default: both)")
    parser.add_argument("--size", type=int, default=256, help="side of the drawings made (default: 256)")
    parser.add_argument("--folder", type=Path, metavar="DIR", help="measure the real drawings in a folder")
    parser.add_argument("--workers", type=int, default=0, help="processes (default: 0, this one)")
    given = parser.parse_args(arguments)
    if given.output is not None:
        given.output.mkdir(parents=True, exist_ok=True)
    if given.folder is not None:
        files = sorted(str(path) for path in given.folder.iterdir() if path.suffix.lower() in SUFFIXES)
        if not files:
            parser.error(f"--folder holds no picture: {given.folder}")
        rows = measured_rows(
            functools.partial(measured_file, output=given.output), files, workers=given.workers
        )
        name = "folder.csv"
    else:
        if given.drawings < 2:
            parser.error("--drawings must be at least 2")
        seeds = chosen_seeds(given.drawings, given.split)
        rows = measured_rows(
            functools.partial(measured_drawing, size=given.size), seeds, workers=given.workers
        )
        name = "drawings.csv"
    print(rows.to_string(index=False, float_format="{:.3f}".format))
    if "refused" in rows:
        print(
            f"refused: {(rows.refused != '').sum()} of {len(rows)}, which count in no mean of leak and response"
        )
    print(summary(rows).to_string(float_format="{:.3f}".format))
    if given.output is not None:
        write_rows(rows, given.output / name)


def chosen_seeds(count: int, split: Split | None) -> list[str]:
    """Return the seeds of so many drawings: of one half, or of both in equal parts."""
    if split is not None:
        return [str(FIRST_SEEDS[split] + step) for step in range(count)]
    return [str(first + step) for first in FIRST_SEEDS.values() for step in range(count // 2)]


if __name__ == "__main__":
    main()

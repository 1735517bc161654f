"""How far the normals of a drawing depend on its resolution.

    python -m benchmarks.resolutions -o notebooks/study/resolutions.csv

Analyzes the study's twenty shapes, each painted with the ablation's six color maps at 1024², and the same pictures reduced
to 256² in linear light. Writes one row per picture: the mean angle between the normals of the two, those of the larger
averaged over the blocks that the smaller pixels stand for. Of the true normals, which tells what such a comparison can see;
of the inflated ones, the corrected ones and the refined ones.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.ablation import COLOR_MAP_NAMES
from benchmarks.shape_rows import Row, measured_rows, write_rows
from toonkit import NormalField, ToonImage, analyze, angular_error, light_direction
from toonkit._validation import FloatArray
from toonkit.estimation.shape_prior import completed, correct_shape
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear
from toonkit.study.color_maps import load_color_maps
from toonkit.study.painting import StudySettings, paint
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES

LARGE, FACTOR = 1024, 4
"""Side of the larger pictures, and how many times smaller the others are."""

STEPS = ("true", "initial", "corrected", "refined")


def reduced(image: ToonImage, factor: int) -> ToonImage:
    """Average the light of the object and its coverage over blocks of `factor` x `factor` pixels."""
    weight = image.alpha * image.mask
    painted = np.where(image.mask[..., None], srgb_to_linear(image.color), 0.0)
    total = _block_means(painted * weight[..., None], factor)
    mean = total / np.maximum(_block_means(weight, factor), 1e-9)[..., None]
    color = linear_to_srgb(np.clip(mean, 0.0, 1.0))
    alpha = _block_means(image.alpha, factor)
    return ToonImage(color, alpha >= 0.5, alpha=alpha)


def apart(small: NormalField, large: NormalField, factor: int) -> float:
    """Mean angle, degrees, between normals and the mean directions of larger ones over the blocks they stand for."""
    summed = _block_means(np.where(large.mask[..., None], large.vectors, 0.0), factor)
    both = small.mask & (np.linalg.norm(summed, axis=-1) > 0.0)
    fields = (np.where(both[..., None], vectors, np.nan) for vectors in (completed(summed), small.vectors))
    mean, own = (NormalField(vectors, both) for vectors in fields)
    return float(angular_error(own, mean).mean)


def measured(shape: str) -> list[Row]:
    """Compare the two sizes of one shape under each color map."""
    settings = StudySettings(size=LARGE)
    truths = [render_shape(SHAPES[shape], size) for size in (LARGE // FACTOR, LARGE)]
    rows: list[Row] = []
    for name in COLOR_MAP_NAMES:
        large = paint(truths[1], load_color_maps()[name], settings).image
        images = reduced(large, FACTOR), large
        fields = [
            (truth.normals, *_fields(image, settings)) for truth, image in zip(truths, images, strict=True)
        ]
        angles = {
            step: apart(*pair, FACTOR) for step, pair in zip(STEPS, zip(*fields, strict=True), strict=True)
        }
        rows.append({"shape": shape, "color_map": name, **angles})
    return rows


def _fields(image: ToonImage, settings: StudySettings) -> tuple[NormalField, NormalField, NormalField]:
    analysis = analyze(image, light_direction(*settings.light))
    corrected = correct_shape(image, analysis.light, analysis.initial_normals)
    return analysis.initial_normals, corrected, analysis.normals


def _block_means(values: FloatArray, factor: int) -> FloatArray:
    height, width = (length // factor for length in values.shape[:2])
    means: FloatArray = values.reshape(height, factor, width, factor, *values.shape[2:]).mean(axis=(1, 3))
    return means


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="How far the normals of a drawing depend on its resolution.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per picture")
    parser.add_argument("--shapes", nargs="+", default=list(SHAPES), choices=list(SHAPES), metavar="SHAPE")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: cores)")
    given = parser.parse_args(arguments)
    rows = measured_rows(measured, given.shapes, workers=given.workers)
    summary = rows[list(STEPS)].agg(["mean", "median", "max"])
    print(summary.to_string(float_format="{:.2f}".format))
    if given.output is not None:
        write_rows(rows, given.output)


if __name__ == "__main__":
    main()

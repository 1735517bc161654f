"""What each part of our method buys: the whole, the whole with one part less, and the steps on the way to it.

    python -m benchmarks.ablation -o notebooks/study/ablation.csv

Runs every variant on the study's twenty shapes, each painted with six color maps of different kinds, at 256² and with the
light given. Writes one row per variant, shape and color map, and prints the means.
"""

from __future__ import annotations

import argparse
import functools
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from benchmarks.shape_rows import Row, measured_rows, write_rows
from toonkit import METHODS, ToonAnalysis
from toonkit.estimation.color_map_fit import allowed_interval, painted_interval
from toonkit.estimation.energy import RefinementOptions
from toonkit.estimation.refinement import Refinement, build_energies, refine_islands
from toonkit.estimation.shape_prior import correct_shape
from toonkit.methods import Method
from toonkit.methods.steps import inflate_drawing
from toonkit.methods.toonkit import OPTIONS
from toonkit.model.color_map import ColorMap
from toonkit.model.materials import Materials
from toonkit.numerics.report import NOT_REFINED
from toonkit.study.color_maps import load_color_maps
from toonkit.study.estimators import Estimator
from toonkit.study.painting import Painting, StudySettings, paint
from toonkit.study.records import Trial
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES
from toonkit.study.trials import run_trial

COLOR_MAP_NAMES = ("plum_cream", "terracotta", "ocean", "night_lamp", "lilac_soft", "clay_smooth")
"""Two, three and five hard tones, uneven ones, soft ones, and one that is nearly Lambert."""

Variants = Callable[[Painting], dict[str, Method]]
"""From a picture and what is true of it, which a variant may be told, to methods by name."""

MEASURES = ("angular_error", "relight_rmse", "input_rmse", "seconds")
COLUMNS = ("variant", "shape", "shape_kind", "color_map", "size", *MEASURES)


def variants(painting: Painting) -> dict[str, Method]:
    """Name -> method, from the paper's to ours; the last one is told what no method can know."""
    return {
        "todo": METHODS["todo"],
        "classical": METHODS["classical"],
        "learned shape alone": functools.partial(varied, refined=False),
        "toonkit": METHODS["toonkit"],
        "toonkit without integrability": functools.partial(
            varied, options=replace(OPTIONS, integrability_length=0.0)
        ),
        "toonkit without creases": functools.partial(varied, options=replace(OPTIONS, crease_turn=1e9)),
        "toonkit without color edges": functools.partial(varied, options=replace(OPTIONS, color_jump=1e9)),
        "toonkit without margin": functools.partial(varied, options=replace(OPTIONS, margin=0.0)),
        "toonkit with the true color map": functools.partial(varied, color_map=painting.color_map),
    }


def varied(
    image,
    light,
    *,
    progress=None,
    refined: bool = True,
    options: RefinementOptions = OPTIONS,
    color_map: ColorMap | None = None,
) -> ToonAnalysis:
    """Analyze as `toonkit` does, but for what is asked for; a given color map is the one refined by and relit with."""
    steps = inflate_drawing(image, light, progress)
    corrected = correct_shape(steps.drawing, steps.light, steps.initial_normals)
    if not refined:
        return steps.finish("varied", Refinement(corrected, NOT_REFINED))
    if color_map is None:
        return steps.finish("varied", steps.refine(corrected, None, options))
    allowed = allowed_interval(steps.drawing.tones, color_map)
    islands = steps.drawing.posed(steps.light).islands
    painted = painted_interval(steps.drawing.tones, color_map, allowed)
    energies = build_energies(islands, corrected, steps.light, allowed, options, painted=painted)
    refinement = refine_islands(islands, energies, steps.drawing.mask, options)
    analysis = steps.finish("varied", refinement)
    return replace(analysis, materials=Materials.single(steps.drawing.mask, color_map))


def measured(
    shape: str, color_maps: Sequence[str], settings: StudySettings, variants: Variants = variants
) -> list[Row]:
    """Run all variants on one shape, painted with each of the color maps."""
    truth = render_shape(SHAPES[shape], settings.size)
    paintings = {name: paint(truth, load_color_maps()[name], settings) for name in color_maps}
    return [
        _row(variant, Trial(shape, name, variant, "given"), painting, method)
        for name, painting in paintings.items()
        for variant, method in variants(painting).items()
    ]


def _row(variant: str, trial: Trial, painting: Painting, method: Method) -> Row:
    record = run_trial(trial, SHAPES[trial.shape].kind, painting, Estimator(method))
    if record.error:
        raise RuntimeError(f"{trial.key}: {record.error}")
    return {"variant": variant, **{name: getattr(record, name) for name in COLUMNS[1:]}}


def means(rows: pd.DataFrame) -> str:
    """One line per variant, as a Markdown table."""
    lines = ["| variant | " + " | ".join(MEASURES) + " |", "|---" * (1 + len(MEASURES)) + "|"]
    for variant, mean in rows.groupby("variant", sort=False)[list(MEASURES)].mean().iterrows():
        lines.append(f"| {variant} | " + " | ".join(f"{value:.4g}" for value in mean) + " |")
    return "\n".join(lines)


def run(variants: Variants, purpose: str, arguments: Sequence[str] | None) -> None:
    """Measure variants as a command line asks for it, print their means and write the rows."""
    parser = argparse.ArgumentParser(description=purpose)
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per trial")
    parser.add_argument("--size", type=int, default=256, help="side of the pictures (default: 256)")
    parser.add_argument("--shapes", nargs="+", default=list(SHAPES), choices=list(SHAPES), metavar="SHAPE")
    parser.add_argument(
        "--maps",
        nargs="+",
        default=list(COLOR_MAP_NAMES),
        choices=list(load_color_maps()),
        metavar="COLOR_MAP",
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: cores)")
    given = parser.parse_args(arguments)
    settings = StudySettings(size=given.size)
    work = functools.partial(measured, color_maps=given.maps, settings=settings, variants=variants)
    rows = measured_rows(work, given.shapes, workers=given.workers)[list(COLUMNS)]
    print(means(rows))
    if given.output is not None:
        write_rows(rows, given.output)


def main(arguments: Sequence[str] | None = None) -> None:
    run(variants, "What each part of our method buys.", arguments)


if __name__ == "__main__":
    main()

"""What more sweeps would buy the paper's method, whose text does not say how many it was given; and what its minimum would.

    python -m benchmarks.sweeps -o notebooks/study/sweeps.csv

Runs `todo` with its published weights on six shapes x two color maps at 512², stopped after more and more sweeps, and writes
the mean errors and the energy of Eq. 5, as a share of that of the initial normals. The last row, of "inf" sweeps, is a
minimum of Eq. 5 by multigrid, from the same initial normals.
"""

from __future__ import annotations

import argparse
import csv
import functools
import math
import sys
from pathlib import Path

import numpy as np
from tqdm import tqdm

from toonkit import ToonAnalysis
from toonkit.estimation.refinement import Refinement, refine_as_printed
from toonkit.methods.steps import inflate_drawing
from toonkit.methods.todo import LAMBDA, RHO
from toonkit.model.normals import NormalField
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_field import solve_unit_field
from toonkit.study.color_maps import load_color_maps
from toonkit.study.estimators import Estimator
from toonkit.study.painting import StudySettings, paint
from toonkit.study.records import Trial
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES
from toonkit.study.trials import run_trial

SWEEPS = (0, 20, 50, 100, 200, 500, 1000, 2000, 5000, math.inf)
CONVERGED = 1e-6
"""Relative decrease of the energy in one cycle at which it is taken for least."""

SHAPE_NAMES = ("ellipsoid", "torus", "pear", "cat", "duck", "teapot")
COLOR_MAP_NAMES = ("terracotta", "lilac_soft")
COLUMNS = ("sweeps", "angular_error", "relight_rmse", "input_rmse", "energy")

Row = dict[str, float]


def stopped(image, light, *, progress=None, sweeps: float, energies: list[float]) -> ToonAnalysis:
    """Analyze as `todo` does, but for the number of sweeps; note the energy at the end against that at the start."""
    steps = inflate_drawing(image, light, progress)
    allowed, _ = steps.fit_intervals(steps.initial_normals)
    energy = steps.printed_energy(allowed, rho=RHO, smoothness=LAMBDA)
    if math.isinf(sweeps):
        refinement = minimized(energy, steps.drawing.mask)
    else:
        refinement = refine_as_printed(energy, steps.drawing.mask, max_sweeps=int(sweeps), tolerance=0.0)
    energies.append(refinement.report.energies[-1] / refinement.report.energies[0])
    return steps.finish("todo", refinement)


def minimized(energy: SmoothnessEnergy, mask: np.ndarray) -> Refinement:
    """Minimize Eq. 5 from the initial normals by multigrid, until nothing is left to gain."""
    field, report = solve_unit_field(energy, tolerance=CONVERGED, max_cycles=1000)
    return Refinement(NormalField.of_pixels(field, mask), report)


def measured(settings: StudySettings) -> list[Row]:
    rows: dict[float, list[Row]] = {sweeps: [] for sweeps in SWEEPS}
    cells = [(shape, color_map) for shape in SHAPE_NAMES for color_map in COLOR_MAP_NAMES]
    for shape, color_map in tqdm(cells, file=sys.stderr, unit="picture"):
        truth = render_shape(SHAPES[shape], settings.size)
        painting = paint(truth, load_color_maps()[color_map], settings)
        for sweeps in SWEEPS:
            energies: list[float] = []
            method = functools.partial(stopped, sweeps=sweeps, energies=energies)
            trial = Trial(shape, color_map, "todo", "given")
            record = run_trial(trial, SHAPES[shape].kind, painting, Estimator(method))
            if record.error:
                raise RuntimeError(record.error)
            row = {name: getattr(record, name) for name in COLUMNS[1:-1]}
            rows[sweeps].append({**row, "energy": energies[0]})
    return [
        {"sweeps": sweeps, **{name: float(np.mean([row[name] for row in of])) for name in COLUMNS[1:]}}
        for sweeps, of in rows.items()
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description="What more sweeps would buy the paper's method.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per number of sweeps")
    parser.add_argument("--size", type=int, default=512, help="side of the pictures (default: 512)")
    arguments = parser.parse_args()
    rows = measured(StudySettings(size=arguments.size))
    for row in rows:
        print("  ".join(f"{name} {value:.4g}" for name, value in row.items()))
    if arguments.output is not None:
        with arguments.output.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=COLUMNS)
            writer.writeheader()
            writer.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)


if __name__ == "__main__":
    main()

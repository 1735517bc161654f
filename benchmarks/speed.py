"""Speed and memory, side by side in one process: the analysis at all sizes, and its solvers against the usual ones.

    python -m benchmarks.speed -o benchmarks/results

For each size a disc and the silhouette of a cat, painted in four soft tones. Medians over repeats after a first run, so that
neither compiling counts nor memory that a virtual machine has yet to be given (speed.csv has the first run's time, too);
every repeat sees a picture of its own, of which nothing is kept.
Machines are noisy: read the times as ratios to those beside them. Writes speed.csv, solvers.csv, first_use.csv and
scaling.png.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import zoom
from tqdm import tqdm

import toonkit
from benchmarks import other_solvers
from toonkit.estimation.energy import change_energy
from toonkit.estimation.inflation import RESIDUAL_TOLERANCE, silhouette_system
from toonkit.estimation.shape_prior import correct_shape
from toonkit.methods.steps import inflate_drawing
from toonkit.methods.todo import LAMBDA, RHO
from toonkit.methods.toonkit import OPTIONS
from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.screened_poisson import ScreenedPoisson, solve_screened_poisson
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_field import solve_unit_field
from toonkit.numerics.unit_vectors import UnitVectorEnergy
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES

LIGHT = toonkit.light_direction(129, 50)
NEARBY_LIGHT = toonkit.light_direction(135, 53)
NEW_LIGHT = toonkit.light_direction(20, 40)
RENDERED = 256
"""Side at which the silhouettes are rendered; larger ones are interpolated from it, which speed does not mind."""

SIZES = (256, 512, 1024, 2048, 4096)
BASELINES_AT = 512
"""Side at which the other methods are timed too."""

LIMIT = 60.0
"""Seconds after which another solver is stopped; at larger sizes it is not started."""

FEW = 2048
"""Side from which on three repeats do."""

SWEEPS = "over-relaxed sweeps"
"""What the paper's way to minimize is called in the tables."""

PRINTED = "Eq. 5"
"""What the paper's smoothing is called in the tables."""

PRINTED_TOLERANCE = 1e-3
"""Relative decrease of its energy in one cycle at which toonkit's solver stops: a tenth of a percent."""

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


def again(image: toonkit.ToonImage) -> toonkit.ToonImage:
    """Return the same picture, of which nothing is remembered."""
    return toonkit.ToonImage.like(image, image.pixels, image.fringe_colors)


def timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def first_and_median(work: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Seconds of a first run, and the median of so many repeats."""
    first, *later = (timed(work) for _ in range(1 + repeats))
    return first, float(np.median(later))


def median_seconds(work: Callable[[], object], repeats: int) -> float:
    return first_and_median(work, repeats)[1]


def peak_bytes(work: Callable[[], object]) -> int:
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def measured(shape: str, size: int, method: str, repeats: int) -> Row:
    """Time one method on one picture: from scratch, again under a light nearby, and relighting what it found."""
    image = drawing(shape, size)

    analysis: toonkit.ToonAnalysis | None = None

    def work() -> None:
        nonlocal analysis
        analysis = toonkit.analyze(again(image), LIGHT, method=method)

    first, seconds = first_and_median(work, repeats)
    assert analysis is not None
    found = analysis
    warm = median_seconds(
        lambda: toonkit.analyze(found.image, NEARBY_LIGHT, method=method, previous=found), repeats
    )
    return {
        "shape": shape,
        "size": size,
        "method": method,
        "object_pixels": int(image.mask.sum()),
        "analyze_seconds": seconds,
        "first_seconds": first,
        "analyze_microseconds_per_pixel": seconds / size**2 * 1e6,
        "again_seconds": warm,
        "peak_bytes_per_pixel": peak_bytes(work) / size**2,
        "relight_seconds": median_seconds(lambda: toonkit.relight(found, NEW_LIGHT), max(repeats, 5)),
        "iterations": found.report.iterations,
    }


@dataclass(frozen=True)
class Problems:
    """What an analysis solves: the inflation's system with its right side, the refinement's field; and Eq. 5 from N0."""

    system: ScreenedPoisson
    right_side: np.ndarray
    field: ChangeEnergy
    printed: SmoothnessEnergy


def problems(shape: str, size: int) -> Problems:
    image = drawing(shape, size)
    steps = inflate_drawing(image, LIGHT, None)
    (island,) = steps.drawing.islands
    system, right_side = silhouette_system(island.grid, island.silhouette)
    initial = steps.initial_normals
    corrected = correct_shape(steps.drawing, LIGHT, initial)
    (allowed, _), (printed, _) = (steps.fit_intervals(normals) for normals in (corrected, initial))
    return Problems(
        system,
        right_side,
        change_energy(island.grid, island.silhouette, corrected.compact, LIGHT, allowed, OPTIONS),
        steps.printed_energy(printed, rho=RHO, smoothness=LAMBDA),
    )


def compared(shape: str, size: int, repeats: int, slow: set[tuple[str, str]]) -> list[Row]:
    """
    Solve the problems by toonkit and by the others, but for those that were too slow at a smaller size.

    The paper's sweeps are run at `BASELINES_AT` whatever they took before: how they compare is to be known there.
    """
    posed = problems(shape, size)

    def ours() -> object:
        return solve_screened_poisson(posed.system, posed.right_side, tolerance=RESIDUAL_TOLERANCE)

    others: dict[tuple[str, str], Callable[[], float]] = {
        ("inflation", "sparse LU"): lambda: timed(
            lambda: other_solvers.solve_poisson_with(posed.system, posed.right_side, other_solvers.factorized)
        ),
        ("inflation", "pyamg"): lambda: timed(
            lambda: other_solvers.solve_poisson_with(posed.system, posed.right_side, other_solvers.by_pyamg)
        ),
        ("inflation", SWEEPS): lambda: other_solvers.sweep_poisson(
            posed.system, posed.right_side, RESIDUAL_TOLERANCE, LIMIT
        ),
    }
    rows = [_solver_row(shape, size, "inflation", "toonkit", median_seconds(ours, repeats))]
    vectors: list[tuple[str, UnitVectorEnergy, float, int]] = [
        ("refinement", posed.field, OPTIONS.tolerance, repeats),
        (PRINTED, posed.printed, PRINTED_TOLERANCE, 1 if size >= FEW else repeats),
    ]
    for name, problem, tolerance, times in vectors:
        goal, seconds = solved(problem, tolerance, times)
        rows.append(_solver_row(shape, size, name, "toonkit", seconds))
        others |= {(name, solver): work for solver, work in _vector_solvers(problem, goal).items()}
    for (problem, solver), work in others.items():
        if (problem, solver) in slow and (solver, size) != (SWEEPS, BASELINES_AT):
            continue
        seconds = work()
        if (
            seconds > LIMIT / 8
        ):  # at twice the side it would take longer than the limit, or more memory than there is
            slow.add((problem, solver))
        rows.append(_solver_row(shape, size, problem, solver, seconds))
    return rows


def solved(problem: UnitVectorEnergy, tolerance: float, repeats: int) -> tuple[float, float]:
    """Return the energy that toonkit's solver reaches, and the median of the seconds that it takes after a first run."""
    energy = float(solve_unit_field(problem, tolerance=tolerance)[1].energies[-1])
    seconds = [timed(lambda: solve_unit_field(problem, tolerance=tolerance)) for _ in range(repeats)]
    return energy, float(np.median(seconds))


def _vector_solvers(problem: UnitVectorEnergy, goal: float) -> dict[str, Callable[[], float]]:
    """Return the other ways to an energy, timed; one that ends above it counts as one whose time was up."""

    def newton(solve: other_solvers.LinearSolver) -> float:
        seconds, reached, _ = other_solvers.newton(problem, goal, LIMIT, solve)
        return seconds if reached <= goal else max(seconds, LIMIT)

    return {
        "Newton, sparse LU": lambda: newton(other_solvers.factorized),
        "Newton, pyamg": lambda: newton(other_solvers.by_pyamg),
        SWEEPS: lambda: other_solvers.swept(problem, goal, LIMIT)[0],
    }


FRESH = """
import time; begin = time.perf_counter()
import numpy as np, toonkit
stored = np.load({path!r})
image = toonkit.ToonImage(stored["color"], stored["mask"], alpha=stored["alpha"])
toonkit.analyze(image, toonkit.light_direction(129, 50))
print(time.perf_counter() - begin)
"""


def first_use() -> Row:
    """
    Time a 512² drawing in new processes, imports included: the first one on a machine compiles, later ones need not.

    Medians over five of each; to a first one the machine is new, for it finds nothing compiled.
    """
    image = drawing("cat", 512)
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "drawing.npz")
        np.savez(path, color=image.color, mask=image.mask, alpha=image.alpha)

        def seconds(machine: int) -> float:
            environment = {**os.environ, "NUMBA_CACHE_DIR": str(Path(folder) / f"machine {machine}")}
            run = [sys.executable, "-c", FRESH.format(path=path)]
            return float(
                subprocess.run(run, env=environment, check=True, capture_output=True, text=True).stdout
            )

        first, later = ([seconds(machine) for machine in range(5)] for _ in range(2))
    return {
        "first_process_seconds": float(np.median(first)),
        "later_process_seconds": float(np.median(later)),
    }


def _solver_row(shape: str, size: int, problem: str, solver: str, seconds: float) -> Row:
    return {"shape": shape, "size": size, "problem": problem, "solver": solver, "seconds": seconds}


def table(rows: list[Row]) -> str:
    """One line per case, as a Markdown table."""
    lines = [
        "| shape | size | method | analyze | per pixel | light moved | peak memory per pixel | relight |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        lines.append(
            f"| {row['shape']} | {int(row['size'])}² | `{row['method']}` | {float(row['analyze_seconds']):.2f} s "
            f"| {float(row['analyze_microseconds_per_pixel']):.2f} µs | {float(row['again_seconds']):.2f} s "
            f"| {float(row['peak_bytes_per_pixel']):.0f} B | {1000 * float(row['relight_seconds']):.0f} ms |"
        )
    return "\n".join(lines)


def solver_table(rows: list[Row]) -> str:
    """One line per problem and solver, its seconds at each size, as a Markdown table; a dash where it was not run."""
    sizes = sorted({int(row["size"]) for row in rows})
    known = {(row["problem"], row["solver"], int(row["size"])): float(row["seconds"]) for row in rows}
    lines = [
        "| problem | solver | " + " | ".join(f"{size}²" for size in sizes) + " |",
        "|---" * (2 + len(sizes)) + "|",
    ]
    for problem, solver in dict.fromkeys((problem, solver) for problem, solver, _ in known):
        cells = [known.get((problem, solver, size)) for size in sizes]
        shown = ["–" if cell is None else _seconds(cell) for cell in cells]
        lines.append(f"| {problem} | {solver} | " + " | ".join(shown) + " |")
    return "\n".join(lines)


def _seconds(value: float) -> str:
    return f"> {LIMIT:.0f} s" if value >= LIMIT else f"{value:.3g} s"


def sweeps_text(solvers: list[Row]) -> str:
    """Say how the paper's sweeps compare on the paper's energy, on the largest picture of each shape that they solved."""
    parts = []
    for shape, name in (("sphere", "disc"), ("cat", "cat")):
        seconds = {
            (row["solver"], int(row["size"])): float(row["seconds"])
            for row in solvers
            if (row["shape"], row["problem"]) == (shape, PRINTED)
        }
        size = max(size for solver, size in seconds if solver == SWEEPS)
        spent = seconds[SWEEPS, size]
        ratio = int(min(spent, LIMIT) / seconds["toonkit", size])
        more = "more than " if spent >= LIMIT else ""
        parts.append(f"{more}{ratio} times as long for the {name} at {size}²")
    return f"To reach the same energy of Eq. 5, the paper's sweeps take longer than toonkit: {' and '.join(parts)}."


def scaling_figure(rows: list[Row], solvers: list[Row]) -> Figure:
    """Seconds against the picture's side, both axes logarithmic: the whole analysis, and two problems by each solver."""
    figure = Figure(figsize=(13, 3.6), layout="constrained")
    whole, *compared = figure.subplots(1, 3)
    for shape, name in (("sphere", "disc"), ("cat", "cat")):
        chosen = [row for row in rows if (row["shape"], row["method"]) == (shape, "toonkit")]
        whole.loglog(*_curve(chosen, "analyze_seconds"), "o-", label=f"analyze, {name}")
        whole.loglog(*_curve(chosen, "relight_seconds"), "s--", label=f"relight, {name}")
    for axes, problem, title in zip(
        compared,
        ("refinement", PRINTED),
        ("Refining the cat, to the same energy", "The paper's Eq. 5 for the cat, likewise"),
        strict=True,
    ):
        axes.set_title(title)
        for solver in dict.fromkeys(row["solver"] for row in solvers if row["problem"] == problem):
            chosen = [
                {**row, "seconds": min(float(row["seconds"]), LIMIT)}
                for row in solvers
                if (row["shape"], row["problem"], row["solver"]) == ("cat", problem, solver)
            ]
            (curve,) = axes.loglog(*_curve(chosen, "seconds"), "-", label=solver)
            for row in chosen:
                # Of one that was stopped nobody knows how long it takes: it points upwards.
                stopped = row["seconds"] == LIMIT
                axes.plot(row["size"], row["seconds"], "^" if stopped else "o", color=curve.get_color())
    whole.set_title("The whole analysis")
    for axes in (whole, *compared):
        sizes = sorted({int(row["size"]) for row in rows})
        axes.set_xticks(sizes, [f"{size}²" for size in sizes], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("picture")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8, frameon=False)
    whole.set_ylabel("seconds")
    return figure


def _curve(rows: list[Row], name: str) -> tuple[list[float], list[float]]:
    return [float(row["size"]) for row in rows], [float(row[name]) for row in rows]


def main() -> None:
    parser = argparse.ArgumentParser(description="Speed and memory of the analysis and of its solvers.")
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="write tables and figure")
    parser.add_argument("--sizes", type=int, nargs="+", default=list(SIZES))
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument(
        "--first-use", action="store_true", help="measure the first use alone, and write its table"
    )
    arguments = parser.parse_args()
    fresh = first_use()
    print(
        "{first_process_seconds:.2f} s in a first process, {later_process_seconds:.2f} s in a later one".format(
            **fresh
        )
    )
    if arguments.output is not None:
        arguments.output.mkdir(parents=True, exist_ok=True)
        _write(arguments.output / "first_use.csv", [fresh])
    if arguments.first_use:
        return
    rows: list[Row] = []
    solvers: list[Row] = []
    slow: dict[str, set[tuple[str, str]]] = {"sphere": set(), "cat": set()}
    cases = [(shape, size) for size in arguments.sizes for shape in slow]
    for shape, size in tqdm(cases, file=sys.stderr, unit="case"):
        repeats = min(arguments.repeats, 3) if size >= FEW else arguments.repeats
        methods = toonkit.METHODS if size == BASELINES_AT else ("toonkit",)
        rows += [measured(shape, size, method, repeats) for method in methods]
        solvers += compared(shape, size, repeats, slow[shape])
    print(table(rows))
    for shape in slow:
        print(f"\n{shape}\n" + solver_table([row for row in solvers if row["shape"] == shape]))
    if arguments.output is not None:
        _write(arguments.output / "speed.csv", rows)
        _write(arguments.output / "solvers.csv", solvers)
        scaling_figure(rows, solvers).savefig(arguments.output / "scaling.png", dpi=110)


def _write(path: Path, rows: list[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(
            {key: float(f"{value:.4g}") if isinstance(value, float) else value for key, value in row.items()}
            for row in rows
        )


if __name__ == "__main__":
    main()

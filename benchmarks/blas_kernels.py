"""How much an analysis depends on the processor: the same drawings with several kernels of OpenBLAS.

    python -m benchmarks.blas_kernels -o benchmarks/results/blas_kernels.csv

OpenBLAS chooses a kernel for the processor, and each one adds in an order of its own. A process for each kernel analyzes and
relights the samples, with the light estimated. Writes the largest difference from the kernel that is chosen here, for each
kernel and method.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import toonkit
from toonkit.samples import sample_names, sample_path

CHOSEN = "chosen here"
KERNELS = ("Haswell", "Prescott")
"""With fused multiplications of 256 bits, and without any."""

METHODS = ("toonkit", "classical", "lambert")
NEW_LIGHT = (30, 40)

Answers = Mapping[str, NDArray[np.float64]]


def analyze_samples(names: Sequence[str], path: Path) -> None:
    """Write the light, normals and relit colors that each method finds."""
    found = {}
    for name in names:
        for method in METHODS:
            analysis = toonkit.analyze(sample_path(name), method=method)
            relit = toonkit.relight(analysis, NEW_LIGHT)
            found[f"{method} light {name}"] = analysis.light
            found[f"{method} normals {name}"] = analysis.normals.compact
            found[f"{method} colors {name}"] = relit.color[relit.mask]
    np.savez(path, **found)


def answers(kernel: str, names: Sequence[str], folder: Path) -> dict[str, NDArray[np.float64]]:
    """Return what a process of its own answers with one kernel."""
    path = folder / f"{kernel}.npz"
    chosen = {} if kernel == CHOSEN else {"OPENBLAS_CORETYPE": kernel}
    code = f"from benchmarks.blas_kernels import *; analyze_samples({list(names)!r}, Path({str(path)!r}))"
    subprocess.run([sys.executable, "-c", code], env={**os.environ, **chosen}, check=True)
    with np.load(path) as found:
        return dict(found)


def angles(mine: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles between unit vectors in degrees, exact for small ones too."""
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(mine - other, axis=-1) / 2, 0, 1)))


def largest(mine: Answers, other: Answers, method: str) -> dict[str, float]:
    """Return the largest differences of one method over all drawings."""

    def differences(what: str) -> list[float]:
        keys = [key for key in mine if key.startswith(f"{method} {what} ")]
        if what == "colors":
            return [float(np.abs(mine[key] - other[key]).max()) for key in keys]
        return [float(angles(mine[key], other[key]).max()) for key in keys]

    return {
        "light_degrees": max(differences("light")),
        "normals_degrees": max(differences("normals")),
        "relit_color": max(differences("colors")),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="How much an analysis depends on the kernel of OpenBLAS.")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="CSV", help="write one row per kernel and method"
    )
    parser.add_argument(
        "--samples", nargs="+", default=["cat", "duck"], choices=sample_names(), metavar="SAMPLE"
    )
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as temporary:
        mine, *others = (answers(kernel, given.samples, Path(temporary)) for kernel in (CHOSEN, *KERNELS))
    rows = pd.DataFrame(
        {"kernel": kernel, "method": method, **largest(mine, other, method)}
        for kernel, other in zip(KERNELS, others, strict=True)
        for method in METHODS
    )
    print(rows.to_string(index=False, float_format="{:.1e}".format))
    if given.output is not None:
        rows.to_csv(given.output, index=False, float_format="%.1e")


if __name__ == "__main__":
    main()

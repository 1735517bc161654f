"""Another kernel of OpenBLAS changes last digits alone, as the text says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks import blas_kernels

ROOT = Path(__file__).parents[1]
STEP = 1 / 255


def test_small_angles_are_exact():
    turned = np.array([[np.sin(1e-9), 0, np.cos(1e-9)]])
    assert blas_kernels.angles(np.array([[0.0, 0, 1]]), turned) == pytest.approx(np.degrees(1e-9))


def test_the_largest_difference_over_all_drawings_counts():
    mine = {"lumo light a": np.array([0.0, 0, 1]), "lumo light b": np.array([0.0, 0, 1])}
    mine |= {
        f"lumo {what} {name}": np.array([[0.0, 0, 1]]) for what in ("normals", "colors") for name in "ab"
    }
    other = {**mine, "lumo normals b": np.array([[0.0, 1, 0]]), "lumo colors a": np.array([[0.0, 0.5, 1]])}
    found = blas_kernels.largest(mine, other, "lumo")
    assert found == pytest.approx({"light_degrees": 0, "normals_degrees": 90, "relit_color": 0.5})


def test_the_text_says_what_was_measured():
    rows = pd.read_csv(ROOT / "benchmarks" / "results" / "blas_kernels.csv")
    text = " ".join((ROOT / "docs" / "accuracy.md").read_text().split())
    angle = re.search(r"normals of two samples turned by about ([\d.]+)° at most", text)
    color = re.search(r"relit colors changed by about ([\d.]+) at most, a tenth of a step", text)
    assert angle
    assert color
    assert float(f"{rows['normals_degrees'].max():.1g}") == float(angle[1])
    assert float(f"{rows['relit_color'].max():.1g}") == float(color[1])
    assert round(rows["relit_color"].max() / STEP, 1) == 0.1
    assert sorted(set(rows["kernel"])) == sorted(blas_kernels.KERNELS)

"""The benchmark of resolutions reduces pictures rightly, measures angles, and docs/accuracy.md tells what it found."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import toonkit
from benchmarks import resolutions
from benchmarks.ablation import COLOR_MAP_NAMES
from toonkit.study.shapes import SHAPES

ROOT = Path(__file__).parent.parent


def test_a_picture_is_reduced_by_the_light_of_the_object_alone():
    mask = np.zeros((32, 32), bool)
    mask[6:27, 9:26] = True
    color = np.where(np.arange(32)[:, None, None] < 16, 0.2, 0.8) * np.tile([1.0, 0.9, 0.5], (1, 32, 1))
    small = resolutions.reduced(toonkit.ToonImage(color, mask), 2)
    assert small.mask.sum() == pytest.approx(mask.sum() / 4, rel=0.1)
    assert np.abs(small.color - color[::2, ::2])[small.mask].max() < 1e-6
    assert small.alpha.mean() == pytest.approx(mask.mean())


def test_the_same_normals_are_apart_by_nothing_and_tilted_ones_by_their_tilt():
    def tilted(size: int, degrees: float) -> toonkit.NormalField:
        mask = np.zeros((size, size), bool)
        mask[size // 4 : size // 2] = True
        towards = toonkit.light_direction(70, 90 - degrees)
        return toonkit.NormalField(np.where(mask[..., None], towards, np.nan), mask)

    assert resolutions.apart(tilted(16, 25), tilted(64, 25), 4) == pytest.approx(0, abs=1e-6)
    assert resolutions.apart(tilted(16, 25), tilted(64, 40), 4) == pytest.approx(15)


def test_the_command_compares_resolutions(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(resolutions, "LARGE", 128)
    monkeypatch.setattr(resolutions, "COLOR_MAP_NAMES", ("ocean", "lilac_soft"))
    target = tmp_path / "resolutions.csv"
    resolutions.main(["--shapes", "pear", "--workers", "0", "-o", str(target)])
    table = pd.read_csv(target)
    assert list(table.columns) == ["shape", "color_map", *resolutions.STEPS]
    assert table["color_map"].tolist() == ["ocean", "lilac_soft"]
    assert (table["true"] < table["initial"]).all()
    assert (table[list(resolutions.STEPS)] < 30).all(axis=None)
    assert f"{table['refined'].mean():.2f}" in capsys.readouterr().out


def test_the_committed_resolutions_are_of_all_shapes_and_color_maps():
    table = pd.read_csv(ROOT / "notebooks" / "study" / "resolutions.csv")
    expected = set(itertools.product(SHAPES, COLOR_MAP_NAMES))
    assert set(table[["shape", "color_map"]].itertuples(index=False, name=None)) == expected
    assert len(table) == len(expected)
    mean = table[list(resolutions.STEPS)].mean()
    text = " ".join((ROOT / "docs" / "accuracy.md").read_text().split())
    small, large = resolutions.LARGE // resolutions.FACTOR, resolutions.LARGE
    assert f"Drawings of {large} x {large} pixels were reduced to {small} x {small} pixels" in text
    assert f"{len(SHAPES)} shapes with {len(COLOR_MAP_NAMES)} color maps each" in text
    assert f"The normals of the two analyses differ by {mean['refined']:.1f}° on average" in text
    assert f"The true normals of the two sizes already differ by {mean['true']:.1f}°" in text

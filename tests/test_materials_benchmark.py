"""The benchmark of drawings in several materials measures what it says."""

from __future__ import annotations

from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import toonkit
from benchmarks import materials, tone_pairs
from benchmarks.agreement import adjusted_rand_index, f1_score
from benchmarks.material_sheets import TILE, sheet
from toonkit.illustration.contact_cues import CUE_WEIGHTS
from toonkit.metrics import picture_error
from toonkit.model.decoding import read_pixels
from toonkit.synthetic.drawing import draw_scene
from toonkit.synthetic.recipes import RECIPES

EVERYWHERE = np.ones((5, 8), np.bool_)
SIZE = 48


def counted(ours: np.ndarray, theirs: np.ndarray) -> float:
    """The index from its definition, pair by pair."""
    pairs = [(ours[i] == ours[j], theirs[i] == theirs[j]) for i, j in combinations(range(len(ours)), 2)]
    same, one, other = (
        sum(a and b for a, b in pairs), sum(a for a, _ in pairs), sum(b for _, b in pairs)
    )  # fmt: skip
    chance = one * other / len(pairs)
    return (same - chance) / ((one + other) / 2 - chance)


@pytest.mark.parametrize("seed", range(5))
def test_the_rand_index_is_that_of_counted_pairs(seed):
    rng = np.random.default_rng(seed)
    ours, theirs = rng.integers(-1, 4, (2, 5, 8))
    assert adjusted_rand_index(ours, theirs, EVERYWHERE) == pytest.approx(
        counted(ours.ravel(), theirs.ravel())
    )
    half = rng.random((5, 8)) < 0.5
    assert adjusted_rand_index(ours, theirs, half) == pytest.approx(counted(ours[half], theirs[half]))


def test_the_rand_index_ignores_what_regions_are_called():
    labels = np.random.default_rng(0).integers(0, 4, (5, 8))
    assert adjusted_rand_index(7 - labels, labels, EVERYWHERE) == pytest.approx(1.0)
    assert adjusted_rand_index(np.zeros((5, 8), int), labels, EVERYWHERE) == pytest.approx(0.0)
    assert adjusted_rand_index(labels * 0, labels * 0, EVERYWHERE) == 1.0
    assert np.isnan(adjusted_rand_index(labels, labels, ~EVERYWHERE))


def test_f1_is_the_harmonic_mean_of_precision_and_recall():
    truth = np.zeros(20, np.bool_)
    truth[:10] = True
    found = np.zeros(20, np.bool_)
    found[6:11] = True  # precision 4/5, recall 4/10
    assert f1_score(found, truth) == pytest.approx(2 / (5 / 4 + 10 / 4))
    assert f1_score(~truth, truth) == 0.0
    assert f1_score(truth & ~truth, truth & ~truth) == 1.0


def test_the_two_halves_share_no_seed():
    tuning, held_out = (set(materials.chosen_seeds(500, split)) for split in materials.FIRST_SEEDS)
    assert not tuning & held_out
    both = materials.chosen_seeds(60, None)
    assert len(both) == len(set(both)) == 60
    assert len(tuning.intersection(both)) == len(held_out.intersection(both)) == 30


def test_neighboring_seeds_draw_every_recipe():
    first = materials.FIRST_SEEDS["tuning"]
    names = {materials.drawn(first + step, 16).recipe for step in range(len(RECIPES))}
    assert names == set(RECIPES)


@pytest.fixture(scope="module")
def row() -> dict[str, str | float]:
    (row,) = materials.measured_drawing("3", size=SIZE)
    return row


def test_a_row_says_what_doing_nothing_is_worth(row):
    scene = materials.drawn(3, SIZE)
    errors = [
        picture_error(scene.image, scene.relit(toonkit.light_direction(*angles))).rmse
        for angles in materials.LIGHTS
    ]
    assert row["nothing"] == pytest.approx(np.mean(errors))
    assert row["materials"] == len(scene.materials)
    assert 0 < row["nothing_shaded"] < 1
    assert 0 < row["normals"] < 90


def test_the_truth_hardly_leaks_and_responds(row):
    assert row["true_leak"] < 0.05
    assert row["true_response"] > 0.01


def test_a_perfect_analysis_has_no_error(monkeypatch):
    scene = materials.drawn(3, SIZE)
    perfect = SimpleNamespace(
        materials=SimpleNamespace(labels=scene.labels),
        drawing=SimpleNamespace(ink_coverage=scene.ink),
        normals=scene.normals,
    )
    monkeypatch.setattr(toonkit, "analyze", lambda *_: perfect)
    monkeypatch.setattr(toonkit, "relight", lambda _, light, flat_shading: scene.relit(light))
    (row,) = materials.measured_drawing("3", size=SIZE)
    assert row["relit"] == row["relit_shaded"] == row["normals"] == 0.0
    assert row["rand_index"] == pytest.approx(1.0)
    assert row["ink_f1"] == 1.0
    assert row["leak"] == row["true_leak"]


def test_the_drawings_become_a_table(tmp_path, capsys):
    materials.main(["-o", str(tmp_path), "--drawings", "2", "--size", "32", "--split", "tuning"])
    rows = pd.read_csv(tmp_path / "drawings.csv")
    assert rows.seed.tolist() == [10_000, 10_001]
    assert "rand_index" in capsys.readouterr().out


def test_a_folder_becomes_a_table_and_a_sheet_a_drawing(tmp_path):
    (tmp_path / "drawings").mkdir()
    image = draw_scene(4, size=SIZE).image
    image_path = tmp_path / "drawings" / "one.png"
    materials.write_picture(image, image_path)
    materials.main(["-o", str(tmp_path), "--folder", str(tmp_path / "drawings")])
    rows = pd.read_csv(tmp_path / "folder.csv")
    assert rows.file.tolist() == ["one.png"]
    assert rows.response[0] > 0
    assert read_pixels("sheet", tmp_path / "one.png").color.shape[0] > 3 * TILE


def test_an_empty_folder_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        materials.main(["--folder", str(tmp_path)])
    assert "holds no picture" in capsys.readouterr().err


def test_a_sheet_shows_input_regions_base_and_every_light():
    image = draw_scene(4, size=SIZE).image
    shown = sheet(image, np.where(image.mask, 0, -1), image, [image] * 6)
    tiles = [
        shown[8 + 328 * r : 328 + 328 * r, 8 + 328 * c : 328 + 328 * c] for r in range(3) for c in range(3)
    ]
    assert all(np.ptp(tile) > 50 for tile in tiles)
    assert np.array_equal(tiles[0], tiles[2])
    assert not np.array_equal(tiles[0], tiles[1])


def test_weights_of_known_odds_are_fitted():
    random = np.random.default_rng(0)
    cues = np.column_stack([np.ones(4000), random.normal(0, 0.2, 4000), random.uniform(0, 3, 4000)])
    weights = np.array([-1.0, 5.0, 0.8])
    same = random.random(4000) < 1 / (1 + np.exp(-cues @ weights))
    found = tone_pairs.fitted(cues, same, np.ones(4000))
    assert np.allclose(found, weights, rtol=0.2, atol=0.1)


def test_pairs_of_a_drawing_have_a_cue_for_every_weight():
    cues, same, weight = tone_pairs.pairs_of(materials.drawn(3, 96))
    assert cues.shape == (len(same), len(CUE_WEIGHTS)) == (len(weight), len(CUE_WEIGHTS))
    assert 0 < same.sum() < len(same)

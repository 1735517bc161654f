"""Materials to learn from: each part has one, and what is seen of it is its shading alone."""

from __future__ import annotations

import numpy as np
import pytest

from tests.training.shapes import ellipsoids
from toonkit.estimation.shading_ratio import LIT
from toonkit.model.luminance import linear_to_srgb
from toonkit.training import materials
from toonkit.training.materials import MOST, paint_materials, random_labels

SHAPE = ellipsoids(1).view(0, 0)
SEEDS = range(40)


def labeled(seed: int) -> np.ndarray:
    return random_labels(SHAPE.parts, np.random.default_rng(seed))


def painted(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tones, where they show, and the illumination, of a shape whose parts are two materials."""
    rng = np.random.default_rng(seed)
    illumination = SHAPE.normals @ np.float32([0.6, 0.0, 0.8])
    return *paint_materials(SHAPE.parts.astype(np.intp), illumination, rng), illumination


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither patterns nor regions taken apart."""
    monkeypatch.setattr(materials, "PATTERNED", 0.0)
    monkeypatch.setattr(materials, "SPLIT", 0.0)


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("seed", SEEDS)
def test_each_part_is_of_one_material(seed: int) -> None:
    labels = labeled(seed)
    assert (labels[~SHAPE.mask] == -1).all()
    for part in (0, 1):
        (number,) = np.unique(labels[SHAPE.parts == part])
        assert 0 <= number < MOST


@pytest.mark.usefixtures("plain")
def test_parts_share_a_material_now_and_then() -> None:
    counts = [len(np.unique(labeled(seed)[SHAPE.mask])) for seed in SEEDS]
    assert set(counts) == {1, 2}


def test_a_pattern_covers_a_part_of_one_material(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(materials, "SPLIT", 0.0)
    for share in (0.0, 1.0):
        monkeypatch.setattr(materials, "PATTERNED", share)
        covered = [(labeled(seed) == MOST).sum() / SHAPE.mask.sum() for seed in SEEDS]
        assert (max(covered) > 0) == bool(share)
        assert max(covered) < 0.8


def test_a_material_taken_apart_has_a_number_for_each_region(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(materials, "PATTERNED", 1.0)
    counts = []
    for share in (0.0, 1.0):
        monkeypatch.setattr(materials, "SPLIT", share)
        counts.append([len(np.unique(labeled(seed)[SHAPE.mask])) for seed in SEEDS])
    assert all(apart >= whole for whole, apart in zip(*counts, strict=True))
    assert np.mean(counts[1]) > 2 * np.mean(counts[0])


@pytest.mark.parametrize("seed", SEEDS)
def test_within_a_material_more_light_is_never_seen_darker(seed: int) -> None:
    tones, _, illumination = painted(seed)
    for part in (0, 1):
        here = SHAPE.parts == part
        assert (np.diff(tones[here][np.argsort(illumination[here])]) >= 0).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_brightest_tone_of_every_material_is_seen_alike(seed: int) -> None:
    tones, _, _ = painted(seed)
    brightest = [tones[SHAPE.parts == part].max() for part in (0, 1)]
    assert brightest == pytest.approx([float(linear_to_srgb(np.array(LIT)))] * 2, abs=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_shading_shows_where_a_material_has_more_than_one_tone(seed: int) -> None:
    tones, told, _ = painted(seed)
    for part in (0, 1):
        here = SHAPE.parts == part
        assert told[here].all() == (np.ptp(tones[here]) > 0)
        assert told[here].all() or not told[here].any()
    assert not told[~SHAPE.mask].any()


def test_some_materials_are_flat_and_most_are_not() -> None:
    told = [bool(painted(seed)[1][SHAPE.parts == part].all()) for seed in SEEDS for part in (0, 1)]
    assert 0.4 < np.mean(told) < 0.9

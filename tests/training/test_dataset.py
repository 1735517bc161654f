"""The dataset: shards that can be made in any order and again, the eight views of a shape, and drawings of it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from itertools import islice, repeat
from pathlib import Path

import numpy as np
import pytest

from tests.training.shapes import ellipsoids
from toonkit import ToonkitError, inflate, light_direction
from toonkit.estimation import light_prior
from toonkit.estimation.turn import TURNS
from toonkit.estimation.working_square import FILL, SIZE
from toonkit.training import dataset
from toonkit.training.dataset import CUT_OFF, Dataset, draw_cut_off, make_dataset
from toonkit.training.drawings import DOUBTS, ELEVATIONS, Drawing, Drawings, tilt_light
from toonkit.training.families import random_solid
from toonkit.training.rendering import Rendered, render_solid

VARIANTS = range(8)

FIELDS = [field.name for field in fields(Dataset)]


@pytest.fixture(autouse=True)
def small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two shapes in a file; threads, since a process of its own would not know of it."""
    monkeypatch.setattr(dataset, "SHARD", 2)
    monkeypatch.setattr(dataset, "ProcessPoolExecutor", lambda workers, **_: ThreadPoolExecutor(workers))


def made(folder: Path, count: int = 3, seed: int = 5, workers: int = 1) -> Dataset:
    return make_dataset(folder, count, seed, workers=workers, progress=lambda shards, count: shards)


def same(first: Dataset, second: Dataset) -> bool:
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in FIELDS)


def test_as_many_shapes_as_wanted_with_truth_and_inflated_normals(tmp_path: Path) -> None:
    shapes = made(tmp_path)
    assert len(shapes) == 3
    assert shapes.normals.shape == shapes.initial_normals.shape == (3, SIZE, SIZE, 3)
    assert shapes.normals.dtype == shapes.initial_normals.dtype == np.float16
    for field in (shapes.normals, shapes.initial_normals):
        assert np.linalg.norm(field[shapes.masks].astype(float), axis=-1) == pytest.approx(
            1, abs=2e-3
        )  # 11 bits
        assert not field[~shapes.masks].any()
    rng = np.random.default_rng([5, 0])
    assert rng.random() > CUT_OFF  # the first one is whole
    first = render_solid(random_solid(rng), SIZE)
    assert first is not None
    assert np.array_equal(shapes.masks[0], first.mask)
    assert np.array_equal(shapes.contours[0], first.contours)
    assert np.array_equal(shapes.parts[0], first.parts)
    assert shapes.normals[0] == pytest.approx(first.normals, abs=1e-3)
    inflated = np.nan_to_num(inflate(first.mask, alpha=first.coverage).vectors)
    assert shapes.initial_normals[0] == pytest.approx(inflated, abs=1e-3)


def test_shards_that_are_there_are_read_and_not_rendered_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = made(tmp_path)
    monkeypatch.setattr(dataset, "render_solid", None)
    assert same(made(tmp_path), first)


def test_a_shard_from_before_shapes_had_contours_is_made_again(tmp_path: Path) -> None:
    first = made(tmp_path)
    shard = tmp_path / "shapes-5-00001.npz"
    with np.load(shard) as stored:
        older = {name: stored[name] for name in stored.files if name != "contours"}
    np.savez(shard, **older)
    assert same(made(tmp_path), first)


def test_a_missing_shard_is_made_again_as_it_was(tmp_path: Path) -> None:
    first = made(tmp_path)
    shard = tmp_path / "shapes-5-00001.npz"
    shard.unlink()
    assert same(made(tmp_path), first)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["shapes-5-00000.npz", "shapes-5-00001.npz"]


def test_shapes_do_not_depend_on_how_many_are_made_or_by_how_many(tmp_path: Path) -> None:
    few, many = made(tmp_path / "few"), made(tmp_path / "many", count=5, workers=3)
    assert same(few, Dataset(**{name: getattr(many, name)[:3] for name in FIELDS}))


def test_another_seed_makes_other_shapes_and_no_two_are_alike(tmp_path: Path) -> None:
    masks = [mask for seed in (5, 6) for mask in made(tmp_path, count=3, seed=seed).masks]
    assert all((masks[i] != masks[j]).any() for i in range(6) for j in range(i))


def test_progress_sees_every_shard_once(tmp_path: Path) -> None:
    seen: list[int] = []

    def watched(shards, count):
        assert count == 3
        for shard in shards:
            seen.append(shard)
            yield shard

    make_dataset(tmp_path, 5, 5, workers=2, progress=watched)
    assert seen == [0, 1, 2]


def test_a_solid_that_cannot_be_seen_or_inflated_is_replaced_by_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = made(tmp_path / "plain", count=2)
    refused = iter([True, False, False])

    def slivers(mask: np.ndarray, *, alpha: np.ndarray) -> object:
        if next(refused):
            raise ToonkitError("mask must have an interior; got a sliver")
        return inflate(mask, alpha=alpha)

    monkeypatch.setattr(dataset, "inflate", slivers)
    replaced = made(tmp_path / "replaced", count=2)
    assert np.array_equal(replaced.masks[0], plain.masks[1])
    assert replaced.masks[1].any()


def cut_off_shapes(count: int) -> list[Rendered]:
    rng = np.random.default_rng(8)
    drawn = (draw_cut_off(rng) for _ in repeat(None))
    return list(islice((shape for shape in drawn if shape is not None), count))


def test_what_the_frame_cuts_off_touches_it_and_has_no_rim_there() -> None:
    turned_away = []
    for shape in cut_off_shapes(12):
        ends = [shape.mask[0], shape.mask[-1], shape.mask[:, 0], shape.mask[:, -1]]
        assert any(end.any() for end in ends)
        assert max(np.ptp(places) + 1 for places in np.nonzero(shape.mask)) == pytest.approx(
            FILL * SIZE, rel=0.1
        )
        assert np.linalg.norm(shape.normals[shape.mask], axis=-1) == pytest.approx(1)
        assert np.array_equal(shape.coverage >= 0.5, shape.mask)
        turns = [(shape.mask, shape.normals, (0, 1)), (shape.mask.T, shape.normals.swapaxes(0, 1), (-1, 0))]
        for mask, normals, outward in turns:  # first and last row and column, and which way is out
            turned_away += list(normals[0][mask[0]][:, :2] @ outward)
            turned_away += list(-(normals[-1][mask[-1]][:, :2] @ outward))
    assert np.mean(turned_away) < 0.6  # all rims would have nearly 1


def test_a_shape_that_was_cut_off_stands_as_near_the_middle_as_its_frame_allows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dataset, "CUT_OFF", 1.0)
    shapes = made(tmp_path, count=4)
    for mask, normals in zip(shapes.masks, shapes.normals, strict=True):
        off = [abs(places.min() + places.max() - (SIZE - 1)) for places in np.nonzero(mask)]
        assert min(off) <= 0.1 * SIZE  # along its longer extent
        assert not normals[~mask].any()
        assert np.linalg.norm(normals[mask].astype(float), axis=-1) == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_inflated_normals_of_a_view_are_those_of_its_mask(variant: int) -> None:
    """Inflation is done anew: no rotation of vectors is taken on trust."""
    shape = ellipsoids(2).view(0, variant)
    inflated = np.nan_to_num(inflate(shape.mask).vectors)
    assert (
        np.abs(shape.initial_normals - inflated).max() < 3e-3
    )  # 16-bit numbers, and the membrane is solved to 1e-5


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_truth_of_a_view_turns_with_its_initial_normals(variant: int) -> None:
    straight, shape = (ellipsoids(2).view(1, which) for which in (0, variant))
    # A turn or a reflection of the picture changes no angle between two normals at a pixel.
    before, now = (np.sort((s.normals * s.initial_normals).sum(axis=-1)[s.mask]) for s in (straight, shape))
    assert now == pytest.approx(before, abs=1e-6)
    assert not shape.normals[~shape.mask].any()
    assert shape.normals.dtype == np.float32


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_views_are_the_turns_in_which_the_light_prior_asks(variant: int) -> None:
    def seen(which: int) -> np.ndarray:
        shape = ellipsoids(2).view(0, which)
        tones = np.where(shape.mask, shape.normals[..., 2] + shape.parts, 0)
        return light_prior.features(tones, shape.mask, shape.contours, shape.initial_normals)

    assert np.array_equal(seen(variant), light_prior.turned(seen(0), TURNS[variant]))


def test_the_eight_views_differ() -> None:
    masks = [ellipsoids(2).view(0, variant).mask for variant in VARIANTS]
    assert all((masks[i] != masks[j]).any() for i in VARIANTS for j in range(i))


def test_a_view_leaves_the_dataset_alone() -> None:
    shapes = ellipsoids(2)
    before = shapes.normals.copy()
    shapes.view(0, 6)[0][:] = 9
    shapes.view(0, 0)[0][:] = 9
    assert np.array_equal(shapes.normals, before)


def test_a_drawing_is_painted_by_its_light_alone() -> None:
    drawings = Drawings(ellipsoids(3), 0, 3)
    for seed in range(6):
        drawing = drawings.draw(np.random.default_rng(seed), turned=True)
        illumination = (drawing.normals @ drawing.light)[drawing.mask]
        tones = drawing.tones[drawing.mask][np.argsort(illumination)]
        assert (np.diff(tones) >= 0).all()
        assert drawing.tones.dtype == drawing.light.dtype == np.float32


def test_lights_come_from_the_right_unless_they_may_come_from_anywhere() -> None:
    drawings = Drawings(ellipsoids(1), 0, 1)
    rng = np.random.default_rng(4)
    anywhere, right = (
        np.array([drawings.draw(rng, turned=turned).light for _ in range(80)]) for turned in (True, False)
    )
    for lights in (anywhere, right):
        assert np.linalg.norm(lights, axis=1) == pytest.approx(1, abs=1e-6)
        elevation = np.rad2deg(np.arcsin(lights[:, 2]))
        assert elevation.min() >= ELEVATIONS[0] - 1e-3
        assert elevation.max() <= ELEVATIONS[1] + 1e-3
        assert np.ptp(elevation) > 50
    assert (np.abs(right[:, 1]) < 1e-6).all()
    assert (right[:, 0] > 0).all()
    assert {(bool(x > 0), bool(y > 0)) for x, y in anywhere[:, :2]} == {
        (a, b) for a in (True, False) for b in (True, False)
    }


def test_half_of_the_doubtful_lights_are_not_the_ones_that_painted() -> None:
    drawings = Drawings(ellipsoids(3), 0, 3)
    drawn = [drawings.draw(np.random.default_rng(k), turned=False, doubtful=True) for k in range(60)]
    doubted = [drawing for drawing in drawn if drawing.doubt > 0]
    assert 0.3 < len(doubted) / len(drawn) < 0.7
    doubts = np.rad2deg([drawing.doubt for drawing in doubted])
    assert DOUBTS[0] <= doubts.min() < 5
    assert 15 < doubts.max() <= DOUBTS[1]

    def out_of_order(drawing: Drawing) -> bool:
        illumination = (drawing.normals @ drawing.light)[drawing.mask]
        return bool((np.diff(drawing.tones[drawing.mask][np.argsort(illumination)]) < 0).any())

    assert all(out_of_order(drawing) for drawing in doubted)
    assert not any(out_of_order(drawing) for drawing in drawn if drawing.doubt == 0)
    assert all(drawing.light[1] == 0 for drawing in doubted)  # what is known still comes from the right


def test_a_light_is_tilted_by_its_doubt_about_each_of_two_axes_and_stays_in_front() -> None:
    light, rng = light_direction(20, 60), np.random.default_rng(3)
    assert np.array_equal(tilt_light(light, 0.0, rng), light)
    lights = np.array([tilt_light(light, np.deg2rad(4), rng) for _ in range(4000)])
    assert np.linalg.norm(lights, axis=1) == pytest.approx(1)
    side = np.cross(light, [0, 0, 1]) / np.linalg.norm(np.cross(light, [0, 0, 1]))
    for axis in (side, np.cross(light, side)):
        assert np.rad2deg((lights @ axis).std()) == pytest.approx(4, rel=0.05)
    low = np.array([tilt_light(light_direction(0, 3), np.deg2rad(20), rng) for _ in range(200)])
    assert (low[:, 2] > 0).all()


def test_ink_hides_the_paint_and_what_is_seen_there_is_the_nearest_that_shows() -> None:
    drawings = Drawings(ellipsoids(3), 0, 3)
    for seed in range(8):
        clean, inked = (
            drawings.draw(np.random.default_rng(seed), turned=True, inked=inked) for inked in (0.0, 1.0)
        )
        assert not clean.ink.any()
        assert inked.ink.any()
        assert np.array_equal(inked.normals, clean.normals)
        assert np.array_equal(inked.light, clean.light)
        shown = inked.mask & ~inked.ink
        assert np.array_equal(inked.tones[shown], clean.tones[shown])
        row, column = np.argwhere(inked.ink)[7]
        places = np.argwhere(shown)
        away = np.hypot(*(places - [row, column]).T)
        nearest = places[away == away.min()]
        assert inked.tones[row, column] in clean.tones[tuple(nearest.T)]


def test_as_many_drawings_are_inked_as_asked() -> None:
    drawings = Drawings(ellipsoids(3), 0, 3)
    drawn = [drawings.draw(np.random.default_rng(k), turned=True, inked=0.4) for k in range(100)]
    assert 0.25 < np.mean([drawing.ink.any() for drawing in drawn]) < 0.55


def test_only_the_shapes_asked_for_are_drawn() -> None:
    shapes = ellipsoids(4)
    sizes = {int(mask.sum()) for mask in shapes.masks[1:3]}
    rng = np.random.default_rng(0)
    drawn = {int(Drawings(shapes, 1, 3).draw(rng, turned=False).mask.sum()) for _ in range(40)}
    assert drawn == sizes


def test_of_flat_materials_and_under_ink_the_nearest_shading_is_seen() -> None:
    drawings = Drawings(ellipsoids(3), 0, 3)
    drawn = [
        drawings.draw(np.random.default_rng(seed), turned=True, inked=seed % 2, colored=True)
        for seed in range(60)
    ]
    hidden = [drawing for drawing in drawn if drawing.ink.sum() > 0.3 * drawing.mask.sum()]
    assert len(hidden) > 5
    for drawing in hidden:
        shown = drawing.mask & ~drawing.ink
        assert shown.any()
        row, column = np.argwhere(drawing.ink)[7]
        places = np.argwhere(shown)
        away = np.hypot(*(places - [row, column]).T)
        nearest = places[away == away.min()]
        assert drawing.tones[row, column] in drawing.tones[tuple(nearest.T)]


def test_materials_meet_where_parts_do() -> None:
    drawings = Drawings(ellipsoids(3), 0, 3)
    drawn = [drawings.draw(np.random.default_rng(seed), turned=True, colored=True) for seed in range(40)]
    assert 0.4 < np.mean([drawing.borders.any() for drawing in drawn]) < 1.0
    assert drawings.draw(np.random.default_rng(0), turned=True).borders is None

"""The benchmarks of parts and of lights measure what they say, and write a row for each trial."""

from __future__ import annotations

import functools
import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import toonkit
from benchmarks import ablation, inflations, interior_contours, lights
from benchmarks.shape_rows import measured_rows
from tests.analytic import SOFT, TWO_TONE, painted
from toonkit.estimation.light_fit import LightEstimate
from toonkit.estimation.packing import round_normals
from toonkit.estimation.preparation import prepare
from toonkit.estimation.refinement import RefinementOptions
from toonkit.estimation.shape_prior import correct_shape
from toonkit.numerics.masked_grid import MaskedGrid
from toonkit.study.color_maps import load_color_maps
from toonkit.study.painting import Painting, StudySettings, paint
from toonkit.study.rendering import RenderedShape, render_shape
from toonkit.study.shapes import SHAPES

STUDY = Path(__file__).parent.parent / "notebooks" / "study"
SMALL = StudySettings(size=48)
NOT_TIMED = [name for name in ablation.COLUMNS if name != "seconds"]


@pytest.fixture(scope="module")
def painting() -> Painting:
    return paint(render_shape(SHAPES["pear"], 64), load_color_maps()["terracotta"], StudySettings(size=64))


def vectors(analysis) -> np.ndarray:
    return analysis.normals.vectors[analysis.image.mask]


def test_a_variant_from_which_nothing_is_taken_is_toonkit(painting):
    ours = toonkit.METHODS["toonkit"](painting.image, painting.light)
    same = ablation.varied(painting.image, painting.light)
    assert np.array_equal(vectors(same), vectors(ours))
    assert np.array_equal(same.color_map.colors, ours.color_map.colors)


def test_the_learned_shape_alone_is_what_the_network_answers(painting):
    alone = ablation.varied(painting.image, painting.light, refined=False)
    answer = correct_shape(
        painting.image, painting.light, toonkit.inflate(painting.image.mask, alpha=painting.image.alpha)
    )
    assert np.array_equal(vectors(alone), round_normals(answer.compact))


def test_every_variant_differs_from_every_other(painting):
    found = {
        name: vectors(method(painting.image, painting.light))
        for name, method in ablation.variants(painting).items()
    }
    names = list(found)
    alike = [
        (one, other)
        for place, one in enumerate(names)
        for other in names[:place]
        if np.allclose(found[one], found[other], atol=1e-6)
    ]
    assert alike == []


def test_the_oracle_refines_into_the_true_intervals_and_relights_with_the_true_color_map():
    # Of a fish in hard tones the color map cannot be told well: the oracle knows what the method does not.
    painting = paint(
        render_shape(SHAPES["fish"], 64), load_color_maps()["terracotta"], StudySettings(size=64)
    )
    told = ablation.varied(
        painting.image,
        painting.light,
        options=RefinementOptions(margin=0.0),
        color_map=painting.color_map,
    )
    assert told.color_map is painting.color_map
    guessed = ablation.varied(painting.image, painting.light, options=RefinementOptions(margin=0.0))
    true = toonkit.illumination_interval(painting.image, painting.color_map)

    def outside(analysis) -> float:
        lit = analysis.illumination[painting.image.mask]
        lower, upper = true.lower[painting.image.mask], true.upper[painting.image.mask]
        return float(np.maximum(np.maximum(lower - lit, lit - upper), 0.0).mean())

    assert outside(told) < 0.2 * outside(guessed)


def test_the_command_writes_a_row_for_each_variant_shape_and_color_map(painting, tmp_path, capsys):
    target = tmp_path / "ablation.csv"
    ablation.main(
        ["--size", "48", "--shapes", "torus", "pear", "--maps", "ocean", "--workers", "0", "-o", str(target)]
    )
    table = pd.read_csv(target)
    assert list(table.columns) == list(ablation.COLUMNS)
    names = list(ablation.variants(painting))
    assert table["variant"].tolist() == names * 2
    assert table["shape"].tolist() == ["torus"] * len(names) + ["pear"] * len(names)
    assert set(table["size"]) == {48}
    assert np.isfinite(table[list(ablation.MEASURES)]).all(axis=None)
    printed = capsys.readouterr().out
    mean = table.loc[table["variant"] == "todo", "angular_error"].mean()
    assert f"| todo | {mean:.4g} |" in printed


def test_workers_measure_the_same():
    work = functools.partial(ablation.measured, color_maps=["ocean"], settings=SMALL)
    here, there = (measured_rows(work, ["torus"], workers=workers)[NOT_TIMED] for workers in (0, 1))
    pd.testing.assert_frame_equal(here, there, rtol=1e-4)


def test_a_trial_that_fails_ends_the_benchmark_by_name(monkeypatch):
    def broken(image, light, *, progress=None):
        raise ValueError("no shape in sight")

    monkeypatch.setitem(toonkit.METHODS, "todo", broken)
    with pytest.raises(RuntimeError, match="torus--ocean--todo--given: ValueError: no shape in sight"):
        ablation.measured("torus", ["ocean"], SMALL)


BALL = render_shape(SHAPES["sphere"], 96)
PICTURE = toonkit.ToonImage(np.full((96, 96, 3), 0.5), BALL.mask, alpha=BALL.coverage)


@pytest.mark.parametrize("name", [name for name in inflations.INFLATIONS if name != "multi-scale"])
def test_a_disc_is_inflated_to_a_half_sphere(name):
    found = inflations.INFLATIONS[name](PICTURE)
    assert toonkit.angular_error(found, BALL.normals).mean < 1.0


def test_scales_that_forget_the_outline_flatten_the_middle_of_a_disc():
    flat = inflations.multi_scale(PICTURE).vectors
    round_one = inflations.poisson(PICTURE).vectors
    middle = BALL.mask & (BALL.normals.vectors[..., 2] > 0.7)
    assert flat[middle][:, 2].mean() > round_one[middle][:, 2].mean() + 0.02


@pytest.mark.parametrize("name", list(inflations.INFLATIONS))
def test_inflations_look_outward_and_are_turned_with_the_silhouette(name):
    truth = render_shape(SHAPES["pear"], 64)
    inflation = inflations.INFLATIONS[name]

    def inflated(mask, alpha):
        return inflation(toonkit.ToonImage(np.full((*mask.shape, 3), 0.5), mask, alpha=alpha)).vectors

    upright = inflated(truth.mask, truth.coverage)
    turned = inflated(np.rot90(truth.mask), np.rot90(truth.coverage))
    x, y, z = np.moveaxis(np.rot90(upright), -1, 0)
    # The outline is traced between pixels row by row, which a turned picture does to a hundredth of a pixel otherwise.
    np.testing.assert_allclose(turned, np.stack([-y, x, z], axis=-1), atol=0.02)
    assert np.nanmin(upright[..., 2]) >= 0


def test_a_refined_inflation_explains_more_of_the_picture(painting):
    alone, refined = (
        inflations.started(painting.image, painting.light, inflation=inflations.medial, refined=refined)
        for refined in (False, True)
    )
    errors = [toonkit.color_rmse(found.picture, painting.image) for found in (alone, refined)]
    assert errors[1] < 0.7 * errors[0]


def test_the_harmonic_variants_are_lumo_and_classical(painting):
    for refined, method in ((False, "lumo"), (True, "classical")):
        ours = inflations.started(
            painting.image, painting.light, inflation=inflations.harmonic, refined=refined
        )
        assert np.array_equal(vectors(ours), vectors(toonkit.METHODS[method](painting.image, painting.light)))


RIGHT = toonkit.light_direction(0, 30)


def balls(*centers: float) -> tuple[toonkit.ToonImage, RenderedShape]:
    """Balls of radius 60, the later in front of the earlier, lit from the right."""
    y, x = np.mgrid[80:-80:161j, -110:110:221j]
    vectors = np.full((161, 221, 3), np.nan)
    depth = np.full((161, 221), np.nan)
    for order, center in enumerate(centers):
        side = np.stack([x - center, y], axis=-1) / 60
        on_it = (side**2).sum(axis=-1) < 1
        up = np.sqrt(np.maximum(1 - (side**2).sum(axis=-1), 0))
        vectors[on_it] = np.dstack([side, up])[on_it]
        depth[on_it] = (60 * up + 100 * order)[on_it]
    normals = toonkit.NormalField(vectors, np.isfinite(depth))
    shape = RenderedShape(
        normals, normals.mask.astype(float), depth, np.where(normals.mask, 0, -1).astype(np.intp)
    )
    return painted(normals, SOFT, light=RIGHT), shape


def test_a_true_contour_ties_the_nearer_side_alone_and_cuts_from_both():
    _, shape = balls(35, -35)
    grid = MaskedGrid(shape.mask)
    contours = interior_contours.true_contours(shape)
    cut, outward = contours.cut, contours.outward
    tied = outward.any(axis=1)
    near = shape.normals.vectors[grid.mask]
    assert tied.sum() > 60
    assert (near[tied][:, 0] > 0.3).all()  # the left ball's right side
    assert np.linalg.norm(outward[tied], axis=1) == pytest.approx(1)
    assert np.einsum("pc,pc->p", outward[tied], near[tied][:, :2]).min() > 0.85
    for direction, there in enumerate(grid.neighbors.T):
        crossing = np.flatnonzero(cut[:, direction])
        assert cut[there[crossing], (direction + 2) % 4].all()


def test_a_crease_is_no_contour():
    """Two balls that touch in one plane: their normals jump, their depth does not."""
    _, left = balls(-35)
    _, right = balls(35)
    nearer = np.nan_to_num(left.depth, nan=-1) >= np.nan_to_num(right.depth, nan=-1)
    vectors = np.where(nearer[..., None], left.normals.vectors, right.normals.vectors)
    depth = np.where(nearer, left.depth, right.depth)
    normals = toonkit.NormalField(vectors, np.isfinite(depth))
    shape = RenderedShape(normals, left.coverage, depth, left.part)
    grid = MaskedGrid(shape.mask)
    field = vectors[grid.mask]
    right_of = grid.neighbors[:, 0]
    jump = np.linalg.norm(field[right_of] - field, axis=1)[right_of >= 0]
    assert jump.max() > 0.8
    contours = interior_contours.true_contours(shape)
    assert not contours.cut.any()
    assert not contours.outward.any()


def test_a_contour_is_found_where_the_lit_end_of_a_ball_meets_the_one_behind_it():
    image, shape = balls(35, -35)
    outward = interior_contours.found_contours(image, RIGHT).outward
    tied = outward.any(axis=1)
    assert tied.sum() > 30
    agree = np.einsum("pc,pc->p", outward[tied], shape.normals.vectors[image.mask][tied][:, :2])
    assert np.mean(agree > 0.7) > 0.9


@pytest.mark.parametrize("known", ["true", "found"])
def test_a_smooth_shape_has_no_interior_contours(known):
    image, shape = balls(0)
    if known == "true":
        contours = interior_contours.true_contours(shape)
    else:
        contours = interior_contours.found_contours(image, RIGHT)
    assert not contours.cut.any()
    assert not contours.outward.any()
    inflated = interior_contours.inflated_within(image, contours)
    assert np.array_equal(inflated.vectors, toonkit.inflate(image.mask).vectors, equal_nan=True)


def test_an_inflation_that_knows_the_true_contours_is_nearer_the_truth():
    image, shape = balls(35, -35)
    inflated = interior_contours.inflated_within(image, interior_contours.true_contours(shape))
    errors = [
        toonkit.angular_error(field, shape.normals).mean for field in (inflated, toonkit.inflate(image.mask))
    ]
    assert errors[0] < 0.75 * errors[1]


def test_a_line_along_a_contour_ties_the_side_that_is_lit_as_a_rim():
    image, shape = balls(35, -35)
    drawing = interior_contours.in_ink(image, shape)
    contours = interior_contours.lines_found(drawing, RIGHT)
    assert contours is not None
    tied = contours.outward.any(axis=1)
    assert tied.sum() > 30
    agree = np.einsum("pc,pc->p", contours.outward[tied], shape.normals.vectors[image.mask][tied][:, :2])
    assert np.mean(agree > 0.7) > 0.9
    errors = [
        toonkit.angular_error(field, shape.normals).mean
        for field in (interior_contours.inflated_within(drawing, contours), toonkit.inflate(image.mask))
    ]
    assert errors[0] < 0.8 * errors[1]


def test_a_line_across_a_ball_is_taken_for_a_contour_which_is_why_no_method_does():
    image, shape = balls(0)
    height = np.mgrid[80:-80:161j, -110:110:221j][0]
    line = (np.abs(height) < 1.1)[..., None]
    from_above = toonkit.light_direction(90, 50)
    clean = painted(shape.normals, TWO_TONE, light=from_above).color
    drawing = interior_contours.in_ink(toonkit.ToonImage(clean, image.mask), shape)
    drawing = toonkit.ToonImage(np.where(line, interior_contours.INK, drawing.color), image.mask)
    contours = interior_contours.lines_found(drawing, from_above)
    assert contours is not None
    plain, contoured = (
        toonkit.angular_error(interior_contours.inflated_within(drawing, given), shape.normals).mean
        for given in (None, contours)
    )
    assert contoured > plain + 5


def test_the_drawing_in_ink_is_the_picture_but_for_its_lines():
    image, shape = balls(35, -35)
    drawing = interior_contours.in_ink(image, shape)
    ink = prepare(drawing).mixed
    changed = np.abs(drawing.color - image.color).max(axis=-1)[image.mask] > 0
    assert set(ink.pixels) >= set(np.flatnonzero(changed & (image.color[image.mask].mean(axis=1) > 0.4)))
    near = interior_contours.true_contours(shape).outward.any(axis=1)
    assert np.allclose(drawing.color[drawing.mask][near], interior_contours.INK)


@pytest.mark.parametrize("learned", [False, True])
def test_lines_that_are_taken_off_cost_less_than_lines_read_as_shading(learned):
    truth = render_shape(SHAPES["pear"], 96)
    painting = paint(truth, load_color_maps()["terracotta"], StudySettings(size=96))
    name = "toonkit" if learned else "classical"
    methods = interior_contours.variants(painting)
    errors = [
        toonkit.angular_error(
            methods[name + suffix](painting.image, painting.light).normals, truth.normals
        ).mean
        for suffix in ("", ", in ink, taken off", ", in ink, read as shading")
    ]
    assert errors[0] < errors[1] < errors[2]


def test_the_lights_stand_all_around_and_three_at_each_elevation():
    azimuths, elevations = np.transpose(lights.LIGHTS)
    assert np.diff(np.sort(azimuths)) == pytest.approx(np.full(8, 40.0))
    assert {float(height): (elevations == height).sum() for height in lights.ELEVATIONS} == {
        20.0: 3,
        47.5: 3,
        75.0: 3,
    }


def toward_the_viewer(image, *, initial_normals) -> LightEstimate:
    assert initial_normals.mask is image.mask or np.array_equal(initial_normals.mask, image.mask)
    return LightEstimate(toonkit.light_direction(0, 90), 0.25)


def test_the_error_of_a_light_is_the_angle_to_the_true_one(monkeypatch):
    monkeypatch.setattr(lights, "estimate_light", toward_the_viewer)
    table = pd.DataFrame(lights.measured("pear", ["ocean"], 48))
    assert table["error"].tolist() == pytest.approx((90.0 - table["elevation"]).tolist())
    assert table["estimated_elevation"].tolist() == pytest.approx([90.0] * 9)
    assert set(table["confidence"]) == {0.25}


def test_the_command_writes_a_row_for_each_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(lights, "estimate_light", toward_the_viewer)
    target = tmp_path / "lights.csv"
    lights.main(
        [
            "--size",
            "48",
            "--shapes",
            "torus",
            "pear",
            "--maps",
            "ocean",
            "candy",
            "--workers",
            "0",
            "-o",
            str(target),
        ]
    )
    table = pd.read_csv(target)
    assert list(table.columns) == list(lights.COLUMNS)
    assert len(table) == 2 * 2 * len(lights.LIGHTS)
    assert not table.duplicated(["shape", "color_map", "azimuth", "elevation"]).any()
    printed = capsys.readouterr().out
    assert all(row in printed for row in ("all pictures", "the surer half", "the rest", "elevation 47.5°"))


@pytest.mark.parametrize("command", [ablation.main, inflations.main, lights.main])
def test_an_unknown_shape_is_refused_before_any_work(command, capsys):
    with pytest.raises(SystemExit):
        command(["--shapes", "unicorn"])
    assert "unicorn" in capsys.readouterr().err


@pytest.mark.parametrize(
    "benchmark", [ablation, inflations, interior_contours], ids=lambda module: module.__name__
)
def test_the_committed_table_has_every_variant_on_all_shapes(painting, benchmark):
    table = pd.read_csv(STUDY / f"{benchmark.__name__.rpartition('.')[2]}.csv")
    assert list(table.columns) == list(ablation.COLUMNS)
    names = list(benchmark.variants(painting))
    assert list(dict.fromkeys(table["variant"])) == names
    assert set(table["size"]) == {256}
    expected = set(itertools.product(names, SHAPES, ablation.COLOR_MAP_NAMES))
    assert set(table[["variant", "shape", "color_map"]].itertuples(index=False, name=None)) == expected
    assert len(table) == len(expected)


def test_the_committed_lights_are_those_of_the_benchmark():
    table = pd.read_csv(STUDY / "lights.csv")
    assert list(table.columns) == list(lights.COLUMNS)
    assert set(table["size"]) == {256}
    asked = ["shape", "color_map", "azimuth", "elevation"]
    expected = {
        (*names, *angles)
        for names in itertools.product(SHAPES, load_color_maps())
        for angles in lights.LIGHTS
    }
    assert set(table[asked].itertuples(index=False, name=None)) == expected
    assert len(table) == len(expected)

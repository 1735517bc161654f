"""Materials are found whatever they are painted like, and none is found where there is only shading."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from tests.illustration.drawings import (
    BLACK,
    BLUE,
    GREEN,
    LIGHT,
    RED,
    SKIN,
    Ball,
    Canvas,
    Drawn,
    agreement,
    same_partition,
)
from toonkit import Materials, ToonImage, analyze, angular_error, find_materials, relight
from toonkit.estimation.preparation import prepare
from toonkit.study.color_maps import load_color_maps
from toonkit.synthetic.drawing import draw_scene

BODY = Ball(48, 48, 42, RED)
LEFT, RIGHT = Ball(48, 32, 28, GREEN), Ball(50, 66, 24, SKIN)


def found(drawn: Drawn) -> Materials:
    """Find the materials of a drawing."""
    return find_materials(ToonImage(drawn.color, drawn.mask))


def agrees(drawn: Drawn, materials: Materials) -> float:
    shown = drawn.mask & (drawn.ink < 0.5)
    return agreement(drawn.label[shown], materials.labels[shown])


def two_parts(*, ink: float = 0.0) -> Drawn:
    canvas = Canvas()
    for label, ball in enumerate((LEFT, RIGHT)):
        canvas.ball(ball, label)
        if ink:
            canvas.outline(ball, ink)
    return canvas.drawn()


@pytest.mark.parametrize("ink", [0.0, 1.2, 2.4])
def test_two_shaded_parts_are_two_materials(ink: float) -> None:
    drawn = two_parts(ink=ink)
    materials = found(drawn)
    assert materials.count == 2
    assert agrees(drawn, materials) > 0.97


@pytest.mark.parametrize("name", list(load_color_maps()))
def test_a_ball_in_one_material_is_one_however_its_hue_turns(name: str) -> None:
    canvas = Canvas()
    canvas.ball(BODY, 0)
    drawn = canvas.drawn()
    color = np.zeros_like(drawn.color)
    color[drawn.mask] = load_color_maps()[name]((drawn.normals @ LIGHT)[drawn.mask])
    assert found(Drawn(color, drawn.mask, drawn.label, drawn.ink, drawn.normals)).count == 1


def test_tones_are_the_painted_colors_darkest_first() -> None:
    materials = found(two_parts())
    for tones, painted in zip(materials.tones, (GREEN, SKIN), strict=True):
        np.testing.assert_allclose(tones, painted, atol=0.01)


def test_flat_fills_are_materials() -> None:
    canvas = Canvas()
    for label, (row, color) in enumerate([(30, RED[1]), (48, BLUE[1]), (66, (0.95, 0.85, 0.3))]):
        canvas.fill(canvas.disc(row, 48, 26), color, label)
    drawn = canvas.drawn()
    materials = found(drawn)
    assert materials.count == 3
    assert agrees(drawn, materials) > 0.98


def test_grays_that_belong_to_different_things_stay_apart() -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, ((0.62, 0.64, 0.70), (0.96, 0.96, 0.97))), 0)
    canvas.fill(canvas.disc(70, 40, 9), (0.35, 0.35, 0.36), 1)
    canvas.fill(canvas.disc(34, 60, 6), (0.08, 0.08, 0.09), 2)
    drawn = canvas.drawn()
    materials = found(drawn)
    assert materials.count == 3
    assert agrees(drawn, materials) > 0.97


def test_one_color_in_separate_parts_is_one_material() -> None:
    canvas = Canvas(128)
    canvas.ball(Ball(64, 64, 40, RED), 0)
    for row, column in ((20, 20), (20, 108), (108, 64)):
        canvas.ball(Ball(row, column, 16, BLUE), 1)
    drawn = canvas.drawn()
    materials = found(drawn)
    assert materials.count == 2
    assert agrees(drawn, materials) > 0.98


def _spots(canvas: Canvas) -> np.ndarray:
    centers = [(30, 40), (40, 64), (60, 36), (64, 62), (48, 48)]
    return np.any([canvas.disc(row, column, 6) for row, column in centers], axis=0)


def _stripes(canvas: Canvas) -> np.ndarray:
    return (canvas.columns % 16 < 8) & (canvas.label == 0)


def _eyes(canvas: Canvas) -> np.ndarray:
    return canvas.disc(40, 36, 3) | canvas.disc(40, 60, 3)


def _cheeks(canvas: Canvas) -> np.ndarray:
    return canvas.disc(58, 28, 7) | canvas.disc(58, 66, 7)


@pytest.mark.parametrize(
    ("pattern", "color", "paint"),
    [
        (_spots, (0.95, 0.90, 0.80), RED),
        (_stripes, (0.95, 0.80, 0.25), GREEN),
        (_eyes, (0.10, 0.30, 0.20), SKIN),
        (_cheeks, (0.93, 0.50, 0.52), SKIN),
    ],
)
def test_patterns_and_details_are_materials(pattern: object, color: object, paint: object) -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, paint), 0)
    canvas.fill(pattern(canvas), color, 1)
    drawn = canvas.drawn()
    assert agrees(drawn, found(drawn)) > 0.95


def test_a_soft_gradient_is_one_material_beside_another() -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 40, 36, tuple(map(tuple, np.linspace((0.25, 0.1, 0.3), (0.85, 0.55, 0.9), 60))),
                     tuple(np.linspace(-0.6, 0.9, 59))), 0)  # fmt: skip
    canvas.ball(Ball(60, 72, 20, GREEN), 1)
    drawn = canvas.drawn()
    materials = found(drawn)
    assert materials.count == 2
    assert agrees(drawn, materials) > 0.97


def test_hue_shifted_shadows_join_their_paint() -> None:
    canvas = Canvas()
    canvas.ball(Ball(48, 34, 30, ((0.80, 0.58, 0.54), (0.98, 0.83, 0.72))), 0)
    canvas.ball(Ball(52, 70, 22, ((0.17, 0.35, 0.42), (0.32, 0.58, 0.55))), 1)
    drawn = canvas.drawn()
    materials = found(drawn)
    assert materials.count == 2
    assert agrees(drawn, materials) > 0.97


def test_grain_belongs_to_its_paint() -> None:
    drawn = two_parts()
    noise = ndimage.gaussian_filter(np.random.default_rng(5).normal(size=drawn.mask.shape), 0.7)
    color = np.clip(drawn.color + 0.02 * (noise / noise.std())[..., None], 0, 1)
    grainy = Drawn(color, drawn.mask, drawn.label, drawn.ink, drawn.normals)
    assert agrees(grainy, found(grainy)) > 0.9


def test_compression_makes_no_materials() -> None:
    drawn = two_parts(ink=2.0)
    file = io.BytesIO()
    shown = np.where(drawn.mask[..., None], drawn.color, 1.0)
    Image.fromarray(np.rint(shown * 255).astype(np.uint8)).save(file, "JPEG", quality=90, subsampling=0)
    color = np.asarray(Image.open(file)) / 255.0
    smeared = Drawn(color, drawn.mask, drawn.label, drawn.ink, drawn.normals)
    assert agrees(smeared, found(smeared)) > 0.93


def test_mixed_pixels_of_borders_are_no_material() -> None:
    drawn = two_parts()
    blurred = ndimage.gaussian_filter(drawn.color * drawn.mask[..., None], (0.8, 0.8, 0))
    weight = ndimage.gaussian_filter(drawn.mask.astype(float), 0.8)
    color = np.clip(np.where(drawn.mask[..., None], blurred / np.maximum(weight, 1e-9)[..., None], 0), 0, 1)
    materials = found(Drawn(color, drawn.mask, drawn.label, drawn.ink, drawn.normals))
    assert materials.count == 2


def test_pixel_art_keeps_its_small_parts() -> None:
    picture = np.array([list(row) for row in [
        "..rrrrrr..", ".rrrrrrrr.", "rrrrrrrrRR", "rrwwrrwwRR", "rrwbrrwbRR",
        "rrrrrrrRRR", "gggggggGGG", "ggggggGGGG", ".gggGGGGG.", "..GGGGGG..",
    ]]).repeat(2, axis=0).repeat(2, axis=1)  # fmt: skip
    paints = {"r": RED[1], "R": RED[0], "g": GREEN[1], "G": GREEN[0], "w": (1.0, 1.0, 1.0), "b": BLACK}
    color = np.zeros((*picture.shape, 3))
    label = np.full(picture.shape, -1)
    for name, paint in paints.items():
        color[picture == name] = paint
        label[picture == name] = "rgwb".index(name.lower())
    mask = picture != "."
    drawn = Drawn(color, mask, label, np.zeros(mask.shape), np.zeros((*mask.shape, 3)))
    assert agrees(drawn, found(drawn)) > 0.9


def test_dithered_paint_is_not_cut_to_pieces() -> None:
    drawn = two_parts()
    checks = (np.indices(drawn.mask.shape).sum(axis=0) % 2 == 0)[..., None]
    color = np.clip(np.where(checks, drawn.color * 1.03, drawn.color * 0.97), 0, 1)
    dithered = Drawn(color, drawn.mask, drawn.label, drawn.ink, drawn.normals)
    assert agrees(dithered, found(dithered)) > 0.9


def test_ink_takes_the_material_of_the_paint_beside_it() -> None:
    drawn = two_parts(ink=2.4)
    materials = found(drawn)
    assert (materials.labels[drawn.mask] >= 0).all()
    assert agreement(drawn.label[drawn.mask], materials.labels[drawn.mask]) > 0.9


def test_labels_say_nothing_outside_and_the_largest_comes_first() -> None:
    drawn = two_parts()
    materials = found(drawn)
    assert (materials.labels[~drawn.mask] == -1).all()
    area = np.bincount(materials.labels[drawn.mask])
    assert list(area) == sorted(area, reverse=True)


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_turned_or_mirrored_drawing_has_turned_or_mirrored_materials(turns: int, mirrored: bool) -> None:
    drawn = two_parts(ink=1.6)

    def moved(values: np.ndarray) -> np.ndarray:
        values = np.rot90(values, turns)
        return (values[:, ::-1] if mirrored else values).copy()

    there = found(Drawn(*map(moved, (drawn.color, drawn.mask, drawn.label, drawn.ink, drawn.normals))))
    here = moved(found(drawn).labels)
    assert same_partition(there.labels[moved(drawn.mask)], here[moved(drawn.mask)])


def test_padding_changes_nothing() -> None:
    drawn = two_parts(ink=1.6)
    around = ((9, 3), (2, 17))
    padded = Drawn(
        np.pad(drawn.color, (*around, (0, 0))),
        np.pad(drawn.mask, around),
        *(np.pad(values, around) for values in (drawn.label, drawn.ink)),
        np.pad(drawn.normals, (*around, (0, 0))),
    )
    np.testing.assert_array_equal(found(padded).labels[9:-3, 2:-17], found(drawn).labels)


def test_a_drawing_of_one_flat_color_is_one_material() -> None:
    color = np.full((20, 20, 3), 0.5)
    materials = find_materials(ToonImage(color, np.ones((20, 20), bool)))
    assert materials.count == 1
    np.testing.assert_allclose(materials.tones[0], [[0.5, 0.5, 0.5]], atol=1e-6)


def test_nothing_but_ink_is_one_material() -> None:
    drawing = prepare(ToonImage(np.full((20, 20, 3), 0.1), np.ones((20, 20), bool)))
    drawing.ink = replace(drawing.ink, coverage=drawing.ink.coverage + 1)
    assert drawing.materials.count == 1


@pytest.mark.parametrize("quality", [95, 90])
def test_a_compressor_s_noise_is_taken_off_flat_paint_and_kept_when_relit(quality: int) -> None:
    canvas = Canvas(192)
    canvas.ball(Ball(96, 96, 84, SKIN), 0)
    drawn = canvas.drawn()
    page = np.where(drawn.mask[..., None], drawn.color, 1.0)
    buffer = io.BytesIO()
    Image.fromarray(np.round(page * 255).astype(np.uint8)).save(buffer, "JPEG", quality=quality)
    image = ToonImage(np.asarray(Image.open(buffer)) / 255, drawn.mask)
    drawing = prepare(image)
    assert drawing.materials.count == 1
    shares = []
    for color in (image.color[image.mask], drawing.paint):
        _, pixels = np.unique(np.round(color * 255), axis=0, return_counts=True)
        shares.append(np.sort(pixels)[-2:].sum() / pixels.sum())
    assert shares[0] < 0.95 < shares[1]
    analysis = analyze(image, LIGHT)
    assert np.array_equal(relight(analysis, LIGHT).to_rgba(), image.to_rgba())


def test_a_compressor_hides_neither_ink_nor_tones_and_hardly_changes_the_shape() -> None:
    scene = draw_scene(10_002, size=256, recipe="bee")
    page = np.where(scene.image.mask[..., None], scene.image.color, 1.0)
    buffer = io.BytesIO()
    Image.fromarray(np.round(page * 255).astype(np.uint8)).save(buffer, "JPEG", quality=90)
    compressed = ToonImage(np.asarray(Image.open(buffer)) / 255, scene.image.mask)
    clean, noisy = analyze(scene.image, scene.light), analyze(compressed, scene.light)
    ink = [analysis.drawing.ink_coverage.sum() for analysis in (clean, noisy)]
    assert ink[1] == pytest.approx(ink[0], rel=0.15)
    tones = [[len(shades) for shades in analysis.materials.tones[:3]] for analysis in (clean, noisy)]
    assert tones[0] == tones[1]
    assert angular_error(noisy.normals, clean.normals).mean < 10.0  # 23 with the noise


def test_clean_paint_and_gradients_are_no_noise() -> None:
    for tones in (RED, tuple(map(tuple, np.linspace((0.25, 0.1, 0.3), (0.85, 0.55, 0.9), 60)))):
        canvas = Canvas()
        canvas.ball(Ball(48, 48, 42, tones, tuple(np.linspace(-0.6, 0.9, len(tones) - 1))), 0)
        drawn = canvas.drawn()
        drawing = prepare(ToonImage(drawn.color, drawn.mask))
        assert np.array_equal(drawing.paint, drawn.color[drawn.mask])

"""Drawings in several materials, under ink: taken apart, and relit so that each keeps its own colors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.analytic import ellipse
from tests.illustration.drawings import BLUE, GREEN, LIGHT, RED, Ball, Canvas, Drawn
from toonkit import ToonImage, ToonkitError, analyze, find_materials, illumination, light_direction, relight
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.preparation import prepare
from toonkit.export.picture import write_picture
from toonkit.metrics import leak, response

BODY, HEAD = Ball(62, 48, 30, GREEN), Ball(30, 48, 24, RED)
FLAT = (0.85, 0.75, 0.35)
BADGE = np.hypot(*(np.indices((96, 96)) - np.array([70, 44])[:, None, None])) < 7
LIGHTS = [(40, 40), (180, 15), (0, 15), (270, 25), (0, 90)]


def figure() -> Drawn:
    """A head in front of a body, a flat badge on it, all outlined."""
    canvas = Canvas()
    for number, ball in enumerate((BODY, HEAD)):
        canvas.ball(ball, number)
        canvas.outline(ball, 1.8)
    canvas.fill(canvas.disc(70, 44, 10), FLAT, 2)
    return canvas.drawn()


def picture_of(drawn: Drawn) -> ToonImage:
    return ToonImage(drawn.color, drawn.mask, alpha=np.where(drawn.mask, 0.9, 0.0))


@pytest.fixture(scope="module")
def drawn() -> Drawn:
    return figure()


@pytest.fixture(scope="module")
def analysis(drawn) -> ToonAnalysis:
    return analyze(picture_of(drawn), LIGHT)


def spot(analysis: ToonAnalysis, row: int, column: int) -> int:
    return int(analysis.materials.labels[row, column])


def test_the_figure_has_two_shaded_materials_and_a_flat_one(analysis):
    head, body, badge = spot(analysis, 28, 40), spot(analysis, 60, 30), spot(analysis, 70, 44)
    assert analysis.materials.count == len({head, body, badge}) == 3
    assert analysis.materials.flat[[head, body, badge]].tolist() == [False, False, True]
    assert np.allclose(analysis.materials.tones[badge], [FLAT], atol=0.01)


def test_under_its_own_light_a_drawing_returns_unchanged(analysis):
    same = relight(analysis, LIGHT)
    assert np.array_equal(same.to_rgba(), analysis.image.to_rgba())


@pytest.mark.parametrize("light", LIGHTS)
def test_ink_and_alpha_stay_under_every_light(analysis, light):
    relit, ink = relight(analysis, light), analysis.drawing.ink_coverage > 0.98
    assert ink.sum() > 200
    assert np.abs(relit.color - analysis.image.color)[ink].max() <= 1 / 255
    assert np.array_equal(relit.alpha, analysis.image.alpha)


def test_every_material_keeps_its_own_colors(analysis):
    pictures = [relight(analysis, light) for light in LIGHTS]
    assert np.mean([leak(analysis.image, picture) for picture in pictures]) < 0.02
    assert np.mean([response(analysis.image, picture) for picture in pictures]) > 0.03


def test_a_mirrored_drawing_is_relit_mirrored(drawn, analysis):
    mirrored = picture_of(
        replace(drawn, **{name: getattr(drawn, name)[:, ::-1].copy() for name in ("color", "mask")})
    )
    other = relight(analyze(mirrored, LIGHT * [-1, 1, 1]), (140, 40))
    here = relight(analysis, (40, 40))
    apart = np.abs(other.color[:, ::-1] - here.color)[drawn.mask]
    assert np.mean(apart > 0.05) < 0.02


def test_the_base_color_has_one_tone_a_material_and_the_ink(analysis):
    base = analysis.base_color
    for row, column in ((28, 40), (60, 30)):
        own = (analysis.materials.labels == spot(analysis, row, column)) & (
            analysis.drawing.ink_coverage == 0
        )
        painted, lit = analysis.image.color[own].std(axis=0).max(), base.color[own].std(axis=0).max()
        assert lit < 0.25 * painted
    ink = analysis.drawing.ink_coverage > 0.98
    assert np.array_equal(base.color[ink], analysis.image.color[ink])


def test_several_color_maps_are_not_one(analysis):
    assert len(analysis.materials.color_maps) == 3
    with pytest.raises(ToonkitError, match=r"analysis\.materials\.color_maps.*3 materials"):
        _ = analysis.color_map


@pytest.mark.parametrize("light", LIGHTS)
def test_flat_materials_stay_flat_on_demand(analysis, light):
    plain = relight(analysis, light, flat_shading=0)
    assert np.abs(plain.color - analysis.image.color)[BADGE].max() < 0.02


def test_flat_materials_get_shadows_that_come_in_softly(analysis):
    change = [
        np.abs(relight(analysis, light).color - analysis.image.color)[BADGE].mean()
        for light in ((135, 45), (135, 43), (-45, 5))
    ]
    assert change[0] < 1e-9
    assert change[1] < 0.2 * change[2]
    assert change[2] > 0.02
    assert (relight(analysis, (-45, 5)).color[BADGE].mean(axis=0) < np.array(FLAT)).all()


def test_a_drawing_that_is_flat_throughout_is_shaded_from_the_first_turn():
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, (RED[1],), ()), 0)
    canvas.fill(canvas.disc(40, 36, 8), BLUE[1], 1)
    image = picture_of(canvas.drawn())
    analysis = analyze(image, LIGHT)
    assert analysis.materials.flat.all()
    assert np.array_equal(relight(analysis, LIGHT).to_rgba(), image.to_rgba())
    assert response(image, relight(analysis, (-45, 20))) > 0.03
    assert leak(image, relight(analysis, (-45, 20))) < 0.01


def test_own_materials_are_taken_as_they_are(drawn):
    image = picture_of(drawn)
    labels = np.where(drawn.mask, np.where(np.indices(drawn.mask.shape)[0] < 40, 7, 3), -1)
    analysis = analyze(image, LIGHT, materials=labels)
    found = analysis.materials.labels[drawn.mask]
    assert np.array_equal(found, np.where(labels == 7, 1, 0)[drawn.mask])
    assert len(analysis.materials.color_maps) == 2


def test_materials_are_found_where_nobody_named_them(drawn):
    image, left = picture_of(drawn), np.full(drawn.mask.shape, -1)
    left[:46] = 0
    analysis = analyze(image, LIGHT, materials=left)
    assert (analysis.materials.labels[:46][drawn.mask[:46]] == 0).all()
    assert spot(analysis, 60, 30) != spot(analysis, 70, 44) != 0


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        (np.zeros, "integers"),
        (lambda shape: np.zeros((3, 3), int), "size of the picture"),
        (lambda shape: np.full(shape, -2), "from 0 on"),
        (lambda shape: np.full(shape, -1), "somewhere on the object"),
    ],
)
def test_materials_that_are_none_are_refused(drawn, labels, words):
    with pytest.raises(ToonkitError, match=rf"materials .*{words}"):
        analyze(picture_of(drawn), LIGHT, materials=labels(drawn.mask.shape))


@pytest.mark.parametrize("amount", [-0.1, 1.5, "all", np.nan])
def test_flat_shading_beyond_its_range_is_refused(analysis, amount):
    with pytest.raises(ToonkitError, match="flat_shading must be a number from 0 to 1"):
        relight(analysis, LIGHT, flat_shading=amount)


def lines_alone() -> ToonImage:
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 44, ((1.0, 1.0, 1.0),), ()), 0)
    for radius in (44, 25):
        canvas.outline(Ball(48, 48, radius, ()), 1.5)
    return picture_of(canvas.drawn())


def test_a_drawing_of_lines_alone_is_refused_unless_its_materials_are_given():
    image = lines_alone()
    with pytest.raises(ToonkitError, match="no shading found"):
        analyze(image, LIGHT)
    analysis = analyze(image, LIGHT, materials=np.zeros(image.shape, int))
    assert response(image, relight(analysis, (-45, 20))) > 0.02


def test_a_pixel_between_two_materials_follows_both():
    canvas = Canvas()
    canvas.ball(Ball(48, 30, 26, (GREEN[1],), ()), 0)
    canvas.fill(canvas.disc(48, 66, 26), BLUE[1], 1)
    image = picture_of(canvas.drawn())
    drawing = prepare(image)
    mixed = drawing.mixed
    between = (mixed.shares > 0.2).all(axis=1)
    assert between.sum() > 10
    paint = drawing.paint[mixed.sources[between]]
    shown = np.einsum("nk,nkc->nc", mixed.shares[between], paint)
    assert np.abs(shown - mixed.drawn[between]).max() < 0.12
    dark, bright = paint * 0.5, paint
    assert np.allclose(
        mixed.over(drawing.paint[mixed.sources], 0.5 * drawing.paint[mixed.sources])[between],
        mixed.drawn[between] + np.einsum("nk,nkc->nc", mixed.shares[between], dark - bright),
    )


def test_a_highlight_fades_with_the_light_and_is_no_material():
    canvas = Canvas()
    canvas.ball(Ball(48, 48, 42, RED), 0)
    canvas.ball(Ball(80, 80, 12, BLUE), 1)
    canvas.fill(canvas.disc(34, 34, 6), (1.0, 0.97, 0.95), 0)
    image = picture_of(canvas.drawn())
    analysis = analyze(image, LIGHT)
    assert find_materials(image).count == 2
    assert spot(analysis, 34, 34) == spot(analysis, 34, 44)
    assert max(tones.max() for tones in analysis.materials.tones) < 0.9
    assert np.array_equal(relight(analysis, LIGHT).to_rgba(), image.to_rgba())
    away = relight(analysis, (-45, 20)).color
    assert np.abs(away[34, 34] - away[34, 44]).max() < 0.05
    assert np.abs(analysis.base_color.color[34, 34] - RED[1]).max() < 0.05


def test_ink_leaves_the_light_beneath_it_open():
    canvas = Canvas()
    ball = Ball(48, 48, 42, RED)
    canvas.ball(ball, 0)
    canvas.outline(ball, 3)
    drawn = canvas.drawn()
    analysis = analyze(picture_of(drawn), LIGHT)
    allowed = analysis.intervals()
    inked = analysis.drawing.ink_coverage[drawn.ink > 0.9]
    assert inked.min() > 0
    assert set(allowed.lower[drawn.ink > 0.9]) == {-1.0}
    assert set(allowed.upper[drawn.ink > 0.9]) == {1.0}
    clear = drawn.mask & (analysis.drawing.ink_coverage == 0)
    assert (allowed.upper - allowed.lower)[clear].max() < 2.0


def test_a_path_and_a_light_in_degrees_are_taken(drawn, tmp_path):
    write_picture(picture_of(drawn), tmp_path / "figure.png")
    analysis = analyze(tmp_path / "figure.png", (135, 45))
    assert np.allclose(analysis.light, light_direction(135, 45))
    assert analysis.materials.count == 3


@pytest.mark.parametrize(("edge", "lit"), [(0.97, 1), (0.6, 2)])
def test_a_tone_on_less_than_a_tenth_of_a_material_is_a_shine_and_not_its_base_color(edge, lit):
    shape = ellipse(40, 40)
    tones = np.array([[0.5, 0.2, 0.1], [0.8, 0.4, 0.2], [1.0, 0.9, 0.7]])
    value = illumination(shape.normals, LIGHT)
    band = (value > 0.1).astype(int) + (value > edge)
    picture = ToonImage(np.where(shape.mask[..., None], tones[band], np.nan), shape.mask)
    base = analyze(picture, LIGHT).base_color
    assert np.median(base.color[shape.mask], axis=0) == pytest.approx(tones[lit], abs=0.01)


def test_islands_do_not_see_each_other():
    canvas = Canvas()
    canvas.ball(Ball(22, 48, 20, GREEN), 0)
    lower = canvas.disc(22, 48, 20) & (canvas.rows > 24)
    canvas.fill(lower, FLAT, 1)  # down to the rim, which is nearer to the other ball than to the paint above
    canvas.ball(Ball(66, 48, 22, GREEN), 0)
    drawn = canvas.drawn()
    labels, first = np.where(drawn.mask, drawn.label, -1), np.s_[:43]
    whole = prepare(ToonImage(drawn.color, drawn.mask), materials=labels)
    alone = prepare(ToonImage(drawn.color[first], drawn.mask[first]), materials=labels[first])
    assert len(whole.islands) == 2
    tone = np.zeros(drawn.mask.shape)
    tone[drawn.mask] = whole.posed().gray.tone
    assert np.allclose(tone[first][alone.mask], alone.posed().gray.tone, atol=0.01)

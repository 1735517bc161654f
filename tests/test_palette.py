"""Pixel art keeps its palette and its hard edges."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tests.analytic import LIGHT as BALL_LIGHT
from tests.analytic import SOFT, ellipse, painted
from tests.pixel_art import BUTTON, GLINT, LIGHT, OUTLINE, PALETTE, RAMPS, sprite
from toonkit import ColorMap, ToonImage, ToonkitError, analyze, load_analysis, relight
from toonkit.estimation.preparation import prepare
from toonkit.export.animation import write_orbit
from toonkit.export.layers import split_layers
from toonkit.illustration.palette import FEW_COLORS
from toonkit.relighting import relight_pixels

TWO_TONE_STEP = ColorMap([[0.35, 0.2, 0.45]] * 90_000 + [[0.95, 0.8, 0.6]] * 60_000)

LIGHTS = [(30, 40), (-60, 30), (180, 10), (0, 90), (60, -20)]


@pytest.fixture(scope="module", params=[9, 12, 16, 48])
def analysis(request):
    return analyze(sprite(request.param), LIGHT)


@pytest.fixture(scope="module")
def large():
    return analyze(sprite(48), LIGHT)


def colors_of(picture):
    rgba = picture.to_rgba().reshape(-1, 4)
    return {tuple(color) for color in rgba[rgba[:, 3] > 0, :3].tolist()}


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("options", [{}, {"keep_detail": False, "palette": True}])
def test_relit_pixel_art_has_no_color_of_its_own(analysis, light, options):
    relit = relight(analysis, light, **options)
    assert colors_of(relit) <= colors_of(analysis.image)
    assert not np.array_equal(relit.to_rgba(), analysis.image.to_rgba())


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("name", RAMPS)
def test_each_material_takes_the_colors_of_its_own_ramp(large, light, name):
    ramp = np.array(RAMPS[name])
    was, now = large.image.to_rgba()[..., :3], relight(large, light).to_rgba()[..., :3]
    own = (was[:, :, None] == ramp).all(-1).any(-1)
    assert own.any()
    assert (now[own][:, None] == ramp).all(-1).any(-1).all()


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("color", [OUTLINE, BUTTON])
def test_lines_and_details_stay_where_they_are(large, light, color):
    was, now = large.image.to_rgba(), relight(large, light).to_rgba()
    drawn = (was[..., :3] == color).all(axis=-1)
    assert drawn.any()
    assert np.array_equal(now[drawn], was[drawn])
    assert not (now[~drawn, :3] == color).all(axis=-1)[was[~drawn, 3] > 0].any()


def test_a_highlight_is_there_or_not_but_never_in_between(large):
    drawn = (large.image.to_rgba()[..., :3] == GLINT).all(axis=-1)
    shown = {
        tuple(color) for light in LIGHTS for color in relight(large, light).to_rgba()[drawn, :3].tolist()
    }
    assert shown & set(RAMPS["red"])
    assert shown <= {GLINT, *RAMPS["red"]}


def test_at_its_own_light_pixel_art_returns_to_the_last_bit(analysis):
    again = relight(analysis, analysis.light)
    assert np.array_equal(again.color, analysis.image.color, equal_nan=True)


def test_without_the_palette_colors_are_mixed(large):
    relit = relight(large, (30, 40), palette=False)
    assert not colors_of(relit) <= set(PALETTE)
    assert colors_of(relight(large, (30, 40), palette=True)) <= set(PALETTE)


def test_the_model_alone_has_no_palette_unless_it_is_asked_for(large):
    options = {"keep_detail": False}
    assert not colors_of(relight(large, (30, 40), **options)) <= set(PALETTE)


def test_a_palette_survives_the_archive(large, tmp_path):
    large.save(tmp_path / "sprite.npz")
    loaded = load_analysis(tmp_path / "sprite.npz")
    for kept, ramp in zip(loaded.palette.ramps, large.palette.ramps, strict=True):
        assert np.array_equal(kept, ramp)
    assert colors_of(relight(loaded, (30, 40))) <= set(PALETTE)


def test_pictures_reduced_and_whole_take_the_same_colors(large):
    pixels = np.arange(large.normals.compact.shape[0])[::3]
    (some,) = relight_pixels(large, [large.light * (-1, 1, 1)], pixels)
    whole = relight(large, large.light * (-1, 1, 1))
    assert np.array_equal(some, whole.color[whole.mask][pixels])


def test_layers_of_pixel_art_compose_to_the_relit_picture(large):
    layers = split_layers(large, (-60, 30))
    assert np.array_equal(layers.picture, relight(large, (-60, 30)).to_rgba())
    assert np.abs(layers.compose().astype(int) - layers.picture).max() <= 1


@pytest.mark.parametrize("name", ["orbit.gif", "orbit.webp", "orbit.png"])
def test_an_orbit_keeps_the_palette_in_every_frame(large, tmp_path, name):
    write_orbit(large, tmp_path / name, frames=6)
    with Image.open(tmp_path / name) as orbit:
        for frame in range(6):
            orbit.seek(frame)
            rgba = np.asarray(orbit.convert("RGBA")).reshape(-1, 4)
            assert {tuple(color) for color in rgba[rgba[:, 3] > 0, :3].tolist()} <= set(PALETTE)


@pytest.mark.parametrize("size", [9, 16, 120])
def test_a_drawing_of_few_colors_is_recognized(size):
    assert prepare(sprite(size)).is_pixel_art


@pytest.mark.parametrize("size", [12, 24, 48])
def test_an_antialiased_drawing_is_not_taken_for_pixel_art(size):
    fine = sprite(8 * size)
    blocks = (size, 8, size, 8)
    alpha = fine.mask.reshape(blocks).mean(axis=(1, 3))
    sums = np.nan_to_num(fine.color).reshape(*blocks, 3).mean(axis=(1, 3))
    color = np.round(255 * sums / np.maximum(alpha, 1e-9)[..., None]) / 255
    assert not prepare(ToonImage(color, alpha >= 0.5, alpha=alpha, fringe=color)).is_pixel_art


def test_clip_art_in_large_areas_is_not_taken_for_pixel_art():
    small, large = (prepare(painted(ellipse(size, size).normals, TWO_TONE_STEP)) for size in (30, 80))
    assert small.is_pixel_art
    assert not large.is_pixel_art


def test_a_gradient_is_not_taken_for_pixel_art():
    drawing = prepare(painted(ellipse(60, 50).normals, SOFT))
    assert not drawing.is_pixel_art
    with pytest.raises(ToonkitError, match="palette must be False for a drawing with more than 256 colors"):
        relight(analyze(drawing.image, BALL_LIGHT, method="lumo"), (30, 40), palette=True)


def test_a_drawing_of_few_colors_that_are_soft_at_the_outline_in_many_steps_is_antialiased(large):
    image = large.image
    alpha = np.where(image.mask, np.linspace(0.5, 1.0, image.mask.size).reshape(image.shape), 0.0)
    assert not prepare(ToonImage(image.color, image.mask, alpha=alpha)).is_pixel_art
    levels = np.round(4 * alpha) / 4
    assert prepare(ToonImage(image.color, image.mask, alpha=levels)).is_pixel_art
    assert len(np.unique(alpha)) > FEW_COLORS


def test_translucent_pixels_beside_pixel_art_keep_to_the_palette(large):
    image, fringe = large.image, np.roll(large.image.color, 1, axis=0)
    beside = ~image.mask & ~np.isnan(fringe[..., 0])
    alpha = np.where(image.mask, 1.0, np.where(beside, 0.25, 0.0))
    shaded = ToonImage(image.color, image.mask, alpha=alpha, fringe=np.where(beside[..., None], fringe, 0.0))
    relit = relight(analyze(shaded, LIGHT, method="lumo"), (30, 40))
    assert relit.fringe_colors.size
    assert colors_of(relit) <= set(PALETTE)


def test_a_flat_material_takes_the_shadow_that_the_drawing_has_for_it():
    """Yellow beside ocher, as painters shade gold; the green and the orange beside them are shadows of neither."""
    color = np.zeros((16, 24, 3))
    color[:, :10] = np.array((250, 208, 81)) / 255
    color[:, 10:17] = np.array((214, 158, 64)) / 255
    color[:, 17:] = np.array((40, 160, 80)) / 255
    color[:8, 17:] = np.array((241, 128, 60)) / 255
    gold = analyze(
        ToonImage(color, np.ones((16, 24), bool)),
        (130, 45),
        materials=np.digitize(color[..., 2], [0.24, 0.3, 0.315]),
    )
    assert gold.materials.flat.all()
    yellow = gold.materials.labels[0, 0]
    assert np.array_equal(gold.palette.ramps[yellow], [color[0, 10], color[0, 0]])
    green = gold.materials.labels[0, -1]
    assert np.array_equal(gold.palette.ramps[green], [color[0, -1]])
    relit = relight(gold, (-50, 10))
    assert (relit.color[:, :10] == color[0, 10]).all(axis=-1).any()
    assert np.array_equal(relight(gold, (-50, 10), flat_shading=0.0).color, gold.image.color)


def test_the_materials_of_an_edited_analysis_have_ramps_of_their_own(large):
    merged = replace(large.materials, labels=np.where(large.materials.labels == 2, 0, large.materials.labels))
    kept = replace(merged, tones=merged.tones[:2], flat=merged.flat[:2], color_maps=merged.color_maps[:2])
    assert len(replace(large, materials=kept).palette.ramps) == 2

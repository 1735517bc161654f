"""The drawings that ship with toonkit: what they promise to whoever opens them, and that they can be drawn anew."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageColor
from scipy.ndimage import binary_erosion, maximum_filter, minimum_filter

from toonkit import analyze, light_direction, load_image, relight
from toonkit._validation import ToonkitError
from toonkit.estimation.preparation import prepare
from toonkit.export.report import ink_share
from toonkit.metrics import color_rmse
from toonkit.model.luminance import tone
from toonkit.samples import FOLDER, sample_light, sample_names, sample_path, sample_title
from toonkit.study.inked_samples import SampleScene, draw_sample_scene
from toonkit.study.sample_drawings import SAMPLES, draw_sample, to_bytes, write_samples

NAMES = sample_names()
BY_NAME = {sample.name: sample for sample in SAMPLES}
INKED = {sample.name: sample.scene for sample in SAMPLES if isinstance(sample.scene, SampleScene)}


def pixels(name: str) -> np.ndarray:
    """The (H, W, 4) bytes of a sample's file."""
    with Image.open(sample_path(name)) as picture:
        return np.asarray(picture)


def test_there_are_eight_samples_and_the_cat_comes_first() -> None:
    assert len(NAMES) == 8
    assert NAMES[0] == "cat"


def test_the_samples_that_ship_are_those_that_the_program_draws() -> None:
    assert tuple(sample.name for sample in SAMPLES) == NAMES
    assert [(s.title, s.light) for s in SAMPLES] == [(sample_title(n), sample_light(n)) for n in NAMES]


def test_no_picture_lies_in_the_folder_that_is_not_a_sample() -> None:
    assert {path.stem for path in FOLDER.glob("*.png")} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_is_a_square_8_bit_rgba_png(name: str) -> None:
    size = 512 if name in INKED else 640
    with Image.open(sample_path(name)) as picture:
        assert (picture.format, picture.mode, picture.size) == ("PNG", "RGBA", (size, size))


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_takes_less_than_150_kilobytes(name: str) -> None:
    assert sample_path(name).stat().st_size < 150_000


def test_all_samples_together_take_less_than_a_megabyte() -> None:
    assert sum(sample_path(name).stat().st_size for name in NAMES) < 1_000_000


@pytest.mark.parametrize("name", NAMES)
def test_the_light_of_a_sample_comes_from_the_upper_left_or_right(name: str) -> None:
    azimuth, elevation = sample_light(name)
    assert 100 <= azimuth <= 150 or 30 <= azimuth <= 60
    assert 35 <= elevation <= 55


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_opens_as_an_object_with_an_anti_aliased_outline(name: str) -> None:
    image = load_image(sample_path(name))
    assert np.array_equal(image.mask, image.alpha >= 0.5)
    rim = image.mask & ~binary_erosion(image.mask)
    partly = (image.alpha > 0) & (image.alpha < 1)
    # Of the pixels along an outline about as many are cut by it as lie just inside it.
    assert partly.sum() > 0.6 * rim.sum()


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_leaves_a_margin_on_all_sides(name: str) -> None:
    alpha = pixels(name)[..., 3]
    assert max(alpha[0].max(), alpha[-1].max(), alpha[:, 0].max(), alpha[:, -1].max()) == 0


@pytest.mark.parametrize("name", NAMES)
def test_a_partly_covered_pixel_is_painted_like_the_object_beside_it(name: str) -> None:
    picture = pixels(name)
    brightness = tone(picture[..., :3] / 255)
    full = picture[..., 3] == 255
    # Pixels with no full neighbor within two (the tip of a leaf) have nothing to be compared with.
    darkest = minimum_filter(np.where(full, brightness, np.inf), 5)
    brightest = maximum_filter(np.where(full, brightness, -np.inf), 5)
    partly = (picture[..., 3] > 0) & ~full & np.isfinite(darkest)
    # A band of its own may run along the outline, thinner than a pixel (on the cat's ears): seen only in part.
    strays = (brightness < darkest - 0.15) | (brightness > brightest + 0.15)
    assert (strays & partly).sum() < 0.08 * partly.sum()


def test_the_donut_is_drawn_anew_as_it_ships() -> None:
    again = to_bytes(draw_sample(BY_NAME["donut"])).astype(int)
    # 2 of 255: another processor may round a ray's end differently.
    assert np.abs(again - pixels("donut")).max() <= 2


@pytest.mark.parametrize("name", ["fish", "witch"])
def test_a_sample_is_the_same_each_time_it_is_drawn(name: str) -> None:
    assert np.array_equal(draw_sample(BY_NAME[name], size=48), draw_sample(BY_NAME[name], size=48))


def test_at_least_half_of_the_samples_are_inked_and_in_several_materials() -> None:
    assert len(INKED) >= len(NAMES) / 2
    assert min(len(scene.tones) for scene in INKED.values()) >= 5


def test_the_inked_samples_show_gradients_flat_paint_and_highlights() -> None:
    tones = [tones for scene in INKED.values() for tones in scene.tones.values()]
    assert any(one.softness >= 1 for one in tones)
    assert any(len(one.colors) == 1 for one in tones)
    assert any(one.glossy for one in tones)


@pytest.mark.parametrize("name", INKED)
def test_an_inked_sample_has_a_line_all_along_its_outline(name: str) -> None:
    picture = pixels(name)
    full = picture[..., 3] == 255
    rim = full & ~binary_erosion(full)
    ink = np.array(ImageColor.getrgb(INKED[name].ink))
    assert np.abs(picture[rim][:, :3].astype(int) - ink).max() < 16


@pytest.mark.parametrize("name", NAMES)
def test_ink_is_found_where_it_was_drawn_alone(name: str) -> None:
    share = ink_share(prepare(load_image(sample_path(name))))
    assert 0.05 < share < 0.3 if name in INKED else share == 0


@pytest.mark.parametrize("name", INKED)
def test_every_material_of_an_inked_sample_shows(name: str) -> None:
    scene = draw_sample_scene(INKED[name], light_direction(*BY_NAME[name].light), size=96)
    assert set(scene.materials) == set(INKED[name].tones)


@pytest.mark.parametrize("name", INKED)
def test_a_relit_inked_sample_is_nearer_the_truth_than_the_drawing_is(name: str) -> None:
    light, new = light_direction(*BY_NAME[name].light), light_direction(0, 30)
    scene = draw_sample_scene(INKED[name], light, size=192)
    relit, truth = relight(analyze(scene.image, light), new), scene.relit(new)
    assert color_rmse(relit, truth) < color_rmse(scene.image, truth)


def test_the_two_tone_duck_has_two_colors_but_for_the_pixels_between_them() -> None:
    picture = pixels("duck")
    inside = binary_erosion(picture[..., 3] == 255, iterations=2)
    colors, counts = np.unique(picture[inside][:, :3], axis=0, return_counts=True)
    assert len(colors) > 2
    assert np.sort(counts)[-2:].sum() > 0.95 * inside.sum()


@pytest.mark.parametrize("ask", [sample_path, sample_light, sample_title])
def test_an_unknown_sample_is_refused_with_the_names_of_all(ask: Callable[[str], object]) -> None:
    with pytest.raises(ToonkitError, match=f"one of {', '.join(NAMES)}; got 'dragon'"):
        ask("dragon")


def test_samples_are_written_with_their_list(tmp_path: Path) -> None:
    paths = list(write_samples(tmp_path / "new", [BY_NAME["donut"]], size=32))
    records = json.loads((tmp_path / "new" / "samples.json").read_text())
    assert [path.name for path in paths] == ["donut.png"]
    assert [record["name"] for record in records] == ["donut"]
    assert {path.name for path in (tmp_path / "new").iterdir()} == {"donut.png", "samples.json"}


def test_a_sample_drawn_small_has_the_size_asked_for() -> None:
    assert draw_sample(BY_NAME["donut"], size=40).shape == (40, 40, 4)

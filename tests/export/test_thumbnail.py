"""A thumbnail shows what the whole picture shows, and is painted from few of its pixels."""

import numpy as np
import pytest
from PIL import Image

import toonkit.samples
from toonkit import ToonImage, analyze, light_direction, relight
from toonkit.export.thumbnail import SAMPLES, Thumbnail
from toonkit.relighting import relight_pixels

LIGHT = light_direction(-30, 40)


@pytest.mark.parametrize("which", ["analysis", "several"])
@pytest.mark.parametrize("keep_detail", [True, False])
def test_pixels_are_relit_as_in_the_whole_picture(request, which, keep_detail):
    analysis = request.getfixturevalue(which)
    pixels = np.arange(int(analysis.image.mask.sum()))[::-3]
    whole = relight(analysis, LIGHT, keep_detail=keep_detail).color[analysis.image.mask]
    (found,) = relight_pixels(analysis, [LIGHT], pixels, keep_detail=keep_detail)
    assert np.array_equal(found, whole[pixels])


@pytest.mark.parametrize("which", ["analysis", "several"])
@pytest.mark.parametrize("keep_detail", [True, False])
def test_a_small_drawing_is_shown_whole_with_its_soft_outline(request, which, keep_detail):
    analysis = request.getfixturevalue(which)
    rows, columns = (np.flatnonzero((analysis.image.alpha > 0).any(axis=axis)) for axis in (1, 0))
    small = Thumbnail.of(analysis, max(len(rows), len(columns)) * 2)
    (painted,) = relight_pixels(analysis, [LIGHT], small.pixels, keep_detail=keep_detail)
    shown = np.asarray(small.picture(painted, keep_detail=keep_detail))[::2, ::2]
    whole = relight(analysis, LIGHT, keep_detail=keep_detail).to_rgba()
    assert np.array_equal(shown, whole[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1])


@pytest.fixture(scope="module")
def large():
    """A sample drawn four times as large."""
    with Image.open(toonkit.samples.sample_path("cat")) as picture:
        pixels = np.asarray(picture.convert("RGBA").resize((1024, 1024), Image.Resampling.BICUBIC))
    return analyze(toonkit.load_image(pixels), (130, 42))


def test_a_large_drawing_is_shown_as_if_all_of_its_pixels_were_painted(large):
    side = 60
    small = Thumbnail.of(large, side)
    (painted,) = relight_pixels(large, [LIGHT], small.pixels)
    shown = small.picture(painted)
    assert max(shown.size) == side
    rgba = relight(large, LIGHT).to_rgba()
    rows, columns = np.nonzero(rgba[..., 3])
    box = rgba[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    whole = Image.fromarray(box).resize(shown.size, Image.Resampling.LANCZOS)
    both = [np.asarray(picture.convert("RGBa")).astype(float) for picture in (shown, whole)]
    assert np.abs(both[0] - both[1]).mean() < 2.5  # of 255: lines a pixel wide fall a little to one side


def test_a_large_drawing_is_painted_from_few_pixels(large):
    small = Thumbnail.of(large, 60)
    assert (SAMPLES * 60) ** 2 * 0.2 < len(small.pixels) < (2 * SAMPLES * 60) ** 2
    assert len(small.pixels) < large.image.mask.sum() / 4


def test_what_shows_the_object_alone_has_no_fringe(several):
    small = Thumbnail.of(several, 300)
    colors = np.full((len(small.object_pixels), 3), 200, np.uint8)
    shown = np.asarray(small.of_object(colors))
    assert set(np.unique(shown[..., 0])) == {0, 200}
    assert ((shown[..., 0] == 200) == (shown[..., 3] > 0)).all()


def test_dots_that_lie_between_the_pixels_shown_are_shown_all_the_same():
    mask = np.zeros((200, 200), bool)
    mask[::20, ::20] = True
    labels = np.indices(mask.shape)[0] // 100
    dots = analyze(ToonImage(np.full((*mask.shape, 3), 0.5), mask), LIGHT, materials=labels, method="lumo")
    assert len(Thumbnail.of(dots, 30).object_pixels) == 100

"""The relight page, driven as a visitor would."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.browser


def relit_pixels(page):
    """The relit picture as painted on screen."""
    box = page.locator(".card.relit .stage").bounding_box()
    shot = page.screenshot(clip=box)
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=int)


def sliders(page, card):
    return [int(output.inner_text().rstrip("°")) for output in page.locator(f".card.{card} output").all()]


def drag(page, target, to, steps=6):
    box = page.locator(target).bounding_box()
    center = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*center)
    page.mouse.down()
    page.mouse.move(center[0] + to[0] * box["width"] / 2, center[1] - to[1] * box["height"] / 2, steps=steps)
    page.mouse.up()
    page.wait_for_timeout(300)


def wait_until_idle(page):
    page.wait_for_timeout(400)
    page.wait_for_selector(".busy:not(.on)", state="attached", timeout=60_000)
    page.wait_for_timeout(400)


def test_the_page_opens_with_a_sample_already_relit(relight_page):
    original = relight_page.screenshot(clip=relight_page.locator(".card.original .stage").bounding_box())
    before = np.asarray(Image.open(BytesIO(original)).convert("RGB"), dtype=int)
    after = relit_pixels(relight_page)
    assert before.shape == after.shape
    assert np.abs(before - after).max() > 50
    assert relight_page.locator('[role=radio][aria-checked="true"]').count() == 2  # a sample and a method


@pytest.mark.parametrize("target", [".card.relit .ball-box", ".card.relit .stage"])
def test_dragging_moves_light_picture_and_sliders_together(relight_page, target):
    before = relit_pixels(relight_page)
    drag(relight_page, target, (-0.3, 0.0))
    assert np.abs(relit_pixels(relight_page) - before).max() > 30
    azimuth, elevation = sliders(relight_page, "relit")
    assert azimuth == 180
    assert 40 < elevation < 80


@pytest.mark.parametrize(("azimuth", "side"), [(90, -1), (246, 1)])
def test_a_slider_moves_the_light(relight_page, azimuth, side):
    relight_page.locator(".card.relit input").nth(0).fill(str(azimuth))
    relight_page.wait_for_timeout(200)
    assert sliders(relight_page, "relit")[0] == azimuth
    dot, ball = (relight_page.locator(f".card.relit {part}").bounding_box() for part in (".dot", ".ball-box"))
    assert side * (dot["y"] + dot["height"] / 2 - ball["y"] - ball["height"] / 2) > 0.2 * ball["height"]


def test_reset_shows_the_drawing_unchanged(relight_page):
    relight_page.get_by_text("Reset to original").click()
    relight_page.wait_for_timeout(300)
    assert sliders(relight_page, "relit") == sliders(relight_page, "original")


def test_the_light_circles_until_it_is_touched(relight_page):
    relight_page.get_by_text("Orbit").click()
    relight_page.wait_for_timeout(600)
    first = sliders(relight_page, "relit")
    relight_page.wait_for_timeout(600)
    assert sliders(relight_page, "relit") != first
    relight_page.get_by_text("Stop").click()
    relight_page.wait_for_timeout(300)
    stopped = sliders(relight_page, "relit")
    relight_page.wait_for_timeout(300)
    assert sliders(relight_page, "relit") == stopped


def test_another_method_keeps_the_new_light(relight_page):
    drag(relight_page, ".card.relit .ball-box", (0.2, 0.5))
    light = sliders(relight_page, "relit")
    relight_page.locator('[data-value="lumo"]').click()
    wait_until_idle(relight_page)
    assert sliders(relight_page, "relit") == light
    assert relight_page.locator('[data-value="lumo"]').get_attribute("aria-checked") == "true"


def test_a_picture_that_cannot_be_read_is_reported_and_nothing_changes(relight_page):
    before = relit_pixels(relight_page)
    relight_page.locator("input[type=file]").set_input_files(
        {"name": "broken.png", "mimeType": "image/png", "buffer": b"not a picture"}
    )
    relight_page.wait_for_selector("text=/source/i", timeout=20_000)
    np.testing.assert_array_equal(relit_pixels(relight_page), before)


def test_a_picture_of_ones_own_is_analyzed(relight_page):
    side = 96
    y, x = np.mgrid[:side, :side] - side / 2 + 0.5
    radius = np.hypot(x, y)
    tone = np.where(x + y < 0, 230, 120)
    pixels = np.dstack([tone, tone, tone, np.where(radius < 40, 255, 0)]).astype(np.uint8)
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    relight_page.locator("input[type=file]").set_input_files(
        {"name": "ball.png", "mimeType": "image/png", "buffer": buffer.getvalue()}
    )
    relight_page.wait_for_function(
        "size => [...Bokeh.documents[0]._all_models.values()]"
        ".some(m => m.data?.attributes?.picture_size && m.data.picture_size[0] === size)",
        arg=side,
        timeout=30_000,
    )
    assert (
        relight_page.locator('[data-value][aria-checked="true"]').count() == 1
    )  # no sample is chosen any more


def test_the_relit_picture_is_downloaded_with_its_transparency(relight_page):
    with relight_page.expect_download() as started:
        relight_page.get_by_text("Relit picture").click()
    with Image.open(started.value.path()) as picture:
        assert picture.mode == "RGBA"
        low, high = picture.getchannel("A").getextrema()
        assert (low, high) == (0, 255)


def test_the_tabs_show_color_map_normal_map_and_shape(relight_page):
    relight_page.wait_for_selector(".bk-Figure", timeout=30_000)
    relight_page.get_by_role("tab", name="Normal map").click()
    relight_page.wait_for_selector("text=/which way the surface faces/i", timeout=30_000)
    relight_page.get_by_role("tab", name="Shape in 3-D").click()
    relight_page.wait_for_selector("text=/recovered surface/i", timeout=60_000)


def test_without_webgl_python_paints_the_picture(page, relight_url, complaints):
    page.add_init_script(
        "const real = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
        "  return kind === 'webgl2' ? null : real.call(this, kind, ...rest) }"
    )
    page.goto(relight_url)
    page.wait_for_selector(".relight.no-webgl:not(.empty) .relit img.picture[src^=blob]", timeout=60_000)
    before = relit_pixels(page)
    drag(page, ".card.relit .ball-box", (-0.5, 0.0))
    page.wait_for_timeout(1500)
    assert np.abs(relit_pixels(page) - before).max() > 30

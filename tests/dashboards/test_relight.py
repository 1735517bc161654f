"""The relight page, driven as a visitor would."""

from __future__ import annotations

import time
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from tests.dashboards.conftest import START_SECONDS, wait_until_all_have_left

pytestmark = pytest.mark.browser


def relit_pixels(page):
    """The relit picture as painted on screen."""
    box = page.locator(".card.relit .stage").bounding_box()
    shot = page.screenshot(clip=box)
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=int)


def original_pixels(page):
    """The drawing as painted on screen."""
    shot = page.screenshot(clip=page.locator(".card.original .stage").bounding_box())
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=int)


def surface_pixels(page):
    """The canvas of the 3-D tab as painted on screen, its arrows included."""
    page.locator(".surface canvas").scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    shot = page.locator(".surface canvas").screenshot()
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=int)


def differ(one, other):
    """The share of pixels in which two pictures of one size differ clearly."""
    rows = min(len(one), len(other))
    return (np.abs(one[:rows] - other[:rows]).max(axis=-1) > 30).mean()


def until(page, condition, seconds=60):
    """Wait for what a loaded machine shows late; whether it came."""
    end = time.monotonic() + seconds
    while not (come := condition()) and time.monotonic() < end:
        page.wait_for_timeout(200)
    return come


def upload_ball(page, side, badge=False, flat=False, **options):
    """Drop a drawing of a gray ball, with a flat red badge, unshaded or saved with options, and wait until it shows."""
    y, x = np.mgrid[:side, :side] - side / 2 + 0.5
    tone = np.where((x + y < 0) | flat, 230, 120)
    color = np.dstack([tone, tone, tone])
    if badge:
        color[np.hypot(x - 0.1 * side, y - 0.1 * side) < 0.15 * side] = (200, 30, 40)
    alpha = np.where(np.hypot(x, y) < 0.42 * side, 255, 0)
    buffer = BytesIO()
    Image.fromarray(np.dstack([color, alpha]).astype(np.uint8)).save(buffer, "PNG", **options)
    page.locator("input[type=file]").set_input_files(
        {"name": "ball.png", "mimeType": "image/png", "buffer": buffer.getvalue()}
    )
    page.wait_for_function(
        "size => [...Bokeh.documents[0]._all_models.values()]"
        ".some(m => m.data?.attributes?.picture_size && m.data.picture_size[0] === size)",
        arg=side,
        timeout=60_000,
    )
    wait_until_idle(page)


def open_shape(page):
    """Open the 3-D tab, and wait until a surface stands there."""
    page.get_by_role("tab", name="Shape in 3-D").click()
    page.wait_for_selector(".surface canvas", timeout=60_000)
    assert until(page, lambda: np.ptp(surface_pixels(page)[20:-20], axis=(0, 1)).max() > 60)


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
    upload_ball(relight_page, 96)
    chosen = relight_page.locator('[data-value][aria-checked="true"]')
    # The method alone: no sample any more, and no material once the tab shows the new drawing.
    assert until(relight_page, lambda: chosen.count() == 1)
    relight_page.wait_for_selector("text=/Estimated light: azimuth .* sure/")


def test_the_user_is_told_what_of_a_file_is_ignored(relight_page):
    upload_ball(relight_page, 94, icc_profile=b"no profile")
    relight_page.wait_for_selector("text=/This file: its color profile is damaged and is ignored/")


def test_a_light_that_a_drawing_does_not_say_is_assumed_and_the_user_told(relight_page):
    upload_ball(relight_page, 90, flat=True)
    relight_page.wait_for_selector("text=/does not say where its light is. Upper left is assumed/")
    assert sliders(relight_page, "original") == [130, 50]


def test_a_chosen_material_shows_where_it_is_and_that_its_ramp_is_derived(relight_page):
    upload_ball(relight_page, 128, badge=True)
    cards = relight_page.locator('[aria-label="Material"] [data-value]')
    assert until(relight_page, lambda: cards.count() == 2)
    assert "flat" in cards.nth(1).inner_text()
    cards.nth(1).click()
    relight_page.wait_for_selector("text=/ramp is derived/", timeout=30_000)
    assert cards.nth(1).get_attribute("aria-checked") == "true"


def test_flat_shading_is_offered_where_something_is_flat_and_changes_the_picture(relight_page):
    slider = relight_page.get_by_role("slider", name="Flat shading")
    relight_page.locator('[data-value="pear"]').click()
    assert until(relight_page, lambda: slider.count() == 0)
    upload_ball(relight_page, 128, badge=True)
    assert until(relight_page, lambda: slider.count() == 1)
    relight_page.get_by_role("slider", name="Relit: azimuth").fill("135")
    relight_page.get_by_role("slider", name="Relit: elevation").fill("5")
    relight_page.wait_for_timeout(500)
    before = relit_pixels(relight_page)
    slider.focus()
    relight_page.keyboard.press("Home")
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) > 0.005)


def test_ambient_light_fills_the_shadows_of_the_relit_picture(relight_page):
    before = relit_pixels(relight_page)
    relight_page.get_by_role("slider", name="Ambient light").focus()
    relight_page.keyboard.press("End")
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) > 0.02)
    assert relit_pixels(relight_page).mean() > before.mean()


def test_the_relit_picture_is_downloaded_with_its_transparency(relight_page):
    with relight_page.expect_download() as started:
        relight_page.get_by_text("Relit picture").click()
    with Image.open(started.value.path()) as picture:
        assert picture.mode == "RGBA"
        low, high = picture.getchannel("A").getextrema()
        assert (low, high) == (0, 255)


def test_the_normal_map_is_downloaded(relight_page):
    with relight_page.expect_download() as started:
        relight_page.get_by_text("Normal map", exact=True).first.click()
    with Image.open(started.value.path()) as picture:
        assert started.value.suggested_filename == "normal_map.png"
        assert np.asarray(picture)[..., 2].max() > 250  # something faces the viewer


def test_a_clicked_sample_is_opened(relight_page):
    before = original_pixels(relight_page)
    relight_page.locator('[data-value="donut"]').click()
    assert until(relight_page, lambda: differ(original_pixels(relight_page), before) > 0.05)
    assert relight_page.locator('[data-value="donut"]').get_attribute("aria-checked") == "true"


def test_the_cards_follow_the_drawing_after_a_click_too(relight_page):
    before = original_pixels(relight_page)
    relight_page.locator('[data-value="donut"]').click()
    assert until(relight_page, lambda: differ(original_pixels(relight_page), before) > 0.05)
    donut = original_pixels(relight_page)
    upload_ball(relight_page, 96)
    checked = relight_page.locator('[data-value][aria-checked="true"]')
    assert until(relight_page, lambda: checked.count() == 1)  # the method
    relight_page.locator('[data-value="donut"]').click()
    assert until(relight_page, lambda: differ(original_pixels(relight_page), donut) < 0.001)
    assert checked.count() == 2


def test_an_arrow_key_opens_the_next_sample(relight_page):
    before = original_pixels(relight_page)
    relight_page.locator('[aria-label="Sample drawing"] [aria-checked="true"]').focus()
    relight_page.keyboard.press("ArrowRight")
    cards = relight_page.locator('[aria-label="Sample drawing"] [data-value]')
    assert cards.nth(1).get_attribute("aria-checked") == "true"
    assert cards.nth(1).evaluate("card => card.matches(':focus')")
    assert until(relight_page, lambda: differ(original_pixels(relight_page), before) > 0.05)


def test_without_brushwork_the_picture_is_another(relight_page):
    cat = original_pixels(relight_page)
    relight_page.locator('[data-value="fish"]').click()
    assert until(relight_page, lambda: differ(original_pixels(relight_page), cat) > 0.05)
    before = relit_pixels(relight_page)
    relight_page.get_by_role("switch", name="Keep brushwork").click()
    assert until(relight_page, lambda: np.abs(relit_pixels(relight_page) - before).max() > 10)


def test_a_moved_original_light_is_analyzed_and_estimate_finds_another(relight_page):
    before = relit_pixels(relight_page)
    drag(relight_page, ".card.original .ball-box", (0.6, -0.2))
    moved = sliders(relight_page, "original")
    assert until(relight_page, lambda: np.abs(relit_pixels(relight_page) - before).max() > 10)
    relight_page.get_by_role("button", name="Estimate").click()
    assert until(relight_page, lambda: sliders(relight_page, "original") != moved)


def test_the_tabs_show_color_map_normal_map_and_shape(relight_page):
    relight_page.wait_for_selector(".bk-Figure", timeout=30_000)
    relight_page.get_by_role("tab", name="Normal map").click()
    relight_page.wait_for_selector("text=/which way the surface faces/i", timeout=30_000)
    relight_page.get_by_role("tab", name="Shape in 3-D").click()
    relight_page.wait_for_selector("text=/recovered surface/i", timeout=60_000)


def test_the_shape_tab_shows_each_new_drawing_and_method(relight_page):
    open_shape(relight_page)
    for value in ("donut", "lumo"):
        before = surface_pixels(relight_page)
        relight_page.locator(f'[data-value="{value}"]').click()
        assert until(relight_page, lambda before=before: differ(surface_pixels(relight_page), before) > 0.005)
        relight_page.wait_for_timeout(1000)


def test_the_shape_tab_survives_switches_in_any_order(relight_page):
    open_shape(relight_page)
    first = surface_pixels(relight_page)
    for order in (("Color map",), ("Normal map", "Color map"), ("Color map", "Shape in 3-D", "Normal map")):
        for name in order:
            relight_page.get_by_role("tab", name=name).click()
            relight_page.wait_for_timeout(300)
        open_shape(relight_page)
        assert until(relight_page, lambda: differ(surface_pixels(relight_page), first) < 0.001)
    relight_page.get_by_role("tab", name="Normal map").click()
    relight_page.locator('[data-value="donut"]').click()  # a new drawing while another tab is open
    open_shape(relight_page)
    assert until(relight_page, lambda: differ(surface_pixels(relight_page), first) > 0.02)


def test_the_surface_is_turned_by_hand_and_by_keys_and_its_arrows_can_be_hidden(relight_page):
    open_shape(relight_page)
    first = surface_pixels(relight_page)
    relight_page.get_by_role("button", name="Normals").click()
    bare = surface_pixels(relight_page)
    assert 0.0005 < differ(bare, first) < 0.1
    drag(relight_page, ".surface canvas", (0.3, 0.1))
    dragged = surface_pixels(relight_page)
    assert differ(dragged, bare) > 0.01
    relight_page.locator(".surface canvas").focus()
    relight_page.keyboard.press("ArrowLeft")
    assert differ(surface_pixels(relight_page), dragged) > 0.005
    relight_page.get_by_role("button", name="Reset view").click()
    assert differ(surface_pixels(relight_page), bare) < 0.001


def test_the_surface_stands_on_the_pages_own_ground_in_either_theme(relight_page):
    open_shape(relight_page)
    assert surface_pixels(relight_page)[-5:, :5].max() < 80
    relight_page.get_by_role("button", name="Toggle theme").click()
    relight_page.wait_for_timeout(800)
    assert surface_pixels(relight_page)[-5:, :5].min() > 200


def test_what_visitors_brought_is_freed_once_they_have_left(browser, relight_url):
    side = 100  # of no other drawing
    for _ in range(3):
        page = browser.new_page()
        page.goto(relight_url)
        page.wait_for_selector(".relight:not(.empty)", timeout=60_000)
        upload_ball(page, side)
        open_shape(page)
        page.close()
    found = wait_until_all_have_left(relight_url)
    assert "ServerSession" not in found["counts"]
    assert found["counts"].get("Page", 0) <= 1  # Panel may keep the first page of a process
    assert side not in found["analyses"]


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


def test_on_a_narrow_page_the_sidebar_is_closed_until_it_is_asked_for(browser, relight_url):
    page = browser.new_page(viewport={"width": 420, "height": 800})
    page.goto(relight_url)
    page.wait_for_selector(".relight:not(.empty)", timeout=START_SECONDS * 1000)
    method = page.get_by_role("radiogroup", name="Method")
    expect(method).to_be_hidden()
    page.get_by_role("button", name="Open drawer").click()
    expect(method).to_be_visible()
    page.close()


def test_on_a_wide_page_the_sidebar_is_open(relight_page):
    expect(relight_page.get_by_role("radiogroup", name="Method")).to_be_visible()

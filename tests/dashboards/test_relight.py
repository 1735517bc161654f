"""The relight page, driven as a visitor would."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from tests.dashboards.driving import (
    START_SECONDS,
    differ,
    drag,
    open_shape,
    original_pixels,
    relit_pixels,
    sliders,
    surface_pixels,
    until,
    upload_ball,
    wait_until_answered,
    wait_until_shown,
)

pytestmark = pytest.mark.browser


def test_the_page_opens_with_a_sample_already_relit(opened_relight_page):
    before, after = original_pixels(opened_relight_page), relit_pixels(opened_relight_page)
    assert before.shape == after.shape
    assert np.abs(before - after).max() > 50
    for group in ("Sample drawing", "Method"):
        cards = opened_relight_page.get_by_role("radiogroup", name=group)
        expect(cards).to_be_visible()
        assert cards.locator('[role=radio][aria-checked="true"]').count() == 1
    for name in ("Undo", "Redo"):
        expect(opened_relight_page.get_by_role("button", name=name)).to_be_disabled()


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
    assert until(relight_page, lambda: sliders(relight_page, "relit")[0] == azimuth)
    dot, ball = (relight_page.locator(f".card.relit {part}").bounding_box() for part in (".dot", ".ball-box"))
    assert side * (dot["y"] + dot["height"] / 2 - ball["y"] - ball["height"] / 2) > 0.2 * ball["height"]


def test_reset_shows_the_drawing_unchanged(relight_page):
    assert sliders(relight_page, "relit") != sliders(relight_page, "original")
    relight_page.get_by_text("Reset to original").click()
    assert until(relight_page, lambda: sliders(relight_page, "relit") == sliders(relight_page, "original"))


def test_the_light_circles_until_it_is_touched(relight_page):
    start = sliders(relight_page, "relit")
    relight_page.get_by_text("Orbit").click()
    assert until(relight_page, lambda: sliders(relight_page, "relit") != start)
    first = sliders(relight_page, "relit")
    assert until(relight_page, lambda: sliders(relight_page, "relit") != first)
    relight_page.get_by_text("Stop").click()
    wait_until_shown(relight_page)
    stopped = sliders(relight_page, "relit")
    relight_page.wait_for_timeout(300)
    assert sliders(relight_page, "relit") == stopped


def test_another_method_keeps_the_new_light(relight_page):
    drag(relight_page, ".card.relit .ball-box", (0.2, 0.5))
    light = sliders(relight_page, "relit")
    before = relit_pixels(relight_page)
    relight_page.locator('[data-value="lumo"]').click()
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) > 0.005)
    wait_until_answered(relight_page)
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
    chosen = relight_page.locator('[role=radiogroup]:not([aria-label="Your files"]) [aria-checked="true"]')
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
    assert until(relight_page, lambda: sliders(relight_page, "relit") == [135, 5])
    wait_until_shown(relight_page)
    before = relit_pixels(relight_page)
    slider.focus()
    relight_page.keyboard.press("Home")
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) > 0.005)


def test_both_sliders_of_a_light_may_be_moved_before_the_next_frame(relight_page):
    relight_page.get_by_role("slider", name="Relit: azimuth").evaluate("""(slider) => {
      const inputs = slider.closest(".right").querySelectorAll("input")
      for (const [place, value] of [200, 25].entries()) {
        inputs[place].value = value
        inputs[place].dispatchEvent(new Event("input"))
      }
    }""")
    assert until(relight_page, lambda: sliders(relight_page, "relit") == [200, 25], seconds=10)


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
    checked = relight_page.locator('[aria-label="Sample drawing"] [aria-checked="true"]')
    assert until(relight_page, lambda: checked.count() == 0)
    relight_page.locator('[data-value="donut"]').click()
    assert until(relight_page, lambda: differ(original_pixels(relight_page), donut) < 0.001)
    expect(checked).to_have_count(1)
    assert checked.get_attribute("data-value") == "donut"


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


def wait_until_still(page):
    """Wait until the surface does not change any more."""
    before = surface_pixels(page)
    while differ(after := surface_pixels(page), before) > 0:
        before = after


def test_the_shape_tab_shows_each_new_drawing_and_method(relight_page):
    open_shape(relight_page)
    for value in ("donut", "lumo"):
        before = surface_pixels(relight_page)
        relight_page.locator(f'[data-value="{value}"]').click()
        assert until(relight_page, lambda before=before: differ(surface_pixels(relight_page), before) > 0.005)
        wait_until_still(relight_page)


def test_the_shape_tab_survives_switches_in_any_order(relight_page):
    open_shape(relight_page)
    first = surface_pixels(relight_page)
    for order in (("Color map",), ("Normal map", "Color map"), ("Color map", "Shape in 3-D", "Normal map")):
        for name in order:
            relight_page.get_by_role("tab", name=name).click()
            expect(relight_page.get_by_role("tab", name=name)).to_have_attribute("aria-selected", "true")
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
    toggle = relight_page.get_by_role("button", name="Toggle theme")
    toggle.click()
    assert until(relight_page, lambda: surface_pixels(relight_page)[-5:, :5].min() > 200)
    toggle.click()
    assert until(relight_page, lambda: surface_pixels(relight_page)[-5:, :5].max() < 80)


def test_without_webgl_python_paints_the_picture(page, relight_url, complaints):
    page.add_init_script(
        "const real = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
        "  return kind === 'webgl2' ? null : real.call(this, kind, ...rest) }"
    )
    page.goto(relight_url)
    page.wait_for_selector(".relight.no-webgl:not(.empty) .relit img.picture[src^=blob]", timeout=60_000)
    picture = page.locator(".relit img.picture")
    before, painted = relit_pixels(page), picture.get_attribute("src")
    drag(page, ".card.relit .ball-box", (-0.5, 0.0))
    expect(picture).not_to_have_attribute("src", painted)
    assert until(page, lambda: np.abs(relit_pixels(page) - before).max() > 30)


def test_on_a_narrow_page_the_sidebar_is_closed_and_materials_are_corrected_above_the_tabs(
    page, relight_url, complaints
):
    page.set_viewport_size({"width": 420, "height": 800})
    page.goto(relight_url)
    page.wait_for_selector(".relight:not(.empty)", timeout=START_SECONDS * 1000)
    method = page.get_by_role("radiogroup", name="Method")
    expect(method).to_be_hidden()
    page.get_by_role("button", name="Materials", exact=True).click()
    swatch = page.locator(".swatches .swatch:not(.new)").nth(1)
    swatch.click()
    expect(swatch).to_have_attribute("aria-pressed", "true")
    card = page.locator(".card.original").bounding_box()
    tabs = page.get_by_role("tablist").bounding_box()
    assert tabs["y"] >= card["y"] + card["height"]
    page.get_by_role("button", name="Open drawer").click()
    expect(method).to_be_visible()

"""Ramps of materials edited on the relight page, as a visitor would."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

import toonkit
from tests.dashboards.driving import (
    BADGE,
    BALL,
    button,
    differ,
    place,
    relit_pixels,
    settled,
    sliders,
    swatches,
    until,
    wait_until_answered,
    wait_until_shown,
)

pytestmark = pytest.mark.browser

SILENT_SECONDS = 1.0
MESSAGES = """() => {
  window.sent = 1  // until nothing has been sent for a while
  const send = WebSocket.prototype.send
  WebSocket.prototype.send = function (...data) { window.sent += 1; return send.apply(this, data) }
}"""


@pytest.fixture
def ramp_page(materials_page):
    """The gray ball chosen, which is painted in two tones."""
    materials_page.mouse.click(*place(materials_page, BALL))
    expect(materials_page.get_by_label("Tone 1 of 2, the darkest")).to_be_visible()
    return materials_page


def steps(page):
    return page.locator(".threshold")


def illumination(page, step=0):
    return float(steps(page).nth(step).get_attribute("aria-valuenow"))


def changed(page, before):
    """Wait until the relit picture is another."""
    assert until(page, lambda: differ(relit_pixels(page), before) > 0.01)
    return relit_pixels(page)


def test_a_picked_tone_is_seen_in_the_relit_picture_undone_and_redone(ramp_page):
    before = relit_pixels(ramp_page)
    ramp_page.get_by_label("Tone 1 of 2, the darkest").fill("#2040a0")
    blue = changed(ramp_page, before)
    assert (blue[..., 2] > blue[..., 0] + 80).mean() > 0.01
    ramp_page.keyboard.press("Control+z")
    assert until(ramp_page, lambda: differ(relit_pixels(ramp_page), before) < 0.0005)
    expect(ramp_page.get_by_label("Tone 1 of 2, the darkest")).to_have_value("#787878")
    ramp_page.keyboard.press("Control+Shift+z")
    assert until(ramp_page, lambda: differ(relit_pixels(ramp_page), blue) < 0.0005)


def wait_until_silent(page):
    """Wait until the page has sent nothing for a while: a chosen material is told to the tab below."""
    while page.evaluate("window.sent") > 0:
        page.evaluate("window.sent = 0")
        page.wait_for_timeout(SILENT_SECONDS * 1000)


def test_a_dragged_threshold_moves_the_shadow_without_a_message_to_the_server(ramp_page):
    before, start = relit_pixels(ramp_page), illumination(ramp_page)
    ramp_page.evaluate(MESSAGES)
    wait_until_silent(ramp_page)
    box = steps(ramp_page).first.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    ramp_page.mouse.move(*middle)
    ramp_page.mouse.down()
    ramp_page.mouse.move(middle[0] + 60, middle[1], steps=8)
    changed(ramp_page, before)
    assert ramp_page.evaluate("window.sent") == 0
    ramp_page.mouse.up()
    assert illumination(ramp_page) > start + 0.1
    assert until(ramp_page, lambda: ramp_page.evaluate("window.sent") > 0)
    button(ramp_page, "Undo").click()
    assert until(ramp_page, lambda: illumination(ramp_page) == start)


def test_a_step_is_moved_and_removed_with_keys(ramp_page):
    before, start = relit_pixels(ramp_page), illumination(ramp_page)
    steps(ramp_page).first.focus()
    ramp_page.keyboard.press("ArrowRight")
    assert illumination(ramp_page) == pytest.approx(start + 0.01, abs=0.006)
    ramp_page.keyboard.press("Shift+ArrowRight")
    assert illumination(ramp_page) == pytest.approx(start + 0.11, abs=0.006)
    ramp_page.keyboard.press("Delete")
    expect(steps(ramp_page)).to_have_count(0)
    changed(ramp_page, before)


def test_a_softer_step_blurs_the_edge_of_the_shadow(ramp_page):
    before = relit_pixels(ramp_page)
    ramp_page.get_by_role("slider", name="Softness of the step").fill("0.8")
    soft = changed(ramp_page, before)
    assert len(np.unique(soft)) > len(np.unique(before))


def test_a_tone_is_added_up_to_eight(ramp_page):
    add = ramp_page.get_by_role("button", name="Add a tone")
    for count in range(3, 9):
        add.click()
        expect(ramp_page.locator(".tones input")).to_have_count(count)
    expect(add).to_be_disabled()
    ramp_page.get_by_label("Tone 4 of 8").fill("#ffffff")
    values = [tone.input_value() for tone in ramp_page.locator(".tones input").all()]
    assert values == sorted(
        values
    )  # grays: white would be brighter than the next tone, and is taken back to it


def test_what_stays_flat_does_not_answer_to_the_light(ramp_page):
    stays_flat = ramp_page.get_by_role("checkbox", name="Stays flat")
    stays_flat.check()
    azimuth = ramp_page.get_by_role("slider", name="Relit: azimuth")
    azimuth.fill("10")
    wait_until_answered(ramp_page)
    ramp_page.mouse.click(*place(ramp_page, BADGE))
    expect(stays_flat).not_to_be_checked()  # the badge's, which is shown with the next frame
    stays_flat.check()
    wait_until_answered(ramp_page)
    before = picture_pixels(ramp_page)
    azimuth.fill("190")
    assert until(ramp_page, lambda: sliders(ramp_page, "relit")[0] == 190)
    wait_until_shown(ramp_page)
    assert differ(picture_pixels(ramp_page), before) == 0


def picture_pixels(page):
    """The relit picture without the sun on it."""
    sun = page.locator(".card.relit .sun")
    sun.evaluate("sun => { sun.style.visibility = 'hidden' }")
    pixels = relit_pixels(page)
    sun.evaluate("sun => { sun.style.visibility = '' }")
    return pixels


def test_a_reset_ramp_is_the_one_that_was_found(ramp_page):
    before = relit_pixels(ramp_page)
    reset = ramp_page.get_by_role("button", name="Reset ramp")
    expect(reset).to_be_disabled()
    ramp_page.get_by_label("Tone 2 of 2").fill("#f0f0a0")
    changed(ramp_page, before)
    reset.click()
    assert until(ramp_page, lambda: differ(relit_pixels(ramp_page), before) < 0.0005)
    expect(reset).to_be_disabled()


def test_the_analysis_that_is_downloaded_has_the_edited_ramp(ramp_page):
    ramp_page.get_by_label("Tone 1 of 2, the darkest").fill("#2040a0")
    settled(ramp_page, 2)
    with ramp_page.expect_download() as started:
        ramp_page.get_by_text("Whole analysis").click()
    analysis = toonkit.load_analysis(started.value.path())
    assert started.value.suggested_filename == "analysis.npz"
    color = analysis.materials.color_maps[0](-1.0)
    assert np.array_equal(np.round(255 * color), [0x20, 0x40, 0xA0])


def test_a_ramp_is_shown_on_its_swatch(ramp_page):
    ramp_page.get_by_label("Tone 1 of 2, the darkest").fill("#2040a0")
    background = swatches(ramp_page).first.locator("i").evaluate("node => node.style.background")
    assert "rgb(32, 64, 160)" in background

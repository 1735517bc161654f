"""The relit picture compared with the drawing at a divider."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.dashboards.driving import (
    differ,
    drag,
    original_pixels,
    relit_pixels,
    sliders,
    until,
    wait_until_shown,
    zoom,
)

pytestmark = pytest.mark.browser

SUN = 0.012
"""Share of a half of the stage that a sun covers."""

COUNT_MESSAGES = """() => {
  if (window.messages === undefined) {
    const send = WebSocket.prototype.send
    WebSocket.prototype.send = function (...data) { window.messages += 1; return send.apply(this, data) }
  }
  window.messages = 0
}"""


def divider(page):
    return page.get_by_role("slider", name="How much is shown as drawn")


def sends_nothing(page):
    page.evaluate(COUNT_MESSAGES)
    wait_until_shown(page)
    return page.evaluate("window.messages") == 0


def halves(pixels, share=0.5):
    """What is left and right of the divider, without its handle and the labels."""
    at = round(share * pixels.shape[1])
    return pixels[40:, : at - 20], pixels[40:, at + 20 :]


@pytest.fixture
def split_page(relight_page):
    """The first sample, relit, with the divider in the middle."""
    relight_page.get_by_role("button", name="Compare with the drawing").click()
    divider(relight_page).focus()
    relight_page.keyboard.press("Home")
    for _ in range(5):
        relight_page.keyboard.press("PageUp")
    expect(divider(relight_page)).to_have_attribute("aria-valuenow", "50")
    wait_until_shown(relight_page)
    return relight_page


def test_the_picture_is_split_at_a_divider_once_that_is_asked_for(relight_page):
    expect(divider(relight_page)).to_be_hidden()
    whole = relit_pixels(relight_page)
    assert differ(halves(whole)[0], halves(original_pixels(relight_page))[0]) > 2 * SUN
    toggle = relight_page.get_by_role("button", name="Compare with the drawing")
    expect(toggle).to_have_attribute("aria-pressed", "false")
    toggle.click()
    divider(relight_page).focus()
    relight_page.keyboard.press("Home")
    assert until(relight_page, lambda: differ(relit_pixels(relight_page)[40:, 20:], whole[40:, 20:]) < 0.001)
    relight_page.keyboard.press("End")
    drawn = original_pixels(relight_page)[40:, :-20]
    assert until(relight_page, lambda: differ(relit_pixels(relight_page)[40:, :-20], drawn) < SUN)
    toggle.click()
    expect(divider(relight_page)).to_be_hidden()
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), whole) < 0.001)


def test_the_divider_is_dragged_and_the_light_stays(split_page):
    light = sliders(split_page, "relit")
    stage = split_page.locator(".card.relit .stage").bounding_box()
    y = stage["y"] + 0.8 * stage["height"]
    before = relit_pixels(split_page)
    assert until(split_page, lambda: sends_nothing(split_page))  # a page just opened still fills its tabs
    split_page.evaluate(COUNT_MESSAGES)
    split_page.mouse.move(stage["x"] + stage["width"] / 2 + 5, y)  # beside its line, within its handle
    split_page.mouse.down()
    split_page.mouse.move(stage["x"] + 0.7 * stage["width"] + 5, y, steps=20)
    expect(divider(split_page)).to_have_attribute("aria-valuenow", "70")
    wait_until_shown(split_page)
    shown, drawn = relit_pixels(split_page), original_pixels(split_page)
    assert split_page.evaluate("window.messages") == 0
    split_page.mouse.up()
    assert differ(halves(shown, 0.7)[0], halves(drawn, 0.7)[0]) < SUN
    assert differ(halves(shown, 0.7)[1], halves(before, 0.7)[1]) < 0.001
    assert sliders(split_page, "relit") == light
    split_page.keyboard.press("ArrowLeft")  # what was dragged has the keys
    expect(divider(split_page)).to_have_attribute("aria-valuenow", "69")
    split_page.keyboard.press("Shift+ArrowLeft")
    expect(divider(split_page)).to_have_attribute("aria-valuetext", "59 % as drawn")


def test_a_key_shows_the_divider_where_it_was(split_page):
    split_page.keyboard.press("ArrowRight")
    split_page.keyboard.press("c")
    expect(divider(split_page)).to_be_hidden()
    split_page.keyboard.press("c")
    expect(divider(split_page)).to_have_attribute("aria-valuenow", "51")


def test_only_the_relit_part_follows_the_light(split_page):
    before = relit_pixels(split_page)
    stage = split_page.locator(".card.relit .stage").bounding_box()
    split_page.mouse.move(stage["x"] + 0.8 * stage["width"], stage["y"] + 0.8 * stage["height"])
    split_page.mouse.down()
    split_page.mouse.move(stage["x"] + 0.7 * stage["width"], stage["y"] + 0.85 * stage["height"], steps=5)
    assert until(split_page, lambda: differ(halves(relit_pixels(split_page))[1], halves(before)[1]) > 0.05)
    after = relit_pixels(split_page)  # while the button is down
    split_page.mouse.up()
    assert differ(halves(after)[0], halves(before)[0]) < 0.001


def test_the_divider_stays_on_screen_when_the_picture_is_magnified(split_page):
    stage = split_page.locator(".card.original .stage").bounding_box()
    zoom(split_page, (stage["x"] + 0.4 * stage["width"], stage["y"] + 0.4 * stage["height"]), 5)
    line = split_page.locator(".divider").bounding_box()
    relit = split_page.locator(".card.relit .stage").bounding_box()
    assert line["x"] + line["width"] / 2 == pytest.approx(relit["x"] + relit["width"] / 2, abs=1)
    shown, drawn = relit_pixels(split_page)[:-50], original_pixels(split_page)[:-50]
    assert differ(halves(shown)[0], halves(drawn)[0]) < SUN
    assert differ(halves(shown)[1], halves(drawn)[1]) > SUN
    drag(split_page, ".divider", (0, 0.5))  # upward: it goes to the sides alone
    expect(divider(split_page)).to_have_attribute("aria-valuenow", "50")


def test_another_drawing_is_split_too(split_page):
    before = original_pixels(split_page)
    split_page.locator('[data-value="donut"]').click()
    assert until(split_page, lambda: differ(original_pixels(split_page), before) > 0.05)
    drawn = halves(original_pixels(split_page))[0]
    assert until(split_page, lambda: differ(halves(relit_pixels(split_page))[0], drawn) < SUN)
    assert np.ptp(drawn) > 100

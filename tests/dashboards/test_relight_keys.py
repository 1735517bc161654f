"""The relight page without a mouse: undo, redo, the light, tools, and the list of keys."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.dashboards.driving import differ, relit_pixels, sliders, until, wait_until_answered

pytestmark = pytest.mark.browser


def test_the_light_is_moved_undone_and_redone_with_keys(relight_page):
    start, before = sliders(relight_page, "relit"), relit_pixels(relight_page)
    expect(relight_page.get_by_role("button", name="Undo")).to_be_disabled()
    relight_page.get_by_label("Relit: the light; arrow keys move it").focus()
    relight_page.keyboard.press("ArrowLeft")
    relight_page.keyboard.press("Shift+ArrowUp")
    moved = [start[0] + 1, start[1] + 10]
    assert until(relight_page, lambda: sliders(relight_page, "relit") == moved)
    expect(relight_page.get_by_role("button", name="Undo")).to_be_enabled()
    relight_page.keyboard.press("Control+z")
    assert until(relight_page, lambda: sliders(relight_page, "relit") == start)
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) < 0.0005)
    relight_page.keyboard.press("Control+y")
    assert until(relight_page, lambda: sliders(relight_page, "relit") == moved)


def test_settings_are_undone_in_turn(relight_page):
    before = relit_pixels(relight_page)
    ambient = relight_page.get_by_role("slider", name="Ambient light")
    ambient.focus()
    relight_page.keyboard.press("End")
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) > 0.02)
    relight_page.get_by_role("slider", name="Relit: azimuth").fill("200")
    assert until(relight_page, lambda: sliders(relight_page, "relit") == [200, 40])
    undo = relight_page.get_by_role("button", name="Undo")
    undo.click()
    assert until(relight_page, lambda: sliders(relight_page, "relit") == [35, 40])
    wait_until_answered(relight_page)
    undo.click()
    assert until(relight_page, lambda: differ(relit_pixels(relight_page), before) < 0.0005)
    expect(ambient).to_have_value("0")


def test_a_question_mark_lists_the_keys_and_escape_closes_the_list(relight_page):
    relight_page.keyboard.press("?")
    dialog = relight_page.get_by_role("dialog", name="Keyboard shortcuts")
    expect(dialog).to_be_visible()
    expect(dialog).to_contain_text("Undo, the light included")
    relight_page.keyboard.press("Escape")
    expect(dialog).to_be_hidden()
    relight_page.get_by_role("button", name="Keyboard shortcuts").click()
    dialog.get_by_role("button", name="Close").click()
    expect(dialog).to_be_hidden()


def test_letters_choose_tools(relight_page):
    relight_page.keyboard.press("m")
    expect(relight_page.locator(".label-map")).to_be_visible()
    swatch = relight_page.locator(".swatches .swatch").first
    swatch.focus()
    relight_page.keyboard.press("Enter")
    expect(swatch).to_have_attribute("aria-pressed", "true")
    for letter, name in (("b", "Brush"), ("f", "Fill"), ("s", "Split")):
        relight_page.keyboard.press(letter)
        expect(relight_page.locator(".tools").get_by_role("button", name=name)).to_have_attribute(
            "aria-pressed", "true"
        )
    relight_page.keyboard.press("m")
    expect(relight_page.locator(".label-map")).to_be_hidden()


def test_everything_on_the_cards_has_a_name(relight_page):
    relight_page.keyboard.press("m")
    relight_page.locator(".swatches .swatch").first.click()
    nameless = relight_page.locator(".relight").evaluate(
        "root => [...root.querySelectorAll('button, input, [tabindex]')].filter(node => !(node.getAttribute('aria-label')"
        " || node.textContent.trim() || node.closest('label')?.textContent.trim())).map(node => node.outerHTML)"
    )
    assert nameless == []

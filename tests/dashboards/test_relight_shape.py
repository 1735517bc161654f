"""The shape corrected on the relight page, as a visitor would."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.dashboards.driving import (
    VIEW,
    button,
    differ,
    original_pixels,
    place,
    relit_pixels,
    until,
    wait_until_answered,
    wait_until_shown,
)

pytestmark = pytest.mark.browser

HINTS = f"{VIEW}.shape_normals"


@pytest.fixture
def shape_page(materials_page):
    materials_page.get_by_role("button", name="Shape", exact=True).click()
    size = materials_page.locator(".shape-panel .size")
    size.evaluate("(node) => { node.value = 90 }")
    wait_until_shown(materials_page)
    yield materials_page
    size.evaluate("(node) => { node.value = 45 }")


def kind(page, name):
    return page.get_by_role("group", name="The part is").get_by_role("button", name=name, exact=True)


def pull(page, start, way):
    """Press a place of the picture, and let go some pixels of the screen away."""
    x, y = place(page, start)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + way[0], y + way[1], steps=5)
    page.mouse.up()
    wait_until_answered(page)


def test_a_painted_bulge_is_relit_erased_and_undone(shape_page):
    before = relit_pixels(shape_page)
    kind(shape_page, "Bulge").click()
    pull(shape_page, (0.4, 0.4), (0, 0))
    assert until(shape_page, lambda: differ(relit_pixels(shape_page), before) > 0.002)
    bulged = relit_pixels(shape_page)
    kind(shape_page, "Erase").click()
    pull(shape_page, (0.4, 0.4), (0, 0))
    assert until(shape_page, lambda: differ(relit_pixels(shape_page), before) < 0.0005)
    expect(button(shape_page, "Reset")).to_be_disabled()
    shape_page.keyboard.press("Control+z")
    wait_until_answered(shape_page)
    assert until(shape_page, lambda: differ(relit_pixels(shape_page), bulged) < 0.0005)
    button(shape_page, "Reset").click()
    wait_until_answered(shape_page)
    assert until(shape_page, lambda: differ(relit_pixels(shape_page), before) < 0.0005)


def test_a_normal_is_dragged_tilted_with_keys_and_removed(shape_page):
    button(shape_page, "Tilt").click()
    pull(shape_page, (0.4, 0.4), (40, 0))
    (hint,) = shape_page.evaluate(HINTS)
    side = shape_page.evaluate(f"{VIEW}.picture_size[0]")
    assert abs(hint["column"] - 0.4 * side) <= 1
    assert hint["normal"][0] > 0.4
    point = shape_page.locator(".point")
    point.focus()
    shape_page.keyboard.press("Shift+ArrowUp")
    assert until(shape_page, lambda: shape_page.evaluate(HINTS)[0]["normal"][1] > hint["normal"][1] + 0.2)
    wait_until_answered(shape_page)
    expect(point).to_be_focused()
    pull(shape_page, (0.4, 0.4), (-60, 0))  # takes hold of the same arrow
    (turned,) = shape_page.evaluate(HINTS)
    assert turned["normal"][0] < hint["normal"][0] - 0.5
    point.focus()
    shape_page.keyboard.press("Delete")
    expect(point).to_have_count(0)
    wait_until_answered(shape_page)
    assert shape_page.evaluate(HINTS) == []


def test_a_region_is_filled_and_the_normals_are_shown_or_not(shape_page):
    shown = original_pixels(shape_page)
    shape_page.get_by_text("Show the normals").click()
    wait_until_shown(shape_page)
    drawn = original_pixels(shape_page)
    assert differ(shown, drawn) > 0.1
    kind(shape_page, "In front").click()
    button(shape_page, "Fill").click()
    shape_page.mouse.click(*place(shape_page, (0.6, 0.6)))
    wait_until_answered(shape_page)
    assert until(shape_page, lambda: 0.005 < differ(original_pixels(shape_page), drawn) < 0.1)
    shape_page.get_by_text("Show the normals").click()
    wait_until_shown(shape_page)
    assert differ(original_pixels(shape_page), drawn) > 0.1


def test_the_shape_is_reached_and_left_with_keys(materials_page):
    shape = materials_page.get_by_role("button", name="Shape", exact=True)
    materials_page.keyboard.press("n")
    expect(shape).to_have_attribute("aria-pressed", "true")
    materials_page.keyboard.press("d")
    expect(button(materials_page, "Tilt")).to_have_attribute("aria-pressed", "true")
    materials_page.keyboard.press("Escape")
    expect(button(materials_page, "Tilt")).to_have_attribute("aria-pressed", "false")
    materials_page.keyboard.press("n")
    expect(shape).to_have_attribute("aria-pressed", "false")

"""Materials corrected on the relight page, as a visitor would."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

import toonkit
from tests.dashboards.driving import (
    BADGE,
    BALL,
    BALL_SIDE,
    VIEW,
    button,
    differ,
    pixels_in,
    place,
    relit_pixels,
    settled,
    share_of,
    shown_color,
    sliders,
    swatches,
    until,
    wait_until_answered,
    wait_until_shown,
)

pytestmark = pytest.mark.browser

LIGHT = f"{VIEW}.original_light"


def middle(locator):
    locator.wait_for()  # swatches are made anew with each answer
    box = locator.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page, start, end):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=8)
    page.mouse.up()


def test_a_swatch_pointed_at_shows_its_material_as_drawn_and_veils_the_rest(materials_page):
    tinted = shown_color(materials_page, BADGE)
    assert np.abs(tinted - (200, 30, 40)).max() > 40
    swatches(materials_page).nth(1).hover()
    assert until(materials_page, lambda: np.abs(shown_color(materials_page, BADGE) - (200, 30, 40)).max() < 3)
    assert shown_color(materials_page, BALL).max() < 110  # it is drawn in 230
    materials_page.mouse.move(*place(materials_page, BALL))
    expect(swatches(materials_page).nth(0)).to_have_class("swatch hovered")
    assert until(materials_page, lambda: shown_color(materials_page, BALL).min() > 220)


def test_a_part_that_is_clicked_is_chosen_here_and_in_the_color_map_tab(materials_page):
    cards = materials_page.locator('[aria-label="Material"] [data-value]')
    assert until(materials_page, lambda: cards.count() == 2)
    materials_page.mouse.click(*place(materials_page, BADGE))
    expect(swatches(materials_page).nth(1)).to_have_attribute("aria-pressed", "true")
    expect(cards.nth(1)).to_have_attribute("aria-checked", "true")
    cards.nth(0).click()
    expect(swatches(materials_page).nth(0)).to_have_attribute("aria-pressed", "true")
    materials_page.locator(".card.original header").scroll_into_view_if_needed()
    materials_page.mouse.click(*place(materials_page, BALL))
    expect(materials_page.locator(".swatch[aria-pressed=true]")).to_have_count(0)


def test_materials_are_merged_undone_and_redone_with_keys_alone(materials_page):
    before = relit_pixels(materials_page)
    swatches(materials_page).nth(0).focus()
    materials_page.keyboard.press("ArrowRight")
    materials_page.keyboard.press("Enter")
    expect(button(materials_page, "Merge into")).to_be_enabled()
    button(materials_page, "Merge into").focus()
    materials_page.keyboard.press("Enter")
    swatches(materials_page).nth(0).focus()
    materials_page.keyboard.press("Enter")
    settled(materials_page, 1)
    merged = relit_pixels(materials_page)
    assert differ(merged, before) > 0.005
    materials_page.keyboard.press("Control+z")
    settled(materials_page, 2)
    assert until(materials_page, lambda: differ(relit_pixels(materials_page), before) < 0.0005)
    materials_page.keyboard.press("Control+Shift+z")
    settled(materials_page, 1)
    assert until(materials_page, lambda: differ(relit_pixels(materials_page), merged) < 0.0005)


def test_a_part_of_the_picture_can_be_merged_into_and_escape_leaves_it(materials_page):
    materials_page.mouse.click(*place(materials_page, BADGE))
    button(materials_page, "Merge into").click()
    expect(materials_page.locator(".card.original header p")).to_have_text("Now click what it belongs to")
    materials_page.keyboard.press("Escape")
    expect(button(materials_page, "Merge into")).to_have_attribute("aria-pressed", "false")
    button(materials_page, "Merge into").click()
    materials_page.mouse.click(*place(materials_page, BALL))
    settled(materials_page, 1)


@pytest.mark.parametrize("target", ["swatch", "picture"])
def test_a_swatch_is_dragged_onto_what_it_is_merged_into(materials_page, target):
    badge, ball = swatches(materials_page).nth(1), swatches(materials_page).nth(0)
    drag(materials_page, middle(badge), (5, 5))  # let go beside everything: nothing happens
    expect(swatches(materials_page)).to_have_count(2)
    drag(materials_page, middle(badge), middle(ball) if target == "swatch" else place(materials_page, BALL))
    settled(materials_page, 1)
    assert button(materials_page, "Undo").is_enabled()


def test_a_stroke_gives_what_it_covers_to_the_chosen_material(materials_page):
    before, share = relit_pixels(materials_page), share_of(materials_page, 1)
    swatches(materials_page).nth(1).click()
    button(materials_page, "Brush").click()
    drag(materials_page, place(materials_page, (0.3, 0.6)), place(materials_page, BADGE))
    settled(materials_page, 2)
    assert share_of(materials_page, 1) > share
    assert differ(relit_pixels(materials_page), before) > 0.002
    button(materials_page, "Undo").click()
    assert until(materials_page, lambda: share_of(materials_page, 1) == share)
    wait_until_answered(materials_page)
    assert until(materials_page, lambda: differ(relit_pixels(materials_page), before) < 0.0005)


def test_strokes_that_follow_quickly_are_all_kept(materials_page):
    swatches(materials_page).nth(1).click()
    button(materials_page, "Brush").click()
    share = share_of(materials_page, 1)
    for height in (0.3, 0.4, 0.5):
        drag(materials_page, place(materials_page, (0.25, height)), place(materials_page, (0.4, height)))
    painted = share_of(materials_page, 1)
    assert painted > share
    settled(materials_page, 2)
    assert share_of(materials_page, 1) == painted  # Python paints what the page has painted
    for _ in range(3):
        button(materials_page, "Undo").click()
    assert until(materials_page, lambda: share_of(materials_page, 1) == share)


def test_a_new_material_is_painted(materials_page):
    materials_page.get_by_role("button", name="New material").click()
    expect(button(materials_page, "Brush")).to_have_attribute("aria-pressed", "true")
    drag(materials_page, place(materials_page, (0.3, 0.3)), place(materials_page, (0.5, 0.25)))
    settled(materials_page, 3)
    button(materials_page, "Reset").click()
    settled(materials_page, 2)
    assert button(materials_page, "Reset").is_disabled()


def test_the_brush_has_the_size_that_its_ring_shows(materials_page):
    swatches(materials_page).nth(1).click()
    button(materials_page, "Brush").click()
    materials_page.mouse.move(*place(materials_page, BALL))
    ring = materials_page.locator(".ring")
    widths = []
    for key in ("", "]", "[", "["):
        if key:
            materials_page.keyboard.press(key)
        wait_until_shown(materials_page)
        widths.append(ring.bounding_box()["width"])
    assert widths[3] < widths[0] == widths[2] < widths[1]
    materials_page.get_by_role("slider", name="Brush size").fill("100")
    materials_page.mouse.move(*place(materials_page, BALL))
    assert until(materials_page, lambda: ring.bounding_box()["width"] > 2 * widths[1])
    swatches(materials_page).nth(0).hover()
    expect(ring).to_be_hidden()


def test_the_light_of_the_drawing_is_not_moved_while_materials_are_corrected(materials_page):
    light = materials_page.evaluate(LIGHT)
    drag(materials_page, place(materials_page, (0.2, 0.2)), place(materials_page, (0.8, 0.4)))
    materials_page.get_by_role("button", name="Light", exact=True).click()
    expect(materials_page.locator(".card.original .ball-box")).to_be_visible()
    assert materials_page.evaluate(LIGHT) == pytest.approx(light, abs=0.01)
    expect(materials_page.locator(".label-map")).to_be_hidden()


def test_what_is_downloaded_is_the_corrected_analysis(materials_page):
    materials_page.mouse.click(*place(materials_page, BADGE))
    button(materials_page, "Merge into").click()
    materials_page.mouse.click(*place(materials_page, BALL))
    settled(materials_page, 1)
    for slider, degrees in (("azimuth", "10"), ("elevation", "30")):
        materials_page.get_by_role("slider", name=f"Relit: {slider}").fill(degrees)
    assert until(materials_page, lambda: sliders(materials_page, "relit") == [10, 30])
    wait_until_answered(materials_page)
    with materials_page.expect_download() as started:
        materials_page.get_by_text("Relit picture").click()
    y, x = np.mgrid[:BALL_SIDE, :BALL_SIDE] - BALL_SIDE / 2 + 0.5
    color = np.repeat(np.where(x + y < 0, 230, 120)[..., None], 3, axis=-1) / 255
    color[np.hypot(x - 0.1 * BALL_SIDE, y - 0.1 * BALL_SIDE) < 0.15 * BALL_SIDE] = (
        np.array([200, 30, 40]) / 255
    )
    image = toonkit.ToonImage(color, np.hypot(x, y) < 0.42 * BALL_SIDE)
    one = np.zeros((BALL_SIDE, BALL_SIDE), int)
    corrected = toonkit.analyze(image, materials_page.evaluate(LIGHT), materials=one)
    with Image.open(started.value.path()) as picture:
        downloaded = np.asarray(picture, dtype=int)
    expected = toonkit.relight(corrected, (10, 30)).to_rgba().astype(int)
    assert np.abs(downloaded - expected)[image.mask].max() <= 1


def test_a_region_is_filled_with_a_click_and_taken_back(materials_page):
    swatches(materials_page).nth(0).click()
    button(materials_page, "Fill").click()
    materials_page.mouse.click(*place(materials_page, BADGE))
    settled(materials_page, 1)
    button(materials_page, "Undo").click()
    settled(materials_page, 2)


def test_a_lasso_makes_a_new_material_of_what_it_encloses(materials_page):
    swatches(materials_page).nth(0).click()
    button(materials_page, "Split").click()
    corners = [place(materials_page, corner) for corner in ((0.2, 0.2), (0.5, 0.2), (0.5, 0.45), (0.2, 0.45))]
    materials_page.mouse.move(*corners[0])
    materials_page.mouse.down()
    for corner in corners[1:]:
        materials_page.mouse.move(*corner, steps=8)
    assert materials_page.locator(".lasso polygon").get_attribute("points").count(",") > 10
    materials_page.mouse.up()
    settled(materials_page, 3)
    expect(materials_page.locator(".swatch[aria-pressed=true]")).to_have_count(1)
    share = share_of(materials_page, 1)
    wait_until_answered(materials_page)
    assert share_of(materials_page, 1) == share  # Python encloses what the page has enclosed


def test_what_is_marked_as_ink_is_relit_as_drawn_and_is_no_material(materials_page):
    for slider, degrees in (("azimuth", "135"), ("elevation", "5")):
        materials_page.get_by_role("slider", name=f"Relit: {slider}").fill(degrees)
    assert until(materials_page, lambda: np.abs(relit_color(materials_page, BADGE) - (200, 30, 40)).max() > 3)
    mark(materials_page, "Ink").click()
    button(materials_page, "Fill").click()
    materials_page.mouse.click(*place(materials_page, BADGE))
    settled(materials_page, 1)
    assert until(materials_page, lambda: np.abs(relit_color(materials_page, BADGE) - (200, 30, 40)).max() < 3)
    materials_page.mouse.move(*place(materials_page, BALL))
    assert until(
        materials_page, lambda: shown_color(materials_page, BALL).max() < 110
    )  # all but ink is veiled
    assert np.abs(shown_color(materials_page, BADGE) - (200, 30, 40)).max() < 3
    button(materials_page, "Undo").click()
    settled(materials_page, 2)


@pytest.mark.parametrize("name", ["Highlight", "Cast shadow"])
def test_a_highlight_or_cast_shadow_is_painted_and_fades_under_another_light(materials_page, name):
    for slider, degrees in (("azimuth", "0"), ("elevation", "0")):
        materials_page.get_by_role("slider", name=f"Relit: {slider}").fill(degrees)
    mark(materials_page, name).click()
    button(materials_page, "Fill").click()
    materials_page.mouse.click(*place(materials_page, BADGE))
    settled(materials_page, 1)
    color = relit_color(materials_page, BADGE)
    assert until(materials_page, lambda: np.ptp(relit_color(materials_page, BADGE)) < 60), (
        color
    )  # nearly gray, as the ball is
    materials_page.keyboard.press("Control+z")
    settled(materials_page, 2)


def test_marks_are_found_with_the_keyboard_and_painted_over_with_a_material(materials_page):
    mark(materials_page, "Plain paint").focus()
    materials_page.keyboard.press("Enter")
    expect(button(materials_page, "Brush")).to_have_attribute("aria-pressed", "true")
    mark(materials_page, "Ink").click()
    drag(materials_page, place(materials_page, (0.3, 0.3)), place(materials_page, (0.45, 0.3)))
    settled(materials_page, 2)
    assert until(materials_page, lambda: shown_color(materials_page, (0.4, 0.3)).max() < 250)
    swatches(materials_page).nth(0).click()
    button(materials_page, "Brush").click()
    drag(materials_page, place(materials_page, (0.3, 0.3)), place(materials_page, (0.45, 0.3)))
    settled(materials_page, 2)


def mark(page, name):
    return page.get_by_role("group", name="Mark as").get_by_role("button", name=name)


def relit_color(page, share):
    """Color on screen of a place of the relit picture."""
    x, y = place(page, share)
    one, other = (page.locator(f".card.{card} .stage").bounding_box() for card in ("original", "relit"))
    box = {"x": x - one["x"] + other["x"] - 2, "y": y - 2, "width": 4, "height": 4}
    return pixels_in(page, box).mean(axis=(0, 1))


def test_another_drawing_shows_its_own_materials(materials_page):
    materials_page.mouse.click(*place(materials_page, BADGE))
    materials_page.locator('[data-value="pear"]').click()
    expect(swatches(materials_page)).to_have_count(1)
    expect(materials_page.locator(".swatch[aria-pressed=true]")).to_have_count(0)
    assert button(materials_page, "Merge into").is_disabled()

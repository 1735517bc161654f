"""Both pictures of the relight page magnified and moved together, and what is done on them meanwhile."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.dashboards.driving import (
    BADGE,
    BALL,
    button,
    differ,
    drag,
    original_pixels,
    picture_box,
    place,
    relit_pixels,
    settled,
    share_of,
    shown_color,
    sliders,
    swatches,
    until,
    wait_until_shown,
    zoom,
)

pytestmark = pytest.mark.browser

CARDS = ("original", "relit")
EDGE = (0.45, 0.6)  # left end of the badge
LONGER_THAN_A_DOUBLE_CLICK = 500  # ms


@pytest.fixture
def light_page(materials_page):
    """The ball with its badge, and a light to drag."""
    materials_page.keyboard.press("m")
    expect(materials_page.locator(".label-map")).to_be_hidden()
    wait_until_shown(materials_page)
    return materials_page


def badge(page, card):
    """How many pixels of the badge a card shows, and the middle of them."""
    pixels = (original_pixels if card == "original" else relit_pixels)(page)
    rows, columns = np.nonzero((pixels[..., 0] - pixels[..., 1] > 60) & (pixels[..., 1] < 90))
    return len(rows), np.array([columns.mean(), rows.mean()])


def middle(page, target):
    box = page.locator(target).bounding_box()
    return np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])


def share_under(page, card, at):
    """What of its picture is shown at a place of a card, given on the screen for the original."""
    box = picture_box(page, card)
    stages = [page.locator(f".card.{name} .stage").bounding_box() for name in ("original", card)]
    x = at[0] + stages[1]["x"] - stages[0]["x"]
    y = at[1] + stages[1]["y"] - stages[0]["y"]
    return (x - box["x"]) / box["width"], (y - box["y"]) / box["height"]


def press_and_move(page, at, way, **options):
    page.mouse.move(*at)
    page.mouse.down(**options)
    page.mouse.move(at[0] + way[0], at[1] + way[1], steps=5)
    page.mouse.up(**options)
    wait_until_shown(page)


@pytest.mark.parametrize("notches", [2, 9])
def test_both_pictures_are_magnified_about_the_pointer(light_page, notches):
    at = place(light_page, EDGE)
    areas = [badge(light_page, card)[0] for card in CARDS]
    zoom(light_page, at, notches)
    for card, area in zip(CARDS, areas, strict=True):
        np.testing.assert_allclose(share_under(light_page, card, at), EDGE, atol=0.002)
        if notches == 2:  # the whole badge is on screen
            assert badge(light_page, card)[0] == pytest.approx(area * np.exp(4 * 0.24), rel=0.05)
        else:
            assert badge(light_page, card)[0] > 8 * area
    zoom(light_page, at, -notches)
    expect(light_page.locator(".fit")).to_have_count(2)
    assert [badge(light_page, card)[0] for card in CARDS] == pytest.approx(areas, rel=0.02)


def test_magnified_pixels_are_squares_of_one_color_and_a_fitted_drawing_is_smooth(relight_page):
    picture = relight_page.locator(".card.original canvas.picture")
    assert picture.evaluate("canvas => getComputedStyle(canvas).imageRendering") == "auto"
    stage = relight_page.locator(".card.original .stage").bounding_box()
    fitted = original_pixels(relight_page)
    lower = fitted[len(fitted) // 2 : -80]  # below the sun, above the button
    row, column = np.unravel_index(
        np.abs(np.diff(lower, axis=1)).max(axis=-1).argmax(), np.array(lower.shape[:2]) - (0, 1)
    )
    relight_page.mouse.move(stage["x"] + int(column), stage["y"] + len(fitted) // 2 + int(row))
    relight_page.keyboard.down("Control")
    for _ in range(24):
        relight_page.mouse.wheel(0, -120)
    relight_page.keyboard.up("Control")
    expect(relight_page.locator(".card.original .fit")).to_have_text("3200 %")
    wait_until_shown(relight_page)
    lower = original_pixels(relight_page)[len(fitted) // 2 : -80, 20:-20]
    changes = np.flatnonzero(np.abs(np.diff(lower, axis=1)).max(axis=(0, 2)) > 2)
    assert len(changes) > 2
    assert np.isin(
        np.diff(changes) % 32, (0, 1, 31)
    ).all()  # an edge may lie between two pixels of the screen


def test_the_wheel_alone_scrolls_the_page_and_a_magnified_picture_as_far_as_it_goes(light_page):
    def top():
        return light_page.locator(".card.relit .stage").bounding_box()["y"]

    at = middle(light_page, ".card.relit .stage")
    start = top()
    light_page.mouse.move(*at)
    light_page.mouse.wheel(0, 60)
    assert until(light_page, lambda: top() == start - 60)
    light_page.mouse.wheel(0, -60)
    assert until(light_page, lambda: top() == start)
    zoom(light_page, at, 3)
    before = [picture_box(light_page, card) for card in CARDS]
    light_page.mouse.wheel(20, 60)
    for card, box in zip(CARDS, before, strict=True):
        assert until(
            light_page, lambda card=card, box=box: picture_box(light_page, card)["y"] == box["y"] - 60
        )
        assert picture_box(light_page, card)["x"] == pytest.approx(box["x"] - 20)
    assert top() == start
    light_page.mouse.wheel(0, 5000)  # to the lower edge
    light_page.mouse.wheel(0, 60)
    assert until(light_page, lambda: top() < start)
    light_page.mouse.move(*middle(light_page, ".card.relit .controls"))
    light_page.mouse.wheel(0, -5000)
    assert until(light_page, lambda: top() == start)


@pytest.mark.parametrize("how", ["Space", "middle button"])
def test_both_pictures_are_moved_by_hand_and_the_light_is_not(light_page, how):
    light = sliders(light_page, "relit"), sliders(light_page, "original")
    at = middle(light_page, ".card.relit .stage")
    zoom(light_page, at, 3)
    before = [badge(light_page, card)[1] for card in CARDS]
    if how == "Space":
        light_page.keyboard.down(" ")
        press_and_move(light_page, at, (-30, -40))
        light_page.keyboard.up(" ")
    else:
        press_and_move(light_page, at, (-30, -40), button="middle")
    for card, where in zip(CARDS, before, strict=True):
        np.testing.assert_allclose(badge(light_page, card)[1] - where, (-30, -40), atol=1)
    assert (sliders(light_page, "relit"), sliders(light_page, "original")) == light
    press_and_move(light_page, at, (-30, -40))  # neither is held any more
    assert sliders(light_page, "relit") != light[0]


def test_space_still_presses_a_button_that_was_reached_with_keys(light_page):
    zoom(light_page, middle(light_page, ".card.relit .stage"), 3)
    light_page.get_by_label("Relit: elevation").focus()
    light_page.keyboard.press("Tab")
    light_page.keyboard.press(" ")
    expect(light_page.get_by_role("button", name="Stop")).to_be_visible()
    light_page.keyboard.press(" ")
    expect(light_page.get_by_role("button", name="Orbit")).to_be_visible()


def test_keys_magnify_and_fit(light_page):
    before, width = original_pixels(light_page), picture_box(light_page, "relit")["width"]
    for key, factor in (("+", 2**0.5), ("=", 2), ("-", 2**0.5), ("+", 2)):
        light_page.keyboard.press(key)
        assert until(
            light_page,
            lambda factor=factor: np.isclose(picture_box(light_page, "relit")["width"], factor * width),
        )
    wait_until_shown(light_page)
    assert differ(original_pixels(light_page), before) > 0.1
    light_page.keyboard.press("0")
    expect(light_page.locator(".card.relit .fit")).to_be_hidden()
    assert until(light_page, lambda: differ(original_pixels(light_page), before) < 0.001)


@pytest.mark.parametrize("card", CARDS)
def test_a_double_click_fits_and_leaves_the_light(light_page, card):
    light, before = sliders(light_page, card), relit_pixels(light_page)
    at = middle(light_page, f".card.{card} .stage") + np.array([60, 20])
    zoom(light_page, at, 4)
    light_page.mouse.dblclick(*at)
    expect(light_page.locator(f".card.{card} .fit")).to_be_hidden()
    light_page.wait_for_timeout(LONGER_THAN_A_DOUBLE_CLICK)  # no click is acted on later
    assert sliders(light_page, card) == light
    assert until(light_page, lambda: differ(relit_pixels(light_page), before) < 0.001)


def test_the_light_is_within_reach_of_a_magnified_picture(light_page):
    zoom(light_page, middle(light_page, ".card.relit .stage") + 50, 6)
    before = relit_pixels(light_page)
    drag(light_page, ".card.relit .stage", (-0.3, 0.0))
    assert sliders(light_page, "relit")[0] == 180
    stage = light_page.locator(".card.relit .stage").bounding_box()
    np.testing.assert_allclose(
        middle(light_page, ".card.relit .sun"),
        middle(light_page, ".card.relit .stage") - (0.15 * stage["width"], 0),
        atol=1,
    )
    assert np.abs(relit_pixels(light_page) - before).max() > 30
    light_page.mouse.click(*(middle(light_page, ".card.relit .stage") - np.array([0, 80])))
    assert until(light_page, lambda: sliders(light_page, "relit")[0] == 90)


def test_a_pinch_magnifies_and_moves_and_one_finger_still_drags_the_light(light_page):
    touches = light_page.context.new_cdp_session(light_page)

    def touch(kind, *points):
        fingers = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    light, width = sliders(light_page, "relit"), picture_box(light_page, "relit")["width"]
    x, y = middle(light_page, ".card.relit .stage")
    touch("touchStart", (x - 40, y))
    touch("touchStart", (x - 40, y), (x + 40, y))
    for far in range(45, 101, 5):
        touch("touchMove", (x - far, y + far - 40), (x + far, y + far - 40))
    touch("touchEnd")
    assert until(
        light_page, lambda: np.isclose(picture_box(light_page, "relit")["width"], 2.5 * width, rtol=0.01)
    )
    np.testing.assert_allclose(
        share_under(light_page, "relit", place(light_page, (0.5, 0.5))), 0.5, atol=0.01
    )
    assert picture_box(light_page, "original")["width"] == picture_box(light_page, "relit")["width"]
    assert sliders(light_page, "relit") == light
    touch("touchStart", (x, y))
    for far in range(10, 101, 10):
        touch("touchMove", (x - far, y))
    touch("touchEnd")
    assert until(light_page, lambda: sliders(light_page, "relit")[0] == 180)
    touches.detach()


def test_a_part_of_a_magnified_picture_is_chosen_and_a_double_click_counts_once(materials_page):
    zoom(materials_page, place(materials_page, EDGE), 8)
    x, y = place(materials_page, EDGE)
    materials_page.mouse.click(x + 15, y)
    expect(swatches(materials_page).nth(1)).to_have_attribute("aria-pressed", "true")
    materials_page.mouse.click(x - 15, y)
    expect(swatches(materials_page).nth(0)).to_have_attribute("aria-pressed", "true")
    materials_page.mouse.dblclick(x + 40, y)
    expect(materials_page.locator(".card.original .fit")).to_be_hidden()
    expect(swatches(materials_page).nth(1)).to_have_attribute("aria-pressed", "true")


def test_a_brush_paints_under_its_ring_on_a_magnified_picture(materials_page):
    swatches(materials_page).nth(1).click()
    button(materials_page, "Brush").click()
    materials_page.get_by_role("slider", name="Brush size").fill("45")
    materials_page.mouse.move(*place(materials_page, BALL))
    wait_until_shown(materials_page)
    ring = materials_page.locator(".ring")
    width, share = ring.bounding_box()["width"], share_of(materials_page, 1)
    zoom(materials_page, place(materials_page, (0.35, 0.6)), 4)
    np.testing.assert_allclose(ring.bounding_box()["width"], np.exp(4 * 0.24) * width, rtol=0.02)
    start, end = place(materials_page, (0.3, 0.6)), place(materials_page, (0.4, 0.6))
    press_and_move(materials_page, start, np.subtract(end, start))
    np.testing.assert_allclose(middle(materials_page, ".ring"), end, atol=1)
    settled(materials_page, 2)
    assert share_of(materials_page, 1) > share
    materials_page.keyboard.press("0")
    assert until(materials_page, lambda: shown_color(materials_page, (0.35, 0.6)).min() > 115)  # as drawn
    for beside in ((0.35, 0.52), (0.35, 0.68), (0.24, 0.6)):
        assert shown_color(materials_page, beside).max() < 110  # veiled


def test_regions_are_filled_and_split_on_a_magnified_picture(materials_page):
    zoom(materials_page, place(materials_page, (0.4, 0.4)), 3)
    button(materials_page, "Split").click()
    corners = [place(materials_page, corner) for corner in ((0.3, 0.3), (0.4, 0.3), (0.4, 0.4), (0.3, 0.4))]
    materials_page.mouse.move(*corners[0])
    materials_page.mouse.down()
    for corner in corners[1:]:
        materials_page.mouse.move(*corner, steps=8)
    materials_page.mouse.up()
    settled(materials_page, 3)
    materials_page.mouse.move(*place(materials_page, (0.2, 0.5)))
    swatches(materials_page).nth(0).click()
    button(materials_page, "Fill").click()
    materials_page.mouse.click(*place(materials_page, (0.39, 0.39)))
    settled(materials_page, 2)


def test_a_correction_leaves_the_picture_magnified_and_another_drawing_is_fitted(materials_page):
    zoom(materials_page, place(materials_page, BADGE), 4)
    before = picture_box(materials_page, "relit")
    materials_page.mouse.click(*place(materials_page, BADGE))
    button(materials_page, "Merge into").click()
    materials_page.mouse.click(*place(materials_page, (0.4, 0.5)))
    settled(materials_page, 1)
    assert picture_box(materials_page, "relit") == before
    materials_page.locator('[data-value="pear"]').click()
    expect(materials_page.locator(".card.relit .fit")).to_be_hidden()

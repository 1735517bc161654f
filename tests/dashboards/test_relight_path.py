"""Key lights on the relight page: set, gone to, put in order, played, undone, and downloaded as an animation."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from tests.dashboards.driving import VIEW, differ, relit_pixels, sliders, until, wait_until_answered
from toonkit import light_angles
from toonkit.model.light_path import light_path

pytestmark = pytest.mark.browser

AZIMUTHS = (35, 120, 200)


def add_key_lights(page):
    """Add the light the page opens with, and two others, to the path."""
    for count, azimuth in enumerate(AZIMUTHS, 1):
        page.get_by_role("slider", name="Relit: azimuth").fill(str(azimuth))
        assert until(page, lambda azimuth=azimuth: sliders(page, "relit") == [azimuth, 40])
        page.get_by_role("button", name="Key light", exact=True).click()
        expect(keys(page)).to_have_count(count)
    wait_until_answered(page)


def keys(page):
    return page.locator(".light-path .key")


def azimuths(page):
    return [
        int(name.split("azimuth ")[1].split("°")[0])
        for name in keys(page).evaluate_all("nodes => nodes.map((node) => node.getAttribute('aria-label'))")
    ]


def test_key_lights_are_gone_to_put_in_order_removed_and_undone(relight_page):
    page = relight_page
    expect(page.get_by_role("region", name="Light path")).to_be_hidden()
    add_key_lights(page)
    at_the_end = relit_pixels(page)
    keys(page).first.click()
    assert until(page, lambda: sliders(page, "relit") == [35, 40])
    assert until(page, lambda: differ(relit_pixels(page), at_the_end) > 0.01)
    page.get_by_role("button", name="Move the chosen key light behind the next one").click()
    assert azimuths(page) == [120, 35, 200]
    box, row = keys(page).nth(2).bounding_box(), page.locator(".light-path .keys").bounding_box()
    page.mouse.move(box["x"] + 20, box["y"] + 20)
    page.mouse.down()
    page.mouse.move(row["x"] + 2, box["y"] + 20, steps=5)
    page.mouse.up()
    assert azimuths(page) == [200, 120, 35]
    keys(page).nth(1).focus()
    page.keyboard.press("Delete")
    assert azimuths(page) == [200, 35]
    assert until(page, lambda: len(page.evaluate(f"{VIEW}.key_lights")) == 2)
    page.get_by_role("button", name="Undo").click()
    assert until(page, lambda: azimuths(page) == [200, 120, 35])


def test_the_light_travels_as_in_the_animation_and_python_hears_of_it_once_it_rests(relight_page, tmp_path):
    page = relight_page
    add_key_lights(page)
    page.get_by_role("button", name="Return to the first key light").click()
    page.get_by_role("slider", name="Place of the light on the path").fill("250")
    way = light_path([(azimuth, 40) for azimuth in AZIMUTHS], 5, loop=False)
    azimuth, elevation = light_angles(way[1])
    assert until(page, lambda: sliders(page, "relit") == [round(azimuth), round(elevation)])
    wait_until_answered(page)
    page.get_by_role("spinbutton", name="Seconds that the path takes").fill("1")
    page.keyboard.press("Tab")
    before = page.evaluate(f"{VIEW}.new_light")
    page.get_by_role("button", name="Let the light travel along the path").click()
    assert until(page, lambda: sliders(page, "relit") != [round(azimuth), round(elevation)])
    while page.get_by_role("button", name="Let the light rest").is_visible():
        assert page.evaluate(f"{VIEW}.new_light") == before or sliders(page, "relit") == [200, 40]
    assert sliders(page, "relit") == [200, 40]
    assert until(page, lambda: np.allclose(page.evaluate(f"{VIEW}.new_light"), [-160, 40]))
    with page.expect_download() as started:
        page.get_by_role("button", name="Animation", exact=True).click()
    started.value.save_as(tmp_path / "relit.gif")
    with Image.open(BytesIO((tmp_path / "relit.gif").read_bytes())) as animation:
        assert (animation.n_frames, animation.width) == (17, page.evaluate(f"{VIEW}.picture_size[0]"))

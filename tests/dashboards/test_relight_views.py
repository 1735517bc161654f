"""The linked views of the relight page: panned, zoomed and read together, relit with the page, beside another method."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from tests.dashboards.driving import differ, open_views, until, view, wait_until_answered

pytestmark = pytest.mark.browser

# The longest side of each picture that the page holds for a plot; color-map strips are one pixel high.
SENT = """() => [...Bokeh.documents[0]._all_models.values()]
  .map((model) => model.type === "ColumnDataSource" && model.data.image?.[0].shape)
  .filter((shape) => shape && shape[0] > 1).map((shape) => Math.max(...shape))"""


@pytest.fixture
def views_page(relight_page):
    """The views of the first sample, fitted, without another method; afterwards as they were."""
    page = relight_page
    open_views(page)
    page.get_by_role("button", name="Fit all pictures").click()
    yield page
    choose_other(page, "no other method")


def choose_other(page, name):
    page.get_by_role("combobox", name="Compare with").click()
    page.get_by_role("menuitem", name=name, exact=True).click()


def seen(page, title):
    """A picture as painted on screen, with the pointer beside it."""
    page.mouse.move(640, 4)
    figure = view(page, title)
    figure.scroll_into_view_if_needed()
    return np.asarray(Image.open(BytesIO(figure.screenshot())).convert("RGB"), int)


def reading(page):
    return page.locator(".reading").inner_text()


def test_all_views_are_magnified_together_and_say_what_a_pixel_is(views_page):
    page = views_page
    wide = view(page, "Drawing").bounding_box()["width"]
    assert until(
        page, lambda: abs(max(page.evaluate(SENT)) - wide) <= 1
    )  # of 512 pixels, those that fit the frame
    before = {title: seen(page, title) for title in ("Drawing", "Normal map")}
    figure = view(page, "Drawing")
    figure.scroll_into_view_if_needed()
    box = figure.bounding_box()
    page.mouse.move(box["x"] + 0.45 * box["width"], box["y"] + 0.3 * box["height"])
    assert until(page, lambda: "Material 1 of" in reading(page))
    assert "toonkit" in reading(page)
    assert float(reading(page).split("L · N ")[1].split(" ")[0]) > 0.5  # on the lit side of the head
    page.keyboard.down("Control")
    for _ in range(3):
        page.mouse.wheel(0, -120)
    page.keyboard.up("Control")
    assert until(page, lambda: all(differ(seen(page, title), old) > 0.2 for title, old in before.items()))
    page.get_by_role("button", name="Fit all pictures").click()
    assert until(page, lambda: all(differ(seen(page, title), old) < 0.02 for title, old in before.items()))
    row = page.get_by_role("textbox", name="Row")
    row.fill("0")
    row.press("Enter")
    assert until(page, lambda: "Outside the object" in reading(page))


def test_the_relit_view_follows_the_light_and_another_method_stands_beside_it(views_page):
    page = views_page
    before = seen(page, "Relit")
    page.get_by_role("slider", name="Relit: azimuth").fill("200")
    assert until(page, lambda: differ(seen(page, "Relit"), before) > 0.02)
    choose_other(page, "Lumo")
    expect(view(page, "Relit · Lumo")).to_be_visible()
    expect(view(page, "Normal map · Lumo")).to_be_visible()
    assert until(page, lambda: differ(seen(page, "Relit · Lumo"), seen(page, "Relit")) > 0.01)
    ours, other = (view(page, title).bounding_box() for title in ("Relit", "Relit · Lumo"))
    assert ours["y"] == other["y"]
    assert other["x"] > ours["x"]
    page.get_by_role("button", name="Undo").click()
    wait_until_answered(page)
    assert until(page, lambda: differ(seen(page, "Relit"), before) < 0.02)
    choose_other(page, "no other method")
    expect(view(page, "Relit · Lumo")).to_have_count(0)

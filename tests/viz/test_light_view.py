"""The relight view in a notebook and as a file of its own, against `toonkit.relight`."""

from __future__ import annotations

import time
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

import toonkit
import toonkit.viz
from tests.viz.test_relight_view import REMEMBER_PIXELS, assert_shown
from toonkit import ToneRamp, ToonkitError, light_direction, relight

ANGLES = (20.0, 30.0)
PATIENCE_SECONDS = 60
RAMP = ToneRamp(["#203060", "#5070b0", "#90c0f0"], [0.0, 0.55], [0.2, 0.01])


@pytest.fixture(params=["as drawn", "recolored", "stays flat"])
def shown(request, harlequin):
    if request.param == "as drawn":
        return harlequin
    flat = request.param == "stays flat"
    return harlequin.recolored(
        {0: ToneRamp(RAMP.tones, RAMP.thresholds, RAMP.softness, stays_flat=flat), 2: RAMP}
    )


def drawn_again(page):
    """Wait until the picture is drawn; the page's policy forbids Playwright's own wait, which evaluates a text."""
    end = time.monotonic() + PATIENCE_SECONDS
    while not page.evaluate("window.drawn?.count > 0") and time.monotonic() < end:
        page.wait_for_timeout(50)
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.evaluate("window.drawn?.count > 0")


@pytest.fixture
def offline(page, shown, tmp_path):
    """The file, opened where nothing else can be."""
    shown.save_html(tmp_path / "ball.html", ANGLES)
    heard = []
    page.on("pageerror", lambda error: heard.append(f"page error: {error}"))
    page.on("console", lambda message: heard.append(message.text) if message.type == "error" else None)
    page.on(
        "request", lambda request: heard.append(request.url) if not request.url.startswith("file:") else None
    )
    page.add_init_script(REMEMBER_PIXELS)
    page.goto((tmp_path / "ball.html").as_uri())
    assert drawn_again(page)
    yield page
    assert heard == []


@pytest.mark.browser
def test_the_file_shows_the_relit_picture_and_follows_the_light(offline, shown):
    assert_shown(offline, relight(shown, ANGLES).to_rgba())
    offline.evaluate("window.drawn.count = 0")
    offline.get_by_role("slider", name="Relit: azimuth").fill("200")
    assert drawn_again(offline)
    assert_shown(offline, relight(shown, (200, 30)).to_rgba())
    offline.evaluate("window.drawn.count = 0")
    offline.get_by_role("button", name="Reset to original").click()
    assert drawn_again(offline)
    assert_shown(offline, relight(shown, shown.light).to_rgba())


def stage_pixels(page):
    """The stage as painted on screen."""
    return np.asarray(Image.open(BytesIO(page.locator(".stage").screenshot())).convert("RGB"), dtype=int)


@pytest.mark.browser
def test_the_file_is_split_at_a_divider_left_of_which_it_is_as_drawn(offline, harlequin):
    offline.get_by_role("slider", name="Relit: azimuth").fill("300")  # the sun is on the right
    expect(offline.locator("output").first).to_have_text("300°")
    relit = stage_pixels(offline)
    offline.get_by_role("button", name="Compare with the drawing").click()
    divider = offline.get_by_role("slider", name="How much is shown as drawn")
    divider.press("ArrowRight")
    expect(divider).to_have_attribute("aria-valuenow", "51")
    split, middle = stage_pixels(offline), round(0.51 * relit.shape[1])
    labels, beside = 40, 30
    right = np.s_[labels:, middle + beside :]
    assert (np.abs(split[right] - relit[right]) > 2).mean() < 0.001
    box, stage = (offline.locator(name).last.bounding_box() for name in ("canvas.picture", ".stage"))
    drawn = harlequin.image.to_rgba().astype(int)
    rows, columns = np.nonzero(drawn[..., 3] == 255)
    scale = box["width"] / drawn.shape[1]
    y = (box["y"] - stage["y"] + (rows + 0.5) * scale).astype(int)
    x = (box["x"] - stage["x"] + (columns + 0.5) * scale).astype(int)
    left = (y > labels) & (x < middle - beside)
    assert left.sum() > 1000
    assert np.abs(split[y, x] - drawn[rows, columns, :3])[left].max() <= 1
    assert (np.abs(relit[y, x] - drawn[rows, columns, :3])[left] > 8).mean() > 0.05
    offline.keyboard.press("c")
    expect(divider).to_be_hidden()


@pytest.mark.browser
def test_the_file_magnifies_its_picture_about_the_pointer(offline):
    picture, stage = offline.locator("canvas.picture").last, offline.locator(".stage").bounding_box()
    before = picture.bounding_box()
    offline.mouse.move(stage["x"] + 0.4 * stage["width"], stage["y"] + 0.3 * stage["height"])
    offline.keyboard.down("Control")
    offline.mouse.wheel(0, -120)
    offline.keyboard.up("Control")
    expect(offline.get_by_role("button", name="Fit the picture")).to_be_visible()
    after = picture.bounding_box()
    assert after["width"] == pytest.approx(np.exp(0.24) * before["width"], rel=1e-3)
    offline.get_by_role("slider", name="Relit: azimuth").press("0")
    expect(offline.get_by_role("button", name="Fit the picture")).to_be_hidden()
    assert picture.bounding_box() == before


def test_a_view_is_made_of_an_analysis_and_shows_its_light(shown):
    view = toonkit.viz.relight_view(shown, light_direction(*ANGLES), ambient=0.2)
    assert np.allclose(view.new_light, ANGLES)
    assert (view.ambient, view.picture_size) == (0.2, [120, 120])
    assert bool(view.recolored) == (shown.drawn_materials is not None)


def test_a_file_of_another_kind_and_what_is_no_analysis_are_refused(harlequin, tmp_path):
    with pytest.raises(ToonkitError, match=r"must end in \.html"):
        harlequin.save_html(tmp_path / "ball.png")
    with pytest.raises(ToonkitError, match="analysis must be"):
        toonkit.viz.relight_view("ball.png")

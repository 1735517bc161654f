"""The relight view in a notebook and as a file of its own, against `toonkit.relight`."""

from __future__ import annotations

import time

import numpy as np
import pytest

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

"""A dashboard driven as a visitor would, and what is seen of it on screen."""

from __future__ import annotations

import time
from contextlib import contextmanager
from io import BytesIO

import numpy as np
from PIL import Image
from playwright.sync_api import expect

from toonkit.study.estimators import list_estimators

START_SECONDS = 180  # the first page of a busy machine also compiles
PATIENCE_SECONDS = 90  # for what a page answers once it stands
WINDOW = {"width": 1440, "height": 900}
LOCAL = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")

BALL_SIDE = 128
"""Of the ball with two materials: that of no other drawing."""

BADGE, BALL = (0.6, 0.6), (0.35, 0.35)  # places on its picture, as shares of the sides

# What the relight view knows of Python's state.
VIEW = """[...Bokeh.documents[0]._all_models.values()]
  .find((model) => model.data?.attributes?.picture_size)?.data"""
# Whether the surface of the 3-D tab is painted as the drawing on screen is, and not as the one before.
IS_OF_DRAWING = f"""() => {{
  const view = {VIEW}
  const surface = [...Bokeh.documents[0]._all_models.values()].find((model) => model.data?.attributes?.grid_size)?.data
  const [drawing, painted] = [new Uint8Array(view.color), new Uint8Array(surface?.colors ?? [])]
  const [width, columns] = [view.picture_size[0], surface?.grid_size[0]]
  let [inside, alike] = [0, 0]
  for (let sample = 0; sample < painted.length / 4; sample++) {{
    if (painted[4 * sample + 3] === 0) {{ continue }}
    const step = Math.round(width / columns)
    const pixel = step * (Math.floor(sample / columns) * width + sample % columns)
    inside += 1
    alike += [0, 1, 2].every((k) => Math.abs(drawing[4 * pixel + k] - painted[4 * sample + k]) <= 1)
  }}
  return inside > 0 && alike > 0.99 * inside
}}"""
# Longer than a page takes to show what has arrived: textures and labels are each loaded in a task of their own.
SHOWN = """() => new Promise((done) => setTimeout(
  () => requestAnimationFrame(() => requestAnimationFrame(done)), 100
))"""

expect.set_options(timeout=PATIENCE_SECONDS * 1000)


def listen(page):
    """What a page complains about from now on: errors, and requests that leave this machine."""
    page.set_default_timeout(PATIENCE_SECONDS * 1000)
    heard: list[str] = []
    page.on("pageerror", lambda error: heard.append(f"page error: {error}"))
    page.on("console", lambda message: heard.append(message.text) if message.type == "error" else None)
    page.on("request", lambda request: None if request.url.startswith(LOCAL) else heard.append(request.url))
    return heard


class Tab:
    """
    A dashboard that many tests share, since opening it takes seconds: one test after the other has it to itself.

    Parameters
    ----------
    page : playwright page
        Blank until a test asks for it.
    url : str
        The address of the dashboard.
    when_open : callable
        Waits until the dashboard stands, and returns what tests want to know of how it opens.
    """

    def __init__(self, page, url, when_open):
        self.page = page
        self._url, self._when_open = url, when_open
        self._heard = listen(page)
        self._failures = None  # of all tests when the last one began; None while the page is blank

    def leave(self):
        """End the session of the page, as a visitor who goes elsewhere."""
        self.page.goto("about:blank")
        self._failures = None

    @contextmanager
    def lent(self, failures, start=lambda page, opening: None, *, fresh=False):
        """The page for one test, which begins with `start`; opened anew if asked, or if the test before has failed."""
        if fresh or failures != self._failures:
            self._heard.clear()
            self.page.goto(self._url, timeout=START_SECONDS * 1000)
            self.opening = self._when_open(self.page)
        self._failures = failures
        start(self.page, self.opening)
        yield self.page
        assert self._heard == []


def until(page, condition, seconds=60):
    """Wait for what a loaded machine shows late; whether it came."""
    end = time.monotonic() + seconds
    while not (come := condition()) and time.monotonic() < end:
        page.wait_for_timeout(50)
    return come


def wait_until_shown(page):
    """Wait until the page has painted what it was told last."""
    page.evaluate(SHOWN)


def wait_until_answered(page):
    """Wait until Python has answered all that the relight view has asked for, and the answer is on screen."""
    page.wait_for_selector(".materials:not([aria-busy=true])", state="attached")
    page.wait_for_selector(".busy:not(.on)", state="attached")
    wait_until_shown(page)


def pixels_in(page, box):
    """A part of the page as painted on screen."""
    return np.asarray(Image.open(BytesIO(page.screenshot(clip=box))).convert("RGB"), dtype=int)


def relit_pixels(page):
    """The relit picture as painted on screen."""
    return pixels_in(page, page.locator(".card.relit .stage").bounding_box())


def original_pixels(page):
    """The drawing as painted on screen."""
    return pixels_in(page, page.locator(".card.original .stage").bounding_box())


def surface_pixels(page):
    """The canvas of the 3-D tab as painted on screen, its arrows included."""
    page.locator(".surface canvas").scroll_into_view_if_needed()
    wait_until_shown(page)
    shot = page.locator(".surface canvas").screenshot()
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=int)


def differ(one, other):
    """The share of pixels in which two pictures of one size differ clearly."""
    rows = min(len(one), len(other))
    return (np.abs(one[:rows] - other[:rows]).max(axis=-1) > 30).mean()


def sliders(page, card):
    """Azimuth and elevation of the light of a card, as its sliders say."""
    return [int(output.inner_text().rstrip("°")) for output in page.locator(f".card.{card} output").all()]


def drag(page, target, to, steps=6):
    """Drag from the middle of an element to a place of it, from -1 to 1 to the right and up."""
    box = page.locator(target).bounding_box()
    center = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*center)
    page.mouse.down()
    page.mouse.move(center[0] + to[0] * box["width"] / 2, center[1] - to[1] * box["height"] / 2, steps=steps)
    page.mouse.up()
    wait_until_shown(page)


def picture_side(page):
    """Width of the drawing that the relight page has on screen."""
    return page.evaluate(f"{VIEW}.picture_size[0]")


def upload_ball(page, side, badge=False, flat=False, **options):
    """Drop a drawing of a gray ball, with a flat red badge, unshaded or saved with options, and wait until it shows."""
    y, x = np.mgrid[:side, :side] - side / 2 + 0.5
    tone = np.where((x + y < 0) | flat, 230, 120)
    color = np.dstack([tone, tone, tone])
    if badge:
        color[np.hypot(x - 0.1 * side, y - 0.1 * side) < 0.15 * side] = (200, 30, 40)
    alpha = np.where(np.hypot(x, y) < 0.42 * side, 255, 0)
    buffer = BytesIO()
    Image.fromarray(np.dstack([color, alpha]).astype(np.uint8)).save(buffer, "PNG", **options)
    page.locator("input[type=file]").set_input_files(
        {"name": "ball.png", "mimeType": "image/png", "buffer": buffer.getvalue()}
    )
    page.wait_for_function(f"side => {VIEW}.picture_size[0] === side", arg=side)
    wait_until_answered(page)


def open_shape(page):
    """Open the 3-D tab, and wait until the surface of the drawing stands there."""
    page.get_by_role("tab", name="Shape in 3-D").click()
    page.wait_for_selector(".surface canvas")
    page.wait_for_function(IS_OF_DRAWING)
    assert until(page, lambda: np.ptp(surface_pixels(page)[20:-20], axis=(0, 1)).max() > 60)


def open_views(page):
    """Open the tab of linked views, and wait until all of them stand there."""
    page.get_by_role("tab", name="Views").click()
    expect(view(page, "Illumination after refinement")).to_be_visible()


def view(page, title):
    """The linked view below a title."""
    cell = page.locator(".bk-panel-models-layout-Column").filter(has=page.get_by_text(title, exact=True)).last
    return cell.locator(".bk-Figure")


def wait_until_relit(page):
    """Wait until the relight page has opened with its first sample; both pictures of it."""
    page.wait_for_selector(".relight:not(.empty)", timeout=START_SECONDS * 1000)
    page.wait_for_selector(".busy:not(.on)", state="attached")
    wait_until_shown(page)
    return original_pixels(page), relit_pixels(page)


def show_first_sample(page, opening):
    """Put the relight page back to how it opened."""
    take_all_back(page)
    page.get_by_role("button", name="Light", exact=True).click()
    page.get_by_role("tab", name="Color map").click()
    sample = page.locator('[aria-label="Sample drawing"] [data-value]').first
    if sample.get_attribute("aria-checked") != "true":
        sample.click()
        assert until(page, lambda: differ(original_pixels(page), opening[0]) < 0.001)
        take_all_back(page)
    assert until(page, lambda: differ(relit_pixels(page), opening[1]) < 0.001)


def show_badged_ball(page, _):
    """Bring a gray ball with a red badge to the relight page, and show the materials that were found in it."""
    page.set_viewport_size(WINDOW)
    take_all_back(page)
    if picture_side(page) != BALL_SIDE:
        upload_ball(page, BALL_SIDE, badge=True)
        take_all_back(page)
    page.get_by_role("button", name="Materials", exact=True).click()
    wait_until_answered(page)


def shown_color(page, share):
    """Color on screen around a place of the picture."""
    x, y = place(page, share)
    return pixels_in(page, {"x": x - 2, "y": y - 2, "width": 4, "height": 4}).mean(axis=(0, 1))


def share_of(page, which):
    """Share of the object, in percent, that a swatch says its material has."""
    return int(swatches(page).nth(which).get_attribute("title").split(",")[1].split("%")[0])


def swatches(page):
    return page.locator(".swatch:not(.new):not(.ghost):not(.mark)")


def button(page, name):
    where = page.locator(".icons" if name in ("Undo", "Redo") else ".tools")
    return where.get_by_role("button", name=name)


def picture_box(page, card):
    """Where the picture of a card lies, with what its stage cuts off."""
    return page.locator(f".card.{card} canvas.picture").last.bounding_box()


def zoom(page, at, notches):
    """Turn the wheel over a place on the screen with Ctrl held, and wait until the pictures have followed."""
    before = picture_box(page, "original")
    page.mouse.move(*at)
    page.keyboard.down("Control")
    for _ in range(abs(notches)):
        page.mouse.wheel(0, -120 if notches > 0 else 120)
    page.keyboard.up("Control")
    wanted = before["width"] * np.exp(0.24 * notches)  # 24 pixels of 1 % each count for a notch
    assert until(page, lambda: np.isclose(picture_box(page, "original")["width"], wanted, rtol=1e-3))
    wait_until_shown(page)


def place(page, share):
    """Where on the screen a place of the picture is, however magnified."""
    box = picture_box(page, "original")
    return box["x"] + share[0] * box["width"], box["y"] + share[1] * box["height"]


def settled(page, count):
    """Wait until so many materials are on screen, as analyzed."""
    wait_until_answered(page)
    expect(swatches(page)).to_have_count(count)


def take_all_back(page):
    """Put all tools of the relight page down, close what it says, and undo what was done to the drawing and its light."""
    for _ in range(3):
        page.keyboard.press("Escape")  # a merge, the brush, a choice
    page.mouse.move(WINDOW["width"] / 2, 5)
    fit = page.locator(".card.relit .fit")
    if fit.is_visible():
        fit.click()
    compare = page.get_by_role("button", name="Compare with the drawing")
    if compare.get_attribute("aria-pressed") == "true":
        compare.click()
    undo = page.get_by_role("button", name="Undo")
    wait_until_answered(page)
    while undo.is_enabled():
        undo.click()
        wait_until_answered(page)
    said = page.locator(".notistack-Snackbar")
    said.locator("button").evaluate_all("buttons => buttons.forEach((button) => button.click())")
    expect(said).to_have_count(0)


# The value of each select of the study page, by its label, and that of its method cards; or those to be set.
CHOICES = """(wanted) => Object.fromEntries(
  [...Bokeh.documents[0]._all_models.values()]
    .map((model) => model.data)
    .filter((data) => data?.attributes && ("options" in data.attributes || "choices" in data.attributes))
    .map((data) => {
      if (wanted && data.value !== wanted[data.label]) { data.setv({value: wanted[data.label]}) }
      return [data.label, data.value]
    })
)"""


def shown_pictures(page):
    """The addresses of all pictures of the trial that the study page shows."""
    return page.locator(".sheet .tile img").evaluate_all("images => images.map((image) => image.src)")


def wait_until_examined(page):
    """Wait until the study page has opened with a trial examined by all methods; its choices and pictures."""
    page.wait_for_selector(".bk-Figure", timeout=START_SECONDS * 1000)
    last = page.locator(".sheet img[alt='normal map']").nth(len(list_estimators()))
    last.wait_for(timeout=START_SECONDS * 1000)
    return page.evaluate(CHOICES), shown_pictures(page)


def show_first_choices(page, opening):
    """Put the study page back to how it opened."""
    choices, pictures = opening
    page.keyboard.press("Escape")
    page.evaluate(CHOICES, choices)
    assert until(page, lambda: page.evaluate(CHOICES) == choices)
    assert until(page, lambda: shown_pictures(page) == pictures)

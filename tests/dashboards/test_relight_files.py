"""Files on the relight page: sessions, layered documents, and code that paints what is on screen."""

from __future__ import annotations

import shlex
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

import toonkit
from tests.dashboards.driving import (
    BALL,
    BALL_SIDE,
    VIEW,
    differ,
    original_pixels,
    place,
    relit_pixels,
    settled,
    sliders,
    swatches,
    until,
    wait_until_answered,
    wait_until_shown,
)
from tests.model.layered_files import write_layered
from tests.model.test_layer_loading import CHARACTER, SHAPE
from toonkit.cli import main

pytestmark = pytest.mark.browser

# The relit picture at its own size, drawn once more: a canvas keeps nothing that could be read later.
PAINTED = """canvas => {
  const gl = canvas.getContext("webgl2")
  const [width, height] = [canvas.width, canvas.height]
  const pixels = new Uint8Array(4 * width * height)
  gl.drawArrays(gl.TRIANGLES, 0, 3)
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels)
  return [width, height, [...pixels]]
}"""
STRAY_SHARE = 0.0005  # of pixels, which half floats put on the other side of an edge


def painted(page):
    """The relit picture as the graphics card paints it, RGBA."""
    wait_until_shown(page)
    width, height, pixels = page.locator(".card.relit .after canvas.picture").evaluate(PAINTED)
    return np.array(pixels).reshape(height, width, 4)[::-1]


def drop(page, name, content, size):
    """Drop a file of which the browser knows no type, and wait until a picture of that size is on screen."""
    page.locator("input[type=file]").set_input_files({"name": name, "mimeType": "", "buffer": content})
    page.wait_for_function(f"size => {VIEW}.picture_size.join() === size", arg=",".join(map(str, size)))
    wait_until_answered(page)


def ball_file(side):
    """A PNG of a ball in two tones."""
    y, x = np.mgrid[:side, :side] - side / 2 + 0.5
    tone = np.where(x + y < 0, 230, 120)
    alpha = np.where(np.hypot(x, y) < 0.42 * side, 255, 0)
    file = BytesIO()
    Image.fromarray(np.dstack([tone, tone, tone, alpha]).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


def copied(page, button):
    """What a button has put on the clipboard, and what it says about it."""
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.evaluate("navigator.clipboard.writeText('')")
    page.get_by_role("button", name=button).click()
    box = page.get_by_role("textbox", name=button)
    expect(box).to_be_visible()
    assert until(page, lambda: page.evaluate("navigator.clipboard.readText()") == box.input_value() != "")
    return box.input_value(), page.locator(".copy p").inner_text()


def set_everything(page):
    """Change every setting of the new light."""
    page.get_by_role("slider", name="Relit: azimuth").fill("200")
    page.get_by_role("slider", name="Relit: elevation").fill("25")
    page.get_by_role("slider", name="Ambient light").focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    page.get_by_role("switch", name="Keep brushwork").click()
    page.wait_for_function(f"() => {VIEW}.ambient === 0.25 && {VIEW}.keep_detail === false")
    assert until(page, lambda: sliders(page, "relit") == [200, 25])
    wait_until_answered(page)


def off(picture, page):
    """The share of pixels in which a picture is more than 1/255 off that on the page."""
    return (np.abs(np.asarray(picture, int) - painted(page)).max(axis=-1) > 1).mean()


def test_what_is_copied_paints_the_picture_on_screen(relight_page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, content = "it's my bäll.png", ball_file(112)
    (tmp_path / name).write_bytes(content)
    drop(relight_page, name, content, (112, 112))
    set_everything(relight_page)
    python, _ = copied(relight_page, "Copy as Python")
    assert "ambient=0.25, " not in python  # as the last one
    assert "ambient=0.25)" in python
    exec(compile(python, "<copied>", "exec"), {})
    made = tmp_path / "it's my bäll_relit.png"
    assert off(Image.open(made), relight_page) < STRAY_SHARE
    made.unlink()
    commands, note = copied(relight_page, "Copy as command line")
    assert note == f"Copied. Run it in the folder of {name}."
    for command in commands.split(" &&\n"):
        assert main([*shlex.split(command)[1:], "--quiet"]) == 0
    assert off(Image.open(made), relight_page) < STRAY_SHARE


def test_where_the_clipboard_is_refused_the_code_is_shown_and_selected(relight_page):
    relight_page.evaluate("""() => {
      navigator.clipboard.writeText = () => Promise.reject(new Error("no"))
      document.execCommand = () => false
    }""")
    relight_page.get_by_role("button", name="Copy as Python").click()
    expect(relight_page.locator(".copy p")).to_contain_text("Not copied: press Ctrl+C.")
    box = relight_page.get_by_role("textbox", name="Copy as Python")
    assert until(relight_page, lambda: box.input_value().startswith("import toonkit"))
    assert until(
        relight_page,
        lambda: box.evaluate("box => box.selectionEnd - box.selectionStart === box.value.length"),
    )
    relight_page.evaluate("() => { delete navigator.clipboard.writeText; delete document.execCommand }")


def save_session(page, folder):
    with page.expect_download() as started:
        page.get_by_text("Save session").click()
    path = folder / started.value.suggested_filename
    started.value.save_as(path)
    return path


def show_tone(page):
    """Choose the ball; its darkest tone."""
    page.mouse.click(*place(page, BALL))
    tone = page.get_by_label("Tone 1 of 2, the darkest")
    expect(tone).to_be_visible()
    return tone


@pytest.fixture
def left_tab(relight_tab):
    """Afterwards, the page is left: undo does not take back what an opened session or analysis has set."""
    yield
    relight_tab.leave()


@pytest.mark.usefixtures("left_tab")
def test_a_saved_session_brings_everything_back(materials_page, tmp_path, monkeypatch):
    page = materials_page
    monkeypatch.chdir(tmp_path)
    before = relit_pixels(page)
    show_tone(page).fill("#2040a0")
    assert until(page, lambda: differ(relit_pixels(page), before) > 0.01)
    settled(page, 2)
    set_everything(page)
    worked, drawing, light = painted(page), original_pixels(page), sliders(page, "original")
    path = save_session(page, tmp_path)
    assert path.name == "ball.toonkit"
    page.locator('[data-value="pear"]').click()
    assert until(page, lambda: differ(original_pixels(page), drawing) > 0.05)
    page.get_by_role("slider", name="Relit: azimuth").fill("10")
    wait_until_answered(page)
    drop(page, path.name, path.read_bytes(), (BALL_SIDE, BALL_SIDE))
    assert until(page, lambda: sliders(page, "relit") == [200, 25])
    assert sliders(page, "original") == light
    settled(page, 2)
    assert until(page, lambda: (np.abs(painted(page) - worked).max(axis=-1) > 1).mean() < STRAY_SHARE)
    expect(page.get_by_role("slider", name="Ambient light")).to_have_value("0.25")
    expect(page.get_by_role("switch", name="Keep brushwork")).not_to_be_checked()
    expect(page.get_by_label("Tone 1 of 2, the darkest")).to_have_value("#2040a0")
    python, _ = copied(page, "Copy as Python")
    assert "toonkit.load_analysis('ball.toonkit')" in python
    exec(compile(python, "<copied>", "exec"), {})
    assert off(Image.open("ball_relit.png"), page) < STRAY_SHARE


@pytest.mark.usefixtures("left_tab")
def test_an_analysis_from_python_is_dropped(relight_page, tmp_path):
    (tmp_path / "ball.png").write_bytes(ball_file(104))
    toonkit.analyze(tmp_path / "ball.png", (90, 30), method="lumo").save(tmp_path / "ball.npz")
    drop(relight_page, "ball.npz", (tmp_path / "ball.npz").read_bytes(), (104, 104))
    assert sliders(relight_page, "original") == [90, 30]
    expect(relight_page.locator('[data-value="lumo"]')).to_have_attribute("aria-checked", "true")


@pytest.mark.parametrize("content", [b"PK\x03\x04 cut off", b"%PDF-1.7"])
def test_a_foreign_file_is_refused_with_what_to_do_and_the_work_is_kept(relight_page, content):
    before = relit_pixels(relight_page)
    relight_page.locator("input[type=file]").set_input_files(
        {"name": "other.toonkit", "mimeType": "", "buffer": content}
    )
    relight_page.wait_for_selector("text=/source must be .*other.toonkit/")
    np.testing.assert_array_equal(relit_pixels(relight_page), before)
    expect(relight_page.get_by_role("radio", name="other.toonkit")).to_have_count(0)


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
def test_a_layered_document_is_opened_with_the_materials_of_its_layers(relight_page, kind, tmp_path):
    path = write_layered(kind, CHARACTER, SHAPE, tmp_path)
    drop(relight_page, f"cat.{kind}", path.read_bytes(), SHAPE[::-1])
    relight_page.get_by_role("button", name="Materials", exact=True).click()
    settled(relight_page, 2)
    assert swatches(relight_page).count() == 2


def test_a_picture_is_pasted(relight_page):
    relight_page.evaluate(
        """content => {
          const files = new DataTransfer()
          files.items.add(new File([new Uint8Array(content)], "image.png", {type: "image/png"}))
          document.body.dispatchEvent(new ClipboardEvent("paste", {clipboardData: files, bubbles: true, composed: true}))
        }""",
        list(ball_file(100)),
    )
    relight_page.wait_for_function(f"() => {VIEW}.picture_size[0] === 100")
    wait_until_answered(relight_page)


def test_files_that_were_dropped_together_are_switched_between(relight_page):
    files = [
        {"name": f"ball {side}.png", "mimeType": "image/png", "buffer": ball_file(side)} for side in (98, 102)
    ]
    relight_page.locator("input[type=file]").set_input_files(files)
    cards = relight_page.get_by_role("radiogroup", name="Your files")
    expect(cards.get_by_role("radio", name="ball 102.png")).to_have_attribute("aria-checked", "true")
    for side in (98, 102, 98):
        card = cards.get_by_role("radio", name=f"ball {side}.png")
        card.click()
        relight_page.wait_for_function(f"side => {VIEW}.picture_size[0] === side", arg=side)
        wait_until_answered(relight_page)
        expect(card).to_have_attribute("aria-checked", "true")

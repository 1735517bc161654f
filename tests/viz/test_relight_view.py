"""The shader against `toonkit.relight`, pixel by pixel."""

from __future__ import annotations

import socket
from dataclasses import asdict

import numpy as np
import panel as pn
import pytest

from toonkit import ToneRamp, light_direction, relight
from toonkit.model.luminance import color_of_hex
from toonkit.viz.relight_page.view import RelightView

REMEMBER_PIXELS = """
const draw = WebGL2RenderingContext.prototype.drawArrays;
WebGL2RenderingContext.prototype.drawArrays = function (...call) {
  draw.apply(this, call);
  if (!this.canvas.classList.contains("picture")) return;
  const [width, height] = [this.canvas.width, this.canvas.height];
  const pixels = new Uint8Array(4 * width * height);
  this.readPixels(0, 0, width, height, this.RGBA, this.UNSIGNED_BYTE, pixels);  // in the task that drew them
  window.drawn = {width, height, pixels: Array.from(pixels), count: (window.drawn?.count ?? 0) + 1};
}
"""
RECOLOR = """ramps => {
  for (const model of Bokeh.documents[0]._all_models.values()) {
    if (model.data?.attributes && "edited_ramps" in model.data.attributes) { model.data.setv({edited_ramps: ramps}) }
  }
}"""
SET = """([light, detail, flat, color, ambient]) => {
  for (const model of Bokeh.documents[0]._all_models.values()) {
    if (model.data?.attributes && "keep_detail" in model.data.attributes) {
      window.drawn.count = 0
      model.data.setv({
        new_light: light, keep_detail: detail, flat_shading: flat ?? 1,
        light_color: color ?? "#ffffff", ambient: ambient ?? 0,
      })
    }
  }
}"""


@pytest.fixture(scope="module", params=["ball", "inked_ball", "harlequin", "pixel_sprite"])
def ball(request):
    analysis = request.getfixturevalue(request.param)
    if request.param == "pixel_sprite":
        assert analysis.drawing.is_pixel_art
        assert analysis.drawing.mixed.highlit.any()
        return analysis
    assert analysis.drawing.ink.coverage.any() == (request.param != "ball")
    several = request.param == "harlequin"
    assert analysis.materials.flat.tolist() == ([False, False, True] if several else [False])
    assert (analysis.drawing.mixed.shares > 0).all(axis=1).any() == several
    return analysis


@pytest.fixture(scope="module")
def served_ball(ball):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]

    def app():
        view = RelightView(
            new_light=[77.0, 33.0]
        )  # no light of a test: setting the same again would draw nothing
        view.show(ball)
        return view

    server = pn.serve(
        app, port=port, address="127.0.0.1", websocket_origin=[f"127.0.0.1:{port}"], show=False, threaded=True
    )
    yield f"http://127.0.0.1:{port}"
    server.stop()


@pytest.fixture
def shader(page, served_ball):
    complaints = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
    page.add_init_script(REMEMBER_PIXELS)
    page.goto(served_ball)
    page.wait_for_function("window.drawn", timeout=60_000)
    yield page
    assert complaints == []


def pixels_of(page):
    drawn = page.evaluate("window.drawn")
    pixels = np.array(drawn["pixels"], dtype=int).reshape(drawn["height"], drawn["width"], 4)
    return pixels[::-1]  # WebGL's row 0 is the bottom


def assert_shown(page, wanted):
    difference = np.abs(pixels_of(page) - wanted.astype(int)).max(axis=-1)
    # Half floats: one pixel in a thousand may round to a neighboring 8-bit value but one.
    assert (difference > 1).mean() <= 0.001


@pytest.mark.browser
@pytest.mark.parametrize("keep_detail", [True, False])
@pytest.mark.parametrize("angles", [(130.0, 45.0), (124.0, 47.0), (20.0, 30.0), (-60.0, 5.0), (0.0, 90.0)])
def test_the_shader_paints_what_relight_paints(shader, ball, angles, keep_detail):
    shader.evaluate(SET, [list(angles), keep_detail])
    shader.wait_for_function("window.drawn.count > 0")
    shader.wait_for_timeout(200)
    wanted = relight(ball, light_direction(*angles), keep_detail=keep_detail).to_rgba().astype(int)
    assert_shown(shader, wanted)
    assert (wanted[..., 3] > 0).any()


@pytest.mark.browser
@pytest.mark.parametrize(("color", "ambient"), [("#f94", 0.0), ("#ffffff", 0.4), ("#4080ff", 0.3)])
@pytest.mark.parametrize("angles", [(130.0, 45.0), (20.0, 30.0)])
def test_colored_and_ambient_light_are_those_of_relight(shader, ball, angles, color, ambient):
    shader.evaluate(SET, [list(angles), True, 1.0, color, ambient])
    shader.wait_for_function("window.drawn.count > 0")
    shader.wait_for_timeout(200)
    light = light_direction(*angles)
    wanted = relight(ball, light, light_color=color_of_hex(color), ambient=ambient).to_rgba()
    assert_shown(shader, wanted)
    assert (wanted != relight(ball, light).to_rgba()).any()


@pytest.mark.browser
def test_flat_materials_answer_to_the_light_as_far_as_they_are_asked_to(shader, ball):
    angles = (-10.0, 5.0)
    shader.evaluate(SET, [list(angles), True, 0.4])
    shader.wait_for_function("window.drawn.count > 0")
    shader.wait_for_timeout(200)
    light = light_direction(*angles)
    wanted = relight(ball, light, flat_shading=0.4).to_rgba()
    assert_shown(shader, wanted)
    other = relight(ball, light, flat_shading=1.0).to_rgba()
    answering = ball.materials.flat.any() and not ball.drawing.is_pixel_art
    assert (other != wanted).any() == answering


RAMPS = {
    "tones": ToneRamp(["#203060", "#5070b0", "#90c0f0"], [0.0, 0.55], [0.2, 0.01]),
    "stays flat": ToneRamp(["#203060", "#90c0f0"], [0.3], stays_flat=True),
}


@pytest.mark.browser
@pytest.mark.parametrize("ramp", RAMPS.values(), ids=RAMPS)
@pytest.mark.parametrize("keep_detail", [True, False])
@pytest.mark.parametrize(
    ("angles", "ambient"), [((130.0, 45.0), 0.0), ((20.0, 30.0), 0.0), ((-60.0, 5.0), 0.3)]
)
def test_edited_ramps_are_painted_as_relight_paints_them(shader, ball, ramp, keep_detail, angles, ambient):
    last = ball.materials.count - 1  # in the harlequin, a flat one
    ramps = {0: ramp, last: ramp}
    shader.evaluate(RECOLOR, {str(number): asdict(one) for number, one in ramps.items()})
    shader.evaluate(SET, [list(angles), keep_detail, 1.0, "#ffcc88", ambient])
    shader.wait_for_function("window.drawn.count > 0")
    shader.wait_for_timeout(200)
    options = {"light_color": color_of_hex("#ffcc88"), "ambient": ambient, "keep_detail": keep_detail}
    wanted = relight(ball.recolored(ramps), light_direction(*angles), **options).to_rgba()
    assert_shown(shader, wanted)
    assert (wanted != relight(ball, light_direction(*angles), **options).to_rgba()).any()


@pytest.mark.browser
def test_under_its_own_light_the_drawing_is_unchanged(shader, ball):
    shader.evaluate(SET, [[130.0, 45.0], True])
    shader.wait_for_function("window.drawn.count > 0")
    shader.wait_for_timeout(200)
    assert np.abs(pixels_of(shader) - ball.image.to_rgba()).max() <= 1  # float32 against float64 rounding


def test_without_webgl_the_picture_is_painted_in_python(ball):
    view = RelightView(webgl=False)
    view.show(ball)
    first = view.fallback_picture
    assert first.startswith(b"\x89PNG")
    view.new_light = [-30.0, 20.0]
    assert view.fallback_picture != first


def test_without_webgl_python_paints_edited_ramps_too(ball):
    view = RelightView(webgl=False)
    view.show(ball)
    first = view.fallback_picture
    view.recolor({0: RAMPS["tones"]})
    assert view.fallback_picture != first


@pytest.mark.browser
@pytest.mark.parametrize("elevation", [90.0, 40.0, 0.0])
def test_the_light_ball_shows_the_color_map_of_its_illumination(shader, ball, elevation):
    shader.evaluate(SET, [[0.0, elevation], True])
    shader.wait_for_timeout(300)
    middle = shader.locator(".relit canvas.ball").evaluate(
        "canvas => Array.from(canvas.getContext('2d').getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data)"
    )
    illumination = np.sin(np.deg2rad(elevation))  # the middle of the ball faces the viewer: L · N = L_z
    # Half a pixel off the middle moves L · N by 0.01, a hundredth of this ramp's range.
    np.testing.assert_allclose(middle[:3], 255 * ball.materials.color_maps[0](illumination), atol=4)
    assert middle[3] == 255

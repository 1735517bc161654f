"""What the linked views show of an analysis: pixels as a frame has them, isophotes, and the facts of a pixel."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit import light_direction
from toonkit.viz.relight_page.view_pictures import (
    GROUND,
    Window,
    isophotes,
    pictures_of_drawing,
    pictures_of_method,
    read_pixel,
    reduced,
    relit_picture,
)


def test_every_picture_is_opaque_and_has_the_ground_outside(ball):
    pictures = {
        **pictures_of_drawing(ball),
        **pictures_of_method(ball, "Lumo"),
        "relit": relit_picture(ball.image),
    }
    outside = ball.image.alpha == 0
    for picture in pictures.values():
        assert picture.pixels.shape == (*ball.image.shape, 3)
        assert (picture.pixels[outside] == GROUND).all()
    assert pictures["normals"].title == "Normal map · Lumo"
    whole = ball.image.alpha == 1
    np.testing.assert_array_equal(pictures["drawing"].pixels[whole], ball.image.to_rgba()[whole][:, :3])


@pytest.mark.parametrize(
    ("columns", "rows", "expected"),
    [
        ((0, 400), (0, 300), (0, 300, 0, 400)),
        ((10.2, 50.7), (-20, 20.5), (0, 21, 10, 51)),
        ((-90, -10), (350, 430), (299, 300, 0, 1)),  # beside the picture: never empty
    ],
)
def test_what_is_looked_at_is_sent_in_whole_pixels(columns, rows, expected):
    window = Window.around(columns, rows, (300, 400), 200)
    assert (window.top, window.bottom, window.left, window.right) == expected


def test_a_frame_gets_no_more_pixels_than_it_has_and_close_up_those_of_the_picture():
    pixels = np.random.default_rng(0).integers(0, 256, (2000, 1500, 3), dtype=np.uint8)
    whole = reduced(pixels, Window.around((0, 1500), (0, 2000), (2000, 1500), 300))
    assert whole.shape == (400, 300, 3)
    np.testing.assert_allclose(whole[7, 9], pixels[35:40, 45:50].mean(axis=(0, 1)), atol=1)
    close = Window.around((100.5, 180), (40, 120), (2000, 1500), 300)
    np.testing.assert_array_equal(reduced(pixels, close), pixels[40:120, 100:180])


@pytest.mark.parametrize("sent", [120, 60, 1000])
def test_isophotes_of_a_sphere_lit_from_the_front_are_circles(ball, sent):
    y, x = np.mgrid[:120, :120] + 0.5 - 60
    radius = 50
    z = np.sqrt(np.where(np.hypot(x, y) < radius, 1 - (x**2 + y**2) / radius**2, np.nan))
    curves = isophotes(z, Window.around((0, 120), (0, 120), (120, 120), sent))
    found = np.hypot(*(curves[np.isfinite(curves[:, 0])] - 60).T)
    expected = radius * np.sqrt(1 - np.array([0.25, 0.5, 0.75]) ** 2)
    assert np.abs(found[:, None] - expected).min(axis=1).max() < 1.5
    assert (np.abs(found[:, None] - expected).min(axis=0) < 1).all()


def test_a_row_of_pixels_has_no_isophotes():
    assert isophotes(np.ones((1, 9)), Window.around((0, 9), (0, 1), (1, 9), 100)).shape == (0, 2)


def test_a_pixel_tells_its_paint_its_material_and_both_illuminations(ball):
    light = light_direction(20, 30)
    reading = read_pixel({"Lumo": ball}, 60, 50, light)
    normal = ball.normals.vectors[60, 50]
    assert reading.normals["Lumo"] == tuple(normal)
    assert reading.illuminations["Lumo"] == pytest.approx((normal @ ball.light, normal @ light))
    assert reading.material == "1 of 1"
    assert [int(reading.paint[k : k + 2], 16) for k in (1, 3, 5)] == ball.image.to_rgba()[60, 50, :3].tolist()
    assert read_pixel({"Lumo": ball}, 0, 0, light) is None

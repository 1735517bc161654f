"""Line art that somebody knows is taken as it is given, and is still known after a visit to a file."""

from __future__ import annotations

import numpy as np
import pytest

from tests.illustration.drawings import LIGHT, RED, SKIN, Ball, Canvas, Drawn
from toonkit import ToonImage, ToonkitError, analyze, load_analysis, relight
from toonkit.estimation.preparation import prepare

HEAD = Ball(48, 48, 42, SKIN)
PALE = RED[1]


@pytest.fixture(scope="module")
def drawn() -> Drawn:
    """A head with a thick red mark on it, which looks like a material of its own."""
    canvas = Canvas()
    canvas.ball(HEAD, 0)
    canvas.line(canvas.disc(48, 48, 12), PALE)
    return canvas.drawn()


@pytest.fixture(scope="module")
def image(drawn) -> ToonImage:
    return ToonImage(drawn.color, drawn.mask)


@pytest.fixture(scope="module")
def known(drawn, image):
    return analyze(image, LIGHT, ink=drawn.ink > 0.5)


def test_given_ink_covers_what_it_was_drawn_over(drawn, image, known):
    assert not prepare(image).ink_coverage[48, 48]
    assert np.abs(known.drawing.ink_coverage - drawn.ink)[drawn.mask].mean() < 0.005
    assert known.materials.count == 1


def test_given_ink_stays_under_another_light(drawn, image, known):
    inside = drawn.ink > 0.99
    assert np.array_equal(relight(known, (-30, 20)).color[inside], image.color[inside])


def test_a_drawing_can_be_said_to_have_no_ink(drawn):
    canvas = Canvas()
    canvas.ball(HEAD, 0)
    canvas.outline(HEAD, 2)
    outlined = canvas.drawn()
    image = ToonImage(outlined.color, outlined.mask)
    assert prepare(image).ink_coverage.any()
    assert not prepare(image, ink=np.zeros(image.shape, bool)).ink_coverage.any()


def test_ink_and_materials_are_given_in_any_order(drawn, image):
    ink, labels = drawn.ink > 0.5, np.where(drawn.mask, np.indices(image.shape)[1] // 48, -1)
    first = prepare(prepare(image, ink=ink), materials=labels)
    second = prepare(prepare(image, materials=labels), ink=ink)
    for found in (first, second):
        assert np.array_equal(found.materials.labels, labels)
        assert np.array_equal(found.given_ink, ink & drawn.mask)


def test_given_ink_is_kept_in_an_archive(known, tmp_path):
    known.save(tmp_path / "analysis.npz")
    found = load_analysis(tmp_path / "analysis.npz")
    assert np.array_equal(found.drawing.ink_coverage, known.drawing.ink_coverage)
    assert np.array_equal(found.materials.labels, known.materials.labels)


@pytest.mark.parametrize(
    ("ink", "rule"),
    [
        (np.zeros((5, 5), bool), "ink must have the size of the picture"),
        (np.ones((96, 96), bool), "ink must leave paint somewhere on the object"),
        (np.full((96, 96), 0.5), r"ink must be an \(H, W\) array, True where line art is"),
        ("lines", r"ink must be an \(H, W\) array"),
    ],
)
def test_ink_that_is_no_mask_of_the_picture_is_refused(image, ink, rule):
    with pytest.raises(ToonkitError, match=rule):
        analyze(image, LIGHT, ink=ink)

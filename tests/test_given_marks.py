"""Ink, highlights and cast shadows that are given; see `test_known_ink` for more of ink."""

import numpy as np
import pytest

from tests.analytic import LIGHT, TWO_TONE, ellipse, painted
from toonkit import ToonImage, ToonkitError, analyze, load_analysis, relight

NEW_LIGHT = (30, 40)
STRIPE = (slice(38, 43), slice(20, 60))
SPOT = (slice(25, 32), slice(28, 35))


@pytest.fixture(scope="module")
def drawing():
    """A ball in two tones, with a blue stripe across and a dark green spot, neither of which looks like ink."""
    shape = ellipse(40, 40)
    color = painted(shape.normals, TWO_TONE).color
    color[STRIPE] = (0.3, 0.4, 0.7)
    color[SPOT] = (0.25, 0.5, 0.3)
    color += 0.002 * np.random.default_rng(0).normal(size=color.shape)  # or it would be pixel art
    return ToonImage(np.clip(color, 0, 1), shape.mask)


def marked(drawing, *places):
    marks = np.zeros(drawing.mask.shape, bool)
    for place in places:
        marks[place] = True
    return marks


def test_marked_ink_stays_as_drawn_on_the_material_around(drawing):
    found = analyze(drawing, LIGHT)
    told = analyze(drawing, LIGHT, ink=marked(drawing, STRIPE))
    assert found.materials.count == told.materials.count + 1
    assert (told.drawing.ink_coverage[STRIPE] >= 0.5).all()
    inner = (slice(39, 42), slice(21, 59))
    assert np.allclose(relight(told, NEW_LIGHT).color[inner], drawing.color[inner], atol=2 / 255)


def test_a_marked_highlight_fades_as_the_light_moves(drawing):
    told = analyze(drawing, LIGHT, highlights=marked(drawing, SPOT))
    assert np.allclose(relight(told, told.light).color[SPOT], drawing.color[SPOT], atol=1e-9)
    inner = (slice(27, 30), slice(30, 33))
    relit = relight(told, (-50, 0)).color[inner].reshape(-1, 3)
    tones = told.materials.color_maps[0].colors[[0, -1]]
    assert np.linalg.norm(relit[:, None] - tones, axis=-1).min(axis=1).max() < 0.02


def test_marks_are_saved_and_loaded(drawing, tmp_path):
    told = analyze(drawing, LIGHT, ink=marked(drawing, STRIPE), highlights=marked(drawing, SPOT))
    told.save(tmp_path / "told.npz")
    found = load_analysis(tmp_path / "told.npz")
    assert np.array_equal(found.drawing.ink_coverage, told.drawing.ink_coverage)
    difference = relight(found, NEW_LIGHT).to_rgba().astype(int) - relight(told, NEW_LIGHT).to_rgba()
    assert (np.abs(difference) > 1).mean() < 1e-3  # as archives round normals


def test_a_prepared_drawing_is_told_again_and_keeps_what_it_was_told(drawing):
    first = analyze(drawing, LIGHT, ink=marked(drawing, STRIPE))
    second = analyze(first.drawing, LIGHT, ink=marked(drawing, SPOT))
    assert (second.drawing.ink_coverage[SPOT] >= 0.5).all()
    assert not (second.drawing.ink_coverage[39:42, 40:55] > 0).any()
    third = analyze(first.drawing, LIGHT, highlights=marked(drawing, SPOT))
    assert np.array_equal(third.drawing.ink_coverage, first.drawing.ink_coverage)


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (np.zeros((3, 3), bool), "size of the picture"),
        (np.zeros((89, 89)), "array of bools"),
        (True, "array of bools"),
    ],
)
def test_what_is_no_mark_is_refused(drawing, value, reason):
    with pytest.raises(ToonkitError, match=f"highlights must .*{reason}"):
        analyze(drawing, LIGHT, highlights=value)

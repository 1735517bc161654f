"""What is said about a shape on the relight page, without a page."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from tests.viz.test_relight_state import run
from toonkit import NormalHint, ShapeCorrections, ToonkitError, angular_error
from toonkit.viz.relight_page.codes import MARKS
from toonkit.viz.relight_page.downloads import analysis_file, session_file
from toonkit.viz.relight_page.shape_marks import ERASED, NOTHING_SAID, ShapeMarks
from toonkit.viz.relight_page.snippets import python_snippet
from toonkit.viz.relight_page.state import RelightState

TILT = (0.6, 0.0, 0.8)


@pytest.fixture
def codes():
    labels = np.full((40, 60), -1, np.int16)
    labels[5:35, 5:55] = 0
    labels[5:35, 25:55] = 1
    return labels


@pytest.fixture(scope="module")
def drawing(ball):
    file = BytesIO()
    Image.fromarray(ball.image.to_rgba()).save(file, "PNG")
    return file.getvalue()


@pytest.fixture
def state(drawing):
    state = RelightState(method="classical")
    run(state.open_file("ball.png", drawing))
    return state


def test_a_brush_marks_the_object_alone_and_the_last_kind_counts(codes):
    said = NOTHING_SAID.painted([(10.5, 12.5), (40.5, 12.5)], 6, "bulge", codes)
    said = said.painted([(40.5, 12.5)], 4, "flat", codes)
    shape = said.corrections(codes.shape)
    assert not shape.bulge[codes < 0].any()
    assert shape.flat[12, 40]
    assert not shape.bulge[12, 40]
    assert shape.bulge[12, 20]
    assert shape.in_front is None


def test_a_region_of_one_material_is_filled(codes):
    said = NOTHING_SAID.filled((30.5, 20.5), "in_front", codes)
    np.testing.assert_array_equal(said.corrections(codes.shape).in_front, codes == 1)


def test_an_eraser_takes_marks_and_normals(codes):
    said = NOTHING_SAID.painted([(20, 20)], 8, "bulge", codes)
    for place in ((20.5, 20.5), (45.5, 20.5)):
        said = said.tilted(place, TILT, 9, -1, codes)
    said = said.painted([(20, 20)], 10, ERASED, codes)
    assert said == ShapeMarks(normals=(NormalHint(20, 45, TILT, 9),))


def test_a_normal_is_replaced_and_removed(codes):
    said = NOTHING_SAID.tilted((20.5, 20.5), TILT, 9, -1, codes).tilted((45.5, 20.5), TILT, 9, -1, codes)
    said = said.tilted((20.5, 20.5), (0, 0, 1), 9, 0, codes)
    assert said.normals == (NormalHint(20, 20, (0, 0, 1), 9), NormalHint(20, 45, TILT, 9))
    assert said.tilted((0, 0), None, 9, 0, codes).normals == (NormalHint(20, 45, TILT, 9),)


def test_marks_and_corrections_say_the_same(codes):
    said = NOTHING_SAID.painted([(20, 20)], 8, "bulge", codes).tilted((45.5, 20.5), TILT, 9, -1, codes)
    assert ShapeMarks.of(said.corrections(codes.shape)) == said
    assert ShapeMarks.of(ShapeCorrections()) == ShapeMarks.of(None) == NOTHING_SAID
    lone = ShapeCorrections(normals=[NormalHint(20, 45, TILT, 9)])
    assert ShapeMarks.of(lone).corrections(codes.shape).normals == lone.normals


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda codes: NOTHING_SAID.painted([(9, 9)], 5, "round", codes), "kind must be one of bulge, flat"),
        (lambda codes: NOTHING_SAID.tilted((1, 1), TILT, 5, -1, codes), "place must lie on the object"),
        (lambda codes: NOTHING_SAID.tilted((900, 9), TILT, 5, -1, codes), "place must lie on the object"),
        (lambda codes: NOTHING_SAID.tilted((20, 20), TILT, 5, 0, codes), "which must be a number"),
    ],
)
def test_what_cannot_be_said_is_refused(codes, change, reason):
    with pytest.raises(ToonkitError, match=reason):
        change(codes)


def test_what_is_said_is_refined_undone_and_done_again(state):
    before = state.analysis
    run(state.shape_paint([(60, 60)], 25, "bulge"))
    told = state.analysis
    assert told.drawing.materials is before.drawing.materials
    assert angular_error(told.normals, before.normals).map[60, 75] > 5
    run(state.shape_tilt((60.5, 30.5), TILT, 12))
    assert state.analysis.normals.vectors[30, 60] @ TILT > 0.98
    run(state.undo())
    assert state.analysis is told
    run(state.undo())
    assert state.analysis is before
    run(state.redo())
    assert state.analysis is told
    run(state.shape_reset())
    np.testing.assert_array_equal(state.analysis.normals.compact, before.normals.compact)


def test_the_order_in_which_something_is_said_does_not_matter(state, drawing):
    run(state.shape_paint([(45, 60)], 12, "bulge"))
    run(state.shape_paint([(80, 60)], 12, "flat"))
    other = RelightState(method="classical")
    run(other.open_file("ball.png", drawing))
    run(other.shape_paint([(80, 60)], 12, "flat"))
    run(other.shape_paint([(45, 60)], 12, "bulge"))
    np.testing.assert_array_equal(other.analysis.normals.compact, state.analysis.normals.compact)


def test_other_corrections_and_another_method_keep_what_is_said(state):
    run(state.shape_paint([(60, 60)], 25, "flat"))
    said = state.shape_marks
    run(state.paint([(30, 60)], 8, MARKS["shadow"]))
    state.method = "lumo"
    run(state.analyze())
    assert ShapeMarks.of(state.analysis.drawing.given_shape) == state.shape_marks == said
    assert state.corrected
    run(state.reset_materials())
    assert not state.corrected
    assert ShapeMarks.of(state.analysis.drawing.given_shape) == said


def test_sessions_and_archives_bring_back_what_is_said(state):
    run(state.shape_paint([(60, 60)], 25, "in_front"))
    run(state.shape_tilt((60.5, 30.5), TILT, 12))
    for name, content in (("ball.toonkit", session_file(state)), ("ball.npz", analysis_file(state))):
        other = RelightState()
        run(other.open_file(name, content.getvalue()))
        assert other.shape_marks == state.shape_marks
        np.testing.assert_array_equal(other.relit().to_rgba(), state.relit().to_rgba())
        run(other.shape_reset())
        assert other.analysis.drawing.given_shape is None


def test_what_is_said_is_there_when_the_drawing_is_switched_back_to(state, drawing):
    run(state.shape_paint([(60, 60)], 25, "bulge"))
    said, before = state.shape_marks, state.analysis.normals.compact
    run(state.open_sample("pear"))
    assert state.shape_marks == NOTHING_SAID
    assert state.analysis.drawing.given_shape is None
    run(state.open_file("ball.png", drawing, again=True))
    assert state.shape_marks == said
    np.testing.assert_array_equal(state.analysis.normals.compact, before)


def test_what_is_said_is_copied_with_the_session(state):
    run(state.shape_paint([(60, 60)], 25, "bulge"))
    snippet = python_snippet(state)
    assert "load_analysis('ball.toonkit')" in snippet.text
    assert "save the session first" in snippet.note

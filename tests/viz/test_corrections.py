"""Corrections of materials, without a page."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit import ToneRamp, ToonkitError
from toonkit.viz.relight_page import corrections as module
from toonkit.viz.relight_page.codes import MARKS
from toonkit.viz.relight_page.corrections import MaterialCorrections


@pytest.fixture
def found():
    labels = np.full((40, 60), -1)
    labels[5:35, 5:55] = 0
    labels[5:35, 25:55] = 1
    labels[20:35, 25:55] = 2
    return labels


@pytest.fixture
def corrections(found):
    return MaterialCorrections(found)


def test_what_was_found_is_the_beginning(corrections, found):
    np.testing.assert_array_equal(corrections.labels, found)
    assert (corrections.labels_version, corrections.can_undo, corrections.can_redo) == (None, False, False)


def test_a_merged_material_is_gone_and_the_others_keep_their_numbers(corrections, found):
    corrections.merge(1, 0)
    np.testing.assert_array_equal(corrections.labels, np.where(found == 1, 0, found))
    assert corrections.labels_version is not None


def test_a_click_of_the_brush_paints_a_disc_on_the_object_alone(corrections, found):
    corrections.paint([(10.5, 12.5)], 6.0, 2)
    y, x = np.mgrid[:40, :60]
    disc = (np.hypot(x - 10, y - 12) <= 6) & (found >= 0)
    np.testing.assert_array_equal(corrections.labels, np.where(disc, 2, found))
    assert (found[np.hypot(x - 10, y - 12) <= 6] < 0).any()


def test_a_stroke_leaves_no_gaps_however_fast_the_hand(corrections, found):
    corrections.paint([(-20.0, 10.5), (80.0, 10.5)], 2.0, 2)
    assert (corrections.labels[9:12, 5:55] == 2).all()
    assert (corrections.labels[13] == found[13]).all()


def test_a_new_material_gets_the_next_number(corrections):
    corrections.paint([(10, 20)], 4, 3)
    assert set(np.unique(corrections.labels)) == {-1, 0, 1, 2, 3}


def test_undo_and_redo_go_through_all_corrections(corrections):
    corrections.merge(1, 0)
    corrections.paint([(10, 20)], 4, 2)
    last = corrections.labels
    corrections.undo()
    corrections.undo()
    corrections.undo()
    assert (corrections.labels_version, corrections.can_undo, corrections.can_redo) == (None, False, True)
    for _ in range(3):
        corrections.redo()
    np.testing.assert_array_equal(corrections.labels, last)
    assert not corrections.can_redo


def test_a_new_correction_ends_what_could_be_redone(corrections):
    corrections.merge(1, 0)
    corrections.undo()
    corrections.merge(2, 0)
    assert not corrections.can_redo
    assert set(np.unique(corrections.labels)) == {-1, 0, 1}


def test_reset_returns_to_what_was_found_and_can_be_undone(corrections, found):
    corrections.merge(1, 0)
    corrections.reset()
    np.testing.assert_array_equal(corrections.labels, found)
    assert corrections.labels_version is None
    corrections.undo()
    assert corrections.labels_version is not None


def test_a_correction_that_changes_nothing_is_none(corrections):
    corrections.paint([(1, 1)], 1, 0)
    corrections.merge(1, 1)
    corrections.reset()
    assert not corrections.can_undo


def test_going_back_to_a_version_keeps_what_came_after_it(corrections):
    corrections.merge(1, 0)
    before = corrections.labels_version
    corrections.merge(2, 0)
    corrections.restore(before)
    assert corrections.labels_version == before
    assert corrections.can_redo


def test_a_version_that_was_replaced_can_be_gone_back_to(corrections):
    corrections.merge(1, 0)
    shown = corrections.labels_version
    corrections.undo()
    corrections.merge(2, 0)
    corrections.restore(shown)
    assert corrections.labels_version == shown
    corrections.redo()
    assert set(np.unique(corrections.labels)) == {-1, 0, 1}


def test_after_many_corrections_the_oldest_is_forgotten_but_not_what_was_found(
    corrections, found, monkeypatch
):
    monkeypatch.setattr(module, "MOST_STEPS", 5)
    for column in range(10):
        corrections.paint([(10 + column, 20)], 1, 2)
    for _ in range(10):
        corrections.undo()
    np.testing.assert_array_equal(corrections.labels, found)


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.merge(1, 7),
        lambda c: c.merge(-1, 0),
        lambda c: c.merge("1", 0),
        lambda c: c.paint([(10, 10)], 3, 5),
        lambda c: c.paint([(10, 10)], 3, -1),
        lambda c: c.paint([(10, 10)], 0, 1),
        lambda c: c.paint([(10, 10)], None, 1),
        lambda c: c.paint([], 3, 1),
        lambda c: c.paint([(np.nan, 10)], 3, 1),
        lambda c: c.paint("path", 3, 1),
    ],
)
def test_what_is_no_correction_is_refused_and_changes_nothing(corrections, change):
    with pytest.raises(ToonkitError):
        change(corrections)
    assert not corrections.can_undo


def test_a_ramp_is_undone_and_done_again_among_other_corrections():
    corrections = MaterialCorrections(np.array([[0, 1, 2]]))
    ramp = ToneRamp(["#102030", "#a0b0c0"], [0.2])
    corrections.merge(1, 0)
    corrections.recolor(0, ramp)
    corrections.merge(2, 0)
    assert corrections.ramps == {0: ramp}
    corrections.undo()
    assert (corrections.labels.tolist(), corrections.ramps) == ([[0, 0, 2]], {0: ramp})
    corrections.undo()
    assert (corrections.labels.tolist(), corrections.ramps) == ([[0, 0, 2]], {})
    corrections.redo()
    assert corrections.ramps == {0: ramp}


def test_a_ramp_alone_is_a_correction_but_no_other_label_map():
    corrections = MaterialCorrections(np.array([[0, 1, 2]]))
    corrections.recolor(1, ToneRamp(["#102030"]))
    assert corrections.is_corrected
    assert corrections.labels_version is None
    corrections.recolor(1, None)
    assert not corrections.is_corrected


def test_only_a_material_that_exists_has_a_ramp():
    with pytest.raises(ToonkitError, match="material must be one of the materials"):
        MaterialCorrections(np.array([[0, 1, 2]])).recolor(3, ToneRamp(["#102030"]))


def test_all_that_is_connected_is_filled_and_nothing_else():
    corrections = MaterialCorrections(np.array([[0, 1, 0], [0, 1, 0], [0, 0, 1]]))
    corrections.fill([2.5, 0.5], 2)
    assert corrections.labels.tolist() == [[0, 1, 2], [0, 1, 2], [0, 0, 1]]


def test_a_loop_splits_what_it_encloses_of_one_material(corrections, found):
    corrections.split([[30, 10], [40, 10], [40, 30], [30, 30]], 1)
    enclosed = np.zeros(found.shape, bool)
    enclosed[10:30, 30:40] = True
    np.testing.assert_array_equal(corrections.labels, np.where(enclosed & (found == 1), 3, found))


def test_a_loop_splits_all_materials_where_none_is_chosen(corrections, found):
    corrections.split([[0, 0], [60, 0], [60, 40], [0, 40]], -1)
    np.testing.assert_array_equal(corrections.labels, np.where(found >= 0, 3, -1))


@pytest.mark.parametrize("mark", MARKS)
def test_a_mark_says_what_lies_on_a_material_and_leaves_the_material(mark):
    found = np.zeros((10, 30), int)
    ink, highlights = np.zeros((2, 10, 30), bool)
    ink[:, :10], highlights[:, 20:] = True, True
    corrections = MaterialCorrections(found, ink, highlights)
    assert corrections.ink is None
    assert corrections.highlights is None
    corrections.paint([[0, 5], [30, 5]], 2.0, MARKS[mark])
    assert (corrections.labels == 0).all()
    row = 5
    expected = {"ink": (30, 0), "highlight": (10, 30), "shadow": (10, 30), "plain": (0, 0)}[mark]
    counts = tuple(
        10 * (index == 0) if marks is None else int(marks[row].sum())
        for index, marks in enumerate((corrections.ink, corrections.highlights))
    )
    assert counts == expected


def test_a_material_that_is_marked_whole_is_left_to_an_analysis():
    corrections = MaterialCorrections(np.array([[0, 1, 2, 0]]))
    corrections.fill([1.5, 0.5], MARKS["ink"])
    corrections.fill([2.5, 0.5], MARKS["plain"])
    assert corrections.labels.tolist() == [[0, -1, 2, 0]]
    corrections.fill([1.5, 0.5], 0)
    assert corrections.labels.tolist() == [[0, 0, 2, 0]]
    assert corrections.ink.tolist() == [[False] * 4]


def test_marked_pixels_move_with_their_material_when_it_is_merged():
    corrections = MaterialCorrections(np.array([[0, 1, 1, 1]]))
    corrections.paint([[1.5, 0.5]], 0.6, MARKS["highlight"])
    corrections.merge(1, 0)
    assert corrections.labels.tolist() == [[0, 0, 0, 0]]
    assert corrections.highlights.tolist() == [[False, True, False, False]]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda one: one.fill([70, 5], 1), "place must lie in the picture"),
        (lambda one: one.fill([7, 7], 9), "material must be one of"),
        (lambda one: one.fill([7, 7], 5 * 4096), "material must be one of"),
        (lambda one: one.split(np.zeros((0, 2)), 1), "path must have 1 to"),
        (lambda one: one.split([[0, np.inf]], 1), "must be places in the picture"),
    ],
)
def test_what_is_no_region_is_refused(corrections, change, reason):
    with pytest.raises(ToonkitError, match=reason):
        change(corrections)

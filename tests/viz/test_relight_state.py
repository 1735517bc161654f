"""What the relight page knows, without a page."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import toonkit
from toonkit import ToneRamp, ToonkitError, relight
from toonkit.model.normals import encode_normal_map
from toonkit.viz.relight_page.analyses import SAMPLES
from toonkit.viz.relight_page.codes import MARKS
from toonkit.viz.relight_page.downloads import analysis_file, normal_map_png, relit_png
from toonkit.viz.relight_page.state import RelightState


def run(work):
    """Run a coroutine in a thread of its own: the browser tests may have left an event loop running in this one."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        return pool.submit(asyncio.run, work).result()


@pytest.fixture(autouse=True)
def nothing_kept():
    SAMPLES.clear()


@pytest.fixture
def drawing(ball):
    file = BytesIO()
    Image.fromarray(ball.image.to_rgba()).save(file, "PNG")
    return file.getvalue()


def opened(drawing, method="lumo"):
    state = RelightState(method=method)
    run(state.open_file("drawing.png", drawing))
    return state


def test_a_picture_of_ones_own_gets_an_estimated_light(drawing):
    state = opened(drawing)
    assert state.sample == ""
    assert state.analysis.method == "lumo"
    np.testing.assert_allclose(
        toonkit.light_direction(*state.original_light), state.analysis.light, atol=1e-4
    )
    assert state.step == ""


def test_what_of_a_file_is_ignored_is_said_to_who_opened_it(ball):
    file = BytesIO()
    Image.fromarray(ball.image.to_rgba()).save(file, "PNG", icc_profile=b"no profile")
    (remark,) = run(RelightState(method="lumo").open_file("drawing.png", file.getvalue()))
    assert "color profile is damaged and is ignored" in remark


def test_a_plain_file_calls_for_no_remark(drawing):
    assert run(RelightState(method="lumo").open_file("drawing.png", drawing)) == []


def test_a_picture_that_cannot_be_read_leaves_the_other_one_on_screen(drawing):
    state = opened(drawing)
    before = state.analysis
    with pytest.raises(ToonkitError):
        run(state.open_file("drawing.png", b"no picture"))
    assert state.analysis is before
    assert state.step == ""


def test_another_method_keeps_the_new_light(drawing):
    state = opened(drawing)
    state.param.update(new_light=[12.0, 34.0], method="lambert")
    run(state.analyze())
    assert state.analysis.method == "lambert"
    assert state.new_light == [12.0, 34.0]


def test_a_failed_analysis_takes_the_wish_back(drawing, monkeypatch):
    state = opened(drawing)

    def fail(*_, **__):
        raise ToonkitError("no shape")

    monkeypatch.setattr(toonkit, "analyze", fail)
    state.method = "todo"
    with pytest.raises(ToonkitError, match="no shape"):
        run(state.analyze())
    assert state.method == "lumo"


def test_a_cancelled_analysis_takes_the_wish_back(drawing, monkeypatch):
    state = opened(drawing)

    def endless(*_, progress, **__):
        while True:
            progress("working", 0.5)

    async def analyze_and_cancel():
        task = asyncio.create_task(state.analyze())
        await asyncio.sleep(0.2)
        state.cancel()
        await task

    monkeypatch.setattr(toonkit, "analyze", endless)
    state.method = "todo"
    run(analyze_and_cancel())
    assert state.method == "lumo"
    assert state.step == ""


def test_a_newer_wish_ends_an_older_computation(drawing, monkeypatch):
    state = opened(drawing)
    real = toonkit.analyze

    def slow_for_todo(image, light=None, *, method, progress, **others):
        while method == "todo":
            progress("working", 0.5)
        return real(image, light, method=method, progress=progress, **others)

    async def two_wishes():
        state.method = "todo"
        older = asyncio.create_task(state.analyze())
        await asyncio.sleep(0.2)
        state.method = "lambert"
        await asyncio.gather(older, state.analyze())

    monkeypatch.setattr(toonkit, "analyze", slow_for_todo)
    run(two_wishes())
    assert state.analysis.method == state.method == "lambert"


def test_under_another_original_light_the_answer_that_is_shown_is_where_it_starts(drawing, monkeypatch):
    state = opened(drawing)
    shown, real, previous_ones = state.analysis, toonkit.analyze, []

    def noted(image, light=None, *, previous, **others):
        previous_ones.append(previous)
        return real(image, light, previous=previous, **others)

    monkeypatch.setattr(toonkit, "analyze", noted)
    state.original_light = [77.0, 33.0]
    run(state.analyze())
    assert previous_ones == [shown]
    assert state.analysis is not shown


def test_the_files_hold_the_relit_picture_and_an_opengl_normal_map(drawing):
    state = opened(drawing)
    with Image.open(relit_png(state)) as relit, Image.open(normal_map_png(state)) as normal_map:
        np.testing.assert_array_equal(np.asarray(relit), state.relit().to_rgba())
        assert normal_map.mode == "RGBA"
        middle = normal_map.getpixel((normal_map.width // 2, normal_map.height // 2))
    assert middle[2] > 200  # the middle of a ball faces the viewer


def test_the_file_is_painted_with_as_much_flat_shading_as_is_asked_for(harlequin):
    state = RelightState(analysis=harlequin, new_light=[-10.0, 5.0])
    shaded = state.relit()
    state.flat_shading = 0.0
    badge = harlequin.materials.labels == 2
    pure = badge.copy()
    pure[harlequin.drawing.places(harlequin.drawing.mixed.pixels)] = False
    np.testing.assert_array_equal(state.relit().color[pure], harlequin.image.color[pure])
    assert (shaded.color[pure] != harlequin.image.color[pure]).any()


def test_the_file_is_painted_in_the_light_that_is_asked_for(harlequin):
    state = RelightState(analysis=harlequin, new_light=[-10.0, 35.0], light_color="#ff8000", ambient=0.25)
    expected = relight(harlequin, (-10, 35), light_color=(1, 128 / 255, 0), ambient=0.25)
    np.testing.assert_array_equal(state.relit().to_rgba(), expected.to_rgba())
    assert (expected.to_rgba() != relight(harlequin, (-10, 35)).to_rgba()).any()


@pytest.fixture
def motley(harlequin):
    """A state with a ball of three materials on screen, as an analysis of its file found them."""
    file = BytesIO()
    Image.fromarray(harlequin.image.to_rgba()).save(file, "PNG")
    state = opened(file.getvalue())
    assert state.analysis.materials.count == 3
    return state


def anew(state):
    """The analysis of the drawing on screen with the materials on screen, made from nothing else."""
    light = toonkit.light_direction(*state.original_light)
    return toonkit.analyze(state.analysis.image, light, method=state.method, materials=state.labels)


def wishes(state):
    return state.can_undo, state.can_redo, state.corrected


def test_merged_materials_are_analyzed_and_exported_as_one(motley):
    found = motley.analysis
    run(motley.merge(2, 0))
    assert motley.analysis.materials.count == 2
    np.testing.assert_array_equal(
        motley.labels, np.where(found.materials.labels == 2, 0, found.materials.labels)
    )
    with Image.open(relit_png(motley)) as relit, Image.open(normal_map_png(motley)) as normal_map:
        fresh = anew(motley)
        light = toonkit.light_direction(*motley.new_light)
        # Normals of corrected drawings are rounded as in their files, by less than 0.005 degrees.
        expected = toonkit.relight(fresh, light).to_rgba()
        np.testing.assert_allclose(np.asarray(relit, int), expected, atol=1)
        encoded = encode_normal_map(fresh.normals)
        np.testing.assert_allclose(np.asarray(normal_map, int)[..., :3], encoded, atol=1)
    assert wishes(motley) == (True, False, True)


def test_a_stroke_makes_a_new_material(motley):
    run(motley.paint([(40, 40), (60, 50)], 6, 3))
    assert motley.analysis.materials.count == 4
    np.testing.assert_array_equal(motley.labels, motley.analysis.materials.labels)


def test_undo_and_redo_show_what_was_there_without_another_analysis(motley, monkeypatch):
    found = motley.analysis
    run(motley.merge(1, 0))
    merged = motley.analysis
    monkeypatch.delattr(toonkit, "analyze")
    run(motley.undo())
    assert motley.analysis is found
    assert wishes(motley) == (False, True, False)
    run(motley.redo())
    assert motley.analysis is merged
    run(motley.reset_materials())
    assert motley.analysis is found
    assert wishes(motley) == (True, False, False)


def test_a_number_is_kept_where_another_material_is_gone(motley):
    run(motley.merge(1, 0))
    assert set(np.unique(motley.labels)) == {-1, 0, 2}
    run(motley.merge(2, 0))
    assert motley.analysis.materials.count == 1


def test_an_edited_ramp_is_in_what_is_exported_without_another_analysis(motley, monkeypatch, tmp_path):
    monkeypatch.setattr(toonkit, "analyze", lambda *_, **__: pytest.fail("analyzed anew"))
    ramp = ToneRamp(["#104010", "#40a040"], [0.2])
    before = relit_png(motley).getvalue()
    run(motley.recolor(0, asdict(ramp)))
    path = tmp_path / "analysis.npz"
    path.write_bytes(analysis_file(motley).getvalue())
    found = toonkit.load_analysis(path).materials.color_maps[0]
    assert np.array_equal(found.colors, ramp.color_map().colors)
    assert relit_png(motley).getvalue() != before
    run(motley.undo())
    assert relit_png(motley).getvalue() == before
    run(motley.redo())
    assert motley.ramps == {0: ramp}


def test_an_edited_ramp_stays_with_its_material_when_others_are_merged(motley):
    ramp = ToneRamp(["#104010", "#40a040"], [0.2])
    run(motley.recolor(2, asdict(ramp)))
    run(motley.merge(1, 0))
    assert motley.numbers == [0, 2]
    assert np.array_equal(motley.recolored.materials.color_maps[1].colors, ramp.color_map().colors)


def test_what_is_marked_as_ink_is_ink_in_the_analysis_and_its_material_gone(motley):
    badge = motley.labels == 2
    row, column = np.argwhere(badge)[len(np.argwhere(badge)) // 2]
    run(motley.fill([column + 0.5, row + 0.5], MARKS["ink"]))
    assert motley.numbers == [0, 1]
    assert motley.analysis.materials.count == 2
    assert (motley.analysis.drawing.ink_coverage[badge] > 0).mean() > 0.9
    run(motley.undo())
    assert motley.numbers == [0, 1, 2]


def test_a_split_material_is_analyzed_as_two(motley):
    height, width = motley.labels.shape
    run(motley.split([[0, 0], [width, 0], [width, height / 2], [0, height / 2]], 0))
    assert motley.numbers == [0, 1, 2, 3]
    assert motley.analysis.materials.count == 4


def later(monkeypatch):
    """Let more time pass than one drag takes."""
    monkeypatch.setattr("toonkit.viz.relight_page.state.STEP_SECONDS", 0.0)


def test_the_light_and_corrections_are_undone_in_the_order_they_were_made_in(motley, monkeypatch):
    later(monkeypatch)
    first = motley.new_light
    motley.new_light = [10.0, 20.0]
    run(motley.merge(2, 0))
    motley.param.update(ambient=0.5)
    run(motley.undo())
    assert (motley.ambient, motley.numbers) == (0.0, [0, 1])
    run(motley.undo())
    assert (motley.new_light, motley.numbers) == ([10.0, 20.0], [0, 1, 2])
    run(motley.undo())
    assert motley.new_light == first
    assert not motley.can_undo
    for _ in range(3):
        run(motley.redo())
    assert (motley.new_light, motley.numbers, motley.ambient) == ([10.0, 20.0], [0, 1], 0.5)
    assert not motley.can_redo


def test_a_drag_is_undone_as_a_whole(motley):
    first = motley.new_light
    for azimuth in range(10, 60, 5):
        motley.new_light = [float(azimuth), 20.0]
    run(motley.undo())
    assert motley.new_light == first
    run(motley.redo())
    assert motley.new_light == [55.0, 20.0]


def test_another_method_and_original_light_are_undone_with_their_analysis(motley, monkeypatch):
    later(monkeypatch)
    light = motley.original_light
    motley.original_light = [20.0, 40.0]
    run(motley.analyze())
    motley.method = "lambert"
    run(motley.analyze())
    run(motley.undo())
    assert (motley.method, motley.analysis.method) == ("lumo", "lumo")
    run(motley.undo())
    assert motley.original_light == light
    np.testing.assert_allclose(toonkit.light_angles(motley.analysis.light), light, atol=1e-2)


def test_a_method_that_fails_leaves_nothing_to_undo(motley, monkeypatch):
    later(monkeypatch)
    monkeypatch.setattr(toonkit, "analyze", lambda *_, **__: 1 / 0)
    motley.method = "lambert"
    with pytest.raises(ZeroDivisionError):
        run(motley.analyze())
    assert motley.method == "lumo"
    assert not motley.can_undo


def test_reset_leaves_the_light_where_it_is(motley):
    run(motley.merge(2, 0))
    motley.new_light = [10.0, 20.0]
    run(motley.reset_materials())
    assert (motley.new_light, motley.numbers) == ([10.0, 20.0], [0, 1, 2])


def test_a_selected_material_is_known_by_its_place_in_the_analysis(motley):
    run(motley.merge(1, 0))
    motley.select_place(1)
    assert motley.selected == 2
    assert motley.selected_place == "1"
    motley.selected = 1
    assert motley.selected_place == ""


def test_another_light_and_another_method_keep_the_corrections(motley):
    run(motley.merge(2, 0))
    motley.original_light = [77.0, 33.0]
    run(motley.analyze())
    motley.method = "lambert"
    run(motley.analyze())
    run(motley.estimate_light())
    assert motley.analysis.method == "lambert"
    assert motley.analysis.materials.count == 2
    assert motley.corrected


def test_a_failed_correction_leaves_the_work_and_can_be_tried_again(motley, monkeypatch):
    run(motley.merge(2, 0))
    shown, real = motley.analysis, toonkit.analyze

    def fail(*_, **__):
        raise ToonkitError("no shape")

    monkeypatch.setattr(toonkit, "analyze", fail)
    settled = motley.settled
    with pytest.raises(ToonkitError, match="no shape"):
        run(motley.merge(1, 0))
    assert motley.analysis is shown
    assert motley.settled > settled
    assert wishes(motley) == (True, True, True)
    monkeypatch.setattr(toonkit, "analyze", real)
    run(motley.redo())
    assert motley.analysis.materials.count == 1


def test_what_is_no_correction_is_refused_and_changes_nothing(motley):
    shown, settled = motley.analysis, motley.settled
    with pytest.raises(ToonkitError, match="material"):
        run(motley.merge(7, 0))
    assert motley.analysis is shown
    assert motley.settled > settled


def test_a_stroke_during_an_analysis_is_analyzed_with_the_one_before(motley, monkeypatch):
    real = toonkit.analyze

    def slow_once(*given, progress, **others):
        monkeypatch.setattr(toonkit, "analyze", real)
        while True:
            progress("working", 0.5)

    async def two_strokes():
        first = asyncio.create_task(motley.merge(1, 0))
        await asyncio.sleep(0.2)
        await asyncio.gather(first, motley.paint([(30, 30)], 8, 3))

    monkeypatch.setattr(toonkit, "analyze", slow_once)
    run(two_strokes())
    assert set(np.unique(motley.labels)) == {-1, 0, 2, 3}
    assert motley.analysis.materials.count == 3


def test_a_correction_taken_back_before_it_is_analyzed_leaves_what_is_shown(motley, monkeypatch):
    shown = motley.analysis

    def endless(*_, progress, **__):
        while True:
            progress("working", 0.5)

    async def merge_and_undo():
        merging = asyncio.create_task(motley.merge(1, 0))
        await asyncio.sleep(0.2)
        await asyncio.gather(merging, motley.undo())

    monkeypatch.setattr(toonkit, "analyze", endless)
    run(merge_and_undo())
    assert motley.analysis is shown
    assert wishes(motley) == (False, True, False)


def test_corrections_wait_for_whoever_comes_back_to_their_drawing(motley, drawing):
    image = BytesIO()
    Image.fromarray(motley.analysis.image.to_rgba()).save(image, "PNG")
    run(motley.merge(2, 0))
    run(motley.open_file("drawing.png", drawing))
    assert wishes(motley) == (False, False, False)
    run(motley.open_file("drawing.png", image.getvalue()))
    assert wishes(motley) == (True, False, True)
    assert motley.analysis.materials.count == 2


def test_corrections_of_a_sample_are_their_visitors_own():
    state = RelightState(method="lumo")
    run(state.open_sample("mushroom"))
    run(state.merge(1, 0))
    assert [question.version for question in SAMPLES] == [None]
    other = RelightState(method="lumo")
    run(other.open_sample("mushroom"))
    assert not other.corrected

"""What the relight page knows, without a page."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import toonkit
from toonkit import ToonkitError
from toonkit.viz.relight_page import state as relight_state
from toonkit.viz.relight_page.state import RelightState


def run(work):
    """Run a coroutine in a thread of its own: the browser tests may have left an event loop running in this one."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        return pool.submit(asyncio.run, work).result()


@pytest.fixture(autouse=True)
def nothing_kept():
    relight_state._samples.clear()


@pytest.fixture
def drawing(ball):
    file = BytesIO()
    Image.fromarray(ball.image.to_rgba()).save(file, "PNG")
    return file.getvalue()


def opened(drawing, method="lumo"):
    state = RelightState(method=method)
    run(state.open_file(drawing))
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
    (remark,) = run(RelightState(method="lumo").open_file(file.getvalue()))
    assert "color profile is damaged and is ignored" in remark


def test_a_plain_file_calls_for_no_remark(drawing):
    assert run(RelightState(method="lumo").open_file(drawing)) == []


def test_a_picture_that_cannot_be_read_leaves_the_other_one_on_screen(drawing):
    state = opened(drawing)
    before = state.analysis
    with pytest.raises(ToonkitError):
        run(state.open_file(b"no picture"))
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

    def slow_for_todo(image, light=None, *, method, previous, progress):
        while method == "todo":
            progress("working", 0.5)
        return real(image, light, method=method, previous=previous, progress=progress)

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

    def noted(image, light=None, *, method, previous, progress):
        previous_ones.append(previous)
        return real(image, light, method=method, previous=previous, progress=progress)

    monkeypatch.setattr(toonkit, "analyze", noted)
    state.original_light = [77.0, 33.0]
    run(state.analyze())
    assert previous_ones == [shown]
    assert state.analysis is not shown


def test_the_files_hold_the_relit_picture_and_an_opengl_normal_map(drawing):
    state = opened(drawing)
    with Image.open(state.relit_png()) as relit, Image.open(state.normal_map_png()) as normal_map:
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

"""The path of the light on the relight page: undone, saved, and written as the animation that the code copied writes."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from tests.viz.test_relight_state import run
from tests.viz.test_snippets import run_commands
from toonkit import ToonkitError
from toonkit.viz.relight_page.animation import animation_maker
from toonkit.viz.relight_page.downloads import session_file
from toonkit.viz.relight_page.settings import RelightSettings
from toonkit.viz.relight_page.snippets import command_snippet, python_snippet
from toonkit.viz.relight_page.state import RelightState

PATH = {"key_lights": [[-30.0, 50.0], [110.0, -5.5]], "path_seconds": 0.5, "path_loops": False}


@pytest.fixture
def state(harlequin, tmp_path, monkeypatch):
    """A drawing on screen, its file in the current folder, and its light on a path."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(harlequin.image.to_rgba()).save("cat.png")
    state = RelightState(method="lumo")
    run(state.open_file("cat.png", Path("cat.png").read_bytes()))
    state.param.update(**PATH, ambient=0.25)
    return state


def test_the_path_is_undone_done_again_and_saved(state):
    state.key_lights = [*state.key_lights, [0.0, 90.0]]
    run(state.undo())
    assert state.key_lights == PATH["key_lights"]
    run(state.redo())
    assert state.key_lights[2] == [0.0, 90.0]
    other = RelightState()
    run(other.open_file("cat.toonkit", session_file(state).getvalue()))
    assert (other.key_lights, other.path_seconds, other.path_loops) == (state.key_lights, 0.5, False)


def frames(file):
    with Image.open(file) as animation:
        return np.array([frame.convert("RGBA") for frame in ImageSequence.Iterator(animation)], int)


def test_what_is_copied_writes_the_animation_of_the_page(state):
    state.animation_suffix = ".webp"
    shown = frames(BytesIO(animation_maker(state)(lambda *_: None)))
    assert len(shown) == 8
    made = Path("cat_relit.webp")
    for write in (lambda: exec(python_snippet(state).text, {}), lambda: run_commands(command_snippet(state))):
        write()
        # The light is read from the file again, not from sliders that tell thousandths of a degree apart.
        assert (np.abs(frames(made) - shown).max(axis=-1) > 2).mean() < 0.001
        made.unlink()


def test_without_a_path_the_light_circles_and_nothing_of_it_is_copied(state):
    state.key_lights = [[10.0, 20.0]]
    assert "write_light_path" not in python_snippet(state).text
    assert "--orbit" not in command_snippet(state).text
    with Image.open(BytesIO(animation_maker(state)(lambda *_: None))) as circling:
        assert circling.n_frames == 36


def test_an_animation_that_would_fill_the_memory_is_refused(state, monkeypatch):
    monkeypatch.setattr("toonkit.viz.relight_page.animation.MOST_PIXELS", 10**4)
    with pytest.raises(ToonkitError, match="animation must have at most 0 million pixels"):
        animation_maker(state)


@pytest.mark.parametrize(
    "lights", [[["left", 3]], [[1, 2, 3]], [[0, 91]], [[float("nan"), 0]], 5, [[0, 0]] * 13]
)
def test_a_session_cannot_bring_a_path_that_is_none(lights):
    with pytest.raises(ValueError, match=r"key_lights|key light"):
        RelightSettings(**json.loads(json.dumps({"key_lights": lights})))

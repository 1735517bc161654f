"""What is copied paints the picture that the page shows, from the visitor's file."""

from __future__ import annotations

import shlex
import subprocess
import sys
from dataclasses import asdict
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from tests.viz.test_relight_state import run
from toonkit import ToneRamp, load_image
from toonkit.cli import main
from toonkit.viz.relight_page.codes import MARKS
from toonkit.viz.relight_page.downloads import analysis_file, session_file
from toonkit.viz.relight_page.snippets import command_snippet, python_snippet
from toonkit.viz.relight_page.state import RelightState

NAMES = [
    "cat.png",
    "my cat.png",
    'it\'s a "cat".png',
    "Kätzchen 猫.png",
    "-o.png",
    "~cat.png",
    "sample:cat.png",
    "$(touch cat) & `cat` ; # \\.png",
    "cat.one.png",
    "a\nb.png",
]
RAMP = ToneRamp(["#104010", "#40a040"], [0.2], [0.1])


@pytest.fixture
def content(harlequin):
    file = BytesIO()
    Image.fromarray(harlequin.image.to_rgba()).save(file, "PNG")
    return file.getvalue()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def opened(name, content, folder, method="lumo"):
    """A state with a file of the current folder on screen."""
    (folder / name).write_bytes(content)
    state = RelightState(method=method)
    run(state.open_file(name, content))
    return state


def painted(snippet, folder):
    """The picture that Python paints."""
    before = set(folder.iterdir())
    exec(compile(snippet.text, "<snippet>", "exec"), {})
    (made,) = set(folder.iterdir()) - before
    with Image.open(made) as picture:
        pixels = np.asarray(picture).astype(int)
    made.unlink()
    return pixels


def run_commands(snippet):
    for command in snippet.text.split(" &&\n"):
        program, *arguments = shlex.split(command)
        assert program == "toonkit"
        assert main([*arguments, "--quiet"]) == 0


def off(picture, state):
    """By how much, of 255, a picture is off that on the page."""
    return np.abs(picture - state.relit().to_rgba()).max()


@pytest.mark.parametrize("name", NAMES)
def test_python_paints_the_picture_of_a_file_of_any_name(name, content, folder):
    state = opened(name, content, folder)
    assert off(painted(python_snippet(state), folder), state) == 0


@pytest.mark.parametrize("name", NAMES)
def test_commands_paint_the_picture_of_a_file_of_any_name(name, content, folder):
    state = opened(name, content, folder)
    run_commands(command_snippet(state))
    (made,) = folder.glob("*_relit.png")
    with Image.open(made) as picture:
        assert off(np.asarray(picture).astype(int), state) <= 1


def test_a_shell_runs_the_commands(content, folder):
    state = opened("it's a cat.png", content, folder)
    state.param.update(light_color="#ff8000", ambient=0.25, keep_detail=False, new_light=[-20.25, 12.5])
    script = f'toonkit() {{ {shlex.quote(sys.executable)} -m toonkit "$@"; }}\n{command_snippet(state).text}'
    subprocess.run(["bash", "-c", script], check=True, cwd=folder, stdout=subprocess.DEVNULL)
    with Image.open(folder / "it's a cat_relit.png") as picture:
        assert off(np.asarray(picture).astype(int), state) <= 1


@pytest.mark.parametrize(
    "settings",
    [
        {"new_light": [-123.456, 7.5]},
        {"new_light": [35.217391304347828, 40.0], "light_color": "#ff8001"},
        {"ambient": 0.35, "flat_shading": 0.15},
        {"keep_detail": False},
    ],
)
def test_every_setting_is_in_both_snippets(settings, content, folder):
    state = opened("cat.png", content, folder)
    plain = state.relit().to_rgba()
    state.param.update(**settings)
    assert (state.relit().to_rgba() != plain).any()
    assert off(painted(python_snippet(state), folder), state) == 0
    run_commands(command_snippet(state))
    with Image.open("cat_relit.png") as picture:
        assert off(np.asarray(picture).astype(int), state) <= 1


def test_an_estimated_light_is_estimated_again_and_a_given_one_is_given(content, folder):
    state = opened("cat.png", content, folder)
    assert "toonkit.analyze('cat.png', method='lumo')" in python_snippet(state).text
    state.original_light = [77.0, 33.0]
    run(state.analyze())
    assert "toonkit.analyze('cat.png', (77, 33), method='lumo')" in python_snippet(state).text
    assert "--light=77,33 --method lumo" in command_snippet(state).text
    assert off(painted(python_snippet(state), folder), state) == 0


def test_a_sample_is_named_and_needs_no_file(folder):
    state = RelightState(method="lumo")
    run(state.open_sample("pear"))
    snippet = python_snippet(state)
    assert "toonkit.analyze('sample:pear', (" in snippet.text
    assert snippet.note == ""
    assert off(painted(snippet, folder), state) == 0


def test_edited_ramps_are_in_python_and_for_commands_in_the_session(content, folder):
    state = opened("my cat.png", content, folder)
    run(state.recolor(0, asdict(RAMP)))
    python, command = python_snippet(state), command_snippet(state)
    assert "ToneRamp(" in python.text
    assert python.note == "Run it in the folder of my cat.png."
    assert off(painted(python, folder), state) == 0
    assert "my cat.toonkit" in command.text
    assert "save the session first" in command.note
    (folder / "my cat.toonkit").write_bytes(session_file(state).getvalue())
    run_commands(command)
    with Image.open("my cat_relit.png") as picture:
        assert off(np.asarray(picture).astype(int), state) <= 1


@pytest.mark.parametrize("correct", ["merge", "mark", "warm start"])
def test_what_code_cannot_say_is_in_the_session(correct, content, folder):
    state = opened("my cat.png", content, folder, "classical" if correct == "warm start" else "lumo")
    if correct == "merge":
        run(state.merge(2, 0))
    elif correct == "mark":
        run(state.paint([(40, 40), (60, 50)], 6, MARKS["shadow"]))
    else:
        state.original_light = [77.0, 33.0]
        run(state.analyze())
    snippet = python_snippet(state)
    assert snippet.text.splitlines()[2] == "analysis = toonkit.load_analysis('my cat.toonkit')"
    assert "save the session first" in snippet.note
    (folder / "my cat.toonkit").write_bytes(session_file(state).getvalue())
    assert off(painted(snippet, folder), state) == 0
    run_commands(command_snippet(state))
    with Image.open("my cat_relit.png") as picture:
        assert off(np.asarray(picture).astype(int), state) <= 1


def test_a_session_that_was_opened_is_the_file_until_it_is_changed(content, folder):
    first = opened("cat.png", content, folder)
    run(first.merge(2, 0))
    run(first.recolor(0, asdict(RAMP)))
    state = opened("kept.toonkit", session_file(first).getvalue(), folder)
    snippet = python_snippet(state)
    assert "toonkit.load_analysis('kept.toonkit')\nrelit" in snippet.text
    assert snippet.note == "Run it in the folder of kept.toonkit."
    assert off(painted(snippet, folder), state) == 0
    run(state.recolor(0, None))
    assert "analysis.recolored({})" in python_snippet(state).text
    assert off(painted(python_snippet(state), folder), state) == 0
    run(state.merge(1, 0))
    assert "save the session first" in python_snippet(state).note


def test_an_archive_analyzed_by_another_method_is_no_picture_to_begin_with(content, folder):
    first = opened("cat.png", content, folder)
    state = opened("analysis.npz", analysis_file(first).getvalue(), folder)
    assert "toonkit.load_analysis('analysis.npz')" in python_snippet(state).text
    state.method = "lambert"
    run(state.analyze())
    assert "toonkit.load_analysis('analysis.toonkit')" in python_snippet(state).text


def test_the_drawing_that_a_snippet_reads_is_the_one_on_screen(content, folder):
    state = opened("cat.png", content, folder)
    np.testing.assert_array_equal(load_image("cat.png").mask, state.analysis.image.mask)

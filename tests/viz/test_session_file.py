"""A session that is saved and opened brings back what was on screen; what is none is refused."""

from __future__ import annotations

from dataclasses import asdict
from io import BytesIO
from zipfile import ZipFile

import numpy as np
import pytest
from PIL import Image

import toonkit
from tests.model.layered_files import write_layered
from tests.model.test_layer_loading import CHARACTER, HAIR, HEAD, RING, SHAPE
from tests.viz.test_relight_state import run
from toonkit import ToneRamp, ToonkitError
from toonkit.viz.relight_page.codes import MARKS
from toonkit.viz.relight_page.downloads import analysis_file, session_file
from toonkit.viz.relight_page.state import RelightState

RAMP = ToneRamp(["#104010", "#40a040"], [0.2], [0.1])


@pytest.fixture(scope="module")
def drawing(harlequin):
    """A picture file of three materials."""
    file = BytesIO()
    Image.fromarray(harlequin.image.to_rgba()).save(file, "PNG")
    return file.getvalue()


@pytest.fixture(scope="module")
def worked(drawing):
    """A drawing with a mark, two materials merged, an edited ramp and every setting changed."""
    state = RelightState(method="lumo")
    run(state.open_file("my cat.png", drawing))
    run(state.paint([(40, 40), (60, 50)], 6, MARKS["shadow"]))
    run(state.merge(1, 0))
    run(state.recolor(2, asdict(RAMP)))
    state.param.update(
        new_light=[-20.5, 61.25],
        light_color="#ff8000",
        ambient=0.25,
        flat_shading=0.4,
        keep_detail=False,
        original_light=[100.0, 40.0],
        selected=2,
    )
    run(state.analyze())
    return state


def reopened(state, name="my cat.toonkit"):
    other = RelightState()
    assert run(other.open_file(name, session_file(state).getvalue())) == []
    return other


def test_everything_on_screen_comes_back(worked):
    state = reopened(worked)
    assert state.look == worked.look
    assert (state.selected, state.numbers, state.ramps) == (2, [0, 2], {2: RAMP})
    np.testing.assert_array_equal(state.codes, worked.codes)
    np.testing.assert_array_equal(state.analysis.image.to_rgba(), worked.analysis.image.to_rgba())
    np.testing.assert_array_equal(state.relit().to_rgba(), worked.relit().to_rgba())
    assert state.corrected


def test_work_goes_on_where_it_was_left(worked):
    state = reopened(worked)
    run(state.merge(2, 0))
    assert state.numbers == [0]
    run(state.undo())
    assert (state.numbers, state.ramps) == ([0, 2], {2: RAMP})
    run(state.recolor(2, None))
    assert state.ramps == {}
    run(state.reset_materials())
    assert state.numbers == [0, 1, 2]
    assert state.analysis.drawing.given_highlights is None
    assert not state.corrected


def test_a_session_is_saved_again_as_it_was(worked):
    once = reopened(worked)
    twice = reopened(once)
    assert twice.look == once.look
    np.testing.assert_array_equal(twice.codes, once.codes)
    np.testing.assert_array_equal(twice.relit().to_rgba(), once.relit().to_rgba())


def test_a_session_is_an_archive_of_the_recolored_analysis(worked, tmp_path):
    path = tmp_path / "my cat.toonkit"
    path.write_bytes(session_file(worked).getvalue())
    analysis = toonkit.load_analysis(path)
    assert np.array_equal(analysis.materials.color_maps[1].colors, RAMP.color_map().colors)


def test_a_session_is_called_like_its_drawing(worked):
    assert worked.on_screen.opened.session_name == "my cat.toonkit"
    assert reopened(worked, "renamed.toonkit").on_screen.opened.session_name == "renamed.toonkit"


def test_a_session_of_the_drawing_on_screen_replaces_what_was_done_since(worked):
    saved = session_file(worked).getvalue()
    state = reopened(worked)
    run(state.merge(2, 0))
    run(state.open_file("my cat.toonkit", saved))
    assert state.numbers == [0, 2]


def test_a_plain_archive_is_opened_with_its_materials_and_ramps(worked):
    state = RelightState(new_light=[12.0, 34.0])
    run(state.open_file("analysis.npz", analysis_file(worked).getvalue()))
    assert (state.analysis.method, state.new_light) == ("lumo", [12.0, 34.0])
    assert (state.numbers, list(state.ramps)) == ([0, 1], [1])
    assert not state.can_undo or state.corrected
    state.method = "lambert"
    run(state.analyze())
    np.testing.assert_array_equal(state.analysis.materials.labels, worked.analysis.materials.labels)


def test_going_back_to_a_session_goes_on_with_what_was_done_since(worked, drawing):
    saved = session_file(worked).getvalue()
    state = reopened(worked)
    run(state.merge(2, 0))
    run(state.open_file("other.png", drawing))
    assert state.numbers == [0, 1, 2]
    run(state.open_file("my cat.toonkit", saved, again=True))
    assert state.numbers == [0]
    assert state.original_light == worked.original_light


def test_going_back_to_a_picture_keeps_the_light_that_was_given_for_it(worked, drawing):
    state = RelightState(method="lumo")
    run(state.open_file("other.png", drawing))
    state.original_light = [20.0, 70.0]
    run(state.analyze())
    run(state.open_file("my cat.toonkit", session_file(worked).getvalue()))
    run(state.open_file("other.png", drawing, again=True))
    assert state.original_light == [20.0, 70.0]


def damaged(content):
    yield content[: len(content) // 2]
    yield content[:-1]
    yield content[:3000] + bytes(64) + content[3064:]


def test_a_damaged_session_is_refused_and_the_work_kept(worked):
    content, shown = session_file(worked).getvalue(), worked.analysis
    for broken in damaged(content):
        with pytest.raises(
            ToonkitError, match=r"save it again, or open the drawing itself; got cat\.toonkit"
        ):
            run(worked.open_file("cat.toonkit", broken))
        assert worked.analysis is shown
        assert (worked.numbers, worked.ramps) == ([0, 2], {2: RAMP})


def rewritten(content, **fields):
    """A session with other arrays."""
    file = BytesIO()
    with ZipFile(BytesIO(content)) as old, ZipFile(file, "w") as new:
        for name in old.namelist():
            if name.removesuffix(".npy") not in fields:
                new.writestr(name, old.read(name))
        for name, values in fields.items():
            with new.open(f"{name}.npy", "w") as entry:
                np.lib.format.write_array(entry, np.asarray(values), allow_pickle=False)
    return file.getvalue()


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"session_version": 2}, "use the toonkit that has saved it"),
        ({"session_settings": "{"}, "session or an analysis"),
        ({"session_settings": "[" * 20_000}, "session or an analysis"),
        ({"session_settings": '{"settings": {"ambient": 7}, "ramps": {}, "selected": 0}'}, "ambient"),
        ({"session_settings": '{"settings": {"step": "x"}, "ramps": {}, "selected": 0}'}, "step"),
        ({"session_codes": np.zeros(3, np.int16)}, "shape"),
    ],
)
def test_a_session_that_says_what_cannot_be_is_refused(worked, fields, reason):
    content = rewritten(session_file(worked).getvalue(), **fields)
    with pytest.raises(ToonkitError, match=reason):
        run(RelightState().open_file("cat.toonkit", content))


@pytest.mark.parametrize("value", [-5, 30_000, 1 << 40, 3])
def test_codes_that_no_material_has_are_refused(worked, value):
    codes = np.full(int(worked.analysis.image.mask.sum()), value)
    content = rewritten(session_file(worked).getvalue(), session_codes=codes)
    with pytest.raises(ToonkitError, match="session or an analysis"):
        run(RelightState().open_file("cat.toonkit", content))


@pytest.mark.parametrize("content", [b"no picture", b"", b"PK\x03\x04 no archive", b"PK"])
def test_a_foreign_file_is_refused_by_its_name_and_the_work_kept(worked, content):
    shown = worked.analysis
    with pytest.raises(ToonkitError, match=r"letter\.docx"):
        run(worked.open_file("letter.docx", content))
    assert worked.analysis is shown


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
def test_a_layered_document_has_its_materials_and_ink(kind, tmp_path):
    path = write_layered(kind, CHARACTER, SHAPE, tmp_path)
    state = RelightState(method="lumo")
    run(state.open_file(path.name, path.read_bytes()))
    labels = np.where(HAIR, 1, np.where(HEAD, 0, -1))
    np.testing.assert_array_equal(state.labels, labels)
    np.testing.assert_array_equal(state.analysis.drawing.given_ink, RING)
    run(state.merge(1, 0))
    np.testing.assert_array_equal(state.analysis.drawing.given_ink, RING)
    other = reopened(state)
    run(other.reset_materials())
    np.testing.assert_array_equal(other.labels, labels)
    np.testing.assert_array_equal(other.analysis.drawing.given_ink, RING)


def test_a_document_and_its_merged_picture_are_two_drawings(tmp_path):
    path = write_layered("psd", CHARACTER, SHAPE, tmp_path)
    merged = BytesIO()
    Image.fromarray(toonkit.load_image(path).to_rgba()).save(merged, "PNG")
    state = RelightState(method="lumo")
    run(state.open_file("merged.png", merged.getvalue()))
    assert state.analysis.drawing.given_ink is None
    run(state.open_file("cat.psd", path.read_bytes()))
    np.testing.assert_array_equal(state.analysis.drawing.given_ink, RING)

"""The study on the command line: run, go on, report, and one line for what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

import toonkit
from toonkit.cli import main
from toonkit.study.shapes import SHAPES
from toonkit.study.table import load_provenance, load_trials

SMALL = ["--size", "48", "--maps", "terracotta", "dusk_smooth", "--workers", "0"]


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    assert main(["study", "run", "-o", str(folder), "--shapes", "sphere", "torus", "pear", *SMALL]) == 0
    return folder


def test_a_run_measures_every_method_and_says_where_the_table_is(study, capsys):
    table = load_trials(study)
    assert len(table) == 3 * 2 * 6
    assert main(["study", "run", "-o", str(study), "--shapes", "sphere", *SMALL]) == 0
    assert "36 trials on file, 0 of them failed" in capsys.readouterr().out


def test_a_report_prints_its_tables_and_writes_its_figures(study, capsys, tmp_path):
    assert main(["study", "report", str(study), "-o", str(tmp_path / "report")]) == 0
    printed = capsys.readouterr().out
    assert "| normals, mean error |" in printed
    assert {path.suffix for path in (tmp_path / "report").iterdir()} == {".md", ".csv", ".png", ".pdf"}


def test_a_report_goes_into_the_folder_of_the_study(study):
    assert main(["study", "report", str(study), "--quiet"]) == 0
    assert (study / "report" / "report.md").is_file()


def test_meshes_are_seen_from_the_view_after_them(tmp_path):
    files = [tmp_path / "bar.ply", tmp_path / "ball.ply"]
    trimesh.creation.box(extents=(1, 2, 3)).export(files[0])
    trimesh.creation.icosphere(subdivisions=2).export(files[1])
    command = ["study", "run", "-o", str(tmp_path / "study"), *SMALL, "--methods", "lumo", "--quiet"]
    assert main([*command, "--mesh", str(files[0]), "--view", "-30,20,5", "--mesh", str(files[1])]) == 0
    shapes = load_provenance(tmp_path / "study")["shapes"]
    assert shapes["bar"]["view"] == {"yaw": -30.0, "pitch": 20.0, "roll": 5.0}
    assert shapes["ball"]["view"] == {"yaw": 0.0, "pitch": 0.0, "roll": 0.0}
    assert set(load_trials(tmp_path / "study")["shape_kind"]) == {"mesh"}


def test_both_light_tracks_can_be_run(tmp_path):
    command = ["study", "run", "-o", str(tmp_path), "--shapes", "pear", "--methods", "lumo", *SMALL]
    assert main([*command, "--tracks", "given", "estimated", "--quiet"]) == 0
    table = load_trials(tmp_path).groupby("light_track")["light_error"]
    assert table.max()["given"] == 0 < table.min()["estimated"]


EXTENSION = """
import toonkit
from toonkit.study.registry import shape
from toonkit.study.solids import distance_fields as solid

def mine(image, light, *, progress=None):
    return toonkit.METHODS["lumo"](image, light)

def never(image, light, *, progress=None):
    raise RuntimeError("no idea")

toonkit.METHODS |= {"mine": mine, "never": never}

@shape("egg", "complex")
def egg():
    return solid.ellipsoid((0.0, 0.0, 0.0), (0.7, 0.9, 0.7))
"""


@pytest.fixture
def extension(tmp_path):
    before = dict(toonkit.METHODS), dict(SHAPES)
    path = tmp_path / "mine.py"
    path.write_text(EXTENSION)
    yield str(path)
    for registry, kept in zip((toonkit.METHODS, SHAPES), before, strict=True):
        registry.clear()
        registry.update(kept)


@pytest.mark.parametrize("workers", ["0", "1"])
def test_a_file_of_ones_own_adds_methods_and_shapes(extension, tmp_path, capsys, workers):
    command = ["study", "run", "-o", str(tmp_path / "study"), "--with", extension, "--size", "48"]
    command += ["--shapes", "egg", "--maps", "terracotta", "--methods", "mine", "lumo", "--workers", workers]
    assert main(command) == 0
    table = load_trials(tmp_path / "study").set_index("method")
    assert table.loc["mine", "angular_error"] == table.loc["lumo", "angular_error"]


def test_a_changed_file_of_ones_own_is_measured_again(extension, tmp_path, capsys):
    command = ["study", "run", "-o", str(tmp_path / "study"), "--with", extension, "--shapes", "sphere"]
    command += [*SMALL, "--methods", "mine", "lumo"]
    assert main(command) == 0
    before = load_trials(tmp_path / "study").set_index("method")["angular_error"]
    Path(extension).write_text(EXTENSION.replace('METHODS["lumo"]', 'METHODS["lambert"]'))
    assert main(command) == 0
    after = load_trials(tmp_path / "study").set_index("method")["angular_error"]
    assert (after["mine"] != before["mine"]).all()
    assert (after["lumo"] == before["lumo"]).all()


def test_a_method_is_measured_again_on_demand(tmp_path):
    command = ["study", "run", "-o", str(tmp_path), "--shapes", "sphere", "--methods", "lumo", "flat", *SMALL]
    assert main(command) == main([*command, "--again", "lumo"]) == 0
    assert [run["trials"] for run in load_provenance(tmp_path)["runs"]] == [4, 2]


def test_what_failed_is_told_with_what_to_do(extension, tmp_path, capsys):
    command = [
        "study",
        "run",
        "-o",
        str(tmp_path / "study"),
        "--with",
        extension,
        "--shapes",
        "sphere",
        *SMALL,
    ]
    assert main([*command, "--methods", "never", "lumo"]) == 1
    said = capsys.readouterr().out
    assert "4 trials on file, 2 of them failed" in said
    assert "2 x RuntimeError: no idea" in said
    assert "--retry-failed" in said


def test_the_list_names_everything(capsys):
    assert main(["study", "list"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("teapot", "terracotta", "toonkit", "flat"))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "-o", "{}", "--shapes", "nothing"], "shapes must be among"),
        (["run", "-o", "{}", "--size", "3"], "size must"),
        (["run", "-o", "{}", "--light", "left"], "--light must be AZIMUTH,ELEVATION"),
        (["run", "-o", "{}", "--mesh", "nothing.obj"], "mesh must be a file"),
        (["run", "-o", "{}", "--view", "1,2,3"], "--view must come after"),
        (["run", "-o", "{}", "--workers", "-1"], "workers must"),
        (["run", "-o", "{}", "--workers", "1", "--scheduler", "tcp://a:1"], "not allowed with"),
        (["run", "-o", "{}", "--tracks", "guessed"], "light_tracks must"),
        (["run", "-o", "{}", "--with", "nothing.py"], "--with must be a Python file"),
        (["run", "-o", "{}", "--methods", "flat", "--again", "lumo"], "again must be among the plan's flat"),
        (["report", "{}"], "toonkit study run"),
        (["report", "{}/nothing"], "toonkit study run"),
    ],
)
def test_what_is_refused_is_one_line_and_exit_code_2(arguments, says, tmp_path, capsys):
    assert main(["study", *(argument.format(tmp_path) for argument in arguments)]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_a_view_that_is_none_is_refused(tmp_path, capsys):
    path = tmp_path / "ball.ply"
    trimesh.creation.icosphere(subdivisions=1).export(path)
    assert main(["study", "run", "-o", str(tmp_path), "--mesh", str(path), "--view", "front"]) == 2
    assert "--view must be YAW,PITCH,ROLL" in capsys.readouterr().err

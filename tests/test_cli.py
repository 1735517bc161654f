"""The command line does what the library does, says so in few words, and refuses in one line."""

import io
import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import toonkit
from tests.pixel_art import sprite
from toonkit import ColorMap, NormalField, angular_error, load_image, relight
from toonkit.cli import main
from toonkit.cli.drawing_work import METHOD_NAMES
from toonkit.export.archive import load_analysis
from toonkit.export.label_picture import read_labels
from toonkit.export.picture import write_picture

SIZE, RADIUS = 48, 20.0
NEW_LIGHT = toonkit.light_direction(-30, 50)


@pytest.fixture(scope="module")
def drawing(tmp_path_factory):
    """A file with a three-tone ball lit from the upper left."""
    row, column = np.indices((SIZE, SIZE))
    x, y = (column - 23.5) / RADIUS, (23.5 - row) / RADIUS
    mask = x**2 + y**2 < 1
    normals = NormalField(np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))], axis=-1), mask)
    ramp = ColorMap(np.repeat([[0.3, 0.1, 0.35], [0.7, 0.35, 0.35], [1.0, 0.8, 0.5]], 6, axis=0))
    path = tmp_path_factory.mktemp("drawing") / "ball.png"
    write_picture(toonkit.shade(normals, toonkit.light_direction(135, 45), ramp), path)
    return path


@pytest.fixture(scope="module")
def analyzed(drawing, tmp_path_factory):
    """The folder that analyzing it once wrote."""
    folder = tmp_path_factory.mktemp("analyzed") / "out"
    assert main(["analyze", str(drawing), "--light", "135,45", "-o", str(folder), "--quiet"]) == 0
    return folder


def report_in(folder):
    return json.loads((folder / "report.json").read_text())


def test_analyze_writes_what_it_says_and_says_what_it_wrote(drawing, tmp_path, capsys):
    assert main(["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path / "out")]) == 0
    said, complained = capsys.readouterr()
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert files == set(re.findall(r"^  (\S+)", said, flags=re.MULTILINE))
    assert {
        "analysis.npz",
        "normals.png",
        "color_map.json",
        "relit_contact_sheet.png",
        "report.json",
    } <= files
    assert "azimuth 135°, elevation 45° (given)" in said
    assert complained == ""  # no progress bar where nobody looks


def test_a_report_says_how_the_analysis_went(analyzed, drawing):
    report = report_in(analyzed)
    assert report["drawing"] == str(drawing)
    assert report["method"] == "toonkit"
    assert report["light"]["source"] == "given"
    assert report["light"]["confidence"] is None
    assert report["picture"]["mask_pixels"] == int(load_image(drawing).mask.sum())
    assert 0 <= report["input_fit_rmse"] < 0.5
    assert report["solver"]["reason"]
    assert "reading the drawing" in report["seconds"]
    assert all(seconds >= 0 for seconds in report["seconds"].values())


def test_an_analysis_is_the_librarys(analyzed, drawing):
    expected = toonkit.analyze(load_image(drawing), toonkit.light_direction(135, 45))
    found = load_analysis(analyzed / "analysis.npz")
    assert (
        angular_error(found.normals, expected.normals).map[found.image.mask].max() < 0.01
    )  # as archives round


def test_without_a_light_one_is_estimated(drawing, tmp_path, capsys):
    assert main(["analyze", str(drawing), "-o", str(tmp_path)]) == 0
    report = report_in(tmp_path)
    estimate = toonkit.estimate_light(load_image(drawing))
    assert report["light"]["source"] == "estimated"
    assert report["light"]["confidence"] == pytest.approx(estimate.confidence)
    assert report["light"]["vector"] == pytest.approx(estimate.light)
    assert "estimated, confidence" in capsys.readouterr().out


def test_an_estimate_that_explains_little_is_called_a_guess(drawing, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("toonkit.cli.UNSURE", 1.1)
    assert main(["analyze", str(drawing), "-o", str(tmp_path)]) == 0
    assert "this light is a guess" in capsys.readouterr().out
    monkeypatch.setattr("toonkit.cli.UNSURE", 0.0)
    assert main(["analyze", str(drawing), "-o", str(tmp_path)]) == 0
    assert "this light is a guess" not in capsys.readouterr().out


def test_where_a_drawing_does_not_say_its_light_the_assumed_one_is_named(tmp_path, capsys):
    y, x = np.mgrid[:48, :48] - 23.5
    rgba = np.zeros((48, 48, 4), np.uint8)
    rgba[x**2 + y**2 < 400] = (200, 120, 90, 255)
    Image.fromarray(rgba).save(tmp_path / "disc.png")
    assert main(["analyze", str(tmp_path / "disc.png"), "-o", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert "light: azimuth 130°, elevation 50° (assumed, confidence 0.00)" in shown
    assert "does not say where its light is" in shown


def test_line_art_is_mentioned_where_there_is_some(drawing, tmp_path, capsys):
    image = load_image(drawing)
    row, column = np.indices((SIZE, SIZE))
    outline = np.hypot(column - 23.5, row - 23.5) > RADIUS - 2
    write_picture(
        toonkit.ToonImage(np.where(outline[..., None], 0.02, image.color), image.mask), tmp_path / "a.png"
    )
    for path, share in ((tmp_path / "a.png", outline[image.mask].mean()), (drawing, 0.0)):
        assert main(["analyze", str(path), "--light", "135,45", "-o", str(tmp_path / "out")]) == 0
        assert report_in(tmp_path / "out")["picture"]["ink_share"] == pytest.approx(share, abs=0.02)
        assert ("line art: " in capsys.readouterr().out) == (share > 0)


def test_methods_of_the_help_are_those_of_the_library():
    assert tuple(toonkit.METHODS) == METHOD_NAMES


def test_a_method_can_be_chosen(drawing, tmp_path):
    assert main(["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path), "--method", "lumo"]) == 0
    assert report_in(tmp_path)["method"] == "lumo"


def test_a_mask_can_be_given(drawing, tmp_path):
    mask = load_image(drawing).mask.copy()
    mask[:, :24] = False
    Image.fromarray(mask).save(tmp_path / "mask.png")
    out, mask_file = tmp_path / "out", tmp_path / "mask.png"
    assert main(["analyze", str(drawing), "--light", "135,45", "--mask", str(mask_file), "-o", str(out)]) == 0
    assert report_in(out)["picture"]["mask_pixels"] == mask.sum()


@pytest.fixture(scope="module")
def labels(drawing, tmp_path_factory):
    """A label picture of the drawing: its left and its right half, the latter smaller, and a spot in one tone."""
    mask = load_image(drawing).mask
    colors = np.zeros((SIZE, SIZE, 4), np.uint8)
    colors[mask] = [200, 30, 30, 255]
    colors[mask & (np.arange(SIZE) > 26)] = [30, 30, 200, 255]
    colors[20:24, 14:18] = [30, 200, 30, 255]
    path = tmp_path_factory.mktemp("labels") / "labels.png"
    write_picture(colors, path)
    return path


@pytest.fixture(scope="module")
def analyzed_in_materials(drawing, labels, tmp_path_factory):
    folder = tmp_path_factory.mktemp("materials") / "out"
    names = [str(drawing), "--light", "135,45", "--materials", str(labels), "-o", str(folder)]
    assert main(["analyze", *names, "--quiet"]) == 0
    return folder


def test_materials_can_be_given_as_a_picture(drawing, labels, analyzed_in_materials):
    expected = toonkit.analyze(drawing, (135, 45), materials=read_labels(labels))
    found = load_analysis(analyzed_in_materials / "analysis.npz")
    assert found.materials.count == 3
    assert np.array_equal(found.materials.labels, expected.materials.labels)
    assert angular_error(found.normals, expected.normals).map[found.image.mask].max() < 0.01
    assert len(report_in(analyzed_in_materials)["materials"]) == 3


def test_the_picture_of_materials_that_was_written_can_be_given_again(
    drawing, analyzed_in_materials, tmp_path
):
    materials = analyzed_in_materials / "materials.png"
    names = [str(drawing), "--light", "135,45", "--materials", str(materials), "-o", str(tmp_path)]
    assert main(["analyze", *names]) == 0
    assert (tmp_path / "materials.png").read_bytes() == materials.read_bytes()


def test_analyze_says_how_many_materials_there_are_and_how_many_are_flat(drawing, labels, tmp_path, capsys):
    analyze = ["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path)]
    assert main(analyze) == 0
    assert re.search(r"^materials: 1$", capsys.readouterr().out, flags=re.MULTILINE)
    assert main([*analyze, "--materials", str(labels)]) == 0
    assert re.search(r"^materials: 3, 1 of them flat$", capsys.readouterr().out, flags=re.MULTILINE)


@pytest.mark.parametrize("share", [0.0, 0.4])
def test_relight_shades_flat_materials_as_much_as_is_asked(analyzed_in_materials, tmp_path, share):
    relit, orbit = tmp_path / "relit.png", tmp_path / "orbit.png"
    options = ["--flat-shading", str(share)]
    assert main(["relight", str(analyzed_in_materials), "--light", "-30,50", "-o", str(relit), *options]) == 0
    analysis = load_analysis(analyzed_in_materials / "analysis.npz")
    with Image.open(relit) as found:
        assert np.array_equal(np.asarray(found), relight(analysis, NEW_LIGHT, flat_shading=share).to_rgba())
    assert (
        main(["relight", str(analyzed_in_materials), "--orbit", str(orbit), "--frames", "2", *options]) == 0
    )
    with Image.open(orbit) as found:
        found.seek(1)
        expected = relight(analysis, (315, 45), flat_shading=share).to_rgba()
        seen = expected[..., 3] > 0
        assert np.abs(np.asarray(found.convert("RGBA")).astype(int) - expected)[seen].max() <= 1


def test_pixel_art_keeps_its_palette_until_it_is_told_not_to(tmp_path, capsys):
    drawing, out = tmp_path / "sprite.png", tmp_path / "out"
    sprite(32).save(drawing)
    assert main(["analyze", str(drawing), "--light", "130,45", "-o", str(out)]) == 0
    assert "pixel art: relight keeps to its colors" in capsys.readouterr().out
    analysis = load_analysis(out / "analysis.npz")
    for options, palette in (([], True), (["--no-palette"], False), (["--palette", "--model-only"], True)):
        relit = tmp_path / "relit.png"
        assert main(["relight", str(out), "--light", "-30,50", "-o", str(relit), *options]) == 0
        model = "--model-only" in options
        expected = relight(analysis, NEW_LIGHT, palette=palette, keep_detail=not model)
        with Image.open(relit) as found:
            assert np.array_equal(np.asarray(found), expected.to_rgba())


def test_relight_takes_a_light_color_and_ambient_light(analyzed, tmp_path):
    relit, orbit = tmp_path / "relit.png", tmp_path / "orbit.png"
    options = ["--light-color", "#FF8040", "--ambient", "0.3"]
    assert main(["relight", str(analyzed), "--light", "-30,50", "-o", str(relit), *options]) == 0
    assert main(["relight", str(analyzed), "--orbit", str(orbit), "--frames", "2", *options]) == 0
    analysis = load_analysis(analyzed / "analysis.npz")
    color = (1.0, 128 / 255, 64 / 255)
    expected = relight(analysis, NEW_LIGHT, light_color=color, ambient=0.3).to_rgba()
    assert not np.array_equal(expected, relight(analysis, NEW_LIGHT).to_rgba())
    with Image.open(relit) as found:
        assert np.array_equal(np.asarray(found), expected)
    with Image.open(orbit) as found:
        frame = np.asarray(found.convert("RGBA")).astype(int)
    expected = relight(analysis, analysis.light, light_color=color, ambient=0.3).to_rgba()
    seen = expected[..., 3] > 0
    assert np.abs(frame - expected)[seen].max() <= 1


def test_quiet_says_nothing(drawing, tmp_path, capsys):
    assert main(["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path), "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(("options", "shown"), [([], True), (["--quiet"], False)])
def test_a_terminal_sees_the_steps_go_by(drawing, tmp_path, monkeypatch, options, shown):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert main(["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path), *options]) == 0
    assert ("reading the drawing" in terminal.getvalue()) is shown


@pytest.mark.parametrize("source", [".", "analysis.npz"])
@pytest.mark.parametrize("light", [["--light", "-30,50"], ["--light=-30,50"], ["--light", "330,50"]])
def test_relight_paints_what_the_library_paints(analyzed, tmp_path, capsys, source, light):
    target = tmp_path / "relit.png"
    assert main(["relight", str(analyzed / source), *light, "-o", str(target)]) == 0
    assert str(target) in capsys.readouterr().out
    expected = relight(load_analysis(analyzed / "analysis.npz"), NEW_LIGHT).to_rgba()
    with Image.open(target) as found:
        # one step: azimuths of -30 and 330 degrees round differently
        assert np.abs(np.asarray(found).astype(int) - expected).max() <= 1


def test_relight_takes_a_light_from_behind(analyzed, tmp_path):
    target = tmp_path / "rim.png"
    assert main(["relight", str(analyzed), "--light", "60,-30", "-o", str(target)]) == 0
    expected = relight(load_analysis(analyzed / "analysis.npz"), (60, -30)).to_rgba()
    with Image.open(target) as found:
        assert np.array_equal(np.asarray(found), expected)


def test_relight_lets_a_light_circle_behind_the_picture(analyzed, tmp_path):
    target = tmp_path / "rim.webp"
    options = ["--frames", "2", "--elevation", "-30"]
    assert main(["relight", str(analyzed), "--orbit", str(target), *options]) == 0
    with Image.open(target) as found:
        assert found.n_frames == 2


def test_relight_lets_a_light_go_from_light_to_light(analyzed, tmp_path):
    target = tmp_path / "path.png"
    path = ["--through", "45,30", "-30,-10", "--frames", "2", "--once"]
    assert main(["relight", str(analyzed), "--orbit", str(target), *path]) == 0
    expected = relight(load_analysis(analyzed / "analysis.npz"), (-30, -10)).to_rgba()
    with Image.open(target) as found:
        found.seek(1)
        last = np.asarray(found.convert("RGBA")).astype(int)
    seen = expected[..., 3] > 0
    assert np.abs(last[seen] - expected[seen]).max() <= 1


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--through", "45,30", "60,30"], "needs --orbit FILE beside --through"),
        (["--orbit", "path.gif", "--once"], "needs --through AZ,EL AZ,EL beside --once"),
        (["--orbit", "path.gif", "--through", "45,30"], "lights must be two or more lights"),
        (["--orbit", "path.gif", "--through", "45,30", "left"], "--through must be AZIMUTH,ELEVATION"),
        (["--orbit", "path.gif", "--through", "1,2", "3,4", "--elevation", "5"], "elevations from --through"),
    ],
)
def test_relight_refuses_what_is_no_path(analyzed, tmp_path, monkeypatch, capsys, options, reason):
    monkeypatch.chdir(tmp_path)
    light = [] if "--orbit" in options else ["--light", "45,30", "-o", "relit.png"]
    assert main(["relight", str(analyzed), *light, *options]) == 2
    assert reason in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["layers", "layers.ora"])
def test_relight_writes_layers_with_or_without_the_picture(analyzed, tmp_path, capsys, name):
    target, picture = tmp_path / name, tmp_path / "relit.png"
    command = ["relight", str(analyzed), "--light", "-30,50", "--layers", str(target)]
    assert main(command) == 0
    assert capsys.readouterr().out == f"written to {target}\n"
    assert main([*command, "-o", str(picture)]) == 0
    assert picture.exists()
    if target.is_dir():
        with Image.open(target / "relit.png") as found, Image.open(picture) as expected:
            assert np.array_equal(np.asarray(found), np.asarray(expected))


def test_relight_writes_light_profiles_without_a_light(analyzed, tmp_path):
    target = tmp_path / "profiles"
    assert main(["relight", str(analyzed), "--profiles", str(target)]) == 0
    assert len(list(target.iterdir())) == 10


def test_relight_can_leave_the_drawings_detail_out(analyzed, tmp_path):
    target = tmp_path / "relit.webp"
    assert main(["relight", str(analyzed), "--light", "-30,50", "-o", str(target), "--model-only"]) == 0
    expected = relight(load_analysis(analyzed / "analysis.npz"), NEW_LIGHT, keep_detail=False).to_rgba()
    with Image.open(target) as found:
        assert np.array_equal(np.asarray(found.convert("RGBA")), expected)


def test_an_orbit_is_an_animation(analyzed, tmp_path):
    target = tmp_path / "orbit.gif"
    assert main(["relight", str(analyzed), "--orbit", str(target), "--frames", "5", "--elevation", "30"]) == 0
    with Image.open(target) as found:
        assert found.n_frames == 5


def test_samples_lists_every_shipped_drawing(capsys):
    from toonkit.samples import sample_names, sample_path

    assert main(["samples"]) == 0
    said = capsys.readouterr().out
    for name in sample_names():
        assert re.search(
            rf"^{re.escape(name)} +{re.escape(str(sample_path(name)))}$", said, flags=re.MULTILINE
        )


def test_a_shipped_drawing_is_named_by_its_prefix(tmp_path):
    from toonkit.samples import sample_names

    name = f"sample:{sample_names()[0]}"
    assert (
        main(["analyze", name, "--light", "135,45", "--method", "lumo", "-o", str(tmp_path), "--quiet"]) == 0
    )
    assert report_in(tmp_path)["drawing"] == name


def test_the_version_is_the_packages(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"toonkit {toonkit.__version__}\n"


@pytest.mark.parametrize("arguments", [["--help"], ["analyze", "--help"], ["relight", "--help"]])
def test_help_is_given(arguments, capsys):
    assert main(arguments) == 0
    assert capsys.readouterr().out.startswith("usage: toonkit")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ("", "arguments are required: COMMAND"),
        ("paint x", "invalid choice: 'paint'"),
        ("analyze", "arguments are required: drawing"),
        ("analyze {drawing}", "arguments are required: -o"),
        ("analyze {drawing} -o {out} --method magic", "invalid choice: 'magic'"),
        ("analyze {drawing} -o {out} --bogus", "unrecognized arguments: --bogus"),
        ("analyze {drawing} -o {out} --light 135", "--light must be AZIMUTH,ELEVATION"),
        ("analyze {drawing} -o {out} --light left", "--light must be AZIMUTH,ELEVATION"),
        ("analyze {drawing} -o {out} --light 1,2,3", "--light must be AZIMUTH,ELEVATION"),
        ("analyze {drawing} -o {out} --light 0,-10", "elevation must lie in 0 to 90"),
        ("analyze {drawing} -o {out} --light nan,10", "azimuth must be a finite number"),
        ("analyze {tmp}/nowhere.png -o {out}", "source must be an existing file"),
        ("analyze {drawing} -o {drawing}", "folder must be a folder"),
        ("analyze {drawing} --out={empty}", "folder must have a name"),
        ("analyze {drawing} -o {out} --mask {tmp}/nowhere.png", "mask must be an existing file"),
        ("analyze {drawing} -o {out} --materials {tmp}/nowhere.png", "materials must be an existing file"),
        ("analyze {drawing} -o {out} --materials {tmp}/a.jpg", r"materials must end in \.png or \.webp"),
        (
            "analyze {drawing} -o {out} --materials {analyzed}/color_map.png",
            r"materials must have the size of the picture \(48, 48\); got \(32, 512\)",
        ),
        ("analyze sample:nothing -o {out}", "sample must be one of"),
        ("relight {tmp} --light 30,50 -o {tmp}/relit.png", "path must be an archive of an analysis"),
        ("relight {drawing} --light 30,50 -o {tmp}/relit.png", "path must be an undamaged archive"),
        ("relight {analyzed} --light 30,50", "relight needs -o FILE"),
        ("relight {analyzed} -o {tmp}/relit.png", "needs one of --light AZ,EL and --orbit FILE; got neither"),
        ("relight {analyzed} --light 1,2 --orbit {tmp}/a.gif", "needs one of .* got both"),
        (
            "relight {analyzed} --layers {tmp}/layers",
            "needs one of --light AZ,EL and --orbit FILE; got neither",
        ),
        ("relight {analyzed} --orbit {tmp}/a.gif --layers {tmp}/a", "needs --light AZ,EL beside --layers"),
        ("relight {analyzed} --profiles {tmp}/a -o {tmp}/b.png", "takes the folder's name from --profiles"),
        ("relight {analyzed} --light 30,50 --layers {tmp}/a.xcf", r"path must end in \.ora or \.psd"),
        ("relight {analyzed} --light 30,-91 -o {tmp}/a.png", "elevation must lie in -90 to 90"),
        ("analyze {drawing} -o {out} --engine quake", "invalid choice: 'quake'"),
        ("relight {analyzed} --orbit {tmp}/a.gif -o {tmp}/b.gif", "takes the animation's name from --orbit"),
        ("relight {analyzed} --light 30,50 -o {tmp}/relit.jpg", r"path must end in \.png or \.webp"),
        ("relight {analyzed} --light 30,50 -o {out}/relit.png", "path must lie in an existing folder"),
        ("relight {analyzed} --orbit {tmp}/relit.mp4", r"path must end in \.gif"),
        ("relight {analyzed} --orbit {tmp}/relit.gif --frames 1", "frames must be a whole number"),
        (
            "relight {analyzed} --light 30,50 -o {tmp}/a.png --flat-shading 2",
            "flat_shading must be .* got 2.0",
        ),
        (
            "relight {analyzed} --light 30,50 -o {tmp}/a.png --flat-shading nan",
            "flat_shading must be .* got nan",
        ),
        (
            "relight {analyzed} --light 30,50 -o {tmp}/a.png --light-color red",
            "--light-color must be #RRGGBB",
        ),
        (
            "relight {analyzed} --light 30,50 -o {tmp}/a.png --ambient 2",
            "ambient must be a number from 0 to 1",
        ),
        ("relight {analyzed} --orbit {tmp}/a.gif --flat-shading -1", "flat_shading must be .* got -1.0"),
        ("relight {analyzed} --orbit {tmp}/a.gif --flat-shading dark", "invalid float value: 'dark'"),
        ("relight {analyzed} --orbit {tmp}/relit.gif --frames many", "invalid int value: 'many'"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(drawing, analyzed, tmp_path, capsys, arguments, reason):
    places = {"drawing": drawing, "analyzed": analyzed, "tmp": tmp_path, "out": tmp_path / "out", "empty": ""}
    assert main([part.format(**places) for part in arguments.split()]) == 2
    said, complained = capsys.readouterr()
    assert said == ""
    assert re.fullmatch(rf"toonkit: error: .*{reason}.*\n", complained)
    assert not list(tmp_path.iterdir())  # nothing is left behind


def test_a_mistake_of_ours_is_not_hidden(drawing, tmp_path, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr(toonkit, "analyze", broken)
    with pytest.raises(ZeroDivisionError):
        main(["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path)])


def test_a_reader_that_went_away_ends_it_with_141_and_without_a_traceback():
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "toonkit", "samples"], stdout=writing, stderr=subprocess.PIPE, check=False
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, b"")


@pytest.mark.parametrize("arguments", [["samples"], ["--help"], ["--version"]])
def test_a_full_disk_under_stdout_is_told_in_one_line(arguments):
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "toonkit", *arguments], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert done.returncode == 1
    assert done.stderr == b"toonkit: error: standard output: No space left on device\n"


@pytest.mark.parametrize("closed", [">&-", "2>/dev/full", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    ("arguments", "status"),
    [("--help", 0), ("relight nowhere --light 1,2 -o a.png", 2)],
)
def test_streams_that_are_closed_change_nothing(arguments, status, closed, tmp_path):
    command = f"{sys.executable} -m toonkit {arguments} {closed}"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == status
    assert b"Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("arguments", ["--help", "study list", "samples"])
def test_help_and_lists_may_be_cut_off_by_their_reader(arguments):
    command = f"{sys.executable} -m toonkit {arguments} | true"
    done = subprocess.run(["sh", "-c", command], capture_output=True, check=False)
    assert done.stderr == b""


def test_a_terminal_without_a_sign_for_degrees_gets_another(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "toonkit", "analyze", "sample:cat", "--light", "130,42", "-o", tmp_path],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr.count(b"Error")) == (0, 0)
    assert b"azimuth 130?, elevation 42?" in done.stdout


def test_an_interruption_ends_with_130(drawing, tmp_path, monkeypatch, capsys):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(toonkit, "analyze", interrupted)
    assert main(["analyze", str(drawing), "--light", "135,45", "-o", str(tmp_path)]) == 130
    assert capsys.readouterr().err.strip() == "toonkit: interrupted"
    assert not list(tmp_path.iterdir())


def test_the_package_runs_as_a_program(analyzed, tmp_path):
    shutil.copytree(analyzed, tmp_path / "moved")
    command = [sys.executable, "-W", "error", "-m", "toonkit"]
    done = subprocess.run(
        [*command, "relight", tmp_path / "moved", "--light", "30,50", "-o", tmp_path / "relit.png"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "relit.png").exists()


def test_names_that_start_with_a_tilde_are_names(drawing, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(drawing, "~ball.png")
    analyze = ["analyze", "~ball.png", "--mask", "~ball.png", "--light", "135,45", "--method", "lumo"]
    assert main([*analyze, "-o", "~out", "--quiet"]) == 0
    assert main(["relight", "~out", "--light", "30,50", "-o", "~relit.png", "--quiet"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"~ball.png", "~out", "~relit.png"}


def test_a_warning_is_one_line(drawing, tmp_path, capfd):
    path = tmp_path / "profile.png"
    Image.open(drawing).save(path, icc_profile=b"no profile")
    analyze = ["analyze", str(path), "--light", "135,45", "--method", "lumo", "-o", str(tmp_path / "out")]
    assert main([*analyze, "--quiet"]) == 0
    said, complained = capfd.readouterr()
    assert said == ""
    assert complained == (
        "toonkit: warning: source: its color profile is damaged and is ignored, the colors are read as sRGB\n"
    )

"""A folder of results holds everything, and its report says how it came about."""

import json

import numpy as np
import pytest
from PIL import Image

import toonkit
from toonkit.export.folder import make_folder, write_analysis_folder
from toonkit.export.line_art import line_art
from toonkit.export.report import analysis_report
from toonkit.model.label_colors import label_picture

NAMES = [
    "analysis.npz",
    "input.png",
    "base_color.png",
    "materials.png",
    "normals.png",
    "normals_16.png",
    "normals_directx.png",
    "color_map.png",
    "color_map.json",
    "relit_contact_sheet.png",
    "report.json",
]

NAMES_OF_SEVERAL = [
    "analysis.npz",
    "input.png",
    "base_color.png",
    "materials.png",
    "line_art.png",
    "normals.png",
    "normals_16.png",
    "normals_directx.png",
    "color_maps.png",
    "color_maps.json",
    "relit_contact_sheet.png",
    "report.json",
]


@pytest.mark.parametrize(("which", "names"), [("analysis", NAMES), ("several", NAMES_OF_SEVERAL)])
def test_a_folder_holds_what_it_says_it_holds(request, tmp_path, which, names):
    written = write_analysis_folder(request.getfixturevalue(which), tmp_path / "new" / "out")
    assert [path.name for path in written] == names
    assert sorted(path.name for path in (tmp_path / "new" / "out").iterdir()) == sorted(names)
    assert all(path.stat().st_size > 0 for path in written)
    assert json.loads((tmp_path / "new" / "out" / "report.json").read_text())["files"] == names


def test_the_layers_are_those_of_the_analysis(several, tmp_path):
    write_analysis_folder(several, tmp_path)
    layers = {
        "base_color.png": several.base_color.to_rgba(),
        "materials.png": label_picture(several.materials.labels),
        "line_art.png": line_art(several.drawing),
    }
    for name, expected in layers.items():
        with Image.open(tmp_path / name) as found:
            assert np.array_equal(np.asarray(found), expected)


def test_the_report_says_what_was_done(analysis, tmp_path):
    write_analysis_folder(analysis, tmp_path, notes={"seconds": {"reading": 0.5}})
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["versions"]["toonkit"] == toonkit.__version__
    assert report["versions"]["numpy"] == np.__version__
    assert report["method"] == "toonkit"
    assert report["light"]["azimuth_degrees"] == pytest.approx(135)
    assert report["light"]["elevation_degrees"] == pytest.approx(40)
    assert report["light"]["vector"] == analysis.light.tolist()
    assert (report["light"]["source"], report["light"]["confidence"]) == ("given", None)
    pixels = int(analysis.image.mask.sum())
    assert report["picture"] == {"width": 48, "height": 48, "mask_pixels": pixels, "ink_share": 0.0}
    assert report["materials"] == [
        {"share": 1.0, "flat": False, "tones": ["#4c1a59", "#ffcc80"], "samples": 16, "domain": [-0.7, 0.9]}
    ]
    assert report["solver"] == {
        "iterations": 12,
        "converged": True,
        "reason": "nothing was left to gain",
        "energies": [3.5, 1.25, 1.2],
    }
    assert report["seconds"] == {"reading": 0.5}


def test_the_report_lists_each_material_and_how_sure_the_light_is(several):
    report = analysis_report(several)
    assert report["light"]["source"] == "estimated"
    assert report["light"]["confidence"] == several.light_estimate.confidence
    ink = several.drawing.ink_coverage
    assert report["picture"]["ink_share"] == pytest.approx(ink[several.image.mask].mean())
    assert [each["flat"] for each in report["materials"]] == [False, False, True]
    assert [len(each["tones"]) for each in report["materials"]] == [2, 2, 1]
    for label, each in enumerate(report["materials"]):
        assert each["share"] == (several.materials.labels == label).sum() / several.image.mask.sum()


@pytest.mark.parametrize("which", ["analysis", "several"])
def test_a_report_is_json_that_every_reader_understands(request, which):
    report = analysis_report(request.getfixturevalue(which))
    assert json.loads(json.dumps(report, allow_nan=False)) == report


def test_files_of_an_earlier_analysis_do_not_stay_beside_those_of_another(analysis, several, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    for which, names in ((several, NAMES_OF_SEVERAL), (analysis, NAMES), (several, NAMES_OF_SEVERAL)):
        write_analysis_folder(which, tmp_path)
        assert {path.name for path in tmp_path.iterdir()} == {*names, "notes.txt"}


def test_the_color_map_that_version_0_1_wrote_does_not_stay_beside_several(several, tmp_path):
    for name in ("color_map.png", "color_map.json"):
        (tmp_path / name).write_text("old")
    (tmp_path / "report.json").write_text('{"versions": {"toonkit": "0.1.0"}}')
    write_analysis_folder(several, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(NAMES_OF_SEVERAL)


@pytest.mark.parametrize(
    "report", [None, "text", "[]", "{}", '{"versions": {}, "files": ["../line_art.png"]}']
)
def test_no_file_is_removed_that_no_analysis_wrote(analysis, tmp_path, report):
    folder = tmp_path / "out"
    folder.mkdir()
    for place in (folder, tmp_path):
        (place / "line_art.png").write_text("a drawing of somebody's own")
    if report is not None:
        (folder / "report.json").write_text(report)
    write_analysis_folder(analysis, folder)
    assert (folder / "line_art.png").exists()
    assert (tmp_path / "line_art.png").exists()


def test_files_of_an_earlier_run_are_replaced_and_others_kept(analysis, tmp_path):
    (tmp_path / "report.json").write_text("old")
    (tmp_path / "notes.txt").write_text("mine")
    write_analysis_folder(analysis, tmp_path)
    assert (tmp_path / "report.json").read_text() != "old"
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_file_in_the_folders_place_is_refused(tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(toonkit.ToonkitError, match="folder must be a folder that can be written to"):
        make_folder(tmp_path / "out")

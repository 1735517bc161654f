"""A folder of results holds everything, and its report says how it came about."""

import json

import numpy as np
import pytest

import toonkit
from toonkit.export.folder import make_folder, write_analysis_folder

NAMES = [
    "analysis.npz",
    "input.png",
    "normals.png",
    "normals_16.png",
    "normals_directx.png",
    "color_map.png",
    "color_map.json",
    "relit_contact_sheet.png",
    "report.json",
]


def test_a_folder_holds_what_it_says_it_holds(analysis, tmp_path):
    written = write_analysis_folder(analysis, tmp_path / "new" / "out")
    assert [path.name for path in written] == NAMES
    assert sorted(path.name for path in (tmp_path / "new" / "out").iterdir()) == sorted(NAMES)
    assert all(path.stat().st_size > 0 for path in written)


def test_the_report_says_what_was_done(analysis, tmp_path):
    write_analysis_folder(analysis, tmp_path, notes={"seconds": {"reading": 0.5}})
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["versions"]["toonkit"] == toonkit.__version__
    assert report["versions"]["numpy"] == np.__version__
    assert report["method"] == "toonkit"
    assert report["light"]["azimuth_degrees"] == pytest.approx(135)
    assert report["light"]["elevation_degrees"] == pytest.approx(40)
    assert report["light"]["vector"] == analysis.light.tolist()
    pixels = int(analysis.image.mask.sum())
    assert report["picture"] == {"width": 48, "height": 48, "mask_pixels": pixels, "line_art_share": 0.0}
    assert report["solver"] == {
        "iterations": 12,
        "converged": True,
        "reason": "nothing was left to gain",
        "energies": [3.5, 1.25, 1.2],
    }
    assert report["seconds"] == {"reading": 0.5}


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

"""`toonkit analyze` and `batch` take line art and materials from layered files."""

import json

import numpy as np
import pytest
from PIL import Image

from tests.model.layered_files import Made, write_layered
from tests.model.test_layer_loading import CHARACTER, FLATS, LINES, RING, SHAPE
from toonkit.cli import main
from toonkit.export.archive import load_analysis

QUICK = ["--light", "130,45", "--method", "lumo"]


def report_in(folder):
    return json.loads((folder / "report.json").read_text())


@pytest.fixture
def drawing(tmp_path):
    return write_layered("psd", CHARACTER, SHAPE, tmp_path)


def test_line_art_and_materials_are_from_the_layers(drawing, tmp_path, capsys):
    assert main(["analyze", str(drawing), "-o", str(tmp_path / "out"), *QUICK]) == 0
    printed = capsys.readouterr().out
    assert "line art from the layers: Line art" in printed
    assert "materials from the layers: Flats" in printed
    assert report_in(tmp_path / "out")["layers"] == {"ink": ["Line art"], "flats": ["Flats"]}
    analysis = load_analysis(tmp_path / "out" / "analysis.npz")
    assert analysis.materials.count == 2
    assert (analysis.drawing.ink_coverage[RING] >= 0.5).all()


def test_layers_are_left_out_on_demand(drawing, tmp_path, capsys):
    assert main(["analyze", str(drawing), "-o", str(tmp_path / "out"), "--merged", *QUICK]) == 0
    assert "from the layers" not in capsys.readouterr().out
    assert "layers" not in report_in(tmp_path / "out")


def test_layers_are_named_on_the_command_line(tmp_path):
    layers = (Made("Farben", FLATS), Made("Kontur", LINES))
    path = write_layered("folder", layers, SHAPE, tmp_path)
    (path / "merged.png").write_bytes((path / "0 Farben.png").read_bytes())
    options = ["--ink-layer", "1 Kontur", "--flats-layer", "0 farben"]
    assert main(["analyze", str(path), "-o", str(tmp_path / "out"), *options, *QUICK]) == 0
    assert report_in(tmp_path / "out")["layers"] == {"ink": ["1 Kontur"], "flats": ["0 Farben"]}


def test_a_label_picture_goes_before_flat_colors(drawing, tmp_path):
    Image.fromarray(np.full((*SHAPE, 3), 9, np.uint8)).save(tmp_path / "one.png")
    options = ["--materials", str(tmp_path / "one.png")]
    assert main(["analyze", str(drawing), "-o", str(tmp_path / "out"), *options, *QUICK]) == 0
    assert report_in(tmp_path / "out")["layers"] == {"ink": ["Line art"], "flats": []}
    assert load_analysis(tmp_path / "out" / "analysis.npz").materials.count == 1


def test_a_batch_takes_layered_files_and_their_options(drawing, tmp_path):
    batch = ["batch", str(tmp_path), "-o", str(tmp_path / "out"), "--workers", "0", *QUICK]
    assert main([*batch, "--ink-layer", "Shading"]) == 0
    assert report_in(tmp_path / "out" / "drawing")["layers"]["ink"] == ["Shading"]
    assert main(batch) == 0
    assert report_in(tmp_path / "out" / "drawing")["layers"]["ink"] == ["Line art"]


def test_merged_and_named_layers_exclude_each_other(drawing, tmp_path, capsys):
    options = ["--merged", "--ink-layer", "Line art"]
    assert main(["analyze", str(drawing), "-o", str(tmp_path / "out"), *options]) == 2
    assert "--merged must stand without --ink-layer" in capsys.readouterr().err

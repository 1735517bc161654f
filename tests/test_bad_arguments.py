"""Arguments of the wrong kind raise ToonkitError, whatever function of the public API gets them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import toonkit
from tests.analytic import ellipse
from toonkit import (
    ColorMap,
    HeightField,
    IlluminationInterval,
    LightEstimate,
    Materials,
    NormalField,
    RefinementOptions,
    ToneRamp,
    ToonAnalysis,
    ToonImage,
    ToonkitError,
)
from toonkit.export.animation import write_orbit
from toonkit.export.archive import load_analysis, save_analysis
from toonkit.export.color_map import read_color_map, write_color_map, write_color_maps
from toonkit.export.contact_sheet import contact_sheet
from toonkit.export.folder import make_folder, write_analysis_folder
from toonkit.export.frame_files import read_frame_folder, write_frames
from toonkit.export.line_art import line_art
from toonkit.export.mesh import textured_mesh
from toonkit.export.normal_map import write_normal_map
from toonkit.export.picture import write_picture
from toonkit.export.report import analysis_report, write_report
from toonkit.heightfield import level_rim
from toonkit.model.label_colors import label_picture
from toonkit.model.normals import decode_normal_map, encode_normal_map
from toonkit.samples import sample_path

SHAPE = ellipse(10, 8)
MASK, NORMALS = SHAPE.mask, SHAPE.normals
LIGHT = toonkit.light_direction(135, 45)
RAMP = ColorMap([[0.2, 0.1, 0.3], [0.9, 0.8, 0.6]])
PICTURE = toonkit.shade(NORMALS, LIGHT, RAMP)
ANALYSIS = ToonAnalysis(PICTURE, "lumo", LIGHT, NORMALS, NORMALS, Materials.single(MASK, RAMP))
INTERVAL = toonkit.illumination_interval(PICTURE, RAMP)
HEIGHT = toonkit.height_map(NORMALS)
RAGGED = [[1, 0], [1]]

SAMPLE = sample_path("pear")

ODD = [None, 5, "text", b"bytes", [], [[]], {}, object(), np.zeros((0, 0)), np.array("a"), RAGGED, [10**400]]
"""What is no argument of a function that wants one of ours."""

ONE_ARGUMENT: dict[str, Callable[[object], object]] = {
    "analyze": toonkit.analyze,
    "analyze light": lambda odd: toonkit.analyze(PICTURE, [odd]),
    "analyze method": lambda odd: toonkit.analyze(PICTURE, LIGHT, method=odd),
    "analyze materials": lambda odd: toonkit.analyze(PICTURE, LIGHT, materials=[odd]),
    "analyze ink": lambda odd: toonkit.analyze(PICTURE, LIGHT, ink=[odd]),
    "analyze_frames": toonkit.analyze_frames,
    "analyze_frames frame": lambda odd: toonkit.analyze_frames([odd], LIGHT),
    "FrameAnalysis": lambda odd: toonkit.FrameAnalysis(odd, ()),
    "FrameAnalysis places": lambda odd: toonkit.FrameAnalysis(ANALYSIS, (odd,)),
    "load_layers": toonkit.load_layers,
    "read_frames": toonkit.read_frames,
    "read_frames grid": lambda odd: toonkit.read_frames(SAMPLE, grid=[odd, 0]),
    "read_frames islands": lambda odd: toonkit.read_frames(SAMPLE, islands=odd),
    "textured_mesh": textured_mesh,
    "textured_mesh back": lambda odd: textured_mesh(ANALYSIS, back=odd),
    "textured_mesh size": lambda odd: textured_mesh(ANALYSIS, size=[odd]),
    "textured_mesh vertices": lambda odd: textured_mesh(ANALYSIS, vertices=[odd]),
    "level_rim": level_rim,
    "write_frames": lambda odd: write_frames([], odd, "sheet.png"),
    "read_frame_folder": read_frame_folder,
    "analyze previous": lambda odd: toonkit.analyze(PICTURE, LIGHT, previous=[odd]),
    "analyze progress": lambda odd: toonkit.analyze(PICTURE, LIGHT, progress=[odd]),
    "angular_error": lambda odd: toonkit.angular_error(NORMALS, odd),
    "color_difference": lambda odd: toonkit.color_difference(PICTURE, odd),
    "color_rmse": lambda odd: toonkit.color_rmse(odd, PICTURE),
    "ColorMap": ColorMap,
    "ToneRamp": ToneRamp,
    "ToneRamp thresholds": lambda odd: ToneRamp(["#000000", "#ffffff"], odd),
    "ToneRamp softness": lambda odd: ToneRamp(["#000000", "#ffffff"], [0.0], [odd]),
    "recolored": lambda odd: ANALYSIS.recolored({0: odd}),
    "ColorMap domain": lambda odd: ColorMap([[0, 0, 0]], odd),
    "color map of": lambda odd: RAMP([odd, RAGGED]),
    "invert": RAMP.invert,
    "invert tolerance": lambda odd: RAMP.invert([0.5] * 3, tolerance=[odd]),
    "allowed": lambda odd: RAMP.allowed([odd, RAGGED], 0.5),
    "resampled": lambda odd: RAMP.resampled([odd]),
    "estimate_light": toonkit.estimate_light,
    "estimate_light normals": lambda odd: toonkit.estimate_light(PICTURE, initial_normals=[odd]),
    "extract_color_map": lambda odd: toonkit.extract_color_map(PICTURE, odd),
    "find_materials": toonkit.find_materials,
    "fit_color_map": lambda odd: toonkit.fit_color_map(PICTURE, odd),
    "height_map": toonkit.height_map,
    "height_mesh": toonkit.height_mesh,
    "height_mesh color": lambda odd: toonkit.height_mesh(HEIGHT, color=[odd]),
    "HeightField": lambda odd: HeightField(odd, MASK, HEIGHT.report),
    "HeightField mask": lambda odd: HeightField(HEIGHT.height, odd, HEIGHT.report),
    "HeightField report": lambda odd: HeightField(HEIGHT.height, MASK, odd),
    "illumination": lambda odd: toonkit.illumination(odd, LIGHT),
    "illumination light": lambda odd: toonkit.illumination(NORMALS, odd),
    "illumination_error": lambda odd: toonkit.illumination_error(odd, np.zeros(MASK.shape), MASK),
    "illumination_interval": lambda odd: toonkit.illumination_interval(PICTURE, odd),
    "IlluminationInterval": lambda odd: IlluminationInterval([odd, RAGGED], [odd, RAGGED]),
    "inflate": toonkit.inflate,
    "inflate alpha": lambda odd: toonkit.inflate(MASK, alpha=[odd]),
    "light_angles": toonkit.light_angles,
    "light_direction": lambda odd: toonkit.light_direction([odd], 45),
    "LightEstimate": lambda odd: LightEstimate(odd, 0.5),
    "LightEstimate confidence": lambda odd: LightEstimate(LIGHT, [odd]),
    "load_image": lambda odd: toonkit.load_image([odd]),
    "load_image mask": lambda odd: toonkit.load_image(np.ones((8, 8, 3)), mask=[odd]),
    "Materials labels": lambda odd: Materials(odd, (np.zeros((1, 3)),), np.zeros(1, bool)),
    "Materials tones": lambda odd: Materials(np.zeros((4, 4), int), (odd,), np.zeros(1, bool)),
    "Materials flat": lambda odd: Materials(np.zeros((4, 4), int), (np.zeros((1, 3)),), odd),
    "Materials color_maps": lambda odd: Materials(
        np.zeros((4, 4), int), (np.zeros((1, 3)),), np.zeros(1, bool), (odd,)
    ),
    "NormalField": lambda odd: NormalField(odd, MASK),
    "NormalField mask": lambda odd: NormalField(NORMALS.vectors, odd),
    "refine": lambda odd: toonkit.refine(odd, LIGHT, INTERVAL),
    "refine interval": lambda odd: toonkit.refine(NORMALS, LIGHT, odd),
    "refine alpha": lambda odd: toonkit.refine(NORMALS, LIGHT, INTERVAL, alpha=[odd]),
    "refine options": lambda odd: toonkit.refine(NORMALS, LIGHT, INTERVAL, options=[odd]),
    "refine guess": lambda odd: toonkit.refine(NORMALS, LIGHT, INTERVAL, guess=[odd]),
    "refine progress": lambda odd: toonkit.refine(NORMALS, LIGHT, INTERVAL, progress=[odd]),
    "RefinementOptions": lambda odd: RefinementOptions(margin=[odd]),
    "relight": lambda odd: toonkit.relight(odd, LIGHT),
    "relight light": lambda odd: toonkit.relight(ANALYSIS, odd),
    "relight detail": lambda odd: toonkit.relight(ANALYSIS, LIGHT, keep_detail=odd),
    "relight color": lambda odd: toonkit.relight(ANALYSIS, LIGHT, light_color=odd),
    "relight ambient": lambda odd: toonkit.relight(ANALYSIS, LIGHT, ambient=[odd]),
    "relight palette": lambda odd: toonkit.relight(ANALYSIS, LIGHT, palette=[odd]),
    "relight flat": lambda odd: toonkit.relight(ANALYSIS, LIGHT, flat_shading=[odd]),
    "relight_response": lambda odd: toonkit.relight_response(PICTURE, PICTURE, odd, PICTURE),
    "shade": lambda odd: toonkit.shade(NORMALS, LIGHT, odd),
    "ToonAnalysis image": lambda odd: ToonAnalysis(odd, "m", LIGHT, NORMALS, NORMALS, ANALYSIS.materials),
    "ToonAnalysis light": lambda odd: ToonAnalysis(PICTURE, "m", odd, NORMALS, NORMALS, ANALYSIS.materials),
    "ToonAnalysis normals": lambda odd: ToonAnalysis(PICTURE, "m", LIGHT, odd, odd, ANALYSIS.materials),
    "ToonAnalysis materials": lambda odd: ToonAnalysis(PICTURE, "m", LIGHT, NORMALS, NORMALS, odd),
    "ToonImage": lambda odd: ToonImage(odd, MASK),
    "ToonImage mask": lambda odd: ToonImage(PICTURE.color, odd),
    "ToonImage alpha": lambda odd: ToonImage(PICTURE.color, MASK, alpha=[odd]),
    "analysis_report": analysis_report,
    "contact_sheet": contact_sheet,
    "contact_sheet lights": lambda odd: contact_sheet(ANALYSIS, [odd]),
    "decode_normal_map": lambda odd: decode_normal_map(odd, MASK),
    "decode_normal_map mask": lambda odd: decode_normal_map(encode_normal_map(NORMALS), odd),
    "encode_normal_map": encode_normal_map,
    "encode_normal_map bits": lambda odd: encode_normal_map(NORMALS, bits=[odd]),
    "label_picture": label_picture,
    "line_art": line_art,
    "load_analysis": load_analysis,
    "read_color_map": read_color_map,
    "make_folder": lambda odd: make_folder([odd]),
}
WRITERS: dict[str, tuple[Callable[..., object], object, str]] = {
    "save_analysis": (save_analysis, ANALYSIS, ".npz"),
    "write_analysis_folder": (write_analysis_folder, ANALYSIS, ""),
    "write_color_map": (write_color_map, RAMP, ".json"),
    "write_color_maps": (write_color_maps, ANALYSIS.materials, ".json"),
    "write_normal_map": (write_normal_map, NORMALS, ".png"),
    "write_orbit": (write_orbit, ANALYSIS, ".gif"),
    "write_picture": (write_picture, PICTURE, ".png"),
    "write_report": (write_report, {}, ".json"),
}


@pytest.mark.parametrize("odd", ODD, ids=lambda odd: repr(odd)[:20])
@pytest.mark.parametrize("function", ONE_ARGUMENT.values(), ids=ONE_ARGUMENT)
def test_an_argument_of_the_wrong_kind_is_refused(function, odd):
    with pytest.raises(ToonkitError, match=r"; got "):
        function(odd)


@pytest.mark.parametrize("odd", [None, 5, object(), {1}], ids=lambda odd: type(odd).__name__)
@pytest.mark.parametrize("name", [name for name in WRITERS if name != "write_report"])
def test_what_cannot_be_written_is_refused_and_leaves_no_file(name, odd, tmp_path):
    write, _, suffix = WRITERS[name]
    with pytest.raises(ToonkitError, match=r"; got "):
        write(odd, tmp_path / f"file{suffix}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "path", [None, 5, b"file.png", "nul\0.png", "\ud800.png", "n" * 300 + ".png", []], ids=ascii
)
@pytest.mark.parametrize("name", WRITERS)
def test_a_path_that_names_no_file_is_refused(name, path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write, value, suffix = WRITERS[name]
    if isinstance(path, str):
        path = path.removesuffix(".png") + suffix
    with pytest.raises(ToonkitError, match=r"; got "):
        write(value, path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("report", [{"a": object()}, {(1, 2): 3}])
def test_a_report_that_json_cannot_hold_is_refused(report, tmp_path):
    with pytest.raises(ToonkitError, match="report must hold what JSON can"):
        write_report(report, tmp_path / "report.json")


def test_a_file_object_that_is_closed_is_refused(tmp_path):
    write_picture(PICTURE, tmp_path / "picture.png")
    with (tmp_path / "picture.png").open("rb") as closed:
        pass
    for arguments in ({"source": closed}, {"source": np.ones((8, 8, 3)), "mask": closed}):
        with pytest.raises(ToonkitError, match=r"must be a readable file; got .*closed"):
            toonkit.load_image(**arguments)


@pytest.mark.parametrize("shape", [(0, 0), (0, 0, 3), (0, 8, 4), (8, 0, 3), (8, 8, 0)])
def test_a_picture_without_pixels_is_refused(shape, tmp_path):
    with pytest.raises(ToonkitError, match="source must be"):
        toonkit.load_image(np.zeros(shape, np.uint8))
    with pytest.raises(ToonkitError, match="picture must"):
        write_picture(np.zeros(shape, np.uint8), tmp_path / "picture.png")


@pytest.mark.parametrize("number", [np.int8, np.uint8, np.float16, np.float32, np.float64, int, float])
def test_a_light_is_the_same_whatever_type_its_angles_have(number):
    assert np.array_equal(toonkit.light_direction(number(100), number(45)), toonkit.light_direction(100, 45))
    assert np.array_equal(toonkit.light_direction(number(100), number(0)), toonkit.light_direction(100, 0))


@pytest.mark.parametrize("azimuth", [10**30, -(10**300), 1e300, np.longdouble(1e300)])
def test_a_light_may_have_turned_many_times(azimuth):
    assert np.linalg.norm(toonkit.light_direction(azimuth, 30)) == pytest.approx(1)


@pytest.mark.parametrize("angle", [10**400, np.inf, np.nan, np.longdouble("1e4000"), "45", None, 1j])
def test_an_angle_that_is_no_finite_number_is_refused(angle):
    for angles in ((angle, 45), (45, angle)):
        with pytest.raises(ToonkitError, match=r"(azimuth|elevation) must be a finite number of degrees"):
            toonkit.light_direction(*angles)


def test_labels_beyond_whole_numbers_of_64_bits_are_refused():
    labels = np.full(MASK.shape, 2**64 - 1, np.uint64)
    with pytest.raises(ToonkitError, match="materials must be numbers from 0 on"):
        toonkit.analyze(PICTURE, LIGHT, materials=labels)


@pytest.mark.parametrize("labels", [1, 2**40])
def test_materials_whose_labels_name_no_color_map_are_refused(labels):
    with pytest.raises(ToonkitError, match="labels must lie in -1 to 0"):
        Materials(np.full((4, 4), labels), (np.zeros((1, 3)),), np.zeros(1, bool))


def test_vectors_whose_squares_are_beyond_floats_are_refused():
    with pytest.raises(ToonkitError, match="vectors must have unit length"):
        NormalField(np.full((*MASK.shape, 3), 1e300), MASK)
    with pytest.raises(ToonkitError, match="light must be a unit vector"):
        LightEstimate(np.full(3, 1e300), 0.5)


def test_a_color_outside_the_scale_has_no_illumination():
    with pytest.raises(ToonkitError, match=r"color must be sRGB in \[0, 1\]; got -1 to 0.5"):
        RAMP.invert([0.5, 0.5, -1.0])


def test_a_domain_that_rounding_would_lose_is_refused():
    with pytest.raises(ToonkitError, match="domain must be at least 1e-09 wide"):
        ColorMap([[0, 0, 0], [1, 1, 1]], (0.0, 1e-300))


def test_an_illumination_that_no_light_makes_is_refused():
    with pytest.raises(ToonkitError, match=r"illumination must lie in \[-1, 1\] on the object; got 1e\+308"):
        toonkit.illumination_error(np.full(MASK.shape, 1e308), np.zeros(MASK.shape), MASK)

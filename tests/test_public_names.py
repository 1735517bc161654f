"""What people type: files by name, lights as two angles, and errors that say what to pass instead."""

import numpy as np
import pytest
from PIL import Image

import toonkit
from tests.analytic import LIGHT, SOFT, ellipse, painted
from toonkit import METHODS, ToonkitError, analyze, angular_error, load_analysis, relight
from toonkit._validation import describe_value
from toonkit.model.normals import decode_normal_map
from toonkit.samples import sample_path

ANGLES = (130, 50)
"""`LIGHT` in degrees."""


@pytest.fixture(scope="module")
def analysis():
    egg = ellipse(40, 24)
    return analyze(painted(egg.normals, SOFT, alpha=egg.coverage), LIGHT)


def test_an_analysis_is_saved_and_loaded(analysis, tmp_path):
    analysis.save(tmp_path / "egg.npz")
    found = load_analysis(tmp_path / "egg.npz")
    assert repr(found) == repr(analysis)
    assert np.nanmax(angular_error(found.normals, analysis.normals).map) < 0.01  # as archives round


def test_a_relit_picture_is_saved_with_its_outline(analysis, tmp_path):
    relit = relight(analysis, (30, 50))
    relit.save(tmp_path / "relit.png")
    with Image.open(tmp_path / "relit.png") as found:
        assert np.array_equal(np.asarray(found), relit.to_rgba())


@pytest.mark.parametrize("name", ["picture", "base_color", "image"])
def test_every_picture_of_an_analysis_can_be_saved(analysis, tmp_path, name):
    getattr(analysis, name).save(tmp_path / "picture.webp")
    assert (tmp_path / "picture.webp").stat().st_size > 0


@pytest.mark.parametrize("green", ["opengl", "directx"])
def test_normals_are_saved_as_a_normal_map(analysis, tmp_path, green):
    analysis.normals.save(tmp_path / "normals.png", green=green)
    with Image.open(tmp_path / "normals.png") as found:
        read = decode_normal_map(np.asarray(found), analysis.image.mask, green=green)
    assert toonkit.angular_error(read, analysis.normals).map[analysis.image.mask].max() < 0.6


def test_only_what_is_estimated_has_an_estimate(analysis):
    assert analysis.light_estimate is None
    found = analyze(analysis.image, method="lumo")
    assert isinstance(found.light_estimate, toonkit.LightEstimate)
    assert 0 <= found.light_estimate.confidence <= 1
    assert np.allclose(found.light_estimate.light, found.light, atol=1e-15)


def test_two_angles_are_a_light_wherever_one_is_taken(analysis):
    normals, interval = analysis.normals, analysis.intervals()
    pairs = [
        (toonkit.illumination(normals, LIGHT), toonkit.illumination(normals, ANGLES)),
        (toonkit.shade(normals, LIGHT, SOFT).color, toonkit.shade(normals, ANGLES, SOFT).color),
        (relight(analysis, LIGHT).color, relight(analysis, ANGLES).color),
        (
            toonkit.refine(normals, LIGHT, interval).normals.vectors,
            toonkit.refine(normals, ANGLES, interval).normals.vectors,
        ),
    ]
    assert [np.array_equal(one, other, equal_nan=True) for one, other in pairs] == [True] * len(pairs)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_takes_two_angles_and_an_earlier_analysis(analysis, method):
    found = METHODS[method](analysis.drawing, ANGLES, previous=analysis)
    assert (found.light == LIGHT).all()
    again = analyze(analysis.image, (125, 50), method=method, previous=found)
    assert again.method == method


def test_the_materials_of_one_analysis_serve_another(analysis):
    labels = np.indices(analysis.image.shape)[1] // 40
    first = analyze(analysis.image, LIGHT, method="lumo", materials=labels)
    second = analyze(analysis.image, ANGLES, method="lumo", materials=first.materials)
    assert second.materials.count == first.materials.count > 1
    assert np.array_equal(second.materials.labels, first.materials.labels)


def leaning(drawing, light, *, previous=None, progress=None):
    """A method of one's own: the inflated normals, and the color maps that fit them."""
    normals = drawing.initial_normals
    materials = toonkit.fit_color_maps(drawing, toonkit.illumination(normals, light))
    return toonkit.ToonAnalysis(drawing, "leaning", light, normals, normals, materials)


def test_a_method_of_ones_own_is_analyzed_and_relit_like_the_others(analysis, monkeypatch):
    labels = np.indices(analysis.image.shape)[1] // 40
    monkeypatch.setitem(METHODS, "leaning", leaning)
    ours = analyze(analysis.image, ANGLES, method="leaning", materials=labels)
    theirs = analyze(analysis.image, ANGLES, method="lumo", materials=labels)
    assert repr(ours) == repr(theirs).replace("lumo", "leaning")
    apart = np.abs(relight(ours, (30, 50)).pixels - relight(theirs, (30, 50)).pixels)
    assert (apart > 1 / 255).mean() < 1e-3  # our methods round their normals
    assert analyze(analysis.image, (125, 50), method="leaning", previous=ours).method == "leaning"


def test_one_color_map_paints_the_whole_object(analysis):
    normals = analysis.normals
    found = toonkit.ToonAnalysis(analysis.drawing, "mine", LIGHT, normals, normals, SOFT)
    assert found.color_map is SOFT
    assert np.array_equal(found.materials.labels >= 0, analysis.image.mask)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda a: toonkit.estimate_light("cat.png"),
            r"image must be a ToonImage \(pass toonkit.load_image\(path\).*got 'cat.png'",
        ),
        (
            lambda a: toonkit.find_materials(a.image.color),
            r"ToonImage\(color, mask\)\); got an array of shape \(89, 89, 3\), float64",
        ),
        (
            lambda a: relight("cat.png", (30, 50)),
            r"analysis must be a ToonAnalysis \(pass toonkit.analyze\(image\), or .*'cat.png'",
        ),
        (
            toonkit.height_map,
            r"normals must be a NormalField \(.*or analysis.normals\); got ToonAnalysis",
        ),
        (
            lambda a: toonkit.shade(a.normals, LIGHT, [[0, 0, 0], [1, 1, 1]]),
            r"color_map must be a ColorMap \(pass toonkit.ColorMap\(colors\)",
        ),
        (
            lambda a: toonkit.height_mesh(a.normals),
            r"field must be a HeightField \(pass toonkit.height_map\(normals\)\)",
        ),
        (
            lambda a: toonkit.refine(a.normals, LIGHT, (0, 1)),
            r"interval must be an IlluminationInterval \(pass toonkit.illumination_interval",
        ),
        (
            lambda a: analyze(a.image, method="Tood"),
            r"method must be one of toonkit, .*; got 'Tood'; did you mean 'todo'\?",
        ),
        (lambda a: analyze(a.image, method="best"), r"got 'best'$"),
        (lambda a: analyze(a.image, method=["todo"]), r"method must be one of .*; got \['todo'\]$"),
        (
            lambda a: analyze(a.image, method=METHODS["todo"]),
            r'METHODS\["name"\] = function adds a method; got the function todo',
        ),
        (
            lambda a: toonkit.ToonAnalysis(a.image, "mine", LIGHT, a.normals, a.normals, [SOFT]),
            r"materials must be a Materials \(pass toonkit.fit_color_maps",
        ),
        (
            lambda a: toonkit.extract_color_map(a.image, np.zeros(a.image.shape, np.uint8)),
            r"stroke must be a \(H, W\) bool array, such as array > 0; got an array of shape .*uint8",
        ),
        (
            lambda a: relight(a, toonkit.LightEstimate(LIGHT, 0.5)),
            r"new_light must be .*; got LightEstimate \(pass its .light\)",
        ),
        (lambda a: toonkit.inflate(a.image), r"mask must be .*, such as image.mask; got ToonImage"),
        (
            lambda a: toonkit.ToonImage("cat.png", a.image.mask),
            r"color must hold real numbers; got 'cat.png'",
        ),
        (
            lambda a: toonkit.height_mesh(toonkit.height_map(a.normals), color="cat.png"),
            "color must be a ToonImage",
        ),
        (
            lambda a: toonkit.refine(a.normals, LIGHT, a.intervals(), options={"margin": 0.1}),
            r"options must be a RefinementOptions \(pass .*\); got dict",
        ),
        (lambda a: sample_path("kat"), r"got 'kat'; did you mean 'cat'\?"),
        (lambda a: a.image.save("relit.jpg"), r"path must end in .png or .webp; got relit.jpg"),
        (lambda a: a.save("egg.zip"), r"path must end in .npz; got egg.zip"),
    ],
)
def test_an_error_says_what_to_pass_instead(analysis, call, message):
    with pytest.raises(ToonkitError, match=message):
        call(analysis)


@pytest.mark.parametrize("light", ["130,50", 130, [1, 2, 3, 4], [[1], [1, 2]], None, np.ones((2, 2)), {}])
def test_a_light_of_another_form_is_told_both_forms(analysis, light):
    with pytest.raises(
        ToonkitError, match=r"direction \(x, y, z\), or an azimuth and elevation .*light_direction\("
    ):
        relight(analysis, light)


def test_an_elevation_in_the_place_of_the_azimuth_is_refused_as_one(analysis):
    with pytest.raises(ToonkitError, match="elevation must lie in -90 to 90 degrees"):
        relight(analysis, (50, 130))


@pytest.mark.parametrize("value", ["a" * 1000, list(range(1000)), (0.5,) * 1000, np.ones((500, 500))])
def test_a_message_repeats_no_long_value(value):
    assert len(describe_value(value)) < 70

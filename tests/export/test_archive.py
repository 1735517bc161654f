"""An analysis comes back from its archive, of which only the normals are rounded, and nothing else is taken for one."""

import zipfile
from dataclasses import replace

import numpy as np
import pytest

from toonkit import ToonImage, ToonkitError, analyze, light_direction, relight
from toonkit.export.archive import FORMAT_VERSION, load_analysis, save_analysis
from toonkit.metrics import angular_error
from toonkit.samples import sample_path
from toonkit.synthetic.drawing import draw_scene

PIXELS = 1264
"""Of the ball."""

TURNED = 0.01
"""Degrees that an archive may turn a normal by."""


def same_picture(found, expected):
    """Tell whether two pictures are equal but for what normals so little turned can change: a step of 8 bits."""
    found, expected = found.to_rgba().astype(int), expected.to_rgba().astype(int)
    return np.array_equal(found[..., 3], expected[..., 3]) and np.abs(found - expected).max() <= 1


@pytest.fixture
def saved(analysis, tmp_path):
    path = tmp_path / "analysis.npz"
    save_analysis(analysis, path)
    return path


def test_every_array_but_the_normals_is_read_back_to_the_last_bit(analysis, saved):
    found = load_analysis(saved)
    for name in ("color", "mask", "alpha", "fringe"):
        assert np.array_equal(
            getattr(found.image, name), getattr(analysis.image, name), equal_nan=name in ("color", "fringe")
        )
    assert np.array_equal(found.light, analysis.light)
    assert np.array_equal(found.color_map.colors, analysis.color_map.colors)
    assert np.array_equal(found.report.energies, analysis.report.energies)


def test_normals_are_read_back_to_a_hundredth_of_a_degree(analysis, saved):
    found = load_analysis(saved)
    for name in ("normals", "initial_normals"):
        error = angular_error(getattr(found, name), getattr(analysis, name))
        assert 0 < np.nanmax(error.map) < TURNED


@pytest.mark.parametrize("levels", [255, 65535])
def test_inflated_normals_and_colors_of_any_depth_are_read_back_to_the_last_bit(several, tmp_path, levels):
    image = several.image
    deeper = ToonImage(np.round(image.color * levels) / levels, image.mask, alpha=image.alpha)
    analyzed = analyze(deeper, several.light, materials=several.materials.labels)
    save_analysis(analyzed, tmp_path / "analysis.npz")
    found = load_analysis(tmp_path / "analysis.npz")
    assert np.array_equal(found.image.color, deeper.color, equal_nan=True)
    assert np.array_equal(found.initial_normals.compact, analyzed.initial_normals.compact)


def test_an_archive_has_at_most_eight_bytes_a_pixel_of_the_object(tmp_path):
    analyzed = analyze(sample_path("cat"), (130, 42))
    save_analysis(analyzed, tmp_path / "analysis.npz")
    assert (tmp_path / "analysis.npz").stat().st_size <= 8 * analyzed.image.mask.sum()


def test_everything_else_is_read_back(analysis, saved):
    found = load_analysis(saved)
    assert found.method == analysis.method
    assert found.color_map.domain == analysis.color_map.domain
    for name in ("iterations", "reason", "converged"):
        assert getattr(found.report, name) == getattr(analysis.report, name)
        assert type(getattr(found.report, name)) is type(getattr(analysis.report, name))


def test_a_reloaded_analysis_relights_to_the_same_picture(analysis, saved):
    light = (0.6, 0, 0.8)
    assert same_picture(relight(load_analysis(saved), light), relight(analysis, light))


def test_a_reloaded_analysis_relights_to_its_drawing_at_its_own_light(several, tmp_path):
    save_analysis(several, tmp_path / "analysis.npz")
    read = load_analysis(tmp_path / "analysis.npz")
    assert np.array_equal(relight(read, read.light).to_rgba(), several.image.to_rgba())


@pytest.fixture(scope="module")
def found():
    """An inked drawing whose materials toonkit found by itself."""
    scene = draw_scene(2, size=64)
    return analyze(scene.image, scene.light)


@pytest.fixture(params=["several", "found"])
def in_materials(request):
    return request.getfixturevalue(request.param)


def test_several_materials_are_read_back_to_the_last_bit(in_materials, tmp_path):
    save_analysis(in_materials, tmp_path / "analysis.npz")
    materials, read = in_materials.materials, load_analysis(tmp_path / "analysis.npz").materials
    assert read.count == materials.count > 2
    assert np.array_equal(read.labels, materials.labels)
    assert read.labels.dtype == materials.labels.dtype
    assert np.array_equal(read.flat, materials.flat)
    assert all(map(np.array_equal, read.tones, materials.tones))
    assert all(map(np.array_equal, *([m.colors for m in each.color_maps] for each in (read, materials))))
    assert [m.domain for m in read.color_maps] == [m.domain for m in materials.color_maps]


def test_reloaded_materials_and_ink_make_the_same_pictures(in_materials, tmp_path):
    save_analysis(in_materials, tmp_path / "analysis.npz")
    read = load_analysis(tmp_path / "analysis.npz")
    assert in_materials.drawing.ink.coverage.any()
    assert same_picture(read.base_color, in_materials.base_color)
    assert same_picture(read.picture, in_materials.picture)
    light = light_direction(-30, 30)
    assert same_picture(relight(read, light), relight(in_materials, light))


def test_the_confidence_in_an_estimated_light_is_read_back(several, tmp_path):
    save_analysis(several, tmp_path / "analysis.npz")
    estimate = load_analysis(tmp_path / "analysis.npz").light_estimate
    assert estimate.confidence == several.light_estimate.confidence


def as_version_2(path, analysis):
    """Write an archive of version 3 anew with the numbers of version 2, and return these."""
    image = analysis.image
    with np.load(path) as archive:
        fields = {name: archive[name] for name in archive if not name.startswith("soft")}
    fields |= {
        "format_version": np.array(2),
        "alpha": image.alpha,
        "color": image.color[image.mask],
        "fringe": image.fringe_colors,
        "normals": analysis.normals.compact,
        "initial_normals": analysis.initial_normals.compact,
        "material_labels": analysis.materials.labels[image.mask].astype(np.int32),
    }
    np.savez(path, **fields)
    return fields


def test_an_archive_of_version_2_is_read_back_to_the_last_bit(several, tmp_path):
    path = tmp_path / "analysis.npz"
    save_analysis(several, path)
    as_version_2(path, several)
    read = load_analysis(path)
    assert np.array_equal(read.image.to_rgba(), several.image.to_rgba())
    for name in ("normals", "initial_normals"):
        assert np.array_equal(getattr(read, name).compact, getattr(several, name).compact)
    light = light_direction(-30, 30)
    assert np.array_equal(relight(read, light).to_rgba(), relight(several, light).to_rgba())


def test_an_archive_of_version_1_is_one_material(analysis, saved):
    fields = as_version_2(saved, analysis)
    fields = {name: value for name, value in fields.items() if not name.startswith(("material", "color_map"))}
    fields["format_version"] = np.array(1)
    fields["color_map_colors"] = analysis.color_map.colors
    fields["color_map_domain"] = np.array(analysis.color_map.domain)
    np.savez(saved, **fields)
    read = load_analysis(saved)
    assert read.materials.count == 1
    assert read.color_map.domain == analysis.color_map.domain
    light = light_direction(-30, 30)
    assert np.array_equal(relight(read, light).to_rgba(), relight(analysis, light).to_rgba())


def test_an_archive_holds_no_pickle(saved):
    with np.load(saved, allow_pickle=False) as archive:
        assert all(array.dtype != object for array in archive.values())


def test_any_text_in_a_report_survives(analysis, tmp_path):
    odd = replace(
        analysis, report=replace(analysis.report, reason='ΔE < 10⁻⁶ "so" \'s', energies=np.array([]))
    )
    save_analysis(odd, tmp_path / "odd.npz")
    found = load_analysis(tmp_path / "odd.npz").report
    assert found.reason == odd.report.reason
    assert found.energies.shape == (0,)


def _changed(path, **changes):
    with np.load(path) as archive:
        fields = dict(archive.items())
    fields.update(changes)
    np.savez(path, **{name: value for name, value in fields.items() if value is not None})


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"format_version": FORMAT_VERSION + 1}, f"must be of version {FORMAT_VERSION} .*of version 4"),
        ({"format_version": np.array([1, 1])}, "must be of version"),
        ({"format_version": "1; text"}, "must be of version"),
        ({"format_version": None}, "must be an archive of an analysis; got .* which holds"),
        ({"normals": None}, "must be a complete archive"),
        ({"normals": np.zeros((3, 3))}, "complete archive .*normals are not two 16-bit numbers"),
        ({"normals": np.zeros((3, 2), np.uint16)}, "must be a complete archive"),
        ({"soft_places": np.array([48 * 48])}, "must be a complete archive"),
        ({"soft_places": np.array([0.5])}, "must be a complete archive"),
        ({"soft_alpha": np.zeros(3)}, "must be a complete archive"),
        ({"mask": np.zeros((48, 48), dtype=bool)}, "must be a complete archive"),
        ({"color": np.array("text")}, "must be a complete archive"),
        ({"material_labels": None}, "must be a complete archive"),
        ({"material_labels": np.array(0)}, "complete archive .*labels are not one integer for each pixel"),
        (
            {"material_labels": np.zeros(7, int)},
            "complete archive .*labels are not one integer for each pixel",
        ),
        (
            {"material_labels": np.zeros(PIXELS)},
            "complete archive .*labels are not one integer for each pixel",
        ),
        ({"material_labels": np.full(PIXELS, 1)}, "complete archive .*labels are not numbers from 0 to 0"),
        ({"material_labels": np.full(PIXELS, -1)}, "complete archive .*labels are not numbers from 0 to 0"),
        ({"material_flat": np.zeros((1, 1), bool)}, "complete archive .*which materials are flat"),
        ({"material_flat": np.zeros(2, bool)}, "complete archive .*colors are not those of its materials"),
        ({"material_tone_counts": np.array([3])}, "complete archive .*colors are not those of its materials"),
        ({"color_map_counts": np.array([16.0])}, "complete archive .*colors are not those of its materials"),
        (
            {"color_map_counts": np.array([17, -1])},
            "complete archive .*colors are not those of its materials",
        ),
        ({"color_map_domains": np.zeros((0, 2))}, "must be a complete archive"),
        ({"color_map_domains": np.array([[1.0, -1.0]])}, "must be a complete archive .*lo < hi"),
        ({"method": np.array([{"a": 1}], dtype=object)}, "must be an undamaged archive .*allow_pickle"),
    ],
)
def test_another_archive_is_refused(saved, changes, reason):
    _changed(saved, **changes)
    with pytest.raises(ToonkitError, match=reason):
        load_analysis(saved)


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda data: data[: len(data) // 2], id="cut off"),
        pytest.param(lambda data: data[:300] + bytes(200) + data[500:], id="overwritten"),
        pytest.param(lambda data: b"text", id="text"),
        pytest.param(lambda data: b"", id="empty"),
    ],
)
def test_a_damaged_archive_is_refused(saved, damage):
    saved.write_bytes(damage(saved.read_bytes()))
    with pytest.raises(ToonkitError, match=r"undamaged archive|complete archive"):
        load_analysis(saved)


def test_a_bare_array_and_a_foreign_zip_are_refused(tmp_path):
    np.save(tmp_path / "array.npy", np.zeros(3))
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("note.txt", "hello")
    for name in ("array.npy", "other.zip"):
        with pytest.raises(ToonkitError, match="archive of an analysis"):
            load_analysis(tmp_path / name)


def test_a_missing_archive_is_refused(tmp_path):
    with pytest.raises(ToonkitError, match="which is not a file"):
        load_analysis(tmp_path / "nowhere.npz")


def test_an_archive_is_named_npz(analysis, tmp_path):
    with pytest.raises(ToonkitError, match=r"must end in \.npz"):
        save_analysis(analysis, tmp_path / "analysis.zip")

"""An analysis comes back from its archive bit for bit, and nothing else is taken for one."""

import zipfile
from dataclasses import replace

import numpy as np
import pytest

from toonkit import ToonkitError, analyze, light_direction, relight
from toonkit.export.archive import FORMAT_VERSION, load_analysis, save_analysis
from toonkit.synthetic.drawing import draw_scene

PIXELS = 1264
"""Of the ball."""


@pytest.fixture
def saved(analysis, tmp_path):
    path = tmp_path / "analysis.npz"
    save_analysis(analysis, path)
    return path


def test_every_array_is_read_back_to_the_last_bit(analysis, saved):
    found = load_analysis(saved)
    for name in ("color", "mask", "alpha", "fringe"):
        assert np.array_equal(
            getattr(found.image, name), getattr(analysis.image, name), equal_nan=name in ("color", "fringe")
        )
    assert np.array_equal(found.light, analysis.light)
    assert np.array_equal(found.normals.vectors, analysis.normals.vectors, equal_nan=True)
    assert np.array_equal(found.initial_normals.vectors, analysis.initial_normals.vectors, equal_nan=True)
    assert np.array_equal(found.color_map.colors, analysis.color_map.colors)
    assert np.array_equal(found.report.energies, analysis.report.energies)


def test_everything_else_is_read_back(analysis, saved):
    found = load_analysis(saved)
    assert found.method == analysis.method
    assert found.color_map.domain == analysis.color_map.domain
    for name in ("iterations", "reason", "converged"):
        assert getattr(found.report, name) == getattr(analysis.report, name)
        assert type(getattr(found.report, name)) is type(getattr(analysis.report, name))


def test_a_reloaded_analysis_relights_to_the_same_picture(analysis, saved):
    light = (0.6, 0, 0.8)
    assert np.array_equal(relight(load_analysis(saved), light).to_rgba(), relight(analysis, light).to_rgba())


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
    assert np.array_equal(read.base_color.to_rgba(), in_materials.base_color.to_rgba())
    assert np.array_equal(read.picture.to_rgba(), in_materials.picture.to_rgba())
    light = light_direction(-30, 30)
    assert np.array_equal(relight(read, light).to_rgba(), relight(in_materials, light).to_rgba())


def test_the_confidence_in_an_estimated_light_is_read_back(several, tmp_path):
    save_analysis(several, tmp_path / "analysis.npz")
    estimate = load_analysis(tmp_path / "analysis.npz").light_estimate
    assert estimate.confidence == several.light_estimate.confidence


def test_an_archive_of_version_1_is_one_material(analysis, saved):
    with np.load(saved) as archive:
        fields = {name: archive[name] for name in archive if not name.startswith(("material", "color_map"))}
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
        ({"format_version": FORMAT_VERSION + 1}, f"must be of version {FORMAT_VERSION} .*of version 3"),
        ({"format_version": np.array([1, 1])}, "must be of version"),
        ({"format_version": "1; text"}, "must be of version"),
        ({"format_version": None}, "must be an archive of an analysis; got .* which holds"),
        ({"normals": None}, "must be a complete archive"),
        ({"normals": np.zeros((3, 3))}, "must be a complete archive"),
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

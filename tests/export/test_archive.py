"""An analysis comes back from its archive, of which only the normals are rounded, and nothing else is taken for one."""

import tracemalloc
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from toonkit import ToonImage, ToonkitError, analyze, light_direction, relight
from toonkit.cli import main
from toonkit.export.archive import FORMAT_VERSION, load_analysis, save_analysis
from toonkit.metrics import angular_error
from toonkit.samples import sample_path
from toonkit.synthetic.drawing import draw_scene

PIXELS = 1264
"""Of the ball."""

TURNED = 0.01
"""Degrees that an archive may turn a normal by."""


def same_picture(found, expected):
    """Tell whether pictures are equal but for what normals turned by 0.01° change: a step of 8 bits, more at a hard edge."""
    found, expected = found.to_rgba().astype(int), expected.to_rgba().astype(int)
    apart = np.abs(found - expected).max(axis=-1)
    return np.array_equal(found[..., 3], expected[..., 3]) and (apart > 1).mean() < 1e-3


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


def test_the_normals_of_an_analysis_are_as_its_archive_holds_them(several, tmp_path):
    analyzed = analyze(several.image, (130, 45))
    analyzed.save(tmp_path / "analysis.npz")
    found = load_analysis(tmp_path / "analysis.npz")
    assert np.array_equal(found.normals.compact, analyzed.normals.compact)
    assert np.array_equal(relight(found, (20, 30)).pixels, relight(analyzed, (20, 30)).pixels)


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
    relit = relight(read, read.light)
    assert np.abs(relit.color - several.image.color)[several.image.mask].max() < 1e-12
    assert np.abs(relit.fringe_colors - several.image.fringe_colors).max() < 1e-12


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


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"alpha": np.full((48, 48), np.nan)}, r"alpha must lie in \[0, 1\]|fringe must have shape"),
        ({"alpha": np.zeros((48, 47))}, r"alpha must have shape \(48, 48\)"),
        ({"normals": np.full((PIXELS, 3), np.nan)}, "vectors must be finite"),
        ({"normals": np.zeros((PIXELS, 2), np.uint16)}, "normals must be floats"),
        ({"initial_normals": np.zeros((PIXELS, 3))}, "vectors must have unit length"),
        ({"initial_normals": None}, "must hold initial_normals"),
    ],
)
def test_the_numbers_of_version_2_are_checked(analysis, saved, changes, reason):
    as_version_2(saved, analysis)
    _changed(saved, **changes)
    with pytest.raises(ToonkitError, match=f"complete archive .*({reason})"):
        load_analysis(saved)


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
        (
            {"format_version": FORMAT_VERSION + 1},
            f"must be of version {FORMAT_VERSION} .*of version {FORMAT_VERSION + 1}",
        ),
        ({"format_version": np.array([1, 1])}, "must be of version"),
        ({"format_version": "1; text"}, "must be of version"),
        ({"format_version": None}, "must be an archive of an analysis; got .* which holds"),
        ({"normals": None}, "must be a complete archive"),
        ({"normals": np.zeros((PIXELS, 3))}, "complete archive .*normals must be integers without sign"),
        (
            {"normals": np.zeros((PIXELS, 2), np.uint8)},
            "complete archive .*normals must have 16 bits a number",
        ),
        (
            {"normals": np.zeros((3, 2), np.uint16)},
            rf"complete archive .*normals must have shape \({PIXELS}, 2\)",
        ),
        ({"soft_places": None}, "complete archive .*must hold soft_places"),
        ({"soft_places": np.array([48 * 48])}, "complete archive .*soft_places must ascend from 0 to 2,303"),
        ({"soft_places": np.array([-1, 3])}, "complete archive .*soft_places must ascend from 0 to 2,303"),
        ({"soft_places": np.array([3, 3])}, "complete archive .*soft_places must ascend from 0 to 2,303"),
        ({"soft_places": np.array([0.5])}, "complete archive .*soft_places must be integers"),
        (
            {"soft_places": np.zeros(48 * 48 + 1, int)},
            "complete archive .*soft_places must have at most 2,304 entries",
        ),
        ({"soft_alpha": np.zeros(3)}, r"complete archive .*soft_alpha must have shape"),
        (
            {"soft_places": np.array([0]), "soft_alpha": np.array([2.0])},
            r"complete archive .*(alpha must lie in \[0, 1\]|fringe must have shape)",
        ),
        (
            {"soft_places": np.array([0]), "soft_alpha": np.array([np.nan])},
            r"complete archive .*(alpha must lie in \[0, 1\]|fringe must have shape)",
        ),
        ({"fringe": np.zeros((7, 3), np.uint8)}, "complete archive .*fringe must have shape"),
        ({"color": np.zeros((PIXELS, 3), np.int8)}, "complete archive .*color must be floats, or integers"),
        ({"mask": np.zeros((48, 48), dtype=bool)}, "must be a complete archive"),
        ({"color": np.array("text")}, "must be a complete archive"),
        ({"material_labels": None}, "must be a complete archive"),
        (
            {"material_labels": np.array(0)},
            rf"complete archive .*material_labels must have shape \({PIXELS}\)",
        ),
        (
            {"material_labels": np.zeros(7, int)},
            rf"complete archive .*material_labels must have shape \({PIXELS}\)",
        ),
        (
            {"material_labels": np.zeros(PIXELS)},
            "complete archive .*material_labels must be integers; got float64",
        ),
        ({"material_labels": np.full(PIXELS, 1)}, "complete archive .*labels must lie in -1 to 0"),
        ({"material_labels": np.full(PIXELS, -1)}, "complete archive .*material_labels must be known"),
        (
            {"material_flat": np.zeros((1, 1), bool)},
            r"complete archive .*material_flat must have shape \(any\)",
        ),
        ({"material_flat": np.zeros(2, bool)}, r"complete archive .*tone_counts must have shape \(2\)"),
        (
            {"material_tone_counts": np.array([3])},
            r"complete archive .*material_tones must have shape \(3, 3\)",
        ),
        ({"color_map_counts": np.array([16.0])}, "complete archive .*color_map_counts must be integers"),
        (
            {"color_map_counts": np.array([17, -1])},
            r"complete archive .*color_map_counts must have shape \(1\)",
        ),
        ({"color_map_domains": np.zeros((0, 2))}, "must be a complete archive"),
        ({"color_map_domains": np.array([[1.0, -1.0]])}, "must be a complete archive .*lo < hi"),
        ({"color_map_counts": np.array([-1])}, "complete archive .*color_map_colors must be 1 to"),
        ({"color_map_counts": np.array([2**62])}, "complete archive .*color_map_colors must be 1 to"),
        ({"light": np.array(1.0)}, r"complete archive .*light must have shape \(3\); got \(\)"),
        ({"light": np.zeros(2)}, r"complete archive .*light must have shape \(3\); got \(2,\)"),
        ({"light": np.full(3, np.nan)}, "complete archive .*light must be a unit vector"),
        ({"light": np.array([0, 0, -1.0])}, "complete archive .*light must be a unit vector"),
        ({"light": np.full(3, 1e300)}, "complete archive .*light must be a unit vector"),
        ({"light": np.array([0, 0, 1], np.longdouble)}, "complete archive .*light must have at most 64 bits"),
        ({"light_confidence": np.array(2.0)}, "complete archive .*confidence must be a number from 0 to 1"),
        ({"light_confidence": np.array([0.5])}, r"complete archive .*light_confidence must have shape \(\)"),
        ({"color": np.full((PIXELS, 3), np.nan)}, "complete archive .*color must be painted"),
        ({"color": np.full((PIXELS, 3), 2.0)}, r"complete archive .*color must be sRGB in \[0, 1\]"),
        ({"initial_normals": np.zeros((PIXELS, 3))}, "complete archive .*initial_normals must be integers"),
        ({"material_tones": np.full((2, 3), np.nan)}, "complete archive .*tones must be"),
        ({"material_flat": np.zeros(0, bool)}, "complete archive"),
        ({"report_iterations": np.array(-1)}, "complete archive .*report_iterations must be a number >= 0"),
        ({"report_energies": np.array([np.nan])}, "complete archive .*report_energies must be finite"),
        ({"report_energies": np.zeros(2_000_000)}, "complete archive .*energies must have at most 1,000,000"),
        ({"report_reason": np.array("x" * 20_000)}, "complete archive .*reason must have at most 10,000"),
        ({"report_converged": np.array(1)}, "complete archive .*report_converged must be bool"),
        (
            {"method": np.array([{"a": 1}], dtype=object)},
            "complete archive .*method must be text; got object",
        ),
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


def _put(path, name, content, *, compression=zipfile.ZIP_DEFLATED):
    """Replace a member of an archive, or add one."""
    with zipfile.ZipFile(path) as archive:
        members = {member.filename: archive.read(member) for member in archive.infolist()}
    members[name] = content
    with zipfile.ZipFile(path, "w", compression) as archive:
        for member, data in members.items():
            archive.writestr(member, data)


def _array_file(descr: str, shape: str, content: bytes = b"") -> bytes:
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}".encode() + b"\n"
    return b"\x93NUMPY\x02\x00" + len(header).to_bytes(4, "little") + header + content


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (_array_file("'<f8'", "(3,)"), "light must be complete; got 0 of 24 bytes"),
        (_array_file("'<f8'", "(3,)", bytes(32)), "light must have 24 bytes; got more"),
        (_array_file("'<f8'", "(100000000000,)"), r"light must have shape \(3\)"),
        (_array_file("'<f100000000'", "(3,)"), "light must be (of a type that NumPy knows|floats)"),
        (_array_file("'<U100000000'", "()"), "light must be floats"),
        (_array_file("'<f8'", "(" * 400 + "3" + ")" * 400), "light must be an array of plain numbers"),
        (_array_file("[" * 400 + "]" * 400, "()"), "light must be an array of plain numbers"),
        (_array_file("'<f8'", "(" + "1, " * 400 + ")"), "light must be described in 1024 bytes"),
        (
            _array_file("'|O'", "(3,)", b"cos\nsystem\n"),
            "light must be an array of plain numbers|must be floats",
        ),
        (b"\x93NUMPY\x01\x00\xff", "light must be"),
        (b"", "light must be an array; got something else"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_an_array_says_of_itself_is_checked_before_it_is_read(saved, content, reason):
    _put(saved, "light.npy", content)
    with pytest.raises(ToonkitError, match=f"complete archive .*{reason}"):
        load_analysis(saved)


def test_a_text_of_billions_of_characters_is_not_read(saved):
    _put(saved, "method.npy", _array_file("'<U100000000'", "()"))
    with pytest.raises(ToonkitError, match="method must have at most 10,000 entries"):
        load_analysis(saved)


@pytest.mark.parametrize("code", [b"\x00\xd8\x00\x00", b"\xff\xff\xff\x7f"])
def test_a_text_that_is_no_unicode_is_refused(saved, code):
    _put(saved, "method.npy", _array_file("'<U1'", "()", code))
    with pytest.raises(ToonkitError, match="method must be text"):
        load_analysis(saved)


def test_a_bool_of_other_bytes_than_0_and_1_is_refused(saved):
    _put(saved, "mask.npy", _array_file("'|b1'", "(48, 48)", b"\x02" * 48 * 48))
    with pytest.raises(ToonkitError, match="mask must be True or False; got other bytes"):
        load_analysis(saved)


def test_a_mask_larger_than_any_picture_is_not_read(saved):
    _put(saved, "mask.npy", _array_file("'|b1'", "(100000, 100000)"))
    with pytest.raises(ToonkitError, match="mask must have at most 67,108,864 entries"):
        load_analysis(saved)


def test_an_array_of_the_other_byte_order_or_by_columns_is_read(analysis, saved):
    before = load_analysis(saved)
    with np.load(saved) as archive:
        normals, places = archive["normals"].astype(">u2"), archive["soft_places"].astype(">i8")
        color = np.asfortranarray(archive["color"])
    _changed(saved, light=analysis.light.astype(">f8"), normals=normals, soft_places=places, color=color)
    found = load_analysis(saved)
    assert np.array_equal(found.light, analysis.light)
    assert np.array_equal(found.image.to_rgba(), analysis.image.to_rgba())
    assert np.array_equal(found.normals.compact, before.normals.compact)


def test_what_an_archive_holds_beside_its_arrays_is_not_read(analysis, saved):
    with zipfile.ZipFile(saved, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("bomb.npy", "w") as file:
        file.write(np.lib.format.magic(1, 0))
        for _ in range(64):
            file.write(bytes(1 << 20))
    tracemalloc.start()
    assert load_analysis(saved).method == analysis.method
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 32 << 20


@pytest.mark.parametrize("compression", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_another_compression_than_numpys_is_refused(saved, compression):
    _put(saved, "extra.npy", b"", compression=compression)
    with pytest.raises(ToonkitError, match="must be stored or deflated; got compression"):
        load_analysis(saved)


def _with_directory_field(path, offset, value):
    """Change 16 bits of each entry of a zip file's directory."""
    data = bytearray(path.read_bytes())
    at = data.find(b"PK\x01\x02")
    while at >= 0:
        data[at + offset : at + offset + 2] = value.to_bytes(2, "little")
        at = data.find(b"PK\x01\x02", at + 1)
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("offset", "value", "reason"),
    [(8, 1, "must not be encrypted"), (10, 99, "must be stored or deflated; got compression 99")],
)
def test_an_encrypted_archive_and_an_unknown_compression_are_refused(saved, offset, value, reason):
    _with_directory_field(saved, offset, value)
    with pytest.raises(ToonkitError, match=reason):
        load_analysis(saved)


def test_a_refused_archive_is_one_line_of_the_command_line(saved, capsys):
    _changed(saved, light=np.zeros(2))
    assert main(["relight", str(saved), "--light", "30,50", "-o", str(saved.with_name("relit.png"))]) == 2
    said = capsys.readouterr().err
    assert said.startswith("toonkit: error: path must be a complete archive")
    assert said.count("\n") == 1

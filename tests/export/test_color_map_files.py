"""Color maps come back from JSON exactly, and from a strip as well as eight bits allow."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from toonkit import ColorMap, ToonkitError
from toonkit.export.color_map import STRIP_SIZE, read_color_map, write_color_map, write_color_maps


def test_json_holds_a_color_map_to_the_last_bit(tmp_path):
    levels = np.sort(np.random.default_rng(0).random(9))
    color_map = ColorMap(np.repeat(levels[:, None], 3, axis=1), (-1 / 3, 0.7))
    write_color_map(color_map, tmp_path / "map.json")
    found = read_color_map(tmp_path / "map.json")
    assert np.array_equal(found.colors, color_map.colors)
    assert found.domain == color_map.domain


def test_json_says_what_it_is(analysis, tmp_path):
    write_color_map(analysis.color_map, tmp_path / "map.json")
    content = json.loads((tmp_path / "map.json").read_text())
    assert content["format"] == "toonkit color map"
    assert content["encoding"] == "sRGB, 0 to 1"
    assert content["domain"] == [-0.7, 0.9]
    assert len(content["colors"]) == 16


def test_a_strip_is_what_a_shader_reads_at_half_plus_half_the_illumination(analysis, tmp_path):
    write_color_map(analysis.color_map, tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as strip:
        pixels = np.asarray(strip)
    assert pixels.shape == (*STRIP_SIZE, 3)
    assert (pixels == pixels[:1]).all()
    value = np.linspace(-1, 1, STRIP_SIZE[1])
    assert pixels[0] / 255 == pytest.approx(analysis.color_map(value), abs=0.5 / 255 + 1e-12)


def test_a_strip_is_read_back_within_its_rounding(analysis, tmp_path):
    write_color_map(analysis.color_map, tmp_path / "map.png")
    found = read_color_map(tmp_path / "map.png")
    value = np.linspace(-1, 1, 300)
    # Half an 8-bit step, and where a band of the map begins between two columns, a share of the step's slope.
    slope = np.abs(np.diff(analysis.color_map.colors, axis=0)).max() / (1.6 / 15)
    assert np.abs(found(value) - analysis.color_map(value)).max() < 0.5 / 255 + slope * (2 / 511) / 4 + 1e-9


def test_a_strip_painted_by_anyone_is_a_color_map(tmp_path):
    Image.fromarray(np.repeat(np.arange(0, 250, 10, dtype=np.uint8)[None], 5, axis=0)).save(
        tmp_path / "ramp.png"
    )
    found = read_color_map(tmp_path / "ramp.png")
    assert found.domain == (-1, 1)
    assert found(1) == pytest.approx([240 / 255] * 3)


def test_color_maps_are_listed_by_area_with_all_that_there_is_to_a_material(several, tmp_path):
    write_color_maps(several.materials, tmp_path / "maps.json")
    content = json.loads((tmp_path / "maps.json").read_text())
    assert content["format"] == "toonkit color maps"
    listed = content["color_maps"]
    assert [each["label"] for each in listed] == [0, 1, 2]
    assert [each["flat"] for each in listed] == [False, False, True]
    shares = [each["share"] for each in listed]
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) == pytest.approx(1)
    for each, color_map in zip(listed, several.materials.color_maps, strict=True):
        assert np.array_equal(each["colors"], color_map.colors)
        assert tuple(each["domain"]) == color_map.domain


def test_the_largest_material_comes_first_whatever_its_number(several, tmp_path):
    materials = several.materials
    turned = replace(
        materials,
        labels=np.where(materials.labels < 0, -1, 2 - materials.labels),
        tones=materials.tones[::-1],
        flat=materials.flat[::-1],
        color_maps=materials.color_maps[::-1],
    )
    write_color_maps(turned, tmp_path / "turned.json")
    listed = json.loads((tmp_path / "turned.json").read_text())["color_maps"]
    assert [each["label"] for each in listed] == [2, 1, 0]
    for name, which in (("maps.png", materials), ("turned.png", turned)):
        write_color_maps(which, tmp_path / name)
    assert (tmp_path / "maps.png").read_bytes() == (tmp_path / "turned.png").read_bytes()


def test_strips_of_several_materials_are_those_of_each_in_one_picture(several, tmp_path):
    write_color_maps(several.materials, tmp_path / "maps.png")
    with Image.open(tmp_path / "maps.png") as strips:
        found = np.split(np.asarray(strips), several.materials.count)
    for color_map, strip in zip(several.materials.color_maps, found, strict=True):
        write_color_map(color_map, tmp_path / "map.png")
        with Image.open(tmp_path / "map.png") as expected:
            assert np.array_equal(strip, np.asarray(expected))


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("map.json", "{", "must hold JSON"),
        ("map.json", "\xff", "must hold JSON"),
        ("map.json", "[1, 2]", "must be a color map written by toonkit"),
        (
            "map.json",
            '{"format": "toonkit color map", "version": 99}',
            "must be of version 1; got .* version 99",
        ),
        ("map.json", '{"format": "toonkit color map", "version": 1}', "must hold colors and a domain"),
        (
            "map.json",
            '{"format": "toonkit color map", "version": 1, "domain": [1, -1], "colors": [[0, 0, 0]]}',
            "must hold colors and a domain .*lo < hi",
        ),
        (
            "map.json",
            '{"format": "toonkit color maps", "version": 1}',
            "must be a color map written by toonkit",
        ),
        ("map.txt", "", r"must end in \.png or \.json"),
        ("map.png", "no picture", "must be a PNG"),
    ],
)
def test_what_is_no_color_map_is_refused(tmp_path, name, content, reason):
    (tmp_path / name).write_text(content, encoding="latin-1")
    with pytest.raises(ToonkitError, match=f"path {reason}".replace("domain .*", "domain; got .*")):
        read_color_map(tmp_path / name)


@pytest.mark.parametrize("height", [1, 2, 3])
def test_a_strip_may_have_as_few_rows_as_one(tmp_path, height):
    ramp = np.linspace(0, 255, 64).astype(np.uint8)
    Image.fromarray(np.broadcast_to(ramp[:, None], (height, 64, 3)).copy()).save(tmp_path / "ramp.png")
    assert read_color_map(tmp_path / "ramp.png").colors[:, 1] == pytest.approx(ramp / 255)


def test_nested_json_is_refused(tmp_path):
    (tmp_path / "map.json").write_text("[" * 200_000)
    with pytest.raises(ToonkitError, match="path must hold JSON"):
        read_color_map(tmp_path / "map.json")


def test_a_missing_color_map_is_refused(tmp_path):
    with pytest.raises(ToonkitError, match="must be an existing file"):
        read_color_map(tmp_path / "nowhere.json")

"""Layered files give their merged picture, and line art and materials from their layers."""

from __future__ import annotations

import io
import time
import zipfile

import numpy as np
import pytest

from tests.model.layered_files import (
    Made,
    kra_members,
    merged,
    ora_members,
    png,
    psd_file,
    write_layered,
    zip_file,
)
from toonkit import ToonkitError, ToonkitWarning, analyze, load_image, load_layers
from toonkit.model.documents import roles

SHAPE = (90, 110)
KINDS = ["psd", "ora", "kra", "folder"]

ROWS, COLUMNS = np.indices(SHAPE)
HEAD = np.hypot(ROWS - 44, COLUMNS - 54) < 40
HAIR = HEAD & (ROWS < 34)
RING = HEAD & (np.hypot(ROWS - 44, COLUMNS - 54) > 37.5)
SKIN, RED, BLACK = (240, 200, 170), (180, 40, 50), (20, 16, 24)


def paint(*parts):
    """RGBA pixels in which each part (where, color) is opaque."""
    pixels = np.zeros((*SHAPE, 4), np.uint8)
    for where, color in parts:
        pixels[where] = (*color, 255)
    return pixels


FLATS = paint((HEAD, SKIN), (HAIR, RED))
SHADOW = paint((HEAD & (COLUMNS > 60), (150, 130, 190)))
LINES = paint((RING, BLACK))
CHARACTER = (Made("Flats", FLATS), Made("Shading", SHADOW, blend="multiply"), Made("Line art", LINES))


@pytest.fixture(params=KINDS)
def path(request, tmp_path):
    layers = CHARACTER
    if request.param == "folder":  # which has no blend modes
        layers = (CHARACTER[0], Made("Shading", paint((HAIR, (120, 20, 40)))), CHARACTER[2])
    return write_layered(request.param, layers, SHAPE, tmp_path)


def test_the_merged_picture_is_read(path):
    image = load_image(path)
    assert np.array_equal(image.mask, HEAD)
    assert np.abs(image.color[RING] * 255 - BLACK).max() < 1.5
    assert np.abs(image.color[60, 40] * 255 - SKIN).max() < 1.5


def test_ink_and_materials_are_from_the_layers(path):
    drawing = load_layers(path)
    assert np.array_equal(drawing.ink, RING)
    assert np.array_equal(drawing.materials, np.where(HAIR, 1, np.where(HEAD, 0, -1)))
    assert len(drawing.ink_layers) == len(drawing.flats_layers) == 1
    assert "2 materials from" in repr(drawing)


def test_an_analysis_of_the_file_has_them(path):
    analysis = analyze(path, (130, 45), method="lumo")
    assert (analysis.drawing.ink_coverage[RING] >= 0.5).all()
    assert np.array_equal(analysis.materials.labels, np.where(HAIR, 1, np.where(HEAD, 0, -1)))


def test_what_is_given_goes_before_the_layers(path):
    nothing = np.zeros(SHAPE, bool)
    analysis = analyze(path, (130, 45), method="lumo", ink=nothing, materials=np.where(HEAD, 0, -1))
    assert not analysis.drawing.ink_coverage.any()
    assert analysis.materials.count == 1


@pytest.mark.parametrize("kind", KINDS)
def test_an_open_file_is_read_as_its_path(kind, tmp_path):
    path = write_layered(kind, CHARACTER[::2], SHAPE, tmp_path)
    if path.is_dir():
        return
    with path.open("rb") as file:
        assert np.array_equal(load_layers(file).ink, RING)


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
def test_layers_lie_where_their_offsets_say_and_are_cut_at_the_canvas(kind, tmp_path):
    corner = np.full((40, 30, 4), (*BLACK, 255), np.uint8)
    layers = (Made("flats", FLATS), Made("ink", corner[:, :3], place=(30, 40)), Made("ink", corner, (70, 95)))
    ink = load_layers(write_layered(kind, layers[:2], SHAPE, tmp_path)).ink
    assert np.array_equal(ink, HEAD & (ROWS >= 30) & (ROWS < 70) & (COLUMNS >= 40) & (COLUMNS < 43))


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
def test_the_name_of_a_group_counts_for_its_layers(kind, tmp_path):
    layers = (Made("Face", FLATS, group="FLATS"), Made("Left", LINES, group="Lineart"))
    drawing = load_layers(write_layered(kind, layers, SHAPE, tmp_path))
    assert (drawing.ink_layers, drawing.flats_layers) == (("Left",), ("Face",))


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
def test_layers_of_any_name_are_taken_on_demand(kind, tmp_path):
    layers = (Made("Ebene 1", FLATS), Made("Ebene 2", SHADOW, blend="multiply"), Made("Kontur", LINES))
    path = write_layered(kind, layers, SHAPE, tmp_path)
    drawing = load_layers(path, ink_layer="kontur", flats_layer=["Ebene 1"])
    assert np.array_equal(drawing.ink, RING)
    assert drawing.materials.max() == 1
    with pytest.raises(ToonkitError, match=r"ink_layer must be the name of a layer.*'Ink'; it has Ebene 1"):
        load_layers(path, ink_layer="Ink")


def test_without_names_dark_thin_lines_on_top_are_ink(tmp_path):
    layers = (Made("Layer 1", FLATS), Made("Layer 2", SHADOW, blend="multiply"), Made("Layer 3", LINES))
    drawing = load_layers(write_layered("ora", layers, SHAPE, tmp_path))
    assert np.array_equal(drawing.ink, RING)
    assert drawing.materials is None


@pytest.mark.parametrize(
    "top", [SHADOW, paint((RING, (230, 220, 200))), paint((HEAD, BLACK))], ids=["shadow", "pale", "wide"]
)
def test_without_names_other_layers_on_top_are_no_ink(tmp_path, top):
    layers = (Made("Layer 1", FLATS), Made("Layer 2", top))
    assert load_layers(write_layered("ora", layers, SHAPE, tmp_path)).ink is None


def test_hidden_layers_hold_no_ink_but_may_hold_flats(tmp_path):
    layers = (Made("paint", FLATS), Made("flats", FLATS, visible=False), Made("ink", LINES, visible=False))
    drawing = load_layers(write_layered("psd", layers, SHAPE, tmp_path))
    assert drawing.ink is None
    assert drawing.materials.max() == 1


def test_ink_that_another_layer_hides_is_left_out(tmp_path):
    layers = (Made("flats", FLATS), Made("ink", LINES), Made("Hair", paint((HAIR, RED))))
    assert np.array_equal(load_layers(write_layered("psd", layers, SHAPE, tmp_path)).ink, RING & ~HAIR)


@pytest.mark.parametrize("blend", ["multiply", "normal"])
def test_ink_on_paper_counts_where_it_is_dark(tmp_path, blend):
    scan = paint((HEAD, (255, 255, 255)), (RING, BLACK))
    colors = Made("flats", FLATS, opacity=120)
    layers = (
        (Made("lines", scan), colors) if blend == "normal" else (colors, Made("lines", scan, blend=blend))
    )
    ink = load_layers(write_layered("ora", layers, SHAPE, tmp_path), flats_layer=()).ink
    assert np.array_equal(ink, RING)


def test_soft_borders_of_flats_belong_to_the_nearest_area(tmp_path):
    soft = FLATS.astype(float)
    for row, share in ((32, 0.25), (33, 0.5), (34, 0.75)):  # along a slope, so that mixtures vary
        mixed = np.array(RED) * (1 - share) + np.array(SKIN) * share + (COLUMNS[row, :, None] % 40)
        soft[row, HEAD[row], :3] = np.minimum(mixed, 255)[HEAD[row]]
    layers = (Made("flats", soft.astype(np.uint8)), Made("ink", LINES))
    labels = load_layers(write_layered("ora", layers, SHAPE, tmp_path)).materials
    assert labels.max() == 1
    assert (labels[HEAD & (ROWS < 32)] == 1).all()
    assert (labels[HEAD & (ROWS > 34)] == 0).all()
    assert (labels[HEAD] >= 0).all()


def test_a_flats_layer_with_a_gradient_is_no_label_map(tmp_path):
    shaded = FLATS.copy()
    shaded[..., 0] = (ROWS * 2).astype(np.uint8)
    shaded[..., 1] = (COLUMNS * 2).astype(np.uint8)
    path = write_layered("ora", (Made("flats", shaded), Made("ink", LINES)), SHAPE, tmp_path)
    with pytest.warns(ToonkitWarning, match="the layer flats is not flat"):
        assert load_layers(path).materials is None
    with pytest.raises(ToonkitError, match="flats_layer must hold flat colors"):
        load_layers(path, flats_layer="flats")


def test_the_names_of_layers_come_with_layers(tmp_path):
    (tmp_path / "plain.png").write_bytes(png(FLATS))
    assert load_layers(tmp_path / "plain.png").ink is None
    with pytest.raises(ToonkitError, match="ink_layer must come with a layered document"):
        load_layers(tmp_path / "plain.png", ink_layer="ink")


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_file_cut_off_is_refused(kind, share, tmp_path):
    path = write_layered(kind, CHARACTER, SHAPE, tmp_path)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ToonkitError, match="undamaged"):
        load_layers(path)


@pytest.mark.parametrize("kind", ["psd", "ora", "kra"])
def test_flipped_bytes_are_refused_or_read(kind, tmp_path):
    path = write_layered(kind, CHARACTER, SHAPE, tmp_path)
    content, random = path.read_bytes(), np.random.default_rng(5)
    for _ in range(60):
        damaged = bytearray(content)
        for at in random.integers(0, len(content), 4):
            damaged[at] = random.integers(256)
        try:
            load_layers(io.BytesIO(bytes(damaged)))
        except ToonkitError:
            continue


def bomb(members, name, size):
    """An archive whose member of a name is a long row of zeros."""
    return zip_file({**members, name: bytes(size)}, packed=zipfile.ZIP_DEFLATED)


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (
            lambda: bomb(ora_members(CHARACTER, SHAPE), "mergedimage.png", 2**28),
            "mergedimage.png has at most",
        ),
        (lambda: bomb(ora_members(CHARACTER, SHAPE), "data/2.png", 2**28), "data/2.png has at most"),
        (lambda: bomb(ora_members(CHARACTER, SHAPE), "stack.xml", 2**28), "stack.xml has at most"),
        (lambda: bomb(kra_members(CHARACTER, SHAPE), "cat/layers/layer2", 2**28), "layer2 has at most"),
        (lambda: b"8BPS\0\1" + bytes(7) + b"\3\0\1\0\0\0\1\0\0\0\10\0\3", "at most 8192 x 8192"),
        (lambda: b"8BPS\0\1" + bytes(6) + b"\0\4\0\0\0\77\0\0\0\77\0\10\0\4", "must be RGB or grayscale"),
        (
            lambda: zip_file({"mimetype": "image/openraster", "stack.xml": "<image w='99999' h='99999'/>"}),
            "at most 8192 x 8192",
        ),
        (
            lambda: zip_file(
                {"mimetype": "image/openraster", "stack.xml": "<!DOCTYPE a [<!ENTITY b 'c'>]><image/>"}
            ),
            "declares entities",
        ),
        (
            lambda: zip_file(
                {
                    "mimetype": "image/openraster",
                    "stack.xml": f"<image w='9' h='9'>{'<stack>' * 20000}{'</stack>' * 20000}</image>",
                }
            ),
            "reasonable depth",
        ),
        (lambda: zip_file({"mimetype": "application/x-krita"}), "maindoc.xml is missing"),
    ],
)
def test_bombs_and_nonsense_are_refused_at_once(content, rule):
    file = io.BytesIO(content())
    start = time.perf_counter()
    with pytest.raises(ToonkitError, match=rule):
        load_layers(file)
    assert time.perf_counter() - start < 5


def test_a_document_without_its_merged_picture_says_how_to_get_one(tmp_path):
    members = ora_members(CHARACTER, SHAPE)
    del members["mergedimage.png"]
    with pytest.raises(ToonkitError, match="must hold its merged picture"):
        load_image(io.BytesIO(zip_file(members)))


def test_layers_that_are_too_much_together_are_refused(monkeypatch):
    monkeypatch.setattr(roles, "MOST_PIXELS", 5_000)
    with pytest.raises(ToonkitError, match="source must have layers of at most"):
        load_layers(io.BytesIO(zip_file(ora_members(CHARACTER, SHAPE))))


def test_transparent_colors_of_a_photoshop_document_are_not_mixed_with_white(tmp_path):
    soft = FLATS.copy()
    soft[..., 3] = np.where(HEAD, np.where(COLUMNS < 30, 200, 255), 0)
    image = load_image(io.BytesIO(psd_file((Made("paint", soft),), SHAPE)))
    assert np.array_equal(np.round(image.alpha * 255), soft[..., 3])
    assert np.abs(image.color[HEAD] * 255 - soft[HEAD][:, :3]).max() <= 1.5


@pytest.mark.parametrize(
    ("names", "rule"),
    [
        (["a.png", "b.png"], "must be a folder of layers"),
        ([], "must be a folder of layers"),
        (["lines.png", "analysis.npz"], "must be a folder of layers"),
    ],
)
def test_a_folder_that_says_nothing_of_layers_is_refused(tmp_path, names, rule):
    for name in names:
        (tmp_path / name).write_bytes(png(FLATS))
    with pytest.raises(ToonkitError, match=rule):
        load_layers(tmp_path)


def test_a_folder_of_two_sizes_is_refused(tmp_path):
    (tmp_path / "flats.png").write_bytes(png(FLATS))
    (tmp_path / "lines.png").write_bytes(png(LINES[1:]))
    with pytest.raises(ToonkitError, match=r"layers of one size; got .*lines\.png of 110 x 89"):
        load_layers(tmp_path)


def test_a_merged_picture_in_a_folder_is_the_drawing(tmp_path):
    shown = merged(CHARACTER, SHAPE)
    for name, pixels in (("merged", shown), ("10_lines", LINES), ("9_flats", FLATS)):
        (tmp_path / f"{name}.png").write_bytes(png(pixels))
    drawing = load_layers(tmp_path)
    assert np.array_equal(drawing.image.to_rgba(), shown)
    assert (drawing.ink_layers, drawing.flats_layers) == (("10_lines",), ("9_flats",))

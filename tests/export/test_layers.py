"""A relit picture comes apart into layers, and together again, in memory and through every file."""

import io
import json
import sys
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from toonkit import ToonImage, ToonkitError, analyze, relight, samples
from toonkit.export.layer_files import write_layers
from toonkit.export.layers import KINDS, Layers, split_layers

LIGHTS = [(135, 40), (30, 50), (250, 10), (0, 90), (60, -30), (0, -90)]


def difference(found, expected):
    """The largest difference of two RGBA pictures where anything is to be seen, in steps of 8 bits."""
    shown = expected[..., 3] > 0
    assert (found[~shown] == 0).all()
    return int(np.abs(found[shown].astype(int) - expected[shown]).max())


def draw_as_sprites(parts, background):
    """Draw (blend, RGBA) from the bottom up onto an opaque gray, as an engine draws sprites; it returns RGB."""
    color = np.full((*parts[0][1].shape[:2], 3), background)
    for blend, pixels in parts:
        own, share = pixels[..., :3] / 255, pixels[..., 3:] / 255
        blended = {"normal": own, "multiply": color * own, "add": np.minimum(color + own, 1)}[blend]
        color = color + share * (blended - color)
    return np.round(color * 255).astype(int)


def sprite_difference(parts, expected):
    """The largest difference between layers and a picture, both drawn as sprites, in steps of 8 bits."""
    grounds = (0.0, 0.5, 1.0)
    return max(
        int(np.abs(draw_as_sprites(parts, ground) - draw_as_sprites([("normal", expected)], ground)).max())
        for ground in grounds
    )


@pytest.fixture(scope="module")
def highlit():
    """A ball in two materials, with a highlight on the flat one."""
    y, x = (39.5 - np.indices((80, 80))[0]) / 36, (np.indices((80, 80))[1] - 39.5) / 36
    alpha = np.clip(36 * (1 - np.hypot(x, y)) + 0.5, 0, 1)
    lit = -0.5 * x + 0.6 * y + 0.6 * np.sqrt(np.clip(1 - x**2 - y**2, 0, None))
    color = np.where((lit > 0.3)[..., None], [0.8, 0.3, 0.3], [0.5, 0.15, 0.25])
    color[np.hypot(x, y) < 0.5] = [0.3, 0.3, 0.8]
    color[np.hypot(x + 0.2, y - 0.2) < 0.16] = 1.0
    return analyze(ToonImage(color, alpha >= 0.5, alpha=alpha), (130, 42))


@pytest.fixture(scope="module")
def translucent(several):
    """The drawing in several materials, half transparent on its left."""
    image = several.image
    alpha = image.alpha * np.where(np.arange(image.shape[1]) < 40, 0.6, 1.0)
    faded = ToonImage(image.color, image.mask, alpha=alpha, fringe=image.fringe)
    return analyze(faded, several.light, materials=several.materials.labels)


@pytest.fixture(params=["analysis", "several", "highlit", "translucent"])
def drawing(request):
    return request.getfixturevalue(request.param)


@pytest.mark.parametrize("light", LIGHTS)
def test_layers_compose_to_the_relit_picture(drawing, light):
    layers = split_layers(drawing, light)
    expected = relight(drawing, light).to_rgba()
    assert np.array_equal(layers.picture, expected)
    assert difference(layers.compose(), expected) <= 1


@pytest.mark.parametrize("light", LIGHTS)
def test_layers_drawn_as_sprites_make_the_picture_on_any_background(drawing, light):
    layers = split_layers(drawing, light)
    parts = [(kind.blend, pixels) for _, kind, pixels in layers]
    assert sprite_difference(parts, layers.picture) <= 1


@pytest.mark.parametrize("options", [{"keep_detail": False}, {"flat_shading": 0.0}])
def test_layers_compose_whatever_the_options(several, options):
    layers = split_layers(several, (30, 50), **options)
    assert difference(layers.compose(), relight(several, (30, 50), **options).to_rgba()) <= 1


@pytest.mark.parametrize("name", ["cat", "fish"])
def test_layers_of_a_sample_compose(name):
    analysis = analyze(str(samples.sample_path(name)), (130, 42))
    layers = split_layers(analysis, (300, 20))
    assert difference(layers.compose(), layers.picture) <= 1


def test_the_base_color_is_that_of_the_analysis_away_from_ink(several):
    layers = split_layers(several, (30, 50))
    clean = (layers.picture[..., 3] == 255) & (several.drawing.ink_coverage == 0)
    assert np.array_equal(layers.base_color[clean], several.base_color.to_rgba()[clean])


def test_shadow_never_brightens_and_is_empty_where_nothing_is_darker(several):
    layers = split_layers(several, (30, 50))
    acting = layers.shadow[..., 3] > 0
    assert 0 < acting.sum() < (layers.picture[..., 3] > 0).sum()
    assert (layers.shadow[acting, :3] < 255).any(axis=1).all()
    assert (layers.shadow[~acting] == (255, 255, 255, 0)).all()


def test_ink_lies_where_the_drawing_has_ink_whatever_the_light(several):
    inked = several.drawing.ink_coverage > 0
    opaque = several.image.to_rgba()[..., 3] == 255
    assert (inked & opaque).any()
    for light in LIGHTS:
        found = split_layers(several, light).ink[..., 3] > 0
        assert np.array_equal(found & opaque, inked & opaque)


def test_the_soft_outline_of_a_drawing_in_ink_belongs_to_the_ink(several):
    layers = split_layers(several, (30, 50))
    soft = (layers.picture[..., 3] > 0) & (layers.picture[..., 3] < 255)
    assert soft.any()
    assert np.array_equal(layers.ink[soft], layers.picture[soft])
    assert (layers.base_color[soft, 3] == 0).all()


def test_the_soft_outline_of_a_drawing_without_ink_belongs_to_the_base_color(analysis):
    layers = split_layers(analysis, (30, 50))
    soft = (layers.picture[..., 3] > 0) & (layers.picture[..., 3] < 255)
    assert soft.any()
    assert np.array_equal(layers.base_color[soft], layers.picture[soft])
    assert (layers.ink == 0).all()


def test_a_highlight_is_a_layer_of_its_own_and_fades_as_the_light_turns(highlit):
    spot = np.zeros(highlit.image.mask.size, bool)
    lit = highlit.drawing.mixed.pixels[highlit.drawing.mixed.highlit]
    spot[np.flatnonzero(highlit.image.mask.ravel())[lit]] = True
    assert spot.sum() > 30
    near, far = (split_layers(highlit, light).highlight for light in (highlit.light, (310, 10)))
    assert np.array_equal(near[..., 3].ravel() > 0, spot)
    assert int(far.sum()) < int(near.sum()) // 4


def test_a_layer_over_soft_edges_would_make_them_opaque_so_there_is_none(drawing):
    layers = split_layers(drawing, (30, 50))
    soft = layers.picture[..., 3] < 255
    assert soft.any()
    for key in ("shadow", "light", "highlight"):
        assert (getattr(layers, key)[soft, 3] == 0).all()


def test_engines_that_ignore_alpha_when_they_multiply_or_add_change_nothing_where_layers_do_nothing(drawing):
    layers = split_layers(drawing, (30, 50))
    assert (layers.shadow[layers.shadow[..., 3] == 0, :3] == 255).all()
    for added in (layers.light, layers.highlight):
        assert (added[added[..., 3] == 0, :3] == 0).all()


@pytest.fixture(scope="module")
def layers(several):
    return split_layers(several, (30, 50))


def test_a_folder_of_layers_says_how_it_is_composed(layers, tmp_path):
    written = write_layers(layers, tmp_path / "out")
    assert sorted(written) == sorted((tmp_path / "out").iterdir())
    description = json.loads((tmp_path / "out" / "layers.json").read_text())
    parts = [
        (entry["blend"], np.asarray(Image.open(tmp_path / "out" / entry["file"])))
        for entry in description["layers"]
    ]
    composed = np.asarray(Image.open(tmp_path / "out" / description["composed"]))
    assert [blend for blend, _ in parts] == ["normal", "multiply", "add", "add", "normal"]
    assert np.array_equal(composed, layers.picture)
    assert sprite_difference(parts, composed) <= 1


def read_open_raster(path):
    """Read an OpenRaster file as its specification says: the layers from the bottom up, and the merged picture."""
    with zipfile.ZipFile(path) as archive:
        first = archive.infolist()[0]
        assert (first.filename, first.compress_type) == ("mimetype", zipfile.ZIP_STORED)
        assert archive.read("mimetype") == b"image/openraster"

        def picture(name):
            return np.asarray(Image.open(io.BytesIO(archive.read(name))))

        image = ElementTree.fromstring(archive.read("stack.xml"))
        found = [(layer, picture(layer.get("src"))) for layer in image.iter("layer")][::-1]
        return image, found, picture("mergedimage.png"), picture("Thumbnails/thumbnail.png")


def test_an_open_raster_document_composes_to_its_merged_picture(layers, tmp_path):
    assert write_layers(layers, tmp_path / "cat.ora") == [tmp_path / "cat.ora"]
    image, found, merged, thumbnail = read_open_raster(tmp_path / "cat.ora")
    height, width = layers.picture.shape[:2]
    assert (image.tag, image.get("w"), image.get("h")) == ("image", str(width), str(height))
    assert [layer.get("name") for layer, _ in found] == [kind.name for kind in KINDS.values()]
    assert [group.get("name") for group in image.find("stack")] == ["Ink", "Color"]
    blends = {"svg:src-over": "normal", "svg:multiply": "multiply", "svg:plus": "add"}
    parts = [(blends[layer.get("composite-op")], pixels) for layer, pixels in found]
    assert np.array_equal(merged, layers.picture)
    assert sprite_difference(parts, merged) <= 1
    assert max(thumbnail.shape) <= 256


def test_an_open_raster_thumbnail_is_small(several, tmp_path):
    wide = Layers(*(np.zeros((20, 700, 4), np.uint8) for _ in range(6)))
    write_layers(wide, tmp_path / "wide.ora")
    assert read_open_raster(tmp_path / "wide.ora")[3].shape == (7, 256, 4)


@pytest.mark.parametrize("light", LIGHTS)
def test_a_photoshop_document_composes_to_the_relit_picture(several, tmp_path, light):
    psd_tools = pytest.importorskip("psd_tools")
    from psd_tools.composite import composite

    layers = split_layers(several, light)
    write_layers(layers, tmp_path / "cat.psd")
    document = psd_tools.PSDImage.open(tmp_path / "cat.psd")
    color, _, alpha = composite(document, force=True)
    found = np.round(255 * np.concatenate([color, alpha], axis=-1)).astype(np.uint8)
    found[layers.picture[..., 3] == 0] = 0
    assert difference(found, layers.picture) <= 1


def test_a_photoshop_document_has_named_groups_and_blend_modes(layers, tmp_path):
    psd_tools = pytest.importorskip("psd_tools")
    write_layers(layers, tmp_path / "cat.psd")
    document = psd_tools.PSDImage.open(tmp_path / "cat.psd")
    assert [group.name for group in document] == ["Color", "Light", "Ink"]
    found = {layer.name: (layer.parent.name, layer.blend_mode.name) for layer in document.descendants()}
    assert found["Base color"] == ("Color", "NORMAL")
    assert found["Shadow"] == ("Light", "MULTIPLY")
    assert found["Light"] == ("Light", "LINEAR_DODGE")
    assert found["Highlight"] == ("Light", "LINEAR_DODGE")
    assert found["Ink"] == ("Ink", "NORMAL")
    merged = np.asarray(document.topil())
    opaque = layers.picture[..., 3] == 255
    assert np.abs(merged[opaque].astype(int) - layers.picture[opaque]).max() <= 1


def test_without_psd_tools_the_error_says_what_to_install(layers, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "psd_tools", None)
    with pytest.raises(ToonkitError, match="pip install psd-tools"):
        write_layers(layers, tmp_path / "cat.psd")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["cat.xcf", "cat.png", "missing/cat.ora"])
def test_other_places_for_layers_are_refused(layers, tmp_path, name):
    with pytest.raises(ToonkitError, match=r"path must end in \.ora or \.psd|path must lie in an existing"):
        write_layers(layers, tmp_path / name)

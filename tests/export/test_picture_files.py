"""Pictures and normal maps come back from their files as they were."""

import imagecodecs
import numpy as np
import pytest
from PIL import Image

from toonkit import ToonkitError, load_image
from toonkit.export.normal_map import write_normal_map
from toonkit.export.picture import write_picture
from toonkit.model.normals import decode_normal_map, encode_normal_map


@pytest.mark.parametrize("suffix", [".png", ".webp", ".PNG"])
def test_a_picture_is_read_back_pixel_for_pixel(analysis, tmp_path, suffix):
    path = tmp_path / f"picture{suffix}"
    write_picture(analysis.image, path)
    with Image.open(path) as found:
        assert np.array_equal(np.asarray(found.convert("RGBA")), analysis.image.to_rgba())


def test_a_written_picture_is_loaded_as_the_image_it_was(analysis, tmp_path):
    write_picture(analysis.image, tmp_path / "picture.png")
    image = load_image(tmp_path / "picture.png")
    assert (image.mask == analysis.image.mask).all()
    assert np.nanmax(np.abs(image.color - analysis.image.color)) <= 0.5 / 255 + 1e-12


@pytest.mark.parametrize("channels", [3, 4])
def test_an_array_is_a_picture_too(tmp_path, channels):
    pixels = np.random.default_rng(3).integers(0, 256, (5, 7, channels), dtype=np.uint8)
    write_picture(pixels, tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as found:
        assert np.array_equal(np.asarray(found), pixels)


@pytest.mark.parametrize("name", ["picture.jpg", "picture", "picture.png.txt"])
def test_formats_that_lose_something_are_refused(analysis, tmp_path, name):
    with pytest.raises(ToonkitError, match=r"path must end in \.png or \.webp"):
        write_picture(analysis.image, tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("bad", [np.zeros((4, 4, 3)), np.zeros((4, 4), dtype=np.uint8), "text"])
def test_what_is_no_picture_is_not_written(tmp_path, bad):
    with pytest.raises(ToonkitError, match="picture must be a ToonImage or a uint8 array"):
        write_picture(bad, tmp_path / "picture.png")


def test_a_picture_too_wide_for_webp_is_refused_by_name(tmp_path):
    with pytest.raises(ToonkitError, match=r"must end in \.png for sides over 16383"):
        write_picture(np.zeros((3, 16384, 3), dtype=np.uint8), tmp_path / "wide.webp")


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("green", ["opengl", "directx"])
def test_a_normal_map_file_holds_the_encoded_normals(analysis, tmp_path, bits, green):
    path = tmp_path / "normals.png"
    write_normal_map(analysis.normals, path, bits=bits, green=green)
    found = imagecodecs.png_decode(path.read_bytes())
    assert found.dtype == np.dtype(f"uint{bits}")
    assert np.array_equal(found, encode_normal_map(analysis.normals, bits=bits, green=green))
    decoded = decode_normal_map(found, analysis.normals.mask, green=green)
    # sqrt(3) half steps of 2 / 255 and 2 / 65535
    assert np.nanmax(np.abs(decoded.vectors - analysis.normals.vectors)) < 1.8 / (2**bits - 1)


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("normals.jpg", {}, r"path must end in \.png"),
        ("normals.png", {"bits": 12}, "bits must be 8 or 16"),
        ("normals.png", {"green": "down"}, "green must be"),
    ],
)
def test_other_normal_maps_are_refused(analysis, tmp_path, name, options, reason):
    with pytest.raises(ToonkitError, match=reason):
        write_normal_map(analysis.normals, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())

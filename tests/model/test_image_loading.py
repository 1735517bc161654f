"""load_image: every format and array a drawing may come in, and every way it may be broken."""

import io
import re
import struct
import zlib

import imagecodecs
import numpy as np
import pytest
import tifffile
from PIL import Image, ImageCms

from toonkit import ToonkitError, load_image
from toonkit._validation import ToonkitWarning
from toonkit.model.decoding import MAX_PIXELS

HEIGHT, WIDTH = 24, 32
ROWS, COLUMNS = np.indices((HEIGHT, WIDTH))
INSIDE = (np.abs(ROWS - 11) < 8) & (np.abs(COLUMNS - 14) < 10)
EIGHT_BITS = 1 / 255
SIXTEEN_BITS = 1 / 65535


def rgba(dtype=np.uint8):
    """A gradient with something different in each corner, opaque inside and transparent around."""
    top = np.iinfo(dtype).max
    color = np.stack([COLUMNS / WIDTH, ROWS / HEIGHT, (ROWS + COLUMNS) / (WIDTH + HEIGHT), INSIDE], axis=-1)
    return np.round(color * top).astype(dtype)


def encoded(picture, kind="PNG", **options):
    image = picture if isinstance(picture, Image.Image) else Image.fromarray(picture)
    file = io.BytesIO()
    image.save(file, kind, **options)
    file.seek(0)
    return file


def png_with_size(width, height):
    """A PNG that says it has this size and holds nothing."""
    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    chunk = b"IHDR" + header
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))


# Formats


@pytest.mark.parametrize(
    ("kind", "options"), [("PNG", {}), ("WEBP", {"lossless": True, "exact": True}), ("TIFF", {})]
)
def test_alpha_is_the_mask_and_colors_are_kept(kind, options):
    image = load_image(encoded(rgba(), kind, **options))
    assert (image.mask == INSIDE).all()
    assert image.color[INSIDE] == pytest.approx(rgba()[INSIDE][:, :3] / 255, abs=1e-12)
    assert np.isnan(image.color[~INSIDE]).all()


def _deep_png(samples):
    return io.BytesIO(imagecodecs.png_encode(samples))


def _deep_tiff(samples, **options):
    file = io.BytesIO()
    tifffile.imwrite(file, samples, **{"photometric": "rgb", "extrasamples": ["unassalpha"], **options})
    file.seek(0)
    return file


@pytest.mark.parametrize("encode", [_deep_png, _deep_tiff])
def test_sixteen_bits_are_kept_to_the_last(encode):
    deep = rgba(np.uint16)
    deep[..., 0] += (COLUMNS % 7).astype(np.uint16)  # steps that eight bits cannot hold
    image = load_image(encode(deep))
    assert np.round(image.color[INSIDE] * 65535).astype(int).tolist() == deep[INSIDE][:, :3].tolist()


def test_a_sixteen_bit_gray_png_is_read_in_full():
    gray = rgba(np.uint16)[..., 0]
    image = load_image(_deep_png(np.ascontiguousarray(gray)), mask=INSIDE)
    assert image.color[INSIDE] == pytest.approx(np.repeat(gray[INSIDE][:, None], 3, 1) / 65535, abs=1e-12)


def test_a_float_tiff_is_read_in_full():
    color = np.where(INSIDE[..., None], rgba() / 255 / 3, 0).astype(np.float32)
    color[..., 3] = INSIDE
    with pytest.warns(ToonkitWarning, match="read as sRGB"):
        image = load_image(_deep_tiff(color))
    assert image.color[INSIDE] == pytest.approx(color[INSIDE][:, :3].astype(float), abs=1e-12)


def test_premultiplied_tiff_colors_are_divided_by_alpha():
    straight = np.broadcast_to([0.8, 0.4, 0.2], (HEIGHT, WIDTH, 3))
    alpha = np.where(INSIDE, 0.75, 0.0)[..., None]
    deep = np.round(np.concatenate([straight * alpha, alpha], axis=-1) * 65535).astype(np.uint16)
    image = load_image(_deep_tiff(deep, extrasamples=["assocalpha"]))
    assert image.color[INSIDE] == pytest.approx(straight[INSIDE], abs=2 * SIXTEEN_BITS)


def test_a_tiff_of_separate_planes_is_put_together():
    deep = rgba(np.uint16)
    image = load_image(_deep_tiff(np.moveaxis(deep, -1, 0), planarconfig="separate"))
    assert image.color[INSIDE] == pytest.approx(deep[INSIDE][:, :3] / 65535, abs=1e-12)


def test_a_palette_with_a_transparent_entry_has_a_mask():
    indexed = Image.fromarray(np.where(INSIDE, 1 + COLUMNS % 2, 0).astype(np.uint8))
    indexed.putpalette([255, 0, 255, 200, 100, 50, 20, 40, 60] + [0] * 759)
    for kind in ("PNG", "GIF"):
        image = load_image(encoded(indexed, kind, transparency=0))
        assert (image.mask == INSIDE).all()
        found = {tuple(color) for color in np.round(image.color[INSIDE] * 255).astype(int).tolist()}
        assert found == {(200, 100, 50), (20, 40, 60)}


def test_a_transparent_color_of_an_rgb_png_has_a_mask():
    color = np.where(INSIDE[..., None], [200, 100, 50], [255, 0, 255]).astype(np.uint8)
    assert (load_image(encoded(color, transparency=(255, 0, 255))).mask == INSIDE).all()


def test_gray_and_alpha_become_three_equal_channels():
    gray = Image.fromarray(rgba()[..., 1])
    gray.putalpha(Image.fromarray(rgba()[..., 3]))
    image = load_image(encoded(gray))
    assert (image.mask == INSIDE).all()
    assert (image.color[INSIDE] == image.color[INSIDE][:, :1]).all()


def test_of_an_animation_the_first_frame_counts():
    first, second = (Image.fromarray(np.roll(rgba(), shift, axis=0)) for shift in (0, 3))
    for kind in ("PNG", "WEBP", "GIF"):
        image = load_image(encoded(first, kind, save_all=True, append_images=[second], duration=50))
        assert (image.mask == INSIDE).all()


def test_a_jpeg_is_close_to_what_was_painted():
    flat = np.where(INSIDE[..., None], [180, 90, 60], [255, 255, 255]).astype(np.uint8)
    image = load_image(encoded(flat, "JPEG", quality=95, subsampling=0), mask=INSIDE)
    assert np.median(np.abs(image.color[INSIDE] - np.array([180, 90, 60]) / 255)) < 2 * EIGHT_BITS


def test_a_cmyk_jpeg_is_converted():
    flat = Image.fromarray(np.full((HEIGHT, WIDTH, 3), (200, 80, 60), dtype=np.uint8)).convert("CMYK")
    image = load_image(encoded(flat, "JPEG", quality=95), mask=INSIDE)
    # 3 steps: quantization of four inks
    assert image.color[INSIDE].mean(axis=0) == pytest.approx(
        np.array([200, 80, 60]) / 255, abs=3 * EIGHT_BITS
    )


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["PNG", "TIFF", "WEBP"])
def test_a_picture_is_turned_upright(orientation, kind):
    upright = rgba()
    # What a camera stores for this tag so that the viewer's turn gives `upright`.
    stored = {
        1: upright,
        2: upright[:, ::-1],
        3: upright[::-1, ::-1],
        4: upright[::-1],
        5: upright.swapaxes(0, 1),
        6: np.rot90(upright, 1),
        7: np.rot90(upright.swapaxes(0, 1), 2),
        8: np.rot90(upright, -1),
    }[orientation]
    exif = Image.Exif()
    exif[274] = orientation
    options = {"lossless": True, "exact": True} if kind == "WEBP" else {}
    image = load_image(encoded(np.ascontiguousarray(stored), kind, exif=exif, **options))
    assert (image.mask == INSIDE).all()
    assert image.color[INSIDE] == pytest.approx(upright[INSIDE][:, :3] / 255)


def test_a_deep_tiff_is_turned_upright():
    stored = np.ascontiguousarray(np.rot90(rgba(np.uint16)))
    file = _deep_tiff(stored, extratags=[(274, "H", 1, 6, True)])
    assert (load_image(file).mask == INSIDE).all()


SRGB_PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def _profile_with_red_and_blue_exchanged():
    """The sRGB profile with the directory entries of two primaries renamed, and another description."""
    renamed = {b"rXYZ": b"bXYZ", b"bXYZ": b"rXYZ"}
    profile = re.sub(b"[rb]XYZ", lambda found: renamed[found[0]], SRGB_PROFILE)
    return profile.replace("sRGB".encode("utf-16-be"), "swap".encode("utf-16-be"))


@pytest.mark.parametrize("kind", ["PNG", "16-bit PNG", "16-bit TIFF", "palette"])
def test_an_embedded_profile_is_converted_to_srgb(kind):
    red = np.broadcast_to(np.array([200, 100, 20], dtype=np.uint8), (HEIGHT, WIDTH, 3))
    profile = _profile_with_red_and_blue_exchanged()
    if kind == "16-bit TIFF":
        file = _deep_tiff(red * np.uint16(257), extrasamples=None, iccprofile=profile)
    elif kind == "16-bit PNG":
        plain = _deep_png(red * np.uint16(257)).getvalue()
        with_profile = encoded(red, icc_profile=profile).getvalue()
        start = with_profile.index(b"iCCP") - 4
        (length,) = struct.unpack(">I", with_profile[start : start + 4])
        file = io.BytesIO(plain[:33] + with_profile[start : start + length + 12] + plain[33:])
    else:
        picture = Image.fromarray(red)
        file = encoded(picture.quantize() if kind == "palette" else picture, icc_profile=profile)
    image = load_image(file, mask=INSIDE)
    expected = np.broadcast_to(np.array([20, 100, 200]) / 255, (INSIDE.sum(), 3))
    assert image.color[INSIDE] == pytest.approx(expected, abs=1.5 * EIGHT_BITS)  # tables of the conversion


def test_a_gray_profile_is_converted_to_srgb():
    linear = np.full((HEIGHT, WIDTH), 128, dtype=np.uint8)
    image = load_image(encoded(linear, icc_profile=imagecodecs.cms_profile("gray", gamma=1.0)), mask=INSIDE)
    # Half the light is painted as 188 of 255; a step for the stored 128, which is a little more than half.
    assert image.color[INSIDE] == pytest.approx(np.full((INSIDE.sum(), 3), 188 / 255), abs=1.5 * EIGHT_BITS)


def test_the_profile_of_srgb_changes_nothing():
    image = load_image(encoded(rgba(), icc_profile=SRGB_PROFILE))
    assert image.color[INSIDE] == pytest.approx(rgba()[INSIDE][:, :3] / 255, abs=1e-12)


@pytest.mark.parametrize(
    ("profile", "reason"),
    [
        pytest.param(b"no profile at all", "damaged and is ignored", id="broken"),
        pytest.param(
            imagecodecs.cms_profile("gray", gamma=1.0),
            "GRAY profile does not fit",
            id="of another color space",
        ),
    ],
)
def test_a_profile_that_cannot_be_used_changes_nothing_and_a_warning_says_so(profile, reason):
    with pytest.warns(ToonkitWarning, match=reason):
        image = load_image(encoded(rgba(), icc_profile=profile))
    assert image.color[INSIDE] == pytest.approx(rgba()[INSIDE][:, :3] / 255, abs=1e-12)


# Sources


@pytest.mark.parametrize("as_source", [str, lambda path: path, lambda path: io.BytesIO(path.read_bytes())])
def test_paths_and_files_are_sources(tmp_path, as_source):
    path = tmp_path / "drawing.png"
    path.write_bytes(encoded(rgba()).getvalue())
    assert (load_image(as_source(path)).mask == INSIDE).all()


def test_an_open_file_is_left_open(tmp_path):
    path = tmp_path / "drawing.png"
    path.write_bytes(encoded(rgba()).getvalue())
    with path.open("rb") as file:
        load_image(file)
        assert not file.closed


@pytest.mark.parametrize(
    "array",
    [
        pytest.param(rgba(np.uint8), id="uint8"),
        pytest.param(rgba(np.uint16), id="uint16"),
        pytest.param(rgba(np.uint16) / 65535, id="float64"),
        pytest.param((rgba(np.uint16) / 65535).astype(np.float32), id="float32"),
        pytest.param((rgba() / 255).tolist(), id="nested lists"),
        pytest.param(rgba()[:, ::-1][:, ::-1], id="views"),
    ],
)
def test_arrays_of_any_usual_dtype_are_sources(array):
    image = load_image(array)
    assert (image.mask == INSIDE).all()
    assert image.color[INSIDE] == pytest.approx(rgba()[INSIDE][:, :3] / 255, abs=EIGHT_BITS)


@pytest.mark.parametrize("shape", [(HEIGHT, WIDTH), (HEIGHT, WIDTH, 1)])
def test_gray_and_bool_arrays_are_sources(shape):
    image = load_image(np.ones(shape, dtype=bool), mask=INSIDE)
    assert (image.color[INSIDE] == 1).all()


def test_a_source_array_is_not_changed():
    array = rgba()
    load_image(array, mask=INSIDE)
    assert (array == rgba()).all()


def test_colors_may_be_nan_outside_the_mask():
    first = load_image(rgba())
    again = load_image(first.color, mask=first.mask)
    assert np.array_equal(first.color, again.color, equal_nan=True)


# Masks and alpha


def test_the_outline_runs_where_alpha_is_one_half():
    picture = np.full((HEIGHT, WIDTH, 4), 255, dtype=np.uint8)
    picture[..., 3] = 0
    picture[4:20, 4:20, 3] = 255
    picture[4:20, 20, 3], picture[4:20, 3, 3] = 128, 127
    picture[4:20, 3, :3] = (10, 20, 30)
    image = load_image(picture)
    assert image.mask[10, 20]
    assert not image.mask[10, 3]
    assert image.alpha[10, [20, 3]] == pytest.approx([128 / 255, 127 / 255])
    assert image.fringe[10, 3] * 255 == pytest.approx([10, 20, 30])
    assert image.to_rgba()[10, 3].tolist() == [10, 20, 30, 127]


@pytest.mark.parametrize(
    "mask",
    [
        pytest.param(INSIDE, id="bool"),
        pytest.param(INSIDE.astype(float), id="float"),
        pytest.param(INSIDE.astype(np.uint8) * 255, id="0 and 255"),
        pytest.param(INSIDE.astype(np.uint8), id="uint8 of 0 and 1"),
        pytest.param(INSIDE.astype(int), id="int of 0 and 1"),
        pytest.param(INSIDE.astype(np.uint16) * 65535, id="uint16"),
        pytest.param(INSIDE[..., None], id="(H, W, 1)"),
        pytest.param(INSIDE.tolist(), id="nested lists"),
    ],
)
def test_masks_of_any_usual_dtype_are_the_same_mask(mask):
    assert (load_image(rgba()[..., :3], mask=mask).mask == INSIDE).all()


def test_a_soft_mask_becomes_alpha():
    soft = np.where(INSIDE, 0.8, 0.3)
    image = load_image(rgba()[..., :3], mask=soft)
    assert image.alpha == pytest.approx(soft)
    assert (image.mask == INSIDE).all()


def test_mask_and_alpha_are_multiplied():
    left = COLUMNS < 16
    image = load_image(rgba(), mask=left)
    assert (image.mask == (INSIDE & left)).all()


@pytest.mark.parametrize("kind", ["gray", "bits", "alpha"])
def test_a_mask_may_be_a_picture_file(tmp_path, kind):
    picture = {
        "gray": Image.fromarray(INSIDE.astype(np.uint8) * 255),
        "bits": Image.fromarray(INSIDE),
        "alpha": Image.fromarray(rgba()),
    }[kind]
    path = tmp_path / "mask.png"
    picture.save(path)
    assert (load_image(rgba()[..., :3], mask=path).mask == INSIDE).all()


@pytest.mark.parametrize("lowest", [250, 254])
def test_a_picture_that_is_nearly_opaque_everywhere_is_opaque(lowest):
    picture = np.full((HEIGHT, WIDTH, 4), 255, dtype=np.uint8)
    picture[INSIDE, :3] = (200, 80, 60)
    picture[5, 5, 3], picture[20, 1, 3] = lowest, 253
    image = load_image(picture)  # finds the object on its white background
    assert (image.mask == INSIDE).all()
    assert (load_image(picture, mask=INSIDE).alpha == INSIDE).all()
    assert (load_image(picture, mask=encoded(np.where(INSIDE, 255, 0).astype(np.uint8))).mask == INSIDE).all()


def test_a_picture_with_one_clearly_transparent_pixel_is_not_opaque():
    picture = np.full((HEIGHT, WIDTH, 4), 255, dtype=np.uint8)
    picture[5, 5, 3] = 249
    assert load_image(picture).mask.all()


def test_colors_off_by_rounding_are_clipped():
    color = np.where(INSIDE[..., None], 1 + 1e-13, 0.5)
    color[5, 5] = -1e-13
    image = load_image(color, mask=INSIDE)
    assert image.color[INSIDE].max() == 1
    assert image.color[INSIDE].min() == 0


# What is refused


PNG_BYTES = encoded(rgba()).getvalue()
JPEG_BYTES = encoded(rgba()[..., :3], "JPEG").getvalue()
DEEP_BYTES = _deep_png(rgba(np.uint16)).getvalue()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        pytest.param(b"", "be a picture file; got .* empty", id="empty file"),
        pytest.param(b"this is a text file\n" * 9, "be a PNG, WebP, JPEG", id="text"),
        pytest.param(b"<?xml version='1.0'?><svg></svg>", "SVG drawing", id="SVG"),
        pytest.param(PNG_BYTES[: len(PNG_BYTES) // 2], "complete, undamaged", id="truncated PNG"),
        pytest.param(PNG_BYTES[:20], "be ", id="a few bytes of PNG"),
        pytest.param(DEEP_BYTES[: len(DEEP_BYTES) // 2], "complete, undamaged", id="truncated 16-bit PNG"),
        pytest.param(JPEG_BYTES[: len(JPEG_BYTES) // 2], "complete, undamaged", id="truncated JPEG"),
        pytest.param(b"II*\0" + b"\xff" * 40, "be ", id="nonsense TIFF"),
        pytest.param(b"RIFF\x10\0\0\0WEBPVP8 nonsense", "be ", id="nonsense WebP"),
        pytest.param(png_with_size(30_000, 30_000), "30000 x 30000 pixels", id="900 million pixels"),
        pytest.param(
            png_with_size(2**31 - 1, 2**31 - 1), "scale the picture down", id="as many as PNG allows"
        ),
        pytest.param(png_with_size(8193, 8192), "scale the picture down", id="a column too many"),
        pytest.param(encoded(rgba()[:1, :1]).getvalue(), "at least 3 x 3 pixels; got 1 x 1", id="one pixel"),
    ],
)
def test_a_file_that_is_no_whole_picture_is_refused(tmp_path, content, reason):
    path = tmp_path / "drawing.png"
    path.write_bytes(content)
    with pytest.raises(ToonkitError, match=f"source must .*{reason}"):
        load_image(path)


def test_a_large_gif_is_refused_before_it_is_decoded():
    header = b"GIF89a" + struct.pack("<HH", 20_000, 20_000) + b"\0\0\0,"
    header += struct.pack("<HHHH", 0, 0, 20_000, 20_000) + b"\0\x02\0;"
    with pytest.raises(ToonkitError, match="scale the picture down"):
        load_image(io.BytesIO(header))


def test_the_largest_picture_is_a_square_of_8192():
    assert MAX_PIXELS == 8192**2


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(ToonkitError, match=r"must be an existing file; got .*nowhere\.png"):
        load_image(tmp_path / "nowhere.png")


def test_a_folder_is_refused(tmp_path):
    with pytest.raises(ToonkitError, match=r"must be a folder of layers: .* got the folder"):
        load_image(tmp_path)


def test_a_file_opened_as_text_is_refused():
    with pytest.raises(ToonkitError, match="opened in binary mode"):
        load_image(io.StringIO("text"))


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        (None, "must be a path, a binary file or an array"),
        (b"\x89PNG", "must be a path, a binary file or an array"),
        (7, "must be a path, a binary file or an array"),
        (np.ones((8, 8, 5)), "must be a path, a binary file or an array"),
        (np.ones((8, 8), dtype=complex), "must be a path, a binary file or an array"),
        ([[1], [1, 2]], "rectangular"),
        (np.ones((8, 8, 4), dtype=np.int64), "bool, uint8, uint16 or float"),
        (rgba().astype(float), r"alpha in \[0, 1\] \(divide 8-bit values by 255\)"),
        (np.broadcast_to([np.nan, 0, 0, 1], (8, 8, 4)), "finite colors .* 64 NaN pixels"),
        (np.broadcast_to([0, 0, 0, np.nan], (8, 8, 4)), "alpha without NaN"),
        (np.broadcast_to([0, 0, 1.5, 0.9], (8, 8, 4)), r"sRGB in \[0, 1\]"),
        (np.ones((2, 9, 3)), "at least 3 x 3 pixels; got 9 x 2"),
        (np.full((8, 8, 3), np.nan), "finite colors"),
    ],
)
def test_an_array_that_is_no_picture_is_refused(source, reason):
    with pytest.raises(ToonkitError, match=f"source .*{reason}"):
        load_image(source)


@pytest.mark.parametrize(
    ("mask", "reason"),
    [
        (np.zeros((HEIGHT, WIDTH)), "contain the object; got an empty mask"),
        ((ROWS == 3) & (COLUMNS == 3), "an object of at least 9 pixels .* got 1 pixel$"),
        (np.full((HEIGHT, WIDTH), 0.3), "at least half opaque; got an opacity of at most 0.3"),
        (INSIDE[:-1], r"the size of the picture \(24, 32\); got \(23, 32\)"),
        (INSIDE.T, r"the size of the picture \(24, 32\); got \(32, 24\)"),
        (np.where(INSIDE, 1.0, np.nan), "values without NaN"),
        (INSIDE * 200.0, r"values in \[0, 1\] \(divide"),
        (INSIDE * -1.0, r"values in \[0, 1\]"),
        (INSIDE.astype(np.int64) * 7, "bool, uint8, uint16 or float"),
        (rgba(), r"array of shape \(H, W\)"),
        ("nowhere.png", "be an existing file"),
    ],
)
def test_what_is_no_mask_of_the_picture_is_refused(mask, reason):
    with pytest.raises(ToonkitError, match=f"mask must .*{reason}"):
        load_image(rgba()[..., :3], mask=mask)


@pytest.mark.parametrize(
    ("alpha", "reason"),
    [(0, "a transparent picture"), (90, "at least half opaque; got an opacity of at most 0.35")],
)
def test_a_picture_without_a_solid_object_is_refused(alpha, reason):
    picture = rgba()
    picture[..., 3] = alpha
    with pytest.raises(ToonkitError, match=f"source must contain .*{reason}"):
        load_image(encoded(picture))


def test_a_name_too_long_for_a_file_is_refused():
    with pytest.raises(ToonkitError, match="source must be"):
        load_image("a" * 300)

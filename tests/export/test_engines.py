"""Normal maps drop into engines as they are: axes, depth, alpha, a bled rim, and no color management."""

import struct

import imagecodecs
import numpy as np
import pytest

from toonkit import ToonkitError
from toonkit.cli import drawing_work
from toonkit.export.engines import BLEED, ENGINES, write_engine_normal_map
from toonkit.export.folder import write_analysis_folder
from toonkit.export.light_profiles import PROFILE_LIGHTS, light_profiles, write_light_profiles
from toonkit.export.normal_map import write_normal_map

GREEN_DOWN = {"unreal"}


def chunks(path):
    """The types of a PNG's chunks, in order."""
    data, position, found = path.read_bytes(), 8, []
    while position < len(data):
        length, kind = struct.unpack(">I4s", data[position : position + 8])
        found.append(kind.decode())
        position += 12 + length
    return found


def decoded(pixels, *, down=False):
    """Vectors of a normal map, with y up."""
    vectors = pixels[..., :3] / (np.iinfo(pixels.dtype).max / 2) - 1
    return vectors * [1, -1, 1] if down else vectors


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


@pytest.fixture
def written(analysis, engine, tmp_path):
    path = tmp_path / "ball_n.png"
    write_engine_normal_map(analysis, path, engine)
    return path


def test_a_sphere_decodes_to_its_normals_within_quantization(analysis, engine, written):
    pixels = imagecodecs.png_decode(written.read_bytes())
    assert pixels.dtype == np.dtype(f"uint{ENGINES[engine].bits}")
    found = decoded(pixels, down=engine in GREEN_DOWN)[analysis.image.mask]
    half_a_step = 1 / np.iinfo(pixels.dtype).max
    assert np.abs(found - analysis.normals.compact).max() <= half_a_step + 1e-9


def test_the_upper_half_of_a_sphere_is_greener_only_where_green_points_up(analysis, engine, written):
    green = imagecodecs.png_decode(written.read_bytes())[..., 1].astype(float)
    upper, lower = green[:20][analysis.image.mask[:20]].mean(), green[28:][analysis.image.mask[28:]].mean()
    assert (upper < lower) == (engine in GREEN_DOWN)


def test_the_alpha_of_the_drawing_is_kept(analysis, written):
    pixels = imagecodecs.png_decode(written.read_bytes())
    top = np.iinfo(pixels.dtype).max
    assert np.array_equal(pixels[..., 3], np.round(analysis.image.alpha * top))
    assert ((pixels[..., 3] > 0) & (pixels[..., 3] < top)).any()


def test_no_chunk_lets_a_program_convert_normals_as_colors(written):
    assert set(chunks(written)) == {"IHDR", "IDAT", "IEND"}


@pytest.mark.parametrize("options", [{}, {"bits": 16}, {"green": "directx"}])
def test_no_normal_map_at_all_has_such_a_chunk(analysis, tmp_path, options):
    write_normal_map(analysis.normals, tmp_path / "normals.png", **options)
    assert set(chunks(tmp_path / "normals.png")) == {"IHDR", "IDAT", "IEND"}


@pytest.mark.parametrize("bleed", [0, 1, 3.5, 100])
def test_the_rim_goes_on_outward_as_far_as_asked_and_is_flat_beyond(analysis, tmp_path, bleed):
    write_normal_map(analysis.normals, tmp_path / "plain.png")
    write_normal_map(analysis.normals, tmp_path / "bled.png", bleed=bleed)
    plain, bled = (
        imagecodecs.png_decode((tmp_path / name).read_bytes()) for name in ("plain.png", "bled.png")
    )
    mask = analysis.image.mask
    inside = np.argwhere(mask)
    for row, column in np.argwhere(~mask):
        square = ((inside - (row, column)) ** 2).sum(axis=1)
        nearest = {tuple(plain[tuple(place)]) for place in inside[square == square.min()]}
        expected = nearest if square.min() <= bleed**2 else {(128, 128, 255)}
        assert tuple(bled[row, column]) in expected
    assert np.array_equal(bled[mask], plain[mask])


def test_filtering_at_the_rim_mixes_no_flat_normal_in(analysis, written, engine):
    pixels = imagecodecs.png_decode(written.read_bytes())
    vectors = decoded(pixels, down=engine in GREEN_DOWN)
    halved = vectors.reshape(24, 2, 24, 2, 3).mean(axis=(1, 3))  # the first mipmap
    touched = analysis.image.mask.reshape(24, 2, 24, 2).any(axis=(1, 3))
    row, column = np.nonzero(touched)
    outward = np.stack([2 * column + 0.5 - 23.5, 23.5 - 2 * row - 0.5], axis=-1)
    radius = np.hypot(*outward.T)
    rim = radius > 19
    along = (halved[row, column, :2] * outward).sum(axis=1) / radius
    assert rim.sum() > 20
    assert along[rim].min() > 0.8  # a flat half would leave 0.5


def test_soft_pixels_have_the_normals_of_the_rim_even_without_bleeding(analysis, tmp_path):
    write_normal_map(analysis.normals, tmp_path / "map.png", alpha=analysis.image.alpha)
    pixels = imagecodecs.png_decode((tmp_path / "map.png").read_bytes())
    soft = (analysis.image.alpha > 0) & ~analysis.image.mask
    assert soft.any()
    assert decoded(pixels)[soft][:, 2].max() < 0.5
    clear = analysis.image.alpha == 0
    assert (pixels[clear] == (128, 128, 255, 0)).all()


def test_the_command_line_offers_every_engine():
    assert tuple(ENGINES) == drawing_work.ENGINE_NAMES
    assert drawing_work.BLEED == BLEED
    assert BLEED == 16  # as the help says


def test_the_folder_of_an_analysis_has_the_map_beside_the_sprite_if_asked(analysis, tmp_path):
    names = [path.name for path in write_analysis_folder(analysis, tmp_path, engine="godot")]
    assert {"base_color.png", "base_color_n.png"} < set(names)
    write_analysis_folder(analysis, tmp_path)
    assert not (tmp_path / "base_color_n.png").exists()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"bleed": -1}, "bleed must be a number of pixels >= 0"),
        ({"bleed": float("nan")}, "bleed must be a number of pixels >= 0"),
        ({"alpha": np.ones((3, 3))}, "alpha must have the size"),
        ({"alpha": np.full((48, 48), 2.0)}, r"alpha must lie in \[0, 1\]"),
    ],
)
def test_maps_that_make_no_sense_are_refused(analysis, tmp_path, options, reason):
    with pytest.raises(ToonkitError, match=reason):
        write_normal_map(analysis.normals, tmp_path / "map.png", **options)
    assert not list(tmp_path.iterdir())


def test_an_unknown_engine_is_refused(analysis, tmp_path):
    with pytest.raises(ToonkitError, match="engine must be one of godot, unity"):
        write_engine_normal_map(analysis, tmp_path / "map.png", "quake")
    with pytest.raises(ToonkitError, match="engine must be one of godot, unity"):
        write_analysis_folder(analysis, tmp_path / "out", engine="quake")
    assert not list(tmp_path.iterdir())


def test_gray_profiles_give_the_normals_back(several):
    profiles = {name: pixels[..., 0] / 255 for name, pixels in light_profiles(several).items()}
    across = profiles["right"] - profiles["left"]
    upward = profiles["top"] - profiles["bottom"]
    found = np.stack([across, upward, profiles["front"]], axis=-1)[several.image.mask]
    assert np.abs(found - several.normals.compact).max() <= 0.5 / 255 + 1e-9


def test_color_profiles_are_the_relit_drawing(several):
    from toonkit import relight

    for name, pixels in light_profiles(several, color=True, flat_shading=0.5).items():
        assert np.array_equal(pixels, relight(several, PROFILE_LIGHTS[name], flat_shading=0.5).to_rgba())


def test_profiles_are_written_gray_and_relit_with_the_alpha_of_the_drawing(several, tmp_path):
    written = write_light_profiles(several, tmp_path / "profiles")
    sides = ("left", "right", "top", "bottom", "front")
    assert [path.name for path in written] == [
        f"{side}{kind}.png" for kind in ("", "_color") for side in sides
    ]
    alpha = several.image.to_rgba()[..., 3]
    for path in written:
        assert np.array_equal(imagecodecs.png_decode(path.read_bytes())[..., 3], alpha)

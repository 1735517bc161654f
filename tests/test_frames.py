"""Frames of sheets and animations are analyzed together: nothing flickers, and they come back in their layout."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from tests.turning import INK, LIGHT, TONES, turned, turning
from toonkit import ToonkitError, ToonkitWarning, analyze_frames, load_image, read_frames
from toonkit.cli import main
from toonkit.export.frame_files import read_frame_folder, write_frame_folder, write_frames
from toonkit.frames.montage import cut, lay_out, montage
from toonkit.model.sheet_layout import FrameBox, SheetLayout

NEW_LIGHT = (20.0, 40.0)


@pytest.fixture(scope="module")
def frames():
    """An object that turns once around."""
    return turning(12)


@pytest.fixture(scope="module")
def result(frames):
    return analyze_frames([frame.picture for frame in frames], LIGHT)


@pytest.fixture(scope="module")
def few():
    return [turned(angle, 48).picture for angle in (0, 40, 80, 130, 160, 210)]


@pytest.fixture(scope="module")
def quick(few):
    return analyze_frames(few, LIGHT, method="lumo")


def sheet_of(pictures, columns):
    return np.vstack([np.hstack(pictures[at : at + columns]) for at in range(0, len(pictures), columns)])


def save(pixels, path):
    Image.fromarray(pixels).save(path)
    return path


def read(path):
    with Image.open(path) as picture:
        return np.asarray(picture)


def equal(found, expected):
    """Tell whether pictures are the same wherever anything is to be seen."""
    seen = expected[..., 3] > 0
    return np.array_equal(found[..., 3], expected[..., 3]) and np.array_equal(found[seen], expected[seen])


def test_materials_keep_their_base_color_in_all_frames(frames, result):
    assert result.analysis.materials.count == len(TONES)
    seen = {name: [] for name in range(len(TONES))}
    for base, labels in zip(result.base_colors(), result.labels(), strict=True):
        for name, colors in seen.items():
            own = labels == name
            if own.sum() > 30:
                colors.append(np.median(base[own][:, :3], axis=0))
    for colors in seen.values():
        assert len(colors) == len(frames)
        assert np.ptp(colors, axis=0).max() <= 1
        assert any(np.abs(colors[0] - tones[1]).max() <= 1 for tones in TONES.values())


def test_a_material_is_the_same_number_in_all_frames(frames, result):
    names = {}
    for frame, labels in zip(frames, result.labels(), strict=True):
        height = frame.points[..., 1]
        for name, where in (("shirt", height < -0.35), ("skin", abs(height) < 0.1), ("hair", height > 0.8)):
            names.setdefault(name, []).append(np.bincount(labels[where & (labels >= 0)]).argmax())
    assert [len(set(found)) for found in names.values()] == [1, 1, 1]
    assert len({found[0] for found in names.values()}) == 3


def test_ink_is_found_in_every_frame(frames, result):
    coverage = result.cut(result.analysis.drawing.ink_coverage)
    for frame, found in zip(frames, coverage, strict=True):
        rim = np.isfinite(frame.points[..., 0])
        assert 0.05 < found[rim].mean() < 0.3
        assert found[48, 48] == 0


def angles(first, second):
    return np.degrees(
        np.arctan2(np.linalg.norm(np.cross(first, second), axis=-1), (first * second).sum(axis=-1))
    )


def test_normals_change_no_more_than_the_object_turns():
    frames = turning(6, step=3)
    normals = analyze_frames([frame.picture for frame in frames], LIGHT).normals()
    for first, second in pairwise(normals):
        both = np.isfinite(first[..., 0]) & np.isfinite(second[..., 0])
        assert angles(first[both], second[both]).mean() < 3.0


def test_the_same_frame_twice_has_the_same_normals(few):
    normals = analyze_frames([few[0], few[1], few[0]], LIGHT).normals()
    assert np.array_equal(normals[0], normals[2], equal_nan=True)


def test_under_its_own_light_each_frame_returns_unchanged(few, quick):
    for before, after in zip(few, quick.relight(LIGHT), strict=True):
        assert equal(after, before)


def test_pixel_art_keeps_its_palette_in_all_frames(few):
    colors = np.array([*(tone for tones in TONES.values() for tone in tones), INK])
    hard = []
    for frame in few:
        sprite = frame[::2, ::2].copy()
        nearest = np.square(sprite[..., None, :3].astype(int) - colors).sum(axis=-1).argmin(axis=-1)
        on = sprite[..., 3:] >= 128
        hard.append(np.where(on, np.dstack([colors[nearest], np.full(on.shape, 255)]), 0).astype(np.uint8))
    result = analyze_frames(hard * 6, LIGHT, method="lumo")  # more than 100 pixels across
    assert result.analysis.drawing.is_pixel_art
    relit = np.concatenate([frame[frame[..., 3] > 0] for frame in result.relight(NEW_LIGHT)])
    assert {*map(tuple, relit[:, :3].tolist())} <= {*map(tuple, colors.tolist())}


def test_many_frames_are_each_an_object(few):
    drawing = analyze_frames([few[0][12:36, 12:36]] * 150, LIGHT, method="lumo").analysis.drawing
    assert len(drawing.islands) == 150


def test_frames_of_several_sizes_and_empty_ones_keep_their_place(few):
    small = few[1][8:40, 10:44]
    empty = np.zeros((7, 5, 4), np.uint8)
    result = analyze_frames([few[0], empty, small], LIGHT, method="lumo")
    assert result.analysis.drawing.views == 2
    assert [frame.shape for frame in result.relight(NEW_LIGHT)] == [few[0].shape, empty.shape, small.shape]
    assert not result.relight(NEW_LIGHT)[1].any()
    assert equal(result.relight(LIGHT)[2], small)


def test_frames_in_a_montage_do_not_touch(few):
    shape, places = lay_out(few)
    taken = np.zeros(shape, int)
    for place in places:
        rows, columns = place.in_montage
        taken[rows.start - 2 : rows.stop + 2, columns.start - 2 : columns.stop + 2] += 1
    assert taken.max() == 1
    pixels, places = montage(few)
    for found, expected in zip(cut(pixels.alpha, places), few, strict=True):
        assert np.array_equal(np.round(255 * found), expected[..., 3])


@pytest.mark.parametrize(
    ("bad", "rule"),
    [
        ([], "frames must show something"),
        ([np.zeros((5, 5, 4), np.uint8)], "frames must show something"),
        ([np.zeros((5, 5, 3), np.uint8)], r"frames must be uint8 arrays of shape \(h, w, 4\)"),
        (["frame.png"], r"frames must be uint8 arrays"),
    ],
)
def test_what_are_no_frames_is_refused(bad, rule):
    with pytest.raises(ToonkitError, match=rule):
        analyze_frames(bad, LIGHT)


# sheets


def test_a_grid_is_cut_row_by_row_and_put_together_again(few, tmp_path):
    whole = sheet_of(few, 3)
    frames = read_frames(save(whole, tmp_path / "sheet.png"), grid=(3, 2))
    assert all(equal(found, expected) for found, expected in zip(frames.pictures, few, strict=True))
    assert equal(frames.layout.put_together(frames.pictures), whole)


def test_islands_are_frames_with_their_specks(few, tmp_path):
    whole = sheet_of(few, 3)
    whole[2, 20] = (10, 10, 10, 255)  # above the first one
    frames = read_frames(save(whole, tmp_path / "sheet.png"), islands=True)
    assert len(frames.pictures) == 6
    assert [box.row for box in frames.layout.boxes][:3] == [2, *[frames.layout.boxes[1].row] * 2]
    assert equal(frames.layout.put_together(frames.pictures), whole)


ATLASES = {
    "TexturePacker": lambda boxes: {
        "frames": {
            f"walk/{number}.png": {
                "frame": {"x": x, "y": y, "w": w, "h": h},
                "rotated": rotated,
                "trimmed": False,
                "spriteSourceSize": {"x": 0, "y": 0, "w": w, "h": h},
                "sourceSize": {"w": w, "h": h},
            }
            for number, (x, y, w, h, rotated) in enumerate(boxes)
        },
        "meta": {"app": "https://www.codeandweb.com/texturepacker", "image": "sheet.png", "scale": "1"},
    },
    "Aseprite": lambda boxes: {
        "frames": [
            {
                "filename": f"walk {number}.aseprite",
                "frame": {"x": x, "y": y, "w": w, "h": h},
                "rotated": rotated,
                "duration": 100,
            }
            for number, (x, y, w, h, rotated) in enumerate(boxes)
        ],
        "meta": {"app": "https://www.aseprite.org/", "image": "sheet.png", "frameTags": [{"name": "walk"}]},
    },
}


@pytest.fixture(params=ATLASES)
def packed(request, few, tmp_path):
    """A sheet with an atlas beside it: three frames of unequal size, one turned, and one listed twice."""
    cropped = [few[0][:, 2:46], few[1][1:47, 4:44], few[2]]
    whole = np.zeros((100, 102, 4), np.uint8)
    whole[:48, :44], whole[50:90, 1:47], whole[:48, 50:98] = cropped[0], np.rot90(cropped[1], -1), cropped[2]
    boxes = [(0, 0, 44, 48, False), (1, 50, 40, 46, True), (50, 0, 48, 48, False), (0, 0, 44, 48, False)]
    (tmp_path / "sheet.json").write_text(json.dumps(ATLASES[request.param](boxes)))
    return save(whole, tmp_path / "sheet.png"), whole, cropped


def test_an_atlas_beside_the_sheet_says_where_the_frames_are(packed):
    path, whole, cropped = packed
    frames = read_frames(path)
    assert all(equal(found, expected) for found, expected in zip(frames.pictures, cropped, strict=True))
    assert equal(frames.layout.put_together(frames.pictures), whole)


def test_a_sheet_comes_back_with_its_size_layout_and_atlas(packed, tmp_path):
    path, whole, _ = packed
    assert (
        main(["frames", str(path), "-o", str(tmp_path / "out"), "--method", "lumo", "--light", "130,45"]) == 0
    )
    relit = tmp_path / "relit.png"
    assert main(["relight", str(tmp_path / "out"), "--light", "130,45", "-o", str(relit)]) == 0
    assert equal(read(relit), whole)
    before = json.loads((tmp_path / "sheet.json").read_text())
    before["meta"].pop("image")
    for picture in (relit, tmp_path / "out" / "base_color.png", tmp_path / "out" / "normals.png"):
        assert read(picture).shape == whole.shape
        atlas = json.loads(picture.with_suffix(".json").read_text())
        assert atlas["meta"].pop("image") == picture.name
        assert atlas == before


def test_relit_frames_are_those_of_the_library(packed, tmp_path):
    path, *_ = packed
    frames = read_frames(path)
    result = analyze_frames(frames.pictures, LIGHT, method="lumo")
    write_frame_folder(result, frames, tmp_path / "out")
    found, layout = read_frame_folder(tmp_path / "out")
    write_frames(found.relight(NEW_LIGHT), layout, tmp_path / "relit.png")
    expected = frames.layout.put_together(result.relight(NEW_LIGHT)).astype(int)
    apart = np.abs(read(tmp_path / "relit.png") - expected)
    assert apart[expected[..., 3] > 0].max() <= 1  # as archives round normals


def test_a_normal_map_of_a_sheet_fits_its_frames(packed, tmp_path):
    frames = read_frames(packed[0])
    result = analyze_frames(frames.pictures, LIGHT, method="lumo")
    write_frame_folder(result, frames, tmp_path / "out")
    encoded = read(tmp_path / "out" / "normals.png")[..., :3]
    for cut_out, normals in zip(frames.layout.cut(encoded), result.normals(), strict=True):
        on = np.isfinite(normals[..., 0])
        assert angles(cut_out[on] / 127.5 - 1, normals[on]).max() < 0.6


def test_a_sheet_has_a_normal_map_for_an_engine(packed, tmp_path):
    command = ["frames", str(packed[0]), "-o", str(tmp_path / "out"), "--method", "lumo", "--light", "130,45"]
    assert main([*command, "--engine", "unreal"]) == 0
    up, down = read(tmp_path / "out" / "normals.png"), read(tmp_path / "out" / "base_color_n.png")
    on = up[..., 3] > 0
    assert np.abs(up[on][:, 1].astype(int) + down[on][:, 1] - 255).max() <= 1
    assert np.array_equal(up[on][:, [0, 2, 3]], down[on][:, [0, 2, 3]])
    assert (
        json.loads((tmp_path / "out" / "base_color_n.json").read_text())["meta"]["image"]
        == "base_color_n.png"
    )


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        ("nonsense", "atlas must be a JSON atlas"),
        ('{"frames": 5}', "atlas must be a JSON atlas"),
        ('{"frames": [{"frame": {"x": 0}}]}', "atlas must be a JSON atlas"),
        ('{"frames": {}}', "atlas must have 1 to"),
        (
            '{"frames": [{"frame": {"x": 90, "y": 0, "w": 30, "h": 10}}]}',
            "frames that lie in the sheet of 96 x 48",
        ),
        ("[" * 100_000, "atlas must be a JSON atlas"),
    ],
)
def test_what_is_no_atlas_is_refused(few, tmp_path, content, rule):
    (tmp_path / "atlas.json").write_text(content)
    with pytest.raises(ToonkitError, match=rule):
        read_frames(save(sheet_of(few[:2], 2), tmp_path / "sheet.png"), atlas=tmp_path / "atlas.json")


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ({"grid": (5, 1)}, "grid must divide the sheet of 96 x 48 pixels into equal cells; got 5 x 1"),
        ({"grid": (0, 1)}, "grid must be columns and rows"),
        ({"grid": 4}, "grid must be two numbers"),
        ({"grid": (2, 1), "islands": True}, "atlas must stand alone"),
        ({"islands": "yes"}, "islands must be True or False"),
    ],
)
def test_a_layout_that_does_not_fit_is_refused(few, tmp_path, options, rule):
    with pytest.raises(ToonkitError, match=rule):
        read_frames(save(sheet_of(few[:2], 2), tmp_path / "sheet.png"), **options)


def test_an_opaque_sheet_loses_its_background(few, tmp_path):
    whole = sheet_of(few, 3)
    ground = np.full((*whole.shape[:2], 3), 200, np.uint8)
    share = whole[..., 3:] / 255
    opaque = np.round(whole[..., :3] * share + ground * (1 - share)).astype(np.uint8)
    frames = read_frames(save(opaque, tmp_path / "sheet.png"), grid=(3, 2))
    assert np.abs(frames.pictures[0][..., 3].astype(int) - few[0][..., 3]).mean() < 2


# animations


def animate(pictures, path, **options):
    first, *others = [Image.fromarray(picture) for picture in pictures]
    first.save(
        path, save_all=True, append_images=others, duration=[80, 120, 80, 80, 80, 200], loop=3, **options
    )
    return path


HARD = {
    ".gif": {"disposal": 2},
    ".webp": {"lossless": True},
    ".png": {"blend": 0},
    ".apng": {"blend": 0, "format": "PNG"},
}


@pytest.mark.parametrize("suffix", HARD)
def test_an_animation_comes_back_frame_by_frame(few, tmp_path, suffix):
    pictures = few
    if suffix == ".gif":  # which has no soft outlines
        pictures = [
            np.where(frame[..., 3:] >= 128, frame | np.array([0, 0, 0, 255], np.uint8), 0) for frame in few
        ]
    path = animate(pictures, tmp_path / f"turning{suffix}", **HARD[suffix])
    frames = read_frames(path)
    assert frames.timing.milliseconds == (80, 120, 80, 80, 80, 200)
    assert frames.timing.loops == 3
    result = analyze_frames(frames.pictures, LIGHT, method="lumo")
    write_frames(result.relight(LIGHT), frames, tmp_path / f"same{suffix}")
    again = read_frames(tmp_path / f"same{suffix}")
    assert again.timing == frames.timing
    for found, expected in zip(again.pictures, frames.pictures, strict=True):
        if suffix == ".gif":  # 255 colors for all frames
            assert np.array_equal(found[..., 3], expected[..., 3])
            assert np.abs(found.astype(int) - expected)[expected[..., 3] > 0].mean() < 2
        else:
            assert equal(found, expected)


def test_the_command_keeps_an_animation_one(few, tmp_path, capsys):
    path = animate(few, tmp_path / "turning.webp", lossless=True)
    assert (
        main(["frames", str(path), "-o", str(tmp_path / "out"), "--method", "lumo", "--light", "130,45"]) == 0
    )
    assert "6 frames analyzed as one drawing" in capsys.readouterr().out
    assert (
        main(["relight", str(tmp_path / "out"), "--light", "20,40", "-o", str(tmp_path / "relit.apng")]) == 0
    )
    for name in ("out/base_color.webp", "out/normals.png", "out/materials.png", "relit.apng"):
        with Image.open(tmp_path / name) as found:
            assert found.n_frames == 6
            assert found.size == (48, 48)


def test_gif_warns_of_the_pixels_that_it_drops(few, tmp_path, quick):
    frames = read_frames(animate(few, tmp_path / "turning.webp", lossless=True))
    with pytest.warns(ToonkitWarning, match=r"GIF drops [\d,]+ pixels that are less than half opaque"):
        write_frames(quick.base_colors(), frames, tmp_path / "base.gif")


def test_a_still_picture_is_no_animation(few, tmp_path):
    frames = read_frames(save(few[0], tmp_path / "one.gif.png"))
    assert frames.timing is None
    assert len(frames.pictures) == 1


def test_an_animation_has_no_grid(few, tmp_path):
    path = animate(few, tmp_path / "turning.png", blend=0)
    with pytest.raises(ToonkitError, match="source must be a sheet"):
        read_frames(path, grid=(2, 1))


def test_an_animation_cut_off_is_refused(few, tmp_path):
    path = animate(few, tmp_path / "turning.png", blend=0)
    path.write_bytes(path.read_bytes()[:-3000])
    with pytest.raises(ToonkitError, match="undamaged"):
        read_frames(path)


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        (["frames", "{sheet}", "-o", "{out}", "--grid", "4"], "--grid must be COLUMNSxROWS"),
        (["frames", "{sheet}", "-o", "{out}", "--grid", "2x1", "--islands"], "not allowed with argument"),
        (["relight", "{done}", "--orbit", "{out}.gif"], "without --orbit"),
        (["relight", "{done}", "--light", "1,2", "--layers", "{out}"], "without --layers"),
        (["mesh", "{done}", "-o", "{out}.glb"], "analysis must be of one drawing"),
    ],
)
def test_what_cannot_be_done_with_frames_is_refused(few, quick, tmp_path, capsys, arguments, rule):
    sheet = save(sheet_of(few, 3), tmp_path / "sheet.png")
    write_frame_folder(quick, read_frames(sheet, grid=(3, 2)), tmp_path / "done")
    places = {"sheet": sheet, "out": tmp_path / "out", "done": tmp_path / "done"}
    assert main([argument.format(**places) for argument in arguments]) == 2
    assert rule in capsys.readouterr().err


def test_an_analysis_of_one_drawing_in_the_same_folder_is_no_longer_one_of_frames(few, quick, tmp_path):
    sheet = save(sheet_of(few, 3), tmp_path / "sheet.png")
    write_frame_folder(quick, read_frames(sheet, grid=(3, 2)), tmp_path / "out")
    assert (
        main(
            [
                "analyze",
                str(sheet),
                "-o",
                str(tmp_path / "out"),
                "--light",
                "1,45",
                "--method",
                "lumo",
                "--quiet",
            ]
        )
        == 0
    )
    assert (
        main(["relight", str(tmp_path / "out"), "--light", "1,45", "-o", str(tmp_path / "a.png"), "--quiet"])
        == 0
    )
    assert load_image(tmp_path / "a.png").shape == (96, 144)


def test_a_layout_that_was_damaged_is_refused(few, quick, tmp_path):
    sheet = save(sheet_of(few, 3), tmp_path / "sheet.png")
    write_frame_folder(quick, read_frames(sheet, grid=(3, 2)), tmp_path / "out")
    (tmp_path / "out" / "frames.json").write_text('{"version": 1, "shape": [9]}')
    with pytest.raises(ToonkitError, match=r"undamaged frames\.json"):
        read_frame_folder(tmp_path / "out")


def test_pictures_of_other_sizes_are_not_put_into_a_layout(few, tmp_path):
    frames = read_frames(save(sheet_of(few, 3), tmp_path / "sheet.png"), grid=(3, 2))
    with pytest.raises(ToonkitError, match="pictures must be one for each frame"):
        write_frames([frame[1:] for frame in few], frames, tmp_path / "a.png")


def test_a_turned_frame_is_upright_once_it_is_cut():
    sheet = np.arange(12).reshape(3, 4)
    layout = SheetLayout((3, 4), (FrameBox("a", 0, 1, 3, 2, rotated=True),))
    (frame,) = layout.cut(sheet)
    assert frame.tolist() == [[2, 6, 10], [1, 5, 9]]
    assert layout.put_together([frame], -1).tolist() == [[-1, 1, 2, -1], [-1, 5, 6, -1], [-1, 9, 10, -1]]

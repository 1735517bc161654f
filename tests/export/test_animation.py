"""Animations of a moving light: once around, or from light to light, as transparent as each format can."""

import numpy as np
import pytest
from PIL import Image

from toonkit import ToonkitError, light_direction, relight
from toonkit.export.animation import FRAME_MILLISECONDS, write_light_path, write_orbit

SUFFIXES = [".gif", ".webp", ".png", ".apng"]


def frames_of(path):
    """All frames as RGBA, and the milliseconds that the first one is shown."""
    with Image.open(path) as animation:
        found = []
        for index in range(animation.n_frames):
            animation.seek(index)
            found.append(np.asarray(animation.convert("RGBA")))
        return np.array(found), animation.info.get("duration"), animation.info.get("loop")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_orbit_has_its_frames_and_never_ends(analysis, tmp_path, suffix):
    path = tmp_path / f"orbit{suffix}"
    write_orbit(analysis, path, frames=6)
    frames, milliseconds, loop = frames_of(path)
    assert len(frames) == 6
    assert milliseconds == FRAME_MILLISECONDS
    assert loop == 0


@pytest.mark.parametrize("suffix", [".webp", ".png"])
def test_lossless_frames_are_the_relit_pictures(analysis, tmp_path, suffix):
    path = tmp_path / f"orbit{suffix}"
    write_orbit(analysis, path, frames=4, elevation=30)
    frames, _, _ = frames_of(path)
    for index, frame in enumerate(frames):
        expected = relight(analysis, light_direction(135 + 90 * index, 30)).to_rgba()
        assert np.array_equal(frame[..., 3], expected[..., 3])
        seen = expected[..., 3] > 0
        assert np.array_equal(frame[seen], expected[seen])


@pytest.mark.parametrize(("suffix", "once"), [(".gif", None), (".webp", 1), (".png", 1)])
def test_a_path_of_lights_is_shown_without_end_or_once(analysis, tmp_path, suffix, once):
    lights = [(135, 30), (45, 30), (45, 60)]
    path = tmp_path / f"path{suffix}"
    write_light_path(analysis, path, lights, frames=6)
    looped, _, loop = frames_of(path)
    assert (len(looped), loop) == (6, 0)
    write_light_path(analysis, path, lights, frames=5, loop=False)
    shown, _, loop = frames_of(path)
    # Pillow tells of WebP and PNG how often they are shown, and of a GIF how often again, which it does not say here.
    assert (len(shown), loop) == (5, once)
    if suffix != ".gif":
        for index, light in ((0, lights[0]), (2, lights[1]), (4, lights[2])):
            expected = relight(analysis, light).to_rgba()
            seen = expected[..., 3] > 0
            assert np.abs(shown[index][seen].astype(int) - expected[seen]).max() <= 1


def test_a_gif_is_transparent_outside_and_close_in_color_inside(analysis, tmp_path):
    write_orbit(analysis, tmp_path / "orbit.gif", frames=5, elevation=30)
    frames, _, _ = frames_of(tmp_path / "orbit.gif")
    for index, frame in enumerate(frames):
        expected = relight(analysis, light_direction(135 + 72 * index, 30)).to_rgba().astype(int)
        solid = expected[..., 3] >= 128
        assert ((frame[..., 3] == 255) == solid).all()
        # 12 of 255: what 255 colors for all frames together leave
        assert np.abs(frame[solid].astype(int) - expected[solid])[:, :3].mean() < 12


def test_the_light_starts_where_it_was_analyzed_and_returns(analysis, tmp_path):
    write_orbit(analysis, tmp_path / "orbit.png", frames=8)
    frames, _, _ = frames_of(tmp_path / "orbit.png")
    assert np.array_equal(frames[0], relight(analysis, analysis.light).to_rgba())
    change = [np.abs(frames[i].astype(int) - frames[0]).sum() for i in range(8)]
    assert max(change) == change[4]  # from the other side it looks most different


def test_progress_is_told_after_each_frame(analysis, tmp_path):
    told = []
    write_orbit(analysis, tmp_path / "orbit.webp", frames=4, progress=told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]


def test_without_detail_only_the_model_is_painted(analysis, tmp_path):
    write_orbit(analysis, tmp_path / "orbit.png", frames=2, elevation=30, keep_detail=False)
    frames, _, _ = frames_of(tmp_path / "orbit.png")
    expected = relight(analysis, light_direction(315, 30), keep_detail=False).to_rgba()
    assert np.array_equal(frames[1], expected)


def test_an_orbit_can_leave_flat_materials_flat(several, tmp_path):
    for share, name in ((0, "flat.png"), (1, "shaded.png")):
        write_orbit(several, tmp_path / name, frames=2, flat_shading=share)
    spot = several.materials.labels == 2
    (lit, opposite), (_, shaded) = (
        frames_of(tmp_path / name)[0][:, spot, :3] for name in ("flat.png", "shaded.png")
    )
    assert np.array_equal(opposite, lit)
    assert (shaded != lit).any()


def test_a_place_that_cannot_be_written_to_costs_no_painting(analysis, tmp_path):
    painted = []
    with pytest.raises(ToonkitError, match="existing folder"):
        write_orbit(analysis, tmp_path / "nowhere" / "orbit.webp", frames=4, progress=painted.append)
    assert not painted


def test_a_cancelled_orbit_leaves_no_file(analysis, tmp_path):
    def cancel(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_orbit(analysis, tmp_path / "orbit.gif", frames=4, progress=cancel)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("orbit.mp4", {}, r"path must end in \.gif"),
        ("orbit.gif", {"frames": 1}, "frames must be a whole number from 2 to 720"),
        ("orbit.gif", {"frames": 2.5}, "frames must be a whole number from 2 to 720"),
        ("orbit.gif", {"frames": 721}, "frames must be a whole number from 2 to 720"),
        ("orbit.gif", {"elevation": 91}, "elevation must lie in -90 to 90"),
        ("orbit.gif", {"flat_shading": 1.5}, "flat_shading must be a number from 0 to 1; got 1.5"),
        ("orbit.gif", {"elevation": float("nan")}, "elevation must lie in -90 to 90"),
    ],
)
def test_what_is_no_orbit_is_refused(analysis, tmp_path, name, options, reason):
    with pytest.raises(ToonkitError, match=reason):
        write_orbit(analysis, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())
